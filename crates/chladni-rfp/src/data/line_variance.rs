//! Variance of lines, which local methods tell: it follows the power of the force, and as a
//! part of the FRFs it is what noise of the force would make of all of them.

use crate::data::limits;
use chladni_frf::{Estimator, FrfSet};

/// Variance of lines.
#[derive(Debug, Clone, Default)]
pub(crate) struct LineVariance {
    /// That of each line over that of the median line: with the power of the force it differs
    /// from line to line. The mean over FRFs, each over its own median.
    pub over_median: Vec<f64>,
    /// Σ_l Var H_l/Σ_l |H_l|² of each line.
    pub over_power: Vec<f64>,
    /// Part of the variance that FRFs without noise share by the way they were estimated.
    shared: f64,
}

impl LineVariance {
    /// Part of the variance that FRFs share on a line where it is this `share` of their power.
    pub fn shared_at(&self, share: f64) -> f64 {
        match self.shared > 0.0 {
            true => self.shared + limits::OF_NOISE * share / (share + limits::NOISY_SHARE),
            false => 0.0,
        }
    }

    /// With other lines; empty ones stay so.
    pub fn map(&self, lines: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        match self.over_median.is_empty() {
            true => Self::default(),
            false => Self {
                over_median: lines(&self.over_median),
                over_power: lines(&self.over_power),
                shared: self.shared,
            },
        }
    }
}

/// The variance that a local method tells; `None` where none does.
pub(crate) fn line_variance(
    frf: &FrfSet,
    pairs: &[(usize, usize)],
    lines: &[usize],
) -> Option<LineVariance> {
    let local = frf.estimation.filter(|made| made.estimator.is_local());
    let (Some(variance), Some(made)) = (&frf.variance, local) else {
        return None;
    };
    let mut sum = vec![0.0; lines.len()];
    for &(i, j) in pairs {
        let own: Vec<f64> = lines.iter().map(|&k| variance[[i, j, k]]).collect();
        let middle = median(own.clone())?;
        sum.iter_mut()
            .zip(own)
            .for_each(|(sum, own)| *sum += own / middle);
    }
    let middle = median(sum.clone())?;
    let relative: Vec<f64> = sum.iter().map(|sum| sum / middle).collect();
    // one denominator for all responses of a force
    let shared = match made.estimator {
        Estimator::Lrm => {
            limits::OF_DENOMINATOR / (frf.responses.len() as f64 + limits::OF_DENOMINATOR)
        }
        _ => 0.0,
    };
    let usable = relative.iter().all(|v| v.is_finite() && *v > 0.0);
    let over_power = |&k: &usize| {
        let all = |of: &dyn Fn(usize, usize) -> f64| -> f64 {
            pairs.iter().map(|&(i, j)| of(i, j)).sum()
        };
        let power = all(&|i, j| frf.values.get(i, j, k).norm_sqr());
        all(&|i, j| variance[[i, j, k]]) / power.max(f64::MIN_POSITIVE)
    };
    usable.then(|| LineVariance {
        over_power: lines.iter().map(over_power).collect(),
        shared,
        over_median: relative,
    })
}

/// `None` where it is not above 0.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let value = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    (value > 0.0).then_some(value)
}
