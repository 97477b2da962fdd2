//! Weights for FRFs that are not equally noisy (theory.md, section 2). Once the residual of a fit is
//! white noise, its level in each FRF is known to a few per cent. If equal weights waste
//! information, the fit is made again with the weights 1/σ.
//!
//! Noise is taken as σ·s_i·t_j, the product of that of a sensor (under a laser: of a point) and that
//! of an exciter. Under such weights one shape per mode remains one: ψ_i/s_i and L_j/t_j.

use crate::data::layout::DataLayout;
use crate::data::limits;
use crate::data::pair_weights::PairWeights;

/// True for the relative error of a fit whose residual is rounding and no noise.
pub(crate) fn is_rounding(relative_error: f64) -> bool {
    relative_error < limits::ROUNDING
}

impl PairWeights {
    /// Weights from the residual energy of each pair used; `None` if equal weights are good enough, or
    /// the residual is rounding.
    pub fn if_unequal(
        data: &DataLayout,
        residual_energy: &[f64],
        relative_error: f64,
    ) -> Option<Self> {
        (!is_rounding(relative_error))
            .then(|| Self::by_noise(data, residual_energy))
            .flatten()
    }

    /// Weights from the noise energy of each pair used; `None` if equal weights are good enough, or
    /// a level is not finite.
    pub fn by_noise(data: &DataLayout, noise: &[f64]) -> Option<Self> {
        let lines = data.lines.len() as f64;
        let levels: Vec<f64> = noise.iter().map(|sum| 0.5 * (sum / lines).ln()).collect();
        if levels.is_empty() || levels.iter().any(|level| !level.is_finite()) {
            return None;
        }
        let mean = levels.iter().sum::<f64>() / levels.len() as f64;
        let of_pairs = || data.pairs.iter().zip(&levels);
        // ln s and ln t of the two-way mean
        let (mut s, mut t) = (
            vec![0.0; data.responses.len()],
            vec![0.0; data.references.len()],
        );
        for _ in 0..limits::SWEEPS {
            let without_t = of_pairs().map(|(&(i, j), level)| (i, level - mean - t[j]));
            s = means(s.len(), without_t);
            let without_s = of_pairs().map(|(&(i, j), level)| (j, level - mean - s[i]));
            t = means(t.len(), without_s);
        }
        let weights = Self {
            response: s.iter().map(|v| (-v).exp()).collect(),
            reference: t.iter().map(|v| (-v).exp()).collect(),
        };
        (weights.loss(data) > limits::WORTH_WEIGHING).then_some(weights)
    }

    /// Relative loss of variance by equal weights, mean(σ²)·mean(1/σ²) − 1.
    fn loss(&self, data: &DataLayout) -> f64 {
        let squares = || data.pairs.iter().map(|&pair| self.of(pair).powi(2));
        squares().sum::<f64>() * squares().map(f64::recip).sum::<f64>()
            / (data.pairs.len() as f64).powi(2)
            - 1.0
    }
}

/// Mean of the values (group, value) of each of `count` groups; 0 for a group without values.
fn means(count: usize, values: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); count];
    for (group, value) in values {
        sums[group].0 += value;
        sums[group].1 += 1.0;
    }
    sums.into_iter()
        .map(|(sum, number)| if number > 0.0 { sum / number } else { 0.0 })
        .collect()
}
