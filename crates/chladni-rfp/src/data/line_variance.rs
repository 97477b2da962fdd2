//! Variance of lines, from sets that local methods made. It follows the power of the force. Over the
//! power of the FRFs it is the relative variance that noise of the force would give to all of them.

use crate::data::limits;
use chladni_frf::{Estimator, FrfSet};

/// Variance of lines.
#[derive(Debug, Clone, Default)]
pub(crate) struct LineVariance {
    /// Variance of each line over that of the median line, which differs with the power of the
    /// force. It is the mean over FRFs, each over its own median.
    pub over_median: Vec<f64>,
    /// Σ_l Var H_l/Σ_l |H_l|² of each line.
    pub over_power: Vec<f64>,
    /// Part of the variance that FRFs share by the way they were estimated, in the limit of little
    /// noise.
    shared: f64,
}

impl LineVariance {
    /// Part of the variance that FRFs share on a line.
    ///
    /// * `share`: variance over power of the FRFs on this line
    pub fn shared_at(&self, share: f64) -> f64 {
        match self.shared > 0.0 {
            true => self.shared + limits::OF_NOISE * share / (share + limits::NOISY_SHARE),
            false => 0.0,
        }
    }

    /// The variances on other lines; `lines` turns values on the old lines into values on the new ones.
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

/// Variance of lines from a set that a local method made; `None` for others.
pub(crate) fn line_variance(
    frf: &FrfSet,
    pairs: &[(usize, usize)],
    lines: &[usize],
) -> Option<LineVariance> {
    let by_local_method = frf.estimation.filter(|made| made.estimator.is_local());
    let (Some(variance), Some(made)) = (&frf.variance, by_local_method) else {
        return None;
    };
    let mut sum = vec![0.0; lines.len()];
    for &(i, j) in pairs {
        let of_frf: Vec<f64> = lines.iter().map(|&k| variance[[i, j, k]]).collect();
        let middle = median(of_frf.clone())?;
        sum.iter_mut()
            .zip(of_frf)
            .for_each(|(sum, value)| *sum += value / middle);
    }
    let middle = median(sum.clone())?;
    let over_median: Vec<f64> = sum.iter().map(|sum| sum / middle).collect();
    // all responses of a force have one denominator
    let shared = match made.estimator {
        Estimator::Lrm => {
            limits::OF_DENOMINATOR / (frf.responses.len() as f64 + limits::OF_DENOMINATOR)
        }
        _ => 0.0,
    };
    let usable = over_median.iter().all(|v| v.is_finite() && *v > 0.0);
    let over_power = |&k: &usize| {
        let sum = |value: &dyn Fn(usize, usize) -> f64| -> f64 {
            pairs.iter().map(|&(i, j)| value(i, j)).sum()
        };
        let power = sum(&|i, j| frf.values.get(i, j, k).norm_sqr());
        sum(&|i, j| variance[[i, j, k]]) / power.max(f64::MIN_POSITIVE)
    };
    usable.then(|| LineVariance {
        over_power: lines.iter().map(over_power).collect(),
        shared,
        over_median,
    })
}

/// Correlation of the errors of neighbouring lines: local rational fits share lines of the record
/// (theory.md, eq. F4k).
pub(crate) fn of_neighbours(frf: &FrfSet) -> f64 {
    let by_rational_fits = frf
        .estimation
        .filter(|made| made.estimator == Estimator::Lrm);
    let shares_lines = by_rational_fits.is_some_and(|made| {
        let neighbours = frf.frequency_hz.windows(2).into_iter().next();
        let step = neighbours.map(|two| (two[1] - two[0]) * made.transform_s);
        step.is_some_and(|step| made.lines_per_value as f64 > limits::LINES_SHARED * step)
    });
    match shares_lines {
        true => limits::OF_SHARED_LINES,
        false => 0.0,
    }
}

/// The median; `None` unless it is above 0.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let value = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    (value > 0.0).then_some(value)
}
