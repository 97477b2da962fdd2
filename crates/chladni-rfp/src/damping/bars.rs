//! Frequency and damping of a pole with their standard deviations, in its law.

use chladni_frf::Damping;
use num_complex::Complex64;

/// A pole with standard deviations, in units of ω_max.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UncertainPole {
    /// λ (structural) or s (viscous).
    pub value: Complex64,
    /// ω_n/ω_max.
    pub omega: f64,
    /// η_n.
    pub loss_factor: f64,
    /// Standard deviation of ω_n/ω_max.
    pub omega_std: f64,
    /// Standard deviation of η_n.
    pub loss_factor_std: f64,
}

impl UncertainPole {
    /// A structural pole with the variances of Re λ and Im λ.
    pub fn of_lambda(lambda: Complex64, variance: [f64; 2]) -> Self {
        let omega = lambda.re.max(0.0).sqrt();
        let deviation = variance.map(|v| v.max(0.0).sqrt());
        Self {
            value: lambda,
            omega,
            loss_factor: lambda.im / lambda.re,
            omega_std: deviation[0] / (2.0 * omega),
            loss_factor_std: deviation[1] / lambda.re.abs(),
        }
    }

    /// A viscous pole with the 2 × 2 covariance of (Re s, Im s).
    fn of_s(s: Complex64, covariance: [[f64; 2]; 2]) -> Self {
        let omega = s.norm();
        let zeta = -s.re / omega;
        // ∂|s| = (Re s, Im s)/|s|; ∂ζ = (−Im², Re·Im)/|s|³
        let along = |g: [f64; 2]| {
            (g[0] * g[0] * covariance[0][0]
                + 2.0 * g[0] * g[1] * covariance[0][1]
                + g[1] * g[1] * covariance[1][1])
                .max(0.0)
                .sqrt()
        };
        let cubed = omega.powi(3);
        Self {
            value: s,
            omega,
            loss_factor: 2.0 * zeta,
            omega_std: along([s.re / omega, s.im / omega]),
            loss_factor_std: 2.0 * along([-s.im * s.im / cubed, s.re * s.im / cubed]),
        }
    }

    /// A pole found as `s`, λ in the plane of the law, whose variance `spread` of λ is alike
    /// in all directions.
    pub fn alike(law: Damping, s: Complex64, lambda: Complex64, spread: f64) -> Self {
        match law {
            Damping::Structural => Self::of_lambda(lambda, [0.5 * spread; 2]),
            // |ds| = |dλ|/(2|√λ|)
            Damping::Viscous => {
                let c = 0.5 * spread / (4.0 * lambda.norm());
                Self::of_s(s, [[c, 0.0], [0.0, c]])
            }
        }
    }
}
