//! Poles that a merged sketch shows, with what the second pass and its solution need to
//! know.

use crate::data::error::FitError;
use crate::data::layout::{DataLayout, Weighting};
use crate::data::options::{Effort, FitOptions};
use crate::data::pair_weights::{NextWeights, NoiseSource, PairWeights};
use crate::data::source::{as_json, By, Way};
use crate::pieces::plan::Plan;
use chladni_frf::{Dof, Finding};
use ndarray::{Array2, ArrayView2, ShapeBuilder};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Poles to run a pass with, and all that a fit needs to go on from there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Poles {
    pub(crate) plan: Plan,
    pub(crate) pass: Pass,
    /// Indices of the lines used.
    pub(crate) lines: Vec<usize>,
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
    /// Factors of the pass on FRFs.
    pub(crate) weighting: Option<DofWeights>,
    /// Weights that may be tried after these.
    pub(crate) next_weights: NextWeights,
    /// Outlier lines left out, Hz.
    pub(crate) dropped_hz: Vec<f64>,
    /// Rounds of leaving them out.
    pub(crate) outlier_rounds: usize,
    /// Findings on the data.
    #[serde(with = "as_json")]
    pub(crate) warnings: Vec<Finding>,
    /// The poles, and how they were found; `None` where none were sought yet.
    pub(crate) way: Option<Way>,
}

/// The product of a pass with poles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Pass {
    /// Products with their basis: the second pass.
    Products,
    /// A sketch, and such products besides: a first pass with the poles of a pilot.
    Pilot,
    /// The same anew, of FRFs with other weights.
    Anew,
}

/// Weights of FRFs by their DOFs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct DofWeights {
    responses: Vec<(Dof, f64)>,
    references: Vec<(Dof, f64)>,
    /// Root mean square of the FRFs as they were measured.
    rms: f64,
    noise_source: Option<NoiseSource>,
}

impl DofWeights {
    /// Those of the FRFs of `data`.
    pub fn new(
        data: &DataLayout,
        weights: &PairWeights,
        noise_source: Option<NoiseSource>,
        rms: f64,
    ) -> Self {
        let of = |dofs: &[Dof], values: &[f64]| -> Vec<(Dof, f64)> {
            dofs.iter().copied().zip(values.iter().copied()).collect()
        };
        Self {
            responses: of(&data.responses, &weights.response),
            references: of(&data.references, &weights.reference),
            rms,
            noise_source,
        }
    }

    /// All weights, and the scale.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let weights = self.responses.iter().chain(&self.references);
        weights.map(|(_, weight)| *weight).chain([self.rms])
    }

    /// Those of the FRFs of these DOFs.
    pub fn of(&self, responses: &[Dof], references: &[Dof]) -> Weighting {
        let of = |dofs: &[Dof], all: &[(Dof, f64)]| {
            let all: HashMap<Dof, f64> = all.iter().copied().collect();
            dofs.iter()
                .map(|dof| all.get(dof).copied().unwrap_or(1.0))
                .collect()
        };
        Weighting {
            weights: PairWeights {
                response: of(responses, &self.responses),
                reference: of(references, &self.references),
            },
            rms: self.rms,
            noise_source: self.noise_source,
        }
    }
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

impl<T> Matrix<T> {
    /// The same as an array.
    pub fn view(&self) -> ArrayView2<'_, T> {
        let columns = self.values.len().checked_div(self.rows).unwrap_or(0);
        ArrayView2::from_shape((self.rows, columns).f(), &self.values)
            .expect("columns of this many rows")
    }
}

impl<T: Copy> Matrix<T> {
    pub fn array(&self) -> Array2<T> {
        self.view().to_owned()
    }
}

impl Poles {
    /// True where a pilot found them: the pass that they are for is still the first.
    pub(crate) fn is_of_pilot(&self) -> bool {
        self.pass == Pass::Pilot
    }

    /// Number of poles, those beside the band included.
    pub fn count(&self) -> usize {
        self.lambda().len()
    }

    /// In the x plane.
    fn lambda(&self) -> &[Complex64] {
        self.way.as_ref().map_or(&[], |way| &way.lambda)
    }

    /// Options of the first pass, to run the second with: band, seed, window, sketch, and
    /// the number of modes asked for.
    pub fn options(&self) -> FitOptions {
        let effort = Effort {
            sketch_columns: self.plan.columns,
            ..Effort::default()
        };
        FitOptions {
            band_hz: self.plan.band_hz,
            modes: self.modes,
            seed: self.plan.seed,
            window: self.plan.window(),
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
            .lambda()
            .iter()
            .map(|l| (l.re.max(0.0).sqrt() * hz, l.im / l.re))
            .collect();
        modes.retain(|mode| mode.0 >= first && mode.0 <= hz);
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes
    }

    /// The way in which they were found, in words.
    pub fn evidence(&self) -> String {
        let found = match self.way.as_ref().map(|way| &way.by) {
            Some(By::Fast { .. }) => "fast chain on the sketch".into(),
            Some(By::Measured { evidence, .. }) => format!("measured-data path: {evidence}"),
            Some(By::Conjugated) => "every resonance turns the wrong way".into(),
            Some(By::Delay(_)) => "a delay alone explains the data".into(),
            None => "not sought yet".to_owned(),
        };
        match (self.pass, &self.weighting) {
            (Pass::Anew, Some(_)) => format!("{found}; the next pass weighs FRFs by their noise"),
            (Pass::Anew, None) => format!("{found}; the next pass weighs all FRFs alike"),
            _ => found,
        }
    }

    /// Adds what else is known of the data, for those of these FRFs.
    pub(crate) fn tell(&self, layout: &mut DataLayout) {
        layout.weighting = self
            .weighting
            .as_ref()
            .map(|weights| weights.of(&layout.responses, &layout.references));
        layout.next_weights = self.next_weights;
        layout.dropped_hz.clone_from(&self.dropped_hz);
        layout.outlier_rounds = self.outlier_rounds;
        layout.warnings.clone_from(&self.warnings);
    }

    /// Lines and scale, without DOFs.
    pub(crate) fn layout(&self, effort: Effort) -> Result<DataLayout, FitError> {
        Ok(DataLayout {
            rms: self.rms,
            ..self.plan.layout(self.lines.clone(), effort)?
        })
    }
}
