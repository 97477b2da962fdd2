//! Measured fields in the studio: the agreement of the last one with its prediction, the
//! likely causes of the deviation, and the drive that all of them correct.

use super::question::MeasuredQuestion;
use super::rendered::Rendered;
use super::session::Session;
use crate::field_words::{cause, deviation, sentence};
use chladni_console::quoting::shell_path;
use chladni_frf::{Error, Result};
use chladni_io::{parse_field, sha256_of_bytes};
use chladni_render::{
    calibrate, evaluate, evaluate_field, Calibration, Evaluation, On, PlayedField, RenderOptions,
    Weights,
};
use chladni_report::{scene_data, RenderedScene, ReportInput};
use serde_json::{json, Value};
use std::path::Path;
use std::sync::Arc;

/// A corrected drive.
pub struct Corrected {
    pub weights: Weights,
    pub calibration: Arc<Calibration>,
    /// The field of the drive in the corrected model.
    pub evaluation: Evaluation,
}

impl Session {
    /// The last field against its prediction.
    ///
    /// # Errors
    /// Those of rendering; a field that cannot be read, or is not of its weights.
    pub fn measured(&self, question: &MeasuredQuestion) -> Result<Value> {
        let rendered = self.rendered(&question.scene)?;
        let played = played(&rendered, question)?;
        let PlayedField {
            weights,
            field,
            weights_sha256,
        } = &played[played.len() - 1];
        let name = &question.fields[played.len() - 1].name;
        let judged = evaluate_field(
            weights,
            &rendered.scene,
            &rendered.model,
            field,
            weights_sha256.as_deref(),
        )
        .map_err(|error| error.file(name))?;
        let input = ReportInput {
            model: Some(&rendered.model),
            scenes: vec![RenderedScene::of_measured(weights, &judged)],
            ..ReportInput::default()
        };
        let causes = judged.agreement.hypotheses.iter().map(
            |one| json!({"words": cause(one), "kind": one.kind, "ln_evidence": one.ln_evidence}),
        );
        Ok(json!({
            "scene": scene_data(&input),
            "sentence": sentence(&judged),
            "deviation": deviation(&judged),
            "causes": causes.collect::<Vec<_>>(),
            "findings": judged.findings,
            "command": format!(
                "chladni evaluate weights.json --scene scene.toml --on {} --field {}",
                self.selected_file(&question.scene),
                shell_path(Path::new(name)),
            ),
        }))
    }

    /// The drive that all fields correct, and its field in the corrected model.
    ///
    /// # Errors
    /// Those of [`Self::measured`].
    pub fn correct(&self, question: &MeasuredQuestion) -> Result<Value> {
        let rendered = self.rendered(&question.scene)?;
        let corrected = corrected(&rendered, question)?;
        let input = ReportInput {
            model: Some(&rendered.model),
            scenes: vec![corrected.scene()],
            ..ReportInput::default()
        };
        let model = self.selected_file(&question.scene);
        // the first field was measured under the rendered weights, each later one under the
        // weights that the fields before it corrected
        let pairs = question.fields.iter().enumerate().map(|(k, field)| {
            let weights = match k {
                0 => "weights.json".to_owned(),
                _ => format!("weights-{k}.json"),
            };
            format!(
                " --weights {weights} --field {}",
                shell_path(Path::new(&field.name))
            )
        });
        Ok(json!({
            "scene": scene_data(&input),
            "correction": corrected.weights.correction,
            "findings": corrected.weights.findings.0,
            "command": format!(
                "chladni correct {model} scene.toml{} -o weights-{}.json --calibration calibration.json",
                pairs.collect::<String>(),
                question.fields.len(),
            ),
        }))
    }
}

impl Corrected {
    /// The drive with its field, to be drawn.
    pub fn scene(&self) -> RenderedScene<'_> {
        RenderedScene::of_evaluation(&self.weights, &self.evaluation, "the corrected model")
    }
}

/// The fields, each with the weights that it was measured under: the rendered ones for the
/// first, for each later one those that the fields before it correct.
fn played(rendered: &Rendered, question: &MeasuredQuestion) -> Result<Vec<PlayedField>> {
    if question.fields.is_empty() {
        return Err(Error::bad_data("no measured field")
            .field("fields")
            .expected("the text of a field file"));
    }
    let mut played: Vec<PlayedField> = Vec::new();
    for file in &question.fields {
        let field = parse_field(&file.csv).map_err(|error| error.file(&file.name))?;
        let weights = match played.is_empty() {
            true => rendered.rendering.weights.clone(),
            false => corrected_by(rendered, &played)?.0,
        };
        let sha256 = sha256_of_bytes(weights.to_json()?.as_bytes());
        played.push(PlayedField {
            weights,
            field,
            weights_sha256: Some(sha256),
        });
    }
    Ok(played)
}

fn corrected_by(rendered: &Rendered, played: &[PlayedField]) -> Result<(Weights, Calibration)> {
    let options = RenderOptions::default();
    calibrate(&rendered.model, &rendered.scene, played, &options)
}

/// The drive that all fields of `question` correct.
///
/// # Errors
/// Those of [`Session::measured`].
pub fn corrected(rendered: &Rendered, question: &MeasuredQuestion) -> Result<Corrected> {
    let (weights, calibration) = corrected_by(rendered, &played(rendered, question)?)?;
    let calibration = Arc::new(calibration);
    let mut scene = rendered.scene.clone();
    scene.actuators.calibration = Some(calibration.clone());
    let evaluation = evaluate(&weights, &scene, On::Model(&rendered.model))?;
    Ok(Corrected {
        weights,
        calibration,
        evaluation,
    })
}
