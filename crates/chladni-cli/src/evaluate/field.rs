//! `chladni evaluate --field`: measured fields against their prediction.

use super::Args;
use crate::blame::blame_field;
use crate::field_words::{cause, deviation, sentence};
use crate::indices::indices_table;
use crate::limits::CAUSES_SHOWN;
use chladni_console::input::source;
use chladni_console::table::{significant, table};
use chladni_console::{Console, Outcome};
use chladni_frf::{ModalModel, Result, Source};
use chladni_io::{read_field, sha256_of};
use chladni_render::{evaluate_field, FieldEvaluation, Scene, Weights};
use serde_json::{json, Value};
use std::path::Path;

/// Judges every field of `--field` on a model, which comes with its file.
///
/// # Errors
/// Those of reading, and a field that is not of these weights or not of this model.
pub fn run(
    args: &Args,
    weights: &Weights,
    scene: &Scene,
    (model, model_file): (&ModalModel, &Path),
    mut sources: Vec<Source>,
    console: &Console,
) -> Result<Outcome> {
    console.stage("judging");
    let sha256 = sha256_of(&args.weights)?;
    let (mut all, mut text) = (Vec::new(), String::new());
    for file in &args.field {
        let field = read_field(file)?;
        sources.push(source(file)?);
        // the field says of which tone it is
        let tone = weights
            .tones()
            .find(|tone| tone.frequency_hz == field.frequency_hz);
        let judged = evaluate_field(tone.unwrap_or(weights), scene, model, &field, Some(&sha256))
            .map_err(|error| match error.field.as_deref() {
            Some("frequency_hz") => error.file(file),
            _ => blame_field(error, (file, &args.weights), model_file, scene),
        })?;
        console.find_all(&judged.findings);
        text += &format!(
            "{} at {} Hz\n",
            file.display(),
            significant(field.frequency_hz, 6)
        );
        text += &shown(&judged);
        all.push(json!({
            "field": file.display().to_string(),
            "frequency_hz": field.frequency_hz,
            "indices": judged.indices,
            "agreement": judged.agreement,
        }));
    }
    let first = all[0].clone();
    let mut summary = json!({
        "weights": args.weights.display().to_string(),
        "scene": args.scene.display().to_string(),
        "source": sources,
        "fields": all,
    });
    if let (Value::Object(summary), Value::Object(first)) = (&mut summary, first) {
        summary.extend(first);
    }
    Ok(Outcome::shown(summary, text))
}

fn shown(judged: &FieldEvaluation) -> String {
    let causes = judged.agreement.hypotheses.iter().take(CAUSES_SHOWN);
    let rows: Vec<Vec<String>> = causes
        .map(|one| vec![cause(one), format!("{:.1}", one.ln_evidence)])
        .collect();
    format!(
        "{}\n{}{}\n{}",
        sentence(judged),
        indices_table(&judged.indices),
        deviation(judged),
        table(&["possible cause", "ln evidence"], &rows)
    )
}
