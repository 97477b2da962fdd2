//! A rig that differs from the model: the strongest actuator of the first scene is dead.
//! The field is measured, the dead actuator is named and the weights are corrected, as by
//! `chladni evaluate --field` and `chladni correct`.

use super::files::Files;
use crate::correct::corrected;
use crate::field_words::sentence;
use crate::limits::{SCANNER_SEED, SCANNER_SNR_DB};
use crate::render::write_weights;
use crate::scanned::{scanned, ScannerNoise};
use chladni_console::output::{Output, TABLE, WEIGHTS};
use chladni_console::Console;
use chladni_frf::{Dof, Error, ErrorKind, MeasuredField, ModalModel, Result};
use chladni_io::{field_csv, sha256_of};
use chladni_render::{evaluate, evaluate_field, FieldEvaluation, On, PlayedField, Scene, Weights};
use chladni_report::RenderedScene;
use serde_json::{json, Value};

/// The first scene on the rig with a dead actuator.
pub(super) struct OnRig {
    dead: Dof,
    /// The rendered weights.
    before: Measured,
    /// The weights that the field of `before` corrected.
    after: Measured,
}

/// Weights and the field that was measured while they were played.
struct Measured {
    weights: Weights,
    field: FieldEvaluation,
}

/// Plays `played`, the weights of the first scene, on the rig. Corrects them by their field
/// and plays the corrected weights.
///
/// # Errors
/// Those of writing; anything else is a bug.
pub(super) fn on_rig(
    files: &Files,
    model: &ModalModel,
    truth: &ModalModel,
    played: &Weights,
    console: &Console,
) -> Result<OnRig> {
    console.stage("an actuator dies");
    let scene = Scene::read(&files.scenes[0])?;
    let size = |k: &usize| played.weights[*k].amplitude;
    let dead = (0..played.weights.len())
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .ok_or_else(|| Error::new(ErrorKind::Internal, "weights without actuators"))?;
    let sha256 = sha256_of(&files.weights[0])?;
    let field = measured(played, dead, truth, &scene, sha256.clone())?;
    Output::new(&files.field, TABLE, &[], console)?.write_bytes(field_csv(&field))?;
    let before = evaluate_field(played, &scene, model, &field, Some(&sha256))?;
    let inputs = [
        &files.model,
        &files.scenes[0],
        &files.weights[0],
        &files.field,
    ]
    .map(Clone::clone);
    let pair = PlayedField {
        weights: played.clone(),
        field,
        weights_sha256: Some(sha256),
    };
    let (weights, _) = corrected(model, &scene, &[pair], &inputs)?;
    write_weights(
        &Output::new(&files.corrected, WEIGHTS, &[], console)?,
        &weights,
    )?;
    let again = measured(&weights, dead, truth, &scene, sha256_of(&files.corrected)?)?;
    let after = evaluate_field(&weights, &scene, model, &again, None)?;
    let named = |weights: &Weights, what: String| Weights {
        scene: format!("{}, {what}", played.scene),
        ..weights.clone()
    };
    let dead = played.weights[dead].reference;
    Ok(OnRig {
        before: Measured {
            weights: named(played, format!("actuator {dead} dead")),
            field: before,
        },
        after: Measured {
            weights: named(&weights, "corrected".into()),
            field: after,
        },
        dead,
    })
}

/// The field of `weights` on the true panel without the actuator `dead`.
fn measured(
    weights: &Weights,
    dead: usize,
    truth: &ModalModel,
    scene: &Scene,
    weights_sha256: String,
) -> Result<MeasuredField> {
    let mut rig = weights.clone();
    let silent = &mut rig.weights[dead];
    (silent.re, silent.im, silent.amplitude, silent.phase_deg) = (0.0, 0.0, 0.0, 0.0);
    let field = evaluate(&rig, scene, On::Model(truth))?.field;
    let velocities = field.velocity_m_per_s.iter().copied();
    let velocities: Vec<_> = field.responses.into_iter().zip(velocities).collect();
    let noise = ScannerNoise {
        snr_db: SCANNER_SNR_DB,
        seed: SCANNER_SEED,
    };
    scanned(&velocities, weights.frequency_hz, weights_sha256, noise)
}

impl OnRig {
    /// Both fields, for the report.
    pub(super) fn shown(&self) -> [RenderedScene<'_>; 2] {
        [&self.before, &self.after]
            .map(|shown| RenderedScene::of_measured(&shown.weights, &shown.field))
    }

    /// The verdict on the measured field, and the shares after the correction.
    pub(super) fn text(&self) -> String {
        let points = &self.after.field.indices.points;
        let percent = |ratio: f64| format!("{:.0} %", 100.0 * ratio);
        format!(
            "Scene 1 where actuator {} is dead:\n{}\nCorrected by that field: {} of hot points \
             felt, {} of cold ones quiet.",
            self.dead,
            sentence(&self.before.field).replace(". ", ".\n"),
            percent(points.hot_ratio),
            percent(points.cold_ratio),
        )
    }

    /// The same in numbers.
    pub(super) fn json(&self) -> Value {
        json!({
            "dead": self.dead,
            "likeliest": self.before.field.agreement.hypotheses.first(),
            "before": self.before.field.indices.points,
            "after": self.after.field.indices.points,
        })
    }
}
