//! Measured FRFs compared with their synthesis: the frequency axis, sums over all FRFs, and the
//! pairs to show.

use crate::input::{Measured, Quantity, ReportInput};
use crate::sizes;
use crate::text::fixed;
use chladni_frf::{ComplexMatrix, ComplexVector, Dof, ModalModel, Result};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// The data of the FRF figures.
pub(crate) struct Comparison<'a> {
    pub(crate) model: Option<&'a ModalModel>,
    pub(crate) measured: Option<Measured<'a>>,
    pub(crate) quantity: Quantity,
    pub(crate) frequency_hz: Array1<f64>,
    pub(crate) responses: &'a [Dof],
    pub(crate) references: &'a [Dof],
}

/// Root mean square over all FRFs, per line.
pub(crate) struct Sums {
    pub(crate) measured: Option<Vec<f64>>,
    pub(crate) synthesis: Option<Vec<f64>>,
    pub(crate) difference: Option<Vec<f64>>,
    /// Rms difference over rms measured value of each pair in the band, axes (response,
    /// reference); NaN where not measured.
    pub(crate) error: Option<Array2<f64>>,
}

/// A pair of DOFs, and the reason for showing it.
pub(crate) struct Pair {
    pub(crate) response: usize,
    pub(crate) reference: usize,
    /// Names of both DOFs: `12:+Z / 105:+Z`.
    pub(crate) label: String,
    pub(crate) why: String,
}

impl<'a> Comparison<'a> {
    /// `None` where there is neither a model nor a measurement.
    ///
    /// # Errors
    /// See [`Measured::new`].
    pub(crate) fn new(input: &ReportInput<'a>) -> Result<Option<Self>> {
        let measured = match (input.measured, input.model) {
            (Some(set), Some(model)) => Some(Measured::new(set, model)?),
            (Some(set), None) => Some(Measured::alone(set)),
            (None, _) => None,
        };
        let frequency_hz = match (input.measured, input.model) {
            (Some(set), _) => set.frequency_hz.clone(),
            (None, Some(model)) => synthesis_lines(model),
            (None, None) => return Ok(None),
        };
        let (quantity, responses, references): (_, &[Dof], &[Dof]) =
            match (input.model, input.measured) {
                (Some(model), _) => (
                    Quantity {
                        kind: Some(model.frf_kind),
                        reference_unit: model.reference_unit,
                    },
                    &model.responses,
                    &model.references,
                ),
                (None, Some(set)) => (
                    Quantity {
                        kind: set.kind,
                        reference_unit: set.reference_unit,
                    },
                    &set.responses,
                    &set.references,
                ),
                (None, None) => return Ok(None),
            };
        Ok(Some(Self {
            model: input.model,
            measured,
            quantity,
            frequency_hz,
            responses,
            references,
        }))
    }

    /// Number of pairs.
    pub(crate) fn pair_count(&self) -> usize {
        self.responses.len() * self.references.len()
    }

    /// Sums over all FRFs.
    pub(crate) fn sums(&self) -> Sums {
        let (responses, references) = (self.responses.len(), self.references.len());
        let (mut measured, mut synthesis, mut difference) = (Vec::new(), Vec::new(), Vec::new());
        let (mut data, mut error) = (
            Array2::<f64>::zeros((responses, references)),
            Array2::<f64>::zeros((responses, references)),
        );
        for (k, &f) in self.frequency_hz.iter().enumerate() {
            let matrix = self.model.map(|model| model.frf_matrix(model.frf_kind, f));
            let in_band = self
                .model
                .is_some_and(|model| (model.band_hz[0]..=model.band_hz[1]).contains(&f));
            let (mut m, mut s, mut d) = (Mean::default(), Mean::default(), Mean::default());
            for i in 0..responses {
                for j in 0..references {
                    let synthesised = matrix
                        .as_ref()
                        .map_or(Complex64::new(f64::NAN, f64::NAN), |matrix| matrix[[i, j]]);
                    let value = self
                        .measured
                        .as_ref()
                        .map_or(Complex64::new(f64::NAN, f64::NAN), |measured| {
                            measured.value(i, j, k)
                        });
                    s.add(synthesised);
                    m.add(value);
                    d.add(value - synthesised);
                    if in_band && value.is_finite() && synthesised.is_finite() {
                        data[[i, j]] += value.norm_sqr();
                        error[[i, j]] += (value - synthesised).norm_sqr();
                    }
                }
            }
            measured.push(m.root());
            synthesis.push(s.root());
            difference.push(d.root());
        }
        let both = self.model.is_some() && self.measured.is_some();
        Sums {
            measured: self.measured.is_some().then_some(measured),
            synthesis: self.model.is_some().then_some(synthesis),
            difference: both.then_some(difference),
            error: both.then(|| (error / data).mapv(f64::sqrt)),
        }
    }

    /// Rms difference over rms measured value of all FRFs in the band of the model; `None` where
    /// nothing is measured there.
    pub(crate) fn left_in_band(&self) -> Option<f64> {
        let [low_hz, high_hz] = self.model?.band_hz;
        let Sums {
            measured,
            difference,
            ..
        } = self.sums();
        let (measured, difference) = (measured?, difference?);
        let power = |sums: &[f64]| -> f64 {
            let lines = self.frequency_hz.iter().zip(sums);
            lines
                .filter(|(f, root)| (low_hz..=high_hz).contains(*f) && root.is_finite())
                .map(|(_, root)| root.powi(2))
                .sum()
        };
        let left = (power(&difference) / power(&measured)).sqrt();
        left.is_finite().then_some(left)
    }

    fn pair(&self, at: (usize, usize), why: &str, sums: &Sums) -> Pair {
        let (response, reference) = at;
        let error = sums
            .error
            .as_ref()
            .map_or(f64::NAN, |error| error[[response, reference]]);
        let error = if error.is_finite() {
            format!(", difference {} %", fixed(100.0 * error, 2))
        } else {
            String::new()
        };
        Pair {
            response,
            reference,
            label: format!(
                "{} / {}",
                self.responses[response], self.references[reference]
            ),
            why: format!("{why}{error}"),
        }
    }

    /// The pairs to show: worst, middle and best agreement, driving points, and pairs
    /// spread over the panel.
    pub(crate) fn pairs(&self, sums: &Sums) -> Vec<Pair> {
        let mut pairs: Vec<Pair> = Vec::new();
        let mut push = |(response, reference): (usize, usize), why: &str| {
            let known = pairs
                .iter()
                .any(|pair| (pair.response, pair.reference) == (response, reference));
            let measured = self
                .measured
                .as_ref()
                .is_none_or(|measured| measured.has(response, reference));
            if known || !measured || pairs.len() >= sizes::PAIRS {
                return false;
            }
            pairs.push(self.pair((response, reference), why, sums));
            true
        };
        if let Some(error) = &sums.error {
            let order = from_worst_to_best(error);
            if let (Some(worst), Some(best)) = (order.first(), order.last()) {
                push(*worst, "worst agreement");
                push(order[order.len() / 2], "middle agreement");
                push(*best, "best agreement");
            }
        }
        let mut driving = 0;
        for (i, response) in self.responses.iter().enumerate() {
            let reference = self
                .references
                .iter()
                .position(|reference| reference.same_axis(*response));
            if driving < sizes::DRIVING_POINTS {
                driving += usize::from(reference.is_some_and(|j| push((i, j), "driving point")));
            }
        }
        let (rows, columns) = (self.responses.len(), self.references.len());
        for k in 0..4 * sizes::PAIRS {
            // multiples of these numbers, modulo 1, are spread evenly over a square
            let part = |step: f64| (0.5 + step * k as f64).fract();
            let at = (
                (part(0.618_034) * rows as f64) as usize,
                (part(0.754_878) * columns as f64) as usize,
            );
            if at.0 < rows && at.1 < columns {
                push(at, "spread over the panel");
            }
        }
        pairs
    }

    /// Measured and synthesised FRF of a pair.
    pub(crate) fn curves(&self, pair: &Pair) -> [Option<Vec<Complex64>>; 2] {
        let lines = self.frequency_hz.len();
        let measured = self.measured.as_ref().map(|m| {
            (0..lines)
                .map(|k| m.value(pair.response, pair.reference, k))
                .collect()
        });
        let synthesis = self.model.map(|model| {
            let single = single_pair(model, pair.response, pair.reference);
            self.frequency_hz
                .iter()
                .map(|&f| single.frf_matrix(single.frf_kind, f)[[0, 0]])
                .collect()
        });
        [measured, synthesis]
    }
}

/// The model of one FRF.
fn single_pair(model: &ModalModel, response: usize, reference: usize) -> ModalModel {
    let mut single = ModalModel {
        modes: Vec::new(),
        nodes: Vec::new(),
        ..model.clone()
    };
    single.responses = vec![model.responses[response]];
    single.references = vec![model.references[reference]];
    for mode in &model.modes {
        let mut mode = mode.clone();
        mode.shape = ComplexVector(vec![mode.shape.0[response]]);
        mode.participation = ComplexVector(vec![mode.participation.0[reference]]);
        single.modes.push(mode);
    }
    for term in &mut single.residual_terms.terms {
        term.matrix = ComplexMatrix(Array2::from_elem(
            (1, 1),
            term.matrix.0[[response, reference]],
        ));
    }
    single
}

/// Pairs (response, reference) with a known difference, the largest first.
fn from_worst_to_best(error: &Array2<f64>) -> Vec<(usize, usize)> {
    let mut order: Vec<((usize, usize), f64)> = error
        .indexed_iter()
        .map(|(at, &e)| (at, e))
        .filter(|(_, e)| e.is_finite())
        .collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    order.into_iter().map(|(at, _)| at).collect()
}

/// Evenly spaced lines over the band, and additional ones around each natural frequency, Hz.
fn synthesis_lines(model: &ModalModel) -> Array1<f64> {
    let [low, high] = model.band_hz;
    let step = (high - low) / sizes::SYNTHESIS_LINES as f64;
    let mut lines: Vec<f64> = (0..=sizes::SYNTHESIS_LINES)
        .map(|k| low + step * k as f64)
        .collect();
    for mode in model.in_band_modes() {
        lines.extend(
            (-12..=12).map(|k| mode.frequency_hz * (1.0 + mode.loss_factor * f64::from(k) / 4.0)),
        );
    }
    lines.retain(|f| (low..=high).contains(f) && *f > 0.0);
    lines.sort_by(f64::total_cmp);
    lines.dedup();
    lines.into()
}

/// Sum of squares, and number, of finite values.
#[derive(Default)]
struct Mean {
    sum: f64,
    count: usize,
}

impl Mean {
    fn add(&mut self, value: Complex64) {
        if value.is_finite() {
            self.sum += value.norm_sqr();
            self.count += 1;
        }
    }
    /// Root mean square; NaN without values.
    fn root(&self) -> f64 {
        (self.sum / self.count as f64).sqrt()
    }
}
