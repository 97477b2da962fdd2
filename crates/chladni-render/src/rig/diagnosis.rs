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
use super::hypothesis::{Hypothesis, Place};
use super::swapped::{is_exchanged, Swap, Swapped};
use super::weighed::{variance, Cause, View, WeighedCause};
use crate::panel::interpolation::{Interpolation, Nodes};
use crate::panel::modal_field::ModalField;
use crate::panel::operator::Operator;
use crate::scene::plane::{Position, Rectangle};
use crate::tolerances;
use chladni_frf::{ModalModel, Result};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// All causes, the likeliest first; of those that can sit at several places the likeliest
/// place. Two swapped cables stand beside them.
///
/// * `nis`: of the field; nothing is swapped where the error bars explain it
///
/// # Errors
/// Those of the factorisations.
pub(crate) fn diagnose(
    model: &ModalModel,
    operator: &Operator,
    field: &LaidField,
    prediction: &Prediction,
    nis: f64,
) -> Result<(Vec<Hypothesis>, Option<Swapped>)> {
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
    causes.sort_by(|a, b| b.ln_evidence.total_cmp(&a.ln_evidence));
    let swap = match nis > tolerances::SWAP_NIS {
        true => Swap::likeliest(&view, operator, prediction)?,
        false => None,
    };
    let swapped = match swap {
        Some(swap) => swap.told(&view, prediction, causes[0].ln_evidence)?,
        None => None,
    };
    Ok((causes, swapped))
}

/// True where the field is likelier with the cables of two channels exchanged than as it is.
///
/// # Errors
/// Those of the factorisations.
pub(super) fn has_exchanged(
    model: &ModalModel,
    operator: &Operator,
    field: &LaidField,
    prediction: &Prediction,
    channels: [usize; 2],
) -> Result<bool> {
    let modal = ModalField::new(model, operator, &prediction.drive);
    let view = View::new(model, operator, field, prediction, &modal)?;
    is_exchanged(&view, prediction, channels)
}

impl View<'_> {
    /// Gain of all channels, of each, of one; dead and reversed ones.
    fn channels(&self, operator: &Operator, prediction: &Prediction) -> Result<Vec<Hypothesis>> {
        let sized = |kind: &str, place, found: &WeighedCause| Hypothesis {
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

    /// One natural frequency moved, or all by one factor; shifts that no panel has are left out.
    fn frequencies(&self, model: &ModalModel, modal: &ModalField) -> Result<Vec<Hypothesis>> {
        let numbers = modal.in_band(model);
        let slope = |n: usize| self.rows(&modal.slope(n));
        let weighed = |change: &Array1<Complex64>, alternatives: usize| -> Result<WeighedCause> {
            self.weigh(&Cause {
                columns: self.whitened(change.view())?.insert_axis(Axis(1)),
                prior: tolerances::FREQUENCY_ERROR.powi(2),
                alternatives,
            })
        };
        let cause = |kind: &str, place, found: WeighedCause| Hypothesis {
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
            let found = weighed(&change, numbers.len())?;
            if found.sizes[0].abs() <= tolerances::LARGEST_SHIFT {
                single.push(cause("mode", place, found));
            }
        }
        let mut causes = Vec::from_iter(likeliest(single));
        if numbers.len() > 1 {
            let found = weighed(&sum, 1)?;
            if found.sizes[0].abs() <= tolerances::LARGEST_SHIFT {
                causes.push(cause("modes", None, found));
            }
        }
        Ok(causes)
    }

    /// A load at the likeliest place of a grid over the responses, then of finer ones around
    /// it: a load is seen to a millimetre, and leaves much where it is looked for beside that.
    /// `None` where what is found feeds the panel.
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
        Ok(best.filter(takes_energy))
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
}

/// True for a load that takes energy from the panel, as everything does that rests on it; one
/// that gives some is a fault of another kind.
fn takes_energy(load: &Hypothesis) -> bool {
    let [re, im] = load.value.unwrap_or_default();
    let doubt = load.std.unwrap_or(0.0) + tolerances::LOAD_PASSIVE * re.hypot(im);
    re >= -doubt
}

/// Places of at most `step_m` over a rectangle.
fn grid(over: Rectangle, step_m: f64) -> Vec<Position> {
    let axis = |low: f64, high: f64| {
        let wanted = ((high - low) / step_m - tolerances::GRID_ROUNDING)
            .ceil()
            .max(1.0);
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
