//! Frequency and damping of a pole with their standard deviations, in its law.

use crate::damping::limits;
use chladni_frf::Damping;
use num_complex::Complex64;

/// Numbers whose error bars hold both damping laws.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Number {
    Real,
    Complex,
}

/// The error bar of a number of standard deviation `std` that would be off by `shift` if the law
/// that was not taken held, which is as likely as the other (theory.md, eq. L4).
///
/// The interval that 95 % of errors lie in holds nearly all of them in the law taken and nine
/// tenths of them in the other.
pub(crate) fn in_either_law(number: Number, std: f64, shift: f64) -> f64 {
    let reach = limits::REACH[number as usize];
    let rest = reach - limits::NINE_TENTHS;
    (limits::NINE_TENTHS * std + (rest * std).hypot(shift)) / reach
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
    fn bars_of_an_open_law_hold_95_percent_of_both() {
        // Φ by its series; exact to 1e-7 within six standard deviations
        let below = |x: f64| -> f64 {
            let mut term = x;
            let mut sum = x;
            for n in 1..200 {
                term *= x * x / f64::from(2 * n + 1);
                sum += term;
            }
            0.5 + sum * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
        };
        let reach = limits::REACH[Number::Real as usize];
        for shift in [0.0, 0.3, 1.0, 2.0, 4.0] {
            let interval = reach * in_either_law(Number::Real, 1.0, shift);
            let within = |middle: f64| below(interval - middle) - below(-interval - middle);
            let [taken, other] = [within(0.0), within(shift)];
            let mean = 0.5 * (taken + other);
            assert!((0.949..0.965).contains(&mean), "{shift}: {taken}, {other}");
            assert!((0.90..0.96).contains(&other), "{shift}: {other}");
        }
        for number in [Number::Real, Number::Complex] {
            assert!((in_either_law(number, 0.3, 0.0) - 0.3).abs() < 1e-12);
            let reach = limits::REACH[number as usize];
            let far = reach * in_either_law(number, 1.0, 100.0) - 100.0;
            assert!((far - limits::NINE_TENTHS).abs() < 1e-2, "{far}");
        }
    }
}
