//! Measured fields in the studio: the agreement of the last one with its prediction, the
//! likely causes of the deviation, and the drive that all of them correct.

use super::question::{source_of_text, MeasuredQuestion};
use super::rendered::Rendered;
use super::session::Session;
use crate::correct::name_sources;
use crate::field_words::{cause, deviation, sentence};
use chladni_console::quoting::shell_path;
use chladni_frf::{Error, Result, Source};
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
        let Played { pairs, .. } = Played::new(&rendered, question)?;
        let PlayedField {
            weights,
            field,
            weights_sha256,
        } = &pairs[pairs.len() - 1];
        let name = &question.fields[pairs.len() - 1].name;
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
                "chladni evaluate {} --scene scene.toml --on {} --field {}",
                weights_file(pairs.len() - 1),
                self.rendered_file(&rendered),
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
        let model = self.rendered_file(&rendered);
        // the first field was measured under the rendered weights, each later one under the
        // weights that the fields before it corrected
        let pairs = question.fields.iter().enumerate().map(|(k, field)| {
            let weights = weights_file(k);
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
                "chladni correct {model} scene.toml{} -o {} --calibration calibration.json",
                pairs.collect::<String>(),
                weights_file(question.fields.len()),
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

/// Weights that so many fields corrected, in the commands on the page.
fn weights_file(fields: usize) -> String {
    match fields {
        0 => "weights.json".to_owned(),
        _ => format!("weights-{fields}.json"),
    }
}

/// The fields, each with the weights that it was measured under: the rendered ones for the
/// first, for each later one those that the fields before it correct. The weights are those that
/// the commands on the page write, to the last byte: a field may name the checksum of theirs.
struct Played {
    pairs: Vec<PlayedField>,
    weights_files: Vec<Source>,
    field_files: Vec<Source>,
}

impl Played {
    fn new(rendered: &Rendered, question: &MeasuredQuestion) -> Result<Self> {
        if question.fields.is_empty() {
            return Err(Error::bad_data("no measured field")
                .field("fields")
                .expected("the text of a field file"));
        }
        let mut played = Self {
            pairs: Vec::new(),
            weights_files: Vec::new(),
            field_files: Vec::new(),
        };
        for (k, file) in question.fields.iter().enumerate() {
            let field = parse_field(&file.csv).map_err(|error| error.file(&file.name))?;
            let weights = match k {
                0 => rendered.rendering.weights.clone(),
                _ => played.corrected(rendered)?.0,
            };
            let json = weights.to_json()?;
            played
                .weights_files
                .push(source_of_text(&weights_file(k), &json));
            played
                .field_files
                .push(source_of_text(&file.name, &file.csv));
            played.pairs.push(PlayedField {
                weights,
                field,
                weights_sha256: Some(sha256_of_bytes(json.as_bytes())),
            });
        }
        Ok(played)
    }

    /// The weights that all fields so far correct, and the calibration; both name their sources.
    fn corrected(&self, rendered: &Rendered) -> Result<(Weights, Calibration)> {
        let options = RenderOptions::default();
        let (mut weights, mut calibration) =
            calibrate(&rendered.model, &rendered.scene, &self.pairs, &options)?;
        let of_scene = &rendered.rendering.weights.source;
        let files = of_scene
            .iter()
            .chain(&self.weights_files)
            .chain(&self.field_files);
        name_sources(&mut weights, &mut calibration, files.cloned().collect());
        Ok((weights, calibration))
    }
}

/// The drive that all fields of `question` correct.
///
/// # Errors
/// Those of [`Session::measured`].
pub fn corrected(rendered: &Rendered, question: &MeasuredQuestion) -> Result<Corrected> {
    let (weights, calibration) = Played::new(rendered, question)?.corrected(rendered)?;
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
