//! Frequency and damping of a pole with their standard deviations, in its law; error bars where the
//! law, or a drop of the force, is open.

use crate::damping::limits;
use chladni_frf::Damping;
use num_complex::Complex64;

/// The error bar of a frequency or loss factor of standard deviation `std` that is off by `shift`
/// in the case that was not taken: the other law, or a force that drops (theory.md, eq. L4).
///
/// The interval holds 95 % of errors in either case: nearly all in the one taken where the other one
/// is far.
pub(crate) fn in_either_case(std: f64, shift: f64) -> f64 {
    with_shift(std, shift, limits::REAL_95)
}

/// The same of a complex shape value, which the other law turns by `shift`.
pub(crate) fn turned_in_either_case(std: f64, shift: f64) -> f64 {
    with_shift(std, shift, limits::COMPLEX_95)
}

fn with_shift(std: f64, shift: f64, [within, one_side]: [f64; 2]) -> f64 {
    (one_side * std + ((within - one_side) * std).hypot(shift)) / within
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

    /// Parts of the errors about 0 and about `shift` that lie within `interval`, by sums over a grid.
    ///
    /// * `along`, `across`: standard deviations, along the shift and across it
    fn held(interval: f64, shift: f64, [along, across]: [f64; 2]) -> [f64; 2] {
        let grid: Vec<f64> = (-400..=400).map(|n| f64::from(n) * 0.02).collect();
        let [mut all, mut taken, mut other] = [0.0; 3];
        for x in &grid {
            for y in &grid {
                let weight = (-0.5 * (x * x + y * y)).exp();
                let is_within = |x: f64| f64::from(u8::from(x.hypot(across * y) < interval));
                all += weight;
                taken += weight * is_within(along * x);
                other += weight * is_within(along * x + shift);
            }
        }
        [taken / all, other / all]
    }

    #[test]
    fn bars_of_an_open_law_hold_in_either() {
        let round = [0.5f64.sqrt(); 2];
        for shift in [0.0, 0.1, 0.3, 0.6, 1.0, 2.0, 4.0] {
            let real = limits::REAL_95[0] * in_either_case(1.0, shift);
            let complex = limits::COMPLEX_95[0] * turned_in_either_case(1.0, shift);
            // real errors, complex ones without a direction, and those along the shift
            for (interval, size, expected) in [
                (real, [1.0, 0.0], 0.943..0.960),
                (complex, round, 0.943..0.978),
                (complex, [1.0, 0.0], 0.910..0.935),
            ] {
                let [taken, other] = held(interval, shift, size);
                assert!(expected.contains(&other), "{shift} {size:?}: {other}");
                assert!(taken > other - 2e-3, "{shift} {size:?}: {taken}");
            }
        }
        for bar in [in_either_case, turned_in_either_case] {
            assert!((bar(0.3, 0.0) - 0.3).abs() < 1e-12);
        }
        let far = limits::REAL_95[0] * in_either_case(1.0, 100.0) - 100.0;
        assert!((far - limits::REAL_95[1]).abs() < 1e-2, "{far}");
    }
}
