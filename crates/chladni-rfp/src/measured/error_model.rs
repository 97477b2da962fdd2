//! Noise as the data show it: per FRF, per line, additive and multiplicative (theory.md,
//! eq. 22).

use super::limits::{
    ADDITIVE_LEAST, LEVEL_WINDOW, MEDIAN_TO_MEAN, MULTIPLICATIVE_RANGE, MULTIPLICATIVE_START,
    OWN_SHARE, STRONGEST_PERCENT,
};
use crate::data::columns::{line_energy, Columns};
use crate::data::fourth_difference::FourthDifference;
use crate::data::peaks::running_median;
use crate::tolerances as tol;
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// Variance model of one value of a line: σ_a²(k) + σ_m²·mean|Y_k|².
#[derive(Debug, Clone)]
pub(crate) struct NoiseModel {
    /// Additive part per line.
    pub additive: Array1<f64>,
    /// Relative part (gain noise, misfit), as a ratio of amplitudes.
    pub multiplicative: f64,
}

impl NoiseModel {
    /// Start: additive noise from fourth differences, 2 % gain noise.
    pub fn start(additive: Array1<f64>) -> Self {
        let floor = ADDITIVE_LEAST * additive.mean().unwrap_or(1.0).max(tol::TINY);
        Self {
            additive: additive.mapv(|v| v.max(floor)),
            multiplicative: MULTIPLICATIVE_START,
        }
    }

    /// 1/σ per line, normalised to unit mean square.
    pub fn weights(&self, level: &Array1<f64>) -> Vec<f64> {
        normalised(&self.variance(level))
    }

    /// Variance per line.
    pub fn variance(&self, level: &Array1<f64>) -> Array1<f64> {
        &self.additive + &(level * self.multiplicative.powi(2))
    }

    /// The model that unweighted residuals show. `fitted` is the mean |model|² per line.
    pub fn from_residual(residual: &Array2<Complex64>, fitted: &Array1<f64>) -> Self {
        let n = residual.nrows();
        let error = line_energy(residual);
        let raw: Vec<f64> = error.to_vec();
        let (one_in, least, most) = LEVEL_WINDOW;
        let additive = running_median(&raw, (n / one_in).clamp(least, most))
            .into_iter()
            .map(|v| v / MEDIAN_TO_MEAN)
            .collect::<Array1<f64>>();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| fitted[a].total_cmp(&fitted[b]));
        let mut low: Vec<f64> = order[..n / 2].iter().map(|&k| error[k]).collect();
        let floor = median(&mut low) / MEDIAN_TO_MEAN;
        let mut ratio: Vec<f64> = order[n - n * STRONGEST_PERCENT / 100..]
            .iter()
            .map(|&k| (error[k] - floor) / fitted[k].max(tol::TINY))
            .collect();
        let multiplicative = (median(&mut ratio) / MEDIAN_TO_MEAN)
            .max(0.0)
            .sqrt()
            .clamp(MULTIPLICATIVE_RANGE.0, MULTIPLICATIVE_RANGE.1);
        let least = ADDITIVE_LEAST * fitted.iter().cloned().fold(0.0, f64::max);
        Self {
            additive: additive.mapv(|v| v.max(least)),
            multiplicative,
        }
    }
}

/// 1/σ per line, of unit mean square.
pub(crate) fn normalised(variance: &Array1<f64>) -> Vec<f64> {
    let raw: Vec<f64> = variance
        .iter()
        .map(|v| 1.0 / v.max(tol::TINY).sqrt())
        .collect();
    let mean = (raw.iter().map(|w| w * w).sum::<f64>() / raw.len().max(1) as f64).sqrt();
    raw.iter().map(|w| w / mean).collect()
}

fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Scale of each FRF: √(σ² + (0.01 rms)²), its own noise, but never less than 1 % of
/// itself. Lines count as even: this is a scale, no test.
pub(crate) fn column_scales(work: &Columns) -> Vec<f64> {
    let n = work.lines();
    work.b
        .columns()
        .into_iter()
        .map(|column| {
            let mean_square = column.iter().map(|v| v.norm_sqr()).sum::<f64>() / n as f64;
            let about = |k: usize| [k - 2, k - 1, k, k + 1, k + 2].map(|k| column[k]);
            let mut differences: Vec<f64> = (2..n.saturating_sub(2))
                .map(|k| FourthDifference::OF_EVEN_LINES.energy(about(k)))
                .collect();
            let noise = FourthDifference::noise_of_median(median(&mut differences));
            (noise + OWN_SHARE * mean_square).sqrt().max(tol::TINY)
        })
        .collect()
}
