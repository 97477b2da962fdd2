//! Stabilization: poles of rising order, and the modes that they settle on.
//!
//! A pole of the structure comes back at every order, one that noise or the polynomial
//! makes does not. The diagram (order over frequency) is the display of choice in modal
//! testing; here it is data ([`Stabilization`]), and clusters of stable poles are what
//! [`super::lscf`] and [`super::plscf`] offer as modes. Which of them matter is
//! decided by their residues.

use super::limits::{
    AGREED, AGREED_LEAST, BEYOND, HEAVIEST, LINES_PER_MODE, LINES_PER_POLE, MORE_POLES, ORDERS,
    POLES_PER_MODE, STABILIZATION_CLUSTER_SPACINGS, STABLE_DAMPING, STABLE_FREQUENCY,
};
use crate::damping::places::lambda_of_s;
use crate::data::options::FitOptions;
use crate::methods::clusters::{clusters, median_pole};
use crate::methods::found::MethodPoles;
use crate::methods::found::{OrderPole, Stability, Stabilization};
use crate::methods::matrix_fraction::MatrixFraction;
use crate::methods::selection::modes_of;
use crate::methods::survey::Survey;
use chladni_frf::Damping;
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The highest order looked at, in poles.
pub(crate) fn highest(expected: usize, survey: &Survey) -> usize {
    (POLES_PER_MODE * expected + MORE_POLES)
        .min(survey.data.lines.len() / LINES_PER_POLE)
        .max(1)
}

/// Poles at every order up to the highest.
pub(crate) struct Ladder {
    orders: Vec<usize>,
    /// s/ω_max per order, Re s < 0, rising in frequency.
    poles: Vec<Vec<(Complex64, Stability)>>,
}

impl Ladder {
    /// Orders from `lowest` on.
    ///
    /// # Errors
    /// Eigenvalues that do not converge.
    pub fn climb(fraction: &MatrixFraction, lowest: usize) -> Result<Self, LinalgError> {
        let highest = fraction.order();
        let lowest = lowest.clamp(1, highest);
        let step = (highest - lowest).div_ceil(ORDERS).max(1);
        let mut orders: Vec<usize> = (lowest..=highest).rev().step_by(step).collect();
        orders.reverse();
        let found: Vec<Vec<Complex64>> = orders
            .par_iter()
            .map(|&order| Ok(light(fraction.poles(order)?)))
            .collect::<Result<_, LinalgError>>()?;
        let poles = (0..orders.len())
            .map(|i| {
                found[i]
                    .iter()
                    .map(|&s| {
                        (
                            s,
                            if i > 0 {
                                compared(s, &found[i - 1])
                            } else {
                                Stability::New
                            },
                        )
                    })
                    .collect()
            })
            .collect();
        Ok(Self { orders, poles })
    }

    /// The modes that the orders agree on and the data need.
    ///
    /// # Errors
    /// A decomposition that fails.
    pub fn modes(
        &self,
        survey: &Survey,
        options: &FitOptions,
        how: &'static str,
    ) -> Result<MethodPoles, LinalgError> {
        let work = &survey.sketch;
        let settled: Vec<(usize, Complex64)> = (0..self.orders.len())
            .flat_map(|i| {
                self.poles[i]
                    .iter()
                    .filter(|(_, stability)| *stability == Stability::Stable)
                    .map(move |(s, _)| (i, *s))
            })
            .collect();
        let enough = (AGREED * self.orders.len() as f64).max(AGREED_LEAST);
        let [low, high] = [work.range().0.sqrt(), work.range().1.sqrt()];
        let margin = BEYOND * (high - low);
        let near = |s: Complex64| s.im >= low - margin && s.im <= high + margin;
        let spacing = (high - low) / work.lines() as f64;
        let agreed = clusters(
            &settled,
            STABILIZATION_CLUSTER_SPACINGS * spacing,
            |members| members as f64 >= enough,
        );
        // the higher orders have less bias
        let lambda: Vec<Complex64> = agreed
            .iter()
            .map(|members| median_pole(members[members.len() / 2..].iter().map(|&i| settled[i].1)))
            .filter(|s| near(*s))
            .map(|s| lambda_of_s(Damping::Structural, s))
            .take(work.lines() / LINES_PER_MODE)
            .collect();
        let mut found = modes_of(survey, &lambda, options, how)?;
        found.stabilization = Some(self.diagram(survey));
        Ok(found)
    }

    fn diagram(&self, survey: &Survey) -> Stabilization {
        let hz = survey.data.omega_max / TAU;
        let poles = self
            .orders
            .iter()
            .zip(&self.poles)
            .flat_map(|(&order, poles)| {
                poles.iter().map(move |&(s, stability)| OrderPole {
                    order,
                    frequency_hz: s.norm() * hz,
                    damping_ratio: -s.re / s.norm(),
                    stability,
                })
            });
        Stabilization {
            orders: self.orders.clone(),
            poles: poles.collect(),
        }
    }
}

/// Damped poles that may be modes, rising in frequency.
fn light(mut poles: Vec<Complex64>) -> Vec<Complex64> {
    poles.retain(|s| s.im > 0.0 && s.re < 0.0 && -s.re <= HEAVIEST * s.norm());
    poles.sort_by(|a, b| a.im.total_cmp(&b.im));
    poles
}

fn compared(s: Complex64, before: &[Complex64]) -> Stability {
    let steady = |other: &Complex64| {
        (other.norm() - s.norm()).abs() <= STABLE_FREQUENCY * s.re.abs().min(other.re.abs())
    };
    let alike = |other: &Complex64| (other.re / s.re - 1.0).abs() <= STABLE_DAMPING;
    let near: Vec<&Complex64> = before.iter().filter(|other| steady(other)).collect();
    match (near.is_empty(), near.into_iter().any(alike)) {
        (true, _) => Stability::New,
        (false, false) => Stability::Frequency,
        (false, true) => Stability::Stable,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stability_is_measured_in_bandwidths() {
        let s = Complex64::new(-0.01, 0.5);
        let before = |re: f64, im: f64| [Complex64::new(re, im)];
        assert_eq!(compared(s, &before(-0.0105, 0.501)), Stability::Stable);
        assert_eq!(compared(s, &before(-0.02, 0.501)), Stability::Frequency);
        assert_eq!(compared(s, &before(-0.01, 0.505)), Stability::New);
        assert_eq!(compared(s, &[]), Stability::New);
    }
}
