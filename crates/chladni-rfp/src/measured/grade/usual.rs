//! Common properties of the sure modes of a set: a pole that differs from them is
//! doubtful.

use super::limits::{BEST_KNOWN, COMMON, FEW, FEWEST_NEIGHBOURS, NEIGHBOURS};
use crate::measured::evidence::Evidence;
use num_complex::Complex64;

/// Common properties of the sure modes.
#[derive(Clone, Copy, Default)]
pub(super) struct Usual {
    /// Median loss of the sure modes nearest to the pole.
    pub loss: Option<f64>,
    /// Mean phase of residues, as [`Evidence::mean_phase`].
    pub mean_phase: Option<Complex64>,
}

impl Usual {
    /// As pole `q` of `all` sees it: every sure mode but itself.
    pub fn beside(q: usize, all: &[Evidence], sure: &[bool]) -> Self {
        let others: Vec<&Evidence> = all
            .iter()
            .zip(sure)
            .enumerate()
            .filter(|(other, (_, sure))| *other != q && **sure)
            .map(|(_, (evidence, _))| evidence)
            .collect();
        Self {
            loss: usual_loss(&others, all[q].lambda.re),
            mean_phase: usual_phase(&others),
        }
    }
}

/// Median loss of the modes nearest to `x`; `None` where there are too few.
fn usual_loss(others: &[&Evidence], x: f64) -> Option<f64> {
    let mut nearest: Vec<Complex64> = others.iter().map(|other| other.lambda).collect();
    nearest.sort_by(|a, b| (a.re - x).abs().total_cmp(&(b.re - x).abs()));
    nearest.truncate(NEIGHBOURS);
    let mut losses: Vec<f64> = nearest.iter().map(|pole| pole.im / pole.re).collect();
    losses.sort_by(f64::total_cmp);
    (losses.len() >= FEWEST_NEIGHBOURS).then(|| losses[losses.len() / 2])
}

/// Mean phase of the residues of all modes, each weighted by the precision of its pole; `None`
/// where modes are few, or their phases have no mean.
fn usual_phase(others: &[&Evidence]) -> Option<Complex64> {
    let (mut sum, mut weights, mut squares) = (Complex64::ZERO, 0.0, 0.0);
    for (phase, deviation) in others
        .iter()
        .filter_map(|e| Some((e.mean_phase?, e.deviation)))
    {
        let weight = deviation.max(BEST_KNOWN).powi(-2);
        sum += weight * phase;
        weights += weight;
        squares += weight * weight;
    }
    (weights * weights >= FEW * squares && sum.norm() > COMMON * weights).then_some(sum)
}
