//! FRFs that are not equally noisy (theory.md, section 2): once a fit has left white
//! noise, its level in each FRF is known to a few per cent, and where equal weights waste
//! information the fit is made again with 1/σ.
//!
//! Noise is taken as σ·s_i·t_j, the product of a sensor's (or a point's, under a laser)
//! and an exciter's. Weights of that form keep one shape per mode what it is: ψ_i/s_i and
//! L_j/t_j.

use crate::data::layout::DataLayout;
use crate::data::limits;
use crate::data::pair_weights::PairWeights;

impl PairWeights {
    /// From the sum of squares `left` of each pair used by a model; `None` where equal
    /// weights are good enough, or nothing is known.
    pub fn new(data: &DataLayout, left: &[f64], relative_error: f64) -> Option<Self> {
        (relative_error >= limits::ROUNDING)
            .then(|| Self::of_given(data, left))
            .flatten()
    }

    /// From the noise energy of each pair used; `None` as in [`Self::new`].
    pub fn of_given(data: &DataLayout, noise: &[f64]) -> Option<Self> {
        let lines = data.lines.len() as f64;
        let log: Vec<f64> = noise.iter().map(|sum| 0.5 * (sum / lines).ln()).collect();
        if log.is_empty() || log.iter().any(|level| !level.is_finite()) {
            return None;
        }
        let mean = log.iter().sum::<f64>() / log.len() as f64;
        let (mut s, mut t) = (
            vec![0.0; data.responses.len()],
            vec![0.0; data.references.len()],
        );
        for _ in 0..limits::SWEEPS {
            s = means(
                s.len(),
                data.pairs
                    .iter()
                    .zip(&log)
                    .map(|(&(i, j), level)| (i, level - mean - t[j])),
            );
            t = means(
                t.len(),
                data.pairs
                    .iter()
                    .zip(&log)
                    .map(|(&(i, j), level)| (j, level - mean - s[i])),
            );
        }
        let weights = Self {
            response: s.iter().map(|v| (-v).exp()).collect(),
            reference: t.iter().map(|v| (-v).exp()).collect(),
        };
        (weights.loss(data) > limits::WORTH_WEIGHING).then_some(weights)
    }

    fn loss(&self, data: &DataLayout) -> f64 {
        let squares = || data.pairs.iter().map(|&pair| self.of(pair).powi(2));
        squares().sum::<f64>() * squares().map(f64::recip).sum::<f64>()
            / (data.pairs.len() as f64).powi(2)
            - 1.0
    }
}

/// Mean of the values of each of `count` groups; 0 where there is none.
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
