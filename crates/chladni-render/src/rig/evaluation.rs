//! A measured field judged: its indices, its agreement with the prediction, what may be
//! the cause of the difference.

use super::agreement::{agreement, Agreement, Likeness};
use super::calibrated::Calibrated;
use super::field::{noise_assumed, LaidField, Prediction};
use super::lone_points::without_lone_points;
use super::prior::{design, prior_drift};
use crate::judging::indices::{AreaIndices, Indices, PointIndices};
use crate::panel::field::Field;
use crate::results::evaluate::{laid, Laid, On};
use crate::results::weights::Weights;
use crate::scene::drift::Drift;
use crate::scene::limits::Limits;
use crate::scene::scene_file::Scene;
use crate::scene::zones::ZoneMap;
use chladni_frf::{Finding, MeasuredField, ModalModel, Result};

/// Performance of a measured field, and what it says of the rig.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct FieldEvaluation {
    /// Indices of the measured field.
    pub indices: Indices,
    /// Agreement with the prediction, and the likeliest causes of what is left.
    pub agreement: Agreement,
    /// The measured field; where phases are unknown, with those of the prediction, and at
    /// points that the panel cannot have moved, with what the others tell.
    pub measured: Field,
    /// The prediction at the same responses.
    pub predicted: Field,
    /// The zones.
    pub zones: ZoneMap,
    /// Velocity limits.
    pub limits: Limits,
    /// Everything the user should know.
    pub findings: Vec<Finding>,
}

/// Scores the field that was measured while `weights` were played, against its prediction
/// by `model`.
///
/// * `sha256`: of the weights file, held against the field's own
///
/// # Errors
/// As [`crate::evaluate()`]; a field of another frequency, of other weights, with a
/// response that the model lacks, or without hot or cold responses.
pub fn evaluate_field(
    weights: &Weights,
    scene: &Scene,
    model: &ModalModel,
    field: &MeasuredField,
    sha256: Option<&str>,
) -> Result<FieldEvaluation> {
    let asked = scene;
    let Calibrated {
        model,
        scene,
        findings: of_rig,
    } = Calibrated::new(model, scene, Some(weights.frequency_hz), &Drift::default())?;
    let (model, scene) = (&*model, &*scene);
    let Laid {
        operator,
        drive,
        limits,
        zones,
        mut findings,
    } = laid(weights, scene, On::Model(model))?;
    findings.extend(of_rig);
    let laid_field = LaidField::new(field, &operator, sha256)?;
    let drift = prior_drift(asked, scene, Drift::default());
    let covariance = design(model, &operator, scene, &drift)?;
    let prediction = Prediction::of(&operator, &laid_field.rows, drive.clone());
    let mut sound = laid_field.clone();
    let all = &operator.responses;
    let lone = without_lone_points(&mut sound, &prediction.mobility, all)?;
    let phased = sound.phased(&prediction.velocity);
    let predicted = part(&Field::new(&operator, &zones, &drive), &laid_field.rows);
    let measured = Field {
        velocity_m_per_s: phased.to_vec(),
        ..predicted.clone()
    };
    let points = PointIndices::of_field(&measured, &zones, &limits, &drive, operator.unit)?;
    findings.extend(of_some(laid_field.rows.len(), operator.responses.len()));
    findings.extend(laid_field.noise_assumed.then(noise_assumed));
    findings.extend(lone);
    let likeness = Likeness::of(&prediction.velocity, &sound);
    let (agreement, swapped) = agreement(
        model,
        &operator,
        [&laid_field, &sound],
        (&prediction, covariance.deviation(&drive)),
        &likeness,
    )?;
    let is_explained = likeness.is_unlike() && explains_form(&agreement, swapped.as_ref());
    findings.extend(swapped);
    findings.splice(0..0, likeness.finding().filter(|_| !is_explained));
    // between few responses nothing is interpolated
    let area = (laid_field.rows.len() == operator.responses.len())
        .then(|| measured.area(&zones))
        .flatten()
        .map(|area| AreaIndices::of_area(&area, &zones, &limits));
    Ok(FieldEvaluation {
        indices: Indices { points, area },
        agreement,
        measured,
        predicted,
        zones,
        limits,
        findings,
    })
}

/// True where a fault of the rig explains a field that hardly has the form of its drive: swapped
/// cables, or one dead channel.
fn explains_form(agreement: &Agreement, swapped: Option<&Finding>) -> bool {
    let likeliest = agreement.hypotheses[0].kind.as_str();
    swapped.is_some() || !matches!(likeliest, "unexplained" | "channels")
}

/// The finding of a field that holds only so many responses.
fn of_some(held: usize, all: usize) -> Option<Finding> {
    let words = format!("the field holds {held} of the {all} responses; only these are judged");
    (held < all).then(|| Finding::note("field-of-some-responses", words))
}

/// The field at some of its responses.
fn part(field: &Field, rows: &[usize]) -> Field {
    Field {
        responses: rows.iter().map(|&k| field.responses[k]).collect(),
        positions_m: rows.iter().map(|&k| field.positions_m[k]).collect(),
        ground: rows.iter().map(|&k| field.ground[k]).collect(),
        velocity_m_per_s: rows.iter().map(|&k| field.velocity_m_per_s[k]).collect(),
    }
}
