//! The input of a report.

use chladni_frf::{Dof, Error, Finding, FrfKind, FrfSet, ModalModel, ReferenceUnit, Result};
use chladni_render::{
    AreaField, Evaluation, Field, FieldEvaluation, Indices, Limits, Played, Rendering, Weights,
    ZoneMap,
};
use num_complex::Complex64;

/// The input of a report; every part may be missing, and the report says so.
#[derive(Debug, Clone, Default)]
pub struct ReportInput<'a> {
    /// Title of the page.
    pub title: String,
    /// The modal model.
    pub model: Option<&'a ModalModel>,
    /// The model's file as the commands on the page name it, quoted for a shell; `None`:
    /// `model.json`.
    pub model_file: Option<String>,
    /// The FRFs it was fitted to; without them the report shows its synthesis alone.
    pub measured: Option<&'a FrfSet>,
    /// Scenes that were rendered, in order.
    pub scenes: Vec<RenderedScene<'a>>,
    /// Tables of `chladni bench`: speed against accuracy, scenes over modes and
    /// actuators.
    pub tables: Vec<Table>,
    /// Findings of the caller, for example that the measured file is missing.
    pub findings: Vec<Finding>,
}

/// A table of `chladni bench`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Name of its file, for example `accuracy.csv`.
    pub name: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Cells row by row.
    pub rows: Vec<Vec<String>>,
}

/// Weights for a scene, and the field that they make where it is known.
#[derive(Debug, Clone, Copy)]
pub struct RenderedScene<'a> {
    /// The weights.
    pub weights: &'a Weights,
    /// The field; `None` where it is not known, since weights files do not contain it.
    pub shown: Option<ShownField<'a>>,
    /// The same scene with fewer modes and with fewer actuators.
    pub curves: Option<&'a Curves>,
    /// The drive in time with pictures of the ground, where the scene has a table `[time]`.
    pub time: Option<&'a Played>,
}

/// Performance in a scene over the number of modes and of actuators; every point has
/// weights of its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// The method that made the weights of each point.
    pub method: String,
    /// Over the number of modes that are summed.
    pub modes: Vec<CurvePoint>,
    /// Over the number of actuators that are driven.
    pub actuators: Vec<CurvePoint>,
}

/// A point of [`Curves`]: shares of the judged responses that keep their limits in the
/// whole model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Number of modes or actuators.
    pub count: usize,
    /// Share of the hot responses.
    pub hot_ratio: f64,
    /// Share of the cold responses.
    pub cold_ratio: f64,
    /// Share of both.
    pub success_ratio: f64,
}

/// The field that weights make, with the demands of the scene.
#[derive(Debug, Clone, Copy)]
pub struct ShownField<'a> {
    /// The data that it was computed on, in words: `the model`, `panel.h5 at 300 Hz`.
    pub on: &'a str,
    /// Velocities at the responses.
    pub field: &'a Field,
    /// Velocities between them.
    pub area: Option<&'a AreaField>,
    /// Zones.
    pub zones: &'a ZoneMap,
    /// Velocity limits.
    pub limits: Limits,
    /// Indices of this field.
    pub indices: &'a Indices,
    /// Findings about this field, beside those of the weights.
    pub findings: &'a [Finding],
}

impl<'a> RenderedScene<'a> {
    /// A rendering, with its field in the model.
    pub fn of_rendering(rendering: &'a Rendering) -> Self {
        let shown = ShownField {
            on: "the model",
            field: &rendering.field,
            area: rendering.area.as_ref(),
            zones: &rendering.zones,
            limits: rendering.limits,
            indices: &rendering.weights.indices,
            findings: &[],
        };
        Self {
            shown: Some(shown),
            ..Self::of_weights(&rendering.weights)
        }
    }

    /// Weights and their field on other data; `on` names the data.
    pub fn of_evaluation(weights: &'a Weights, evaluation: &'a Evaluation, on: &'a str) -> Self {
        let shown = ShownField {
            on,
            field: &evaluation.field,
            area: evaluation.area.as_ref(),
            zones: &evaluation.zones,
            limits: evaluation.limits,
            indices: &evaluation.indices,
            findings: &evaluation.findings,
        };
        Self {
            shown: Some(shown),
            ..Self::of_weights(weights)
        }
    }

    /// Weights and the field that was measured under them, at the responses alone.
    pub fn of_measured(weights: &'a Weights, evaluation: &'a FieldEvaluation) -> Self {
        let shown = ShownField {
            on: "the measured field",
            field: &evaluation.measured,
            area: None,
            zones: &evaluation.zones,
            limits: evaluation.limits,
            indices: &evaluation.indices,
            findings: &evaluation.findings,
        };
        Self {
            shown: Some(shown),
            ..Self::of_weights(weights)
        }
    }

    /// Weights alone.
    pub fn of_weights(weights: &'a Weights) -> Self {
        Self {
            weights,
            shown: None,
            curves: None,
            time: None,
        }
    }

    /// The same with curves over the number of modes and actuators.
    pub fn with_curves(self, curves: Option<&'a Curves>) -> Self {
        Self { curves, ..self }
    }

    /// The same with the scene in time.
    pub fn with_time(self, time: Option<&'a Played>) -> Self {
        Self { time, ..self }
    }
}

/// Measured FRFs in the order and kind of a model.
#[derive(Debug, Clone)]
pub(crate) struct Measured<'a> {
    set: &'a FrfSet,
    /// Place in the set of each response of the model.
    responses: Vec<Option<InSet>>,
    /// Place in the set of each reference of the model.
    references: Vec<Option<InSet>>,
    /// Factor from the kind of the set to that of the model, per line.
    factors: Vec<Complex64>,
}

/// A DOF of a model in a set of FRFs.
#[derive(Debug, Clone, Copy)]
struct InSet {
    /// Index among the responses or references of the set.
    index: usize,
    /// 1 where both directions agree, −1 where they are opposite.
    sense: f64,
}

/// The places of the `wanted` DOFs among those of a set.
fn find(wanted: &[Dof], among: &[Dof]) -> Vec<Option<InSet>> {
    let place = |dof: &Dof| {
        let index = among.iter().position(|other| other.same_axis(*dof))?;
        let sense = dof.direction.sign() * among[index].direction.sign();
        Some(InSet { index, sense })
    };
    wanted.iter().map(place).collect()
}

impl<'a> Measured<'a> {
    /// Finds the model's DOFs in the set.
    ///
    /// # Errors
    /// Another reference unit, an unknown FRF kind, or no pair of the model in the set.
    pub(crate) fn new(set: &'a FrfSet, model: &ModalModel) -> Result<Self> {
        if set.reference_unit != model.reference_unit {
            return Err(Error::bad_data(
                "the measured FRFs and the model have different reference units",
            )
            .field("reference_unit")
            .found(set.reference_unit)
            .expected(model.reference_unit));
        }
        let kind = set.known_kind()?;
        let (responses, references) = (
            find(&model.responses, &set.responses),
            find(&model.references, &set.references),
        );
        if responses.iter().all(Option::is_none) || references.iter().all(Option::is_none) {
            return Err(Error::bad_data("the measured FRFs hold no DOF pair of the model")
                .field("measured FRFs")
                .found("none in common")
                .expected("the FRFs that the model was fitted to")
                .help("name with `measured` the file that the model names as its source, or leave \
                       `measured` out"));
        }
        let factor = |&f: &f64| {
            let omega = std::f64::consts::TAU * f;
            model.frf_kind.from_receptance(omega) / kind.from_receptance(omega)
        };
        Ok(Self {
            set,
            responses,
            references,
            factors: set.frequency_hz.iter().map(factor).collect(),
        })
    }

    /// A set without a model, in its own order and kind.
    pub(crate) fn alone(set: &'a FrfSet) -> Self {
        let own = |index| Some(InSet { index, sense: 1.0 });
        let all = |count: usize| (0..count).map(own).collect();
        Self {
            set,
            responses: all(set.responses.len()),
            references: all(set.references.len()),
            factors: vec![Complex64::new(1.0, 0.0); set.frequency_hz.len()],
        }
    }

    /// The value of a pair of the model on a line; NaN where it was not measured.
    pub(crate) fn value(&self, response: usize, reference: usize, line: usize) -> Complex64 {
        match (self.responses[response], self.references[reference]) {
            (Some(i), Some(j)) => {
                let value = self.set.values.get(i.index, j.index, line);
                value * self.factors[line] * (i.sense * j.sense)
            }
            _ => Complex64::new(f64::NAN, f64::NAN),
        }
    }

    /// True where the pair has a value on some line.
    pub(crate) fn has(&self, response: usize, reference: usize) -> bool {
        (0..self.factors.len()).any(|line| self.value(response, reference, line).is_finite())
    }
}

/// Kind and unit of the FRFs that a report shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantity {
    pub(crate) kind: Option<FrfKind>,
    pub(crate) reference_unit: ReferenceUnit,
}

impl Quantity {
    /// `Mobility`, or `FRF` where the kind is unknown.
    pub(crate) fn name(self) -> &'static str {
        match self.kind {
            Some(FrfKind::Receptance) => "Receptance",
            Some(FrfKind::Mobility) => "Mobility",
            Some(FrfKind::Accelerance) => "Accelerance",
            None => "FRF",
        }
    }

    /// `dB re 1 (m/s)/N`.
    pub(crate) fn level_unit(self) -> String {
        let per = self.reference_unit;
        match self.kind {
            Some(FrfKind::Receptance) => format!("dB re 1 m/{per}"),
            Some(FrfKind::Mobility) => format!("dB re 1 (m/s)/{per}"),
            Some(FrfKind::Accelerance) => format!("dB re 1 (m/s²)/{per}"),
            None => "dB re the file's unit".into(),
        }
    }
}
