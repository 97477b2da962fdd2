//! Possible faults of the rig, weighed by evidence.
//!
//! Under the null hypothesis the difference r = v − v̂ has the covariance S₀: noise, the
//! model's own error bars, and a small isotropic part. A cause with columns B and a prior D
//! of its size has the evidence
//!
//! ln BF = ½ bᵀ(BᵀS₀⁻¹B + D⁻¹)⁻¹b − ½ ln det(I + D BᵀS₀⁻¹B) − ln(alternatives),
//! b = BᵀS₀⁻¹r (theory.md, eq. 57),
//!
//! with complex values stacked as real ones. A dead or a reversed channel has no free size.

use super::field::{rms, LaidField, Prediction};
use super::swapped::Swap;
use crate::interpolation::{Interpolation, Nodes};
use crate::kernel_error::unsolvable;
use crate::modal_field::ModalField;
use crate::operator::Operator;
use crate::plane::{Position, Rectangle};
use crate::tolerances;
use chladni_frf::{Dof, Finding, ModalModel, Result};
use ndarray::{Array1, Array2, ArrayView1, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// A cause, where it sits, how large it is, and what speaks for it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Hypothesis {
    /// `nothing`, `gain`, `dead`, `reversed`, `channel`, `channels`, `mode`, `modes`, `load`
    /// or `unexplained`.
    pub kind: String,
    /// The channel, the mode's natural frequency in Hz, or the place in m.
    pub place: Option<Place>,
    /// Size, real and imaginary part: gain error of a channel or of all, relative shift of
    /// natural frequencies, impedance of a load in N·s/m, unexplained part of the field.
    pub value: Option<[f64; 2]>,
    /// Standard deviation of the size.
    pub std: Option<f64>,
    /// ln of the evidence over that of `nothing`.
    pub ln_evidence: f64,
}

/// The place of a cause.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Place {
    /// A channel.
    Channel(Dof),
    /// Natural frequency of a mode, Hz.
    Mode(f64),
    /// A place on the panel, m.
    Point(Position),
}

/// All causes, the likeliest first; of those that can sit at several places the likeliest
/// place. Two swapped cables are named by the finding beside them.
///
/// # Errors
/// Those of the factorisations.
pub(crate) fn diagnose(
    model: &ModalModel,
    operator: &Operator,
    field: &LaidField,
    prediction: &Prediction,
) -> Result<(Vec<Hypothesis>, Option<Finding>)> {
    let modal = ModalField::new(model, operator, &prediction.drive);
    let view = View::new(model, operator, field, prediction, &modal)?;
    let mut causes = vec![Hypothesis {
        kind: "nothing".into(),
        place: None,
        value: None,
        std: None,
        ln_evidence: 0.0,
    }];
    causes.extend(view.channels(operator, prediction)?);
    causes.extend(view.frequencies(model, &modal)?);
    causes.extend(view.load(operator, &modal)?);
    causes.push(view.unexplained()?);
    let swap = Swap::likeliest(&view, operator, prediction)?;
    let finding = swap.as_ref().and_then(|swap| swap.finding(&causes));
    if finding.is_some() {
        causes.extend(swap.as_ref().map(Swap::hypothesis));
    }
    causes.sort_by(|a, b| b.ln_evidence.total_cmp(&a.ln_evidence));
    Ok((causes, finding))
}

/// The difference between measurement and prediction, and how it is weighed.
pub(super) struct View<'a> {
    field: &'a LaidField,
    predicted: &'a Array1<Complex64>,
    /// Covariance of the difference; its diagonal alone counts for magnitudes.
    covariance: Array2<Complex64>,
    /// Cholesky factor of it.
    root: Array2<Complex64>,
    /// The difference, whitened.
    difference: Array1<f64>,
}

/// Prior variance of each part of a complex size with the standard deviation `std`.
fn variance(std: f64) -> f64 {
    0.5 * std * std
}

/// Columns with one prior, and the factor that counts their alternatives.
struct Cause {
    /// Whitened columns.
    columns: Array2<f64>,
    /// Prior variance of each size.
    prior: f64,
    alternatives: usize,
}

/// Sizes of a cause and the evidence for it.
struct Found {
    sizes: Array1<f64>,
    std: f64,
    ln_evidence: f64,
}

impl<'a> View<'a> {
    fn new(
        model: &ModalModel,
        operator: &Operator,
        field: &'a LaidField,
        prediction: &'a Prediction,
        modal: &ModalField,
    ) -> Result<Self> {
        let predicted = &prediction.velocity;
        let covariance = covariance(model, operator, field, predicted, modal);
        let root = chladni_linalg::cholesky(covariance.view()).map_err(unsolvable)?;
        let mut view = Self {
            field,
            predicted,
            covariance,
            root,
            difference: Array1::zeros(0),
        };
        view.difference = view.against(predicted)?;
        Ok(view)
    }

    /// The measured field less `foretold`, whitened.
    fn against(&self, foretold: &Array1<Complex64>) -> Result<Array1<f64>> {
        if !self.field.magnitudes_only {
            return self.whitened((&self.field.velocity - foretold).view());
        }
        let pairs = self.field.velocity.iter().zip(foretold).enumerate();
        Ok(pairs
            .map(|(k, (measured, foretold))| (measured.norm() - foretold.norm()) / self.bar(k))
            .collect())
    }

    /// Standard deviation of a magnitude.
    fn bar(&self, k: usize) -> f64 {
        self.covariance[[k, k]].re.sqrt()
    }

    /// A change of the field as real numbers of unit variance; of magnitudes, its part along
    /// the predicted phase.
    fn whitened(&self, change: ArrayView1<Complex64>) -> Result<Array1<f64>> {
        if self.field.magnitudes_only {
            let along = |(k, change): (usize, &Complex64)| {
                let predicted = self.predicted[k];
                let size = predicted.norm().max(f64::MIN_POSITIVE);
                (predicted.conj() * change).re / size / self.bar(k)
            };
            return Ok(change.iter().enumerate().map(along).collect());
        }
        let column = change.insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(self.root.view(), column).map_err(unsolvable)?;
        let parts = white.iter().map(|v| v.re).chain(white.iter().map(|v| v.im));
        Ok(parts.map(|part| part * std::f64::consts::SQRT_2).collect())
    }

    /// Columns of complex sizes: each change, and the same turned by a quarter.
    fn complex_columns(&self, changes: &[Array1<Complex64>]) -> Result<Array2<f64>> {
        let mut columns = Array2::zeros((self.difference.len(), 2 * changes.len()));
        for (number, change) in changes.iter().enumerate() {
            columns
                .column_mut(2 * number)
                .assign(&self.whitened(change.view())?);
            let turned = change.mapv(|value| value * Complex64::I);
            columns
                .column_mut(2 * number + 1)
                .assign(&self.whitened(turned.view())?);
        }
        Ok(columns)
    }

    fn weigh(&self, cause: &Cause) -> Result<Found> {
        self.weigh_of(cause, &self.difference)
    }

    /// The same of another difference.
    fn weigh_of(&self, cause: &Cause, difference: &Array1<f64>) -> Result<Found> {
        let b = cause.columns.t().dot(difference);
        let mut normal = cause.columns.t().dot(&cause.columns);
        normal
            .diag_mut()
            .mapv_inplace(|value| value + 1.0 / cause.prior);
        let inverse = chladni_linalg::inverse_hermitian(normal.view()).map_err(unsolvable)?;
        let root = chladni_linalg::cholesky(normal.view()).map_err(unsolvable)?;
        let ln_det = 2.0 * root.diag().iter().map(|value| value.ln()).sum::<f64>();
        let sizes = inverse.dot(&b);
        let ln_prior = cause.prior.ln() * b.len() as f64;
        Ok(Found {
            ln_evidence: 0.5 * (b.dot(&sizes) - ln_det - ln_prior)
                - (cause.alternatives as f64).ln(),
            std: inverse.diag().sum().sqrt(),
            sizes,
        })
    }

    /// Evidence of a change without free size.
    pub(super) fn fixed(&self, change: &Array1<Complex64>, alternatives: usize) -> Result<f64> {
        let changed = self.against(&(self.predicted + change))?;
        Ok(
            0.5 * (self.difference.dot(&self.difference) - changed.dot(&changed))
                - (alternatives as f64).ln(),
        )
    }

    /// Evidence of gains that scatter beside a change without free size, after which each
    /// channel moves the field by its path.
    pub(super) fn fixed_and_scattered(
        &self,
        change: &Array1<Complex64>,
        paths: &[Array1<Complex64>],
        alternatives: usize,
    ) -> Result<f64> {
        let changed = self.against(&(self.predicted + change))?;
        let scattered = self.weigh_of(&self.scattered(paths)?, &changed)?;
        Ok(self.fixed(change, alternatives)? + scattered.ln_evidence)
    }

    /// Gains of all channels, each by itself.
    fn scattered(&self, paths: &[Array1<Complex64>]) -> Result<Cause> {
        Ok(Cause {
            columns: self.complex_columns(paths)?,
            prior: variance(tolerances::CHANNEL_GAIN_ERROR),
            alternatives: 1,
        })
    }

    /// True where only magnitudes were measured.
    pub(super) fn magnitudes_only(&self) -> bool {
        self.field.magnitudes_only
    }

    /// Gain of all channels, of each, of one; dead and reversed ones.
    fn channels(&self, operator: &Operator, prediction: &Prediction) -> Result<Vec<Hypothesis>> {
        let sized = |kind: &str, place, found: &Found| Hypothesis {
            kind: kind.into(),
            place,
            value: (found.sizes.len() == 2).then(|| [found.sizes[0], found.sizes[1]]),
            std: Some(found.std),
            ln_evidence: found.ln_evidence,
        };
        let count = operator.references.len();
        let all = self.weigh(&Cause {
            columns: self.complex_columns(std::slice::from_ref(self.predicted))?,
            prior: variance(tolerances::GLOBAL_GAIN_ERROR),
            alternatives: 1,
        })?;
        let mut causes = vec![sized("gain", None, &all)];
        let paths = prediction.paths(&prediction.drive);
        let each = self.weigh(&self.scattered(&paths)?)?;
        let spread = (each.sizes.dot(&each.sizes) / count as f64).sqrt();
        causes.push(Hypothesis {
            value: Some([spread, 0.0]),
            std: Some(each.std / (count as f64).sqrt()),
            ..sized("channels", None, &each)
        });
        let mut singles: [Vec<Hypothesis>; 3] = Default::default();
        for (i, path) in paths.iter().enumerate() {
            let place = Some(Place::Channel(operator.references[i]));
            for (which, (kind, factor)) in [("dead", -1.0), ("reversed", -2.0)].iter().enumerate() {
                singles[which].push(Hypothesis {
                    kind: (*kind).into(),
                    place,
                    value: Some([*factor, 0.0]),
                    std: None,
                    ln_evidence: self.fixed(&path.mapv(|value| value * *factor), count)?,
                });
            }
            let odd = self.weigh(&Cause {
                columns: self.complex_columns(std::slice::from_ref(path))?,
                prior: variance(tolerances::ODD_GAIN_ERROR),
                alternatives: count,
            })?;
            singles[2].push(sized("channel", place, &odd));
        }
        causes.extend(singles.into_iter().filter_map(likeliest));
        Ok(causes)
    }

    /// One natural frequency moved, or all by one factor.
    fn frequencies(&self, model: &ModalModel, modal: &ModalField) -> Result<Vec<Hypothesis>> {
        let numbers = modal.in_band(model);
        let slope = |n: usize| self.rows(&modal.slope(n));
        let weighed = |change: &Array1<Complex64>, alternatives: usize| -> Result<Found> {
            self.weigh(&Cause {
                columns: self.whitened(change.view())?.insert_axis(Axis(1)),
                prior: tolerances::FREQUENCY_ERROR.powi(2),
                alternatives,
            })
        };
        let cause = |kind: &str, place, found: Found| Hypothesis {
            kind: kind.into(),
            place,
            value: Some([found.sizes[0], 0.0]),
            std: Some(found.std),
            ln_evidence: found.ln_evidence,
        };
        let mut sum = Array1::zeros(self.predicted.len());
        let mut single = Vec::new();
        for &(n, frequency_hz) in &numbers {
            let change = slope(n);
            sum += &change;
            let place = Some(Place::Mode(frequency_hz));
            single.push(cause("mode", place, weighed(&change, numbers.len())?));
        }
        let mut causes = Vec::from_iter(likeliest(single));
        if numbers.len() > 1 {
            causes.push(cause("modes", None, weighed(&sum, 1)?));
        }
        Ok(causes)
    }

    /// A load at the likeliest place of a grid over the responses, then of finer ones around
    /// it: a load is seen to a millimetre, and leaves much where it is looked for beside that.
    fn load(&self, operator: &Operator, modal: &ModalField) -> Result<Option<Hypothesis>> {
        let (Some(nodes), Some(around)) = (
            Nodes::new(&operator.positions_m),
            Rectangle::around(&operator.positions_m),
        ) else {
            return Ok(None);
        };
        let between = modal.between_responses();
        let mut step_m = tolerances::LOAD_GRID_M;
        let mut places = grid(around, step_m);
        let mut alternatives = places.len();
        let mut best: Option<Hypothesis> = None;
        for _ in 0..tolerances::LOAD_GRIDS {
            let Some(onto) = nodes.onto(&places) else {
                return Ok(None);
            };
            let found = self.load_at(&places, &onto, modal, &between, alternatives)?;
            best = likeliest(best.into_iter().chain(found).collect());
            let Some(Place::Point([x, y])) = best.as_ref().and_then(|best| best.place) else {
                return Ok(best);
            };
            let near = Rectangle {
                x_min: around.x_min.max(x - step_m),
                y_min: around.y_min.max(y - step_m),
                x_max: around.x_max.min(x + step_m),
                y_max: around.y_max.min(y + step_m),
            };
            step_m /= tolerances::LOAD_FINER;
            places = grid(near, step_m);
            alternatives += places.len();
        }
        Ok(best)
    }

    /// The likeliest of loads at `places`.
    fn load_at(
        &self,
        places: &[Position],
        onto: &Interpolation,
        modal: &ModalField,
        between: &Array2<Complex64>,
        alternatives: usize,
    ) -> Result<Option<Hypothesis>> {
        let from_places = onto.apply(between.view());
        let under = onto.apply(from_places.t());
        let free = onto.apply(modal.free.view().insert_axis(Axis(1)));
        let mut causes = Vec::with_capacity(places.len());
        for (x, place) in places.iter().enumerate() {
            let push = from_places.row(x).mapv(|value| -value * free[[x, 0]]);
            let found = self.weigh(&Cause {
                columns: self.complex_columns(&[self.rows(&push)])?,
                prior: 0.5 * tolerances::LOAD_IMPEDANCE.powi(2),
                alternatives,
            })?;
            let effective = Complex64::new(found.sizes[0], found.sizes[1]);
            // F = Z·v_x with v_x = v̂_x − Y_xx·F
            let slope = (1.0 - under[[x, x]] * effective).inv();
            let impedance = effective * slope;
            causes.push(Hypothesis {
                kind: "load".into(),
                place: Some(Place::Point(*place)),
                value: Some([impedance.re, impedance.im]).filter(|_| impedance.is_finite()),
                std: Some(found.std * slope.norm_sqr()).filter(|std| std.is_finite()),
                ln_evidence: found.ln_evidence,
            });
        }
        Ok(likeliest(causes))
    }

    /// An isotropic error of unknown origin.
    fn unexplained(&self) -> Result<Hypothesis> {
        let size = rms(self.predicted);
        let own = self.ln_likelihood(0.0)?;
        let mut best = Hypothesis {
            kind: "unexplained".into(),
            place: None,
            value: None,
            std: None,
            ln_evidence: f64::NEG_INFINITY,
        };
        let alternatives = (tolerances::UNEXPLAINED.len() as f64).ln();
        for share in tolerances::UNEXPLAINED {
            let ln_evidence = self.ln_likelihood((share * size).powi(2))? - own - alternatives;
            if ln_evidence > best.ln_evidence {
                (best.ln_evidence, best.value) = (ln_evidence, Some([share, 0.0]));
            }
        }
        Ok(best)
    }

    /// ln of the likelihood with `variance` added at each response, to a constant.
    fn ln_likelihood(&self, variance: f64) -> Result<f64> {
        if self.field.magnitudes_only {
            let of = |k: usize| {
                let before = self.covariance[[k, k]].re;
                let after = before + 0.5 * variance;
                -0.5 * (self.difference[k].powi(2) * before / after + after.ln())
            };
            return Ok((0..self.difference.len()).map(of).sum());
        }
        let mut covariance = self.covariance.clone();
        covariance.diag_mut().mapv_inplace(|value| value + variance);
        let root = chladni_linalg::cholesky(covariance.view()).map_err(unsolvable)?;
        let difference = (&self.field.velocity - self.predicted).insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), difference.view());
        let white = white.map_err(unsolvable)?;
        let ln_det = 2.0 * root.diag().iter().map(|value| value.re.ln()).sum::<f64>();
        Ok(-white.iter().map(Complex64::norm_sqr).sum::<f64>() - ln_det)
    }

    /// The measured rows of a field at all responses.
    fn rows(&self, field: &Array1<Complex64>) -> Array1<Complex64> {
        field.select(Axis(0), &self.field.rows)
    }
}

/// S₀; for magnitudes the variances along the phase.
fn covariance(
    model: &ModalModel,
    operator: &Operator,
    field: &LaidField,
    predicted: &Array1<Complex64>,
    modal: &ModalField,
) -> Array2<Complex64> {
    let mut of_model = Array2::<Complex64>::zeros((predicted.len(), predicted.len()));
    for (number, frequency_hz) in modal.in_band(model) {
        let mode = modal.mode(number);
        // ∂v/∂η is j/2 of ∂v/∂ln ω: one column carries both deviations
        let std = (mode.frequency_std_hz / frequency_hz).hypot(0.5 * mode.loss_factor_std);
        if std > 0.0 {
            let slope = modal.slope(number).select(Axis(0), &field.rows);
            let column = slope.insert_axis(Axis(1)).mapv(|value| value * std);
            of_model += &column.dot(&column.t().mapv(|value| value.conj()));
        }
        let part = modal.part_of(number);
        for (k, &row) in field.rows.iter().enumerate() {
            let response = operator.response_rows[row];
            let shape = mode.shape.0[response].norm();
            if shape > 0.0 {
                let error = part[row].norm() * mode.shape_std_at_known_scale(response) / shape;
                of_model[[k, k]] += error * error;
            }
        }
    }
    let isotropic = (tolerances::ISOTROPIC_FIELD_ERROR * rms(predicted)).powi(2);
    of_model.diag_mut().mapv_inplace(|value| value + isotropic);
    if field.magnitudes_only {
        of_model.mapv_inplace(|value| value * 0.5);
    }
    for (value, std) in of_model.diag_mut().iter_mut().zip(&field.std) {
        *value += std * std;
    }
    of_model
}

/// Places of at most `step_m` over a rectangle.
fn grid(over: Rectangle, step_m: f64) -> Vec<Position> {
    let axis = |low: f64, high: f64| {
        let wanted = ((high - low) / step_m - 1e-9).ceil().max(1.0);
        let steps = wanted.min(tolerances::LOAD_GRID_MOST as f64) as usize;
        (0..=steps).map(move |k| low + (high - low) * k as f64 / steps as f64)
    };
    axis(over.y_min, over.y_max)
        .flat_map(|y| axis(over.x_min, over.x_max).map(move |x| [x, y]))
        .collect()
}

fn likeliest(causes: Vec<Hypothesis>) -> Option<Hypothesis> {
    causes
        .into_iter()
        .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))
}
