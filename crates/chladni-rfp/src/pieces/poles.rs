//! Poles that a merged sketch shows, with what the second pass and its solution need to
//! know.

use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::{Effort, FitOptions};
use crate::pieces::plan::Plan;
use crate::poles::estimate::Grade;
use chladni_frf::Finding;
use ndarray::Array2;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Poles to run the second pass with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Poles {
    pub(crate) plan: Plan,
    /// Indices of the lines used.
    pub(crate) lines: Vec<usize>,
    /// In the x plane.
    pub(crate) lambda: Vec<Complex64>,
    /// Root mean square of the data, in SI units of their kind.
    pub(crate) rms: f64,
    /// Energy of each line used over all FRFs, in work units.
    pub(crate) line_energy: Vec<f64>,
    /// Columns of the sketch on these lines, in work units.
    pub(crate) sketch: Matrix<Complex64>,
    /// Number of FRFs in it.
    pub(crate) frfs: usize,
    /// Number of modes asked for.
    pub(crate) modes: Option<usize>,
    /// Outlier lines left out, Hz.
    pub(crate) dropped_hz: Vec<f64>,
    /// How often poles were sought: the second pass may show that they must be sought
    /// again.
    pub(crate) rounds: usize,
    pub(crate) path: Path,
}

/// How poles were found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Path {
    /// Fast chain; what was tried: (poles, residual variance), in order.
    Fast { history: Vec<(usize, f64)> },
    /// Measured-data path, and why; E|δλ|² and grade of each pole.
    Measured {
        evidence: String,
        spread: Vec<f64>,
        grades: Vec<Grade>,
        warnings: Vec<Finding>,
    },
    /// Stopped: every resonance turns the wrong way.
    Conjugated,
}

/// A matrix, column by column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Matrix<T> {
    pub rows: usize,
    pub values: Vec<T>,
}

impl<T: Copy> From<Array2<T>> for Matrix<T> {
    fn from(array: Array2<T>) -> Self {
        let (rows, size) = (array.nrows(), array.len());
        let by_columns = array.reversed_axes();
        let values = match by_columns.is_standard_layout() {
            true => by_columns.into_raw_vec_and_offset().0,
            false => by_columns.iter().copied().collect(),
        };
        assert_eq!(values.len(), size, "no part of a larger array");
        Self { rows, values }
    }
}

impl<T: Copy> Matrix<T> {
    pub fn array(&self) -> Array2<T> {
        let columns = self.values.len().checked_div(self.rows).unwrap_or(0);
        Array2::from_shape_fn(ndarray::ShapeBuilder::f((self.rows, columns)), |(i, c)| {
            self.values[c * self.rows + i]
        })
    }
}

impl Poles {
    /// Number of poles, those beside the band included.
    pub fn count(&self) -> usize {
        self.lambda.len()
    }

    /// Options of the first pass, to run the second with: band, seed, window, sketch, and
    /// the number of modes asked for.
    pub fn options(&self) -> FitOptions {
        let window = self
            .plan
            .window
            .as_deref()
            .and_then(|name| name.parse().ok());
        let effort = Effort {
            sketch_columns: self.plan.columns,
            ..Effort::default()
        };
        FitOptions {
            band_hz: self.plan.band_hz,
            modes: self.modes,
            seed: self.plan.seed,
            window,
            effort,
            ..FitOptions::default()
        }
    }

    /// Natural frequencies and loss factors of the poles of the band, by rising
    /// frequency, as far as the sketch tells them.
    pub fn modes(&self) -> Vec<(f64, f64)> {
        let hz = self
            .lines
            .last()
            .map_or(0.0, |&k| self.plan.frequency_hz[k]);
        let first = self
            .lines
            .first()
            .map_or(0.0, |&k| self.plan.frequency_hz[k]);
        let mut modes: Vec<(f64, f64)> = self
            .lambda
            .iter()
            .map(|l| (l.re.max(0.0).sqrt() * hz, l.im / l.re))
            .collect();
        modes.retain(|mode| mode.0 >= first && mode.0 <= hz);
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes
    }

    /// How they were found, in words.
    pub fn evidence(&self) -> String {
        match &self.path {
            Path::Fast { .. } => "fast chain on the sketch".into(),
            Path::Measured { evidence, .. } => format!("measured-data path: {evidence}"),
            Path::Conjugated => "every resonance turns the wrong way".into(),
        }
    }

    /// Lines and scale, without DOFs.
    pub(crate) fn head(&self, effort: Effort) -> Result<DataLayout, FitError> {
        Ok(DataLayout {
            rms: self.rms,
            ..self.plan.head(self.lines.clone(), effort)?
        })
    }
}
