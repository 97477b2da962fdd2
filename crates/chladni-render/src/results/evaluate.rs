//! Given weights on other data: the measured line at the drive frequency, or another
//! model.

use crate::digits::hertz;
use crate::judging::indices::{AreaIndices, Indices, PointIndices};
use crate::judging::shortcomings::strength;
use crate::panel::drive::Drive;
use crate::panel::field::{AreaField, Field};
use crate::panel::operator::Operator;
use crate::problems::setup::{drive_limits, lay_zones, scene_findings};
use crate::results::weights::Weights;
use crate::rig::{gain_of, Calibrated};
use crate::scene::drift::Drift;
use crate::scene::limits::Limits;
use crate::scene::scene_file::Scene;
use crate::scene::zones::ZoneMap;
use crate::tolerances;
use chladni_frf::{Dof, Error, Finding, FrfSet, ModalModel, Result};

/// The data that the weights are judged on.
#[derive(Debug, Clone, Copy)]
pub enum On<'a> {
    /// A modal model.
    Model(&'a ModalModel),
    /// Measured FRFs: their line nearest to the drive frequency.
    Frf(&'a FrfSet),
}

/// Performance of given weights on other data.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Evaluation {
    /// Frequency at which they were judged, Hz: the line's, where FRFs were given.
    pub frequency_hz: f64,
    /// Indices.
    pub indices: Indices,
    /// Velocities at the responses.
    pub field: Field,
    /// Velocities between them; `None` where they carry no area.
    pub area: Option<AreaField>,
    /// The zones, laid over the responses.
    pub zones: ZoneMap,
    /// Velocity limits.
    pub limits: Limits,
    /// Everything the user should know.
    pub findings: Vec<Finding>,
    /// The same of the other tones of the weights.
    pub other_tones: Vec<Evaluation>,
}

/// The indices of `weights` in `scene` on other data, tone by tone. Only reports: weights
/// that fail are no error.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`]: a driven actuator that the data lack, other
/// units, no line at the drive frequency, no hot or no cold response;
/// [`chladni_frf::ErrorKind::UnknownFrfKind`].
pub fn evaluate(weights: &Weights, scene: &Scene, on: On) -> Result<Evaluation> {
    let first = evaluate_tone(weights, scene, on)?;
    let other_tones = weights
        .other_tones
        .iter()
        .map(|tone| evaluate_tone(tone, scene, on))
        .collect::<Result<_>>()?;
    let mut all = Evaluation {
        other_tones,
        ..first
    };
    all.findings.extend(silent_tones(weights, scene));
    Ok(all)
}

/// The finding on tones of a scene that the weights, made for others of them, do not have.
fn silent_tones(weights: &Weights, scene: &Scene) -> Option<Finding> {
    let tones = scene.tones();
    let driven: Vec<f64> = weights
        .tones()
        .filter_map(|tone| Some(scene.tone_at(tone.frequency_hz)?.frequency_hz))
        .collect();
    let silent: Vec<&Scene> = tones
        .iter()
        .filter(|tone| !driven.contains(&tone.frequency_hz))
        .collect();
    if driven.is_empty() || silent.is_empty() {
        return None;
    }
    let silent: Vec<String> = silent.iter().map(|tone| hertz(tone.frequency_hz)).collect();
    let words = format!(
        "the scene has a tone at {} Hz for which there are no weights: it is not judged",
        silent.join(", ")
    );
    Some(Finding::caution("tone-without-drive", words).help("render the scene again"))
}

/// The finding on a drive that a scene does not allow, by the limits that it names or by
/// those that hold without a word.
fn beyond_limit(scene: &Scene, operator: &Operator, drive: &Drive) -> Option<Finding> {
    // limits in another unit are those of another model
    let (limits, _) = drive_limits(scene, operator.unit).ok()?;
    let times = limits.allowed_gain(drive).recip();
    let words = format!("the drive is {times:.3} times {}", limits.binding(drive));
    let help = match scene.actuators.names_limit() {
        true => "render the scene with this limit",
        false => {
            "render the scene again, or give the limit of the actuators as \
             actuators.max_force_n: the scene names none, and this one holds"
        }
    };
    (times > 1.0 + tolerances::AT_LIMIT).then(|| {
        Finding::caution("drive-beyond-limit", words)
            .value("times_limit", times)
            .help(help)
    })
}

/// The same of one tone.
fn evaluate_tone(weights: &Weights, scene: &Scene, on: On) -> Result<Evaluation> {
    let On::Model(model) = on else {
        return judged(weights, scene, on);
    };
    let at = Some(weights.frequency_hz);
    let Calibrated {
        model,
        scene,
        findings,
    } = Calibrated::new(model, scene, at, &Drift::default())?;
    let mut evaluation = judged(weights, &scene, On::Model(&model))?;
    evaluation.findings.extend(findings);
    Ok(evaluation)
}

/// The indices of one tone, calibrated or not.
fn judged(weights: &Weights, scene: &Scene, on: On) -> Result<Evaluation> {
    let Laid {
        operator,
        drive,
        limits,
        zones,
        mut findings,
    } = laid(weights, scene, on)?;
    let field = Field::new(&operator, &zones, &drive);
    let points = PointIndices::of_field(&field, &zones, &limits, &drive, operator.unit)?;
    let area = field.area(&zones);
    findings.extend(strength(&field, &limits));
    Ok(Evaluation {
        frequency_hz: operator.frequency_hz,
        indices: Indices {
            points,
            area: area
                .as_ref()
                .map(|area| AreaIndices::of_area(area, &zones, &limits)),
        },
        field,
        area,
        zones,
        limits,
        findings,
        other_tones: Vec::new(),
    })
}

/// Given weights and a scene, laid over other data.
pub(crate) struct Laid {
    pub(crate) operator: Operator,
    pub(crate) drive: Drive,
    pub(crate) limits: Limits,
    pub(crate) zones: ZoneMap,
    pub(crate) findings: Vec<Finding>,
}

/// Lays `weights` and `scene` over the data.
///
/// # Errors
/// As [`evaluate`].
pub(crate) fn laid(weights: &Weights, scene: &Scene, on: On) -> Result<Laid> {
    let frequency_hz = weights.frequency_hz;
    let (scene, other_frequency) = tone_at(scene, frequency_hz);
    let driven: Vec<Dof> = weights
        .weights
        .iter()
        .filter(|weight| weight.value().norm() > 0.0)
        .map(|weight| weight.reference)
        .collect();
    // Without a driven actuator any columns will do: the field is zero whatever they hold.
    let only = (!driven.is_empty()).then_some(driven.as_slice());
    let mut operator = match on {
        On::Model(model) => Operator::of_model(model, frequency_hz, only),
        On::Frf(frf) => Operator::of_line(frf, frequency_hz, only),
    }
    .map_err(rename_field)?;
    // what a calibration says of the channels holds for measured lines, too
    let columns = operator.mobility.columns_mut().into_iter();
    for (mut column, &reference) in columns.zip(&operator.references) {
        let gain = gain_of(&scene.actuators, reference, frequency_hz)?;
        column.mapv_inplace(|value| value * gain);
    }
    weights.check_unit(operator.unit)?;
    let drive = drive_on(&operator, weights);
    let limits = scene.limits()?;
    let zones = lay_zones(&scene, &operator);
    let mut findings = scene_findings(&scene, &operator, &zones);
    findings.extend(other_frequency);
    findings.extend(beyond_limit(&scene, &operator, &drive));
    Ok(Laid {
        operator,
        drive,
        limits,
        zones,
        findings,
    })
}

/// The tone of a scene at a frequency. Where the scene has none: the scene with that
/// frequency, and a finding that says so.
fn tone_at(scene: &Scene, frequency_hz: f64) -> (Scene, Option<Finding>) {
    if let Some(tone) = scene.tone_at(frequency_hz) {
        return (tone, None);
    }
    let tones = scene.tones();
    let asked: Vec<String> = tones.iter().map(|tone| hertz(tone.frequency_hz)).collect();
    let words = format!(
        "the weights are for {} Hz and are judged there, not at the scene's {} Hz",
        hertz(frequency_hz),
        asked.join(", ")
    );
    let there = Scene {
        frequency_hz,
        ..scene.clone()
    };
    (there, Some(Finding::caution("judged-elsewhere", words)))
}

/// The weights in the order of the operator's columns; a reference of the opposite sense
/// turns its weight round.
pub(crate) fn drive_on(operator: &Operator, weights: &Weights) -> Drive {
    weights.at(&operator.references).into()
}

/// Blames the weights, not the list of the scene, for an actuator that the data lack.
pub(crate) fn rename_field(mut error: Error) -> Error {
    if error.field.as_deref() == Some("actuators.use") {
        error.message = "the data lack an actuator that the weights drive".into();
        error.field = Some("weights".into());
        error.help = Some("render the scene again with this model or these data".into());
    }
    error
}
