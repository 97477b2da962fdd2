//! A rig that is not as the model: the strongest actuator of the first scene is dead. Its
//! field is measured, named and corrected, as by `chladni evaluate --field` and
//! `chladni correct`.

use super::Judged;
use crate::field_words::sentence;
use crate::limits::{SCANNER_SEED, SCANNER_SNR_DB};
use crate::render::write_weights;
use chladni_console::output::{Output, WEIGHTS};
use chladni_console::Console;
use chladni_frf::{Dof, Error, ErrorKind, FieldPoint, MeasuredField, ModalModel, Result};
use chladni_io::write_atomically;
use chladni_plate::add_white_noise;
use chladni_render::{
    calibrate, evaluate, evaluate_field, FieldEvaluation, On, RenderOptions, Scene, Weights,
};
use chladni_report::RenderedScene;
use ndarray::Array3;
use serde_json::{json, Value};
use std::fmt::Write;
use std::path::Path;

/// The first scene on the rig with a dead actuator.
pub(super) struct OnRig {
    dead: Dof,
    /// The weights of the model, and their field.
    before: (Weights, FieldEvaluation),
    /// Corrected by that field.
    after: (Weights, FieldEvaluation),
}

/// Plays the weights of a scene on the rig, corrects them by the field, plays these.
///
/// # Errors
/// Those of writing; anything else is a bug.
pub(super) fn on_rig(
    [field_file, weights_file]: [&Path; 2],
    model: &ModalModel,
    truth: &ModalModel,
    scene: &Scene,
    judged: &Judged,
    console: &Console,
) -> Result<OnRig> {
    console.stage("an actuator dies");
    let played = &judged.rendering.weights;
    let size = |k: &usize| played.weights[*k].amplitude;
    let dead = (0..played.weights.len())
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .ok_or_else(|| Error::new(ErrorKind::Internal, "weights without actuators"))?;
    let field = measured(played, dead, truth, scene)?;
    let text = csv(&field);
    Output::new(field_file, &["csv"], &[], console)?
        .write(|path, force| write_atomically(path, force, |out| out.write_all(text.as_bytes())))?;
    let before = evaluate_field(played, scene, model, &field, None)?;
    let (weights, _) = calibrate(
        model,
        scene,
        &[(played.clone(), field, None)],
        &RenderOptions::default(),
    )?;
    write_weights(&Output::new(weights_file, WEIGHTS, &[], console)?, &weights)?;
    let again = measured(&weights, dead, truth, scene)?;
    let after = evaluate_field(&weights, scene, model, &again, None)?;
    let named = |weights: &Weights, what: String| Weights {
        scene: format!("{}, {what}", played.scene),
        ..weights.clone()
    };
    let dead = played.weights[dead].reference;
    Ok(OnRig {
        before: (named(played, format!("actuator {dead} dead")), before),
        after: (named(&weights, "corrected".into()), after),
        dead,
    })
}

/// The field of `weights` on the true panel without the actuator `dead`.
fn measured(
    weights: &Weights,
    dead: usize,
    truth: &ModalModel,
    scene: &Scene,
) -> Result<MeasuredField> {
    let mut rig = weights.clone();
    let silent = &mut rig.weights[dead];
    (silent.re, silent.im, silent.amplitude, silent.phase_deg) = (0.0, 0.0, 0.0, 0.0);
    let field = evaluate(&rig, scene, On::Model(truth))?.field;
    let mut values = Array3::from_shape_fn((field.responses.len(), 1, 1), |(i, _, _)| {
        field.velocity_m_per_s[i]
    });
    let variance = add_white_noise(&mut values, SCANNER_SNR_DB, SCANNER_SEED)?;
    let point = |(&response, &velocity_m_per_s)| FieldPoint {
        response,
        velocity_m_per_s,
        std_m_per_s: Some(variance.sqrt()),
        repeats: 1,
    };
    Ok(MeasuredField {
        frequency_hz: weights.frequency_hz,
        weights_sha256: None,
        magnitudes_only: false,
        points: field.responses.iter().zip(&values).map(point).collect(),
    })
}

fn csv(field: &MeasuredField) -> String {
    let mut text = format!(
        "# frequency_hz = {:?}\n# unit = m/s\nresponse,re,im,std\n",
        field.frequency_hz
    );
    for point in &field.points {
        let (v, std) = (point.velocity_m_per_s, point.std_m_per_s.unwrap_or(0.0));
        // a string takes what it is given
        let _ = writeln!(text, "{},{:e},{:e},{std:e}", point.response, v.re, v.im);
    }
    text
}

impl OnRig {
    /// Both fields, for the report.
    pub(super) fn shown(&self) -> [RenderedScene<'_>; 2] {
        [&self.before, &self.after]
            .map(|(weights, field)| RenderedScene::of_measured(weights, field))
    }

    /// The verdict on the measured field, and the shares after the correction.
    pub(super) fn text(&self) -> String {
        let points = &self.after.1.indices.points;
        let percent = |ratio: f64| format!("{:.0} %", 100.0 * ratio);
        format!(
            "Scene 1 where actuator {} is dead:\n{}\nCorrected by that field: {} of hot points \
             felt, {} of cold ones quiet.",
            self.dead,
            sentence(&self.before.1).replace(". ", ".\n"),
            percent(points.hot_ratio),
            percent(points.cold_ratio),
        )
    }

    /// The same in numbers.
    pub(super) fn json(&self) -> Value {
        json!({
            "dead": self.dead,
            "likeliest": self.before.1.agreement.hypotheses.first(),
            "before": self.before.1.indices.points,
            "after": self.after.1.indices.points,
        })
    }
}
