//! Frequency and damping of a pole with their standard deviations, in its law; bars of shapes where
//! the law is open.

use crate::damping::limits;
use chladni_frf::Damping;
use num_complex::Complex64;

/// The error bar of a shape value of standard deviation `std` that would be turned by `shift` if
/// the law that was not taken held (theory.md, eq. L4).
///
/// The interval holds 95 % of errors in either law: nearly all in the one taken where the other one
/// is far.
pub(crate) fn in_either_law(std: f64, shift: f64) -> f64 {
    let rest = limits::COMPLEX_95 - limits::ONE_SIDE;
    (limits::ONE_SIDE * std + (rest * std).hypot(shift)) / limits::COMPLEX_95
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_of_an_open_law_hold_in_either() {
        // Φ by its series
        let below = |x: f64| -> f64 {
            let mut term = x;
            let mut sum = x;
            for n in 1..200 {
                term *= x * x / f64::from(2 * n + 1);
                sum += term;
            }
            0.5 + sum * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
        };
        for shift in [0.0, 0.1, 0.3, 1.0, 2.0, 4.0] {
            let interval = limits::COMPLEX_95 * in_either_law(1.0, shift);
            // noise along the shift, as that of a scale that turns is
            let within = |middle: f64| below(interval - middle) - below(-interval - middle);
            let [taken, other] = [within(0.0), within(shift)];
            assert!((0.915..0.96).contains(&other), "{shift}: {other}");
            assert!(taken > other - 1e-9, "{shift}: {taken}");
        }
        assert!((in_either_law(0.3, 0.0) - 0.3).abs() < 1e-12);
        let far = limits::COMPLEX_95 * in_either_law(1.0, 100.0) - 100.0;
        assert!((far - limits::ONE_SIDE).abs() < 1e-2, "{far}");
    }
}
