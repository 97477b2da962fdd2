//! `chladni evaluate --field`: measured fields against their prediction.

use super::Args;
use crate::indices::indices_table;
use crate::limits::CAUSES_SHOWN;
use chladni_console::input::source;
use chladni_console::table::{significant, table};
use chladni_console::{Console, Outcome};
use chladni_frf::{ModalModel, Result, Source};
use chladni_io::{read_field, sha256_of};
use chladni_render::{
    evaluate_field, Agreement, FieldEvaluation, Hypothesis, Place, Scene, Weights,
};
use serde_json::{json, Value};

/// Scores every field that was named.
///
/// # Errors
/// Those of reading, and a field that is not of these weights or not of this model.
pub fn run(
    args: &Args,
    weights: &Weights,
    scene: &Scene,
    model: &ModalModel,
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
            .map_err(|error| error.file(file))?;
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
    let Agreement {
        nis,
        coefficient,
        level_db,
        phase_deg,
        hypotheses,
        ..
    } = &judged.agreement;
    let phase = phase_deg.map_or(String::new(), |phase| format!(", phase {phase:+.1} deg"));
    let word = if *nis <= 1.5 {
        "the error bars explain the difference"
    } else {
        "more than the error bars explain"
    };
    let rows: Vec<Vec<String>> = hypotheses.iter().take(CAUSES_SHOWN).map(row).collect();
    format!(
        "{}against the prediction: level {level_db:+.2} dB{phase}, coefficient {coefficient:.4}, \
         NIS {} ({word})\n{}",
        indices_table(&judged.indices),
        significant(*nis, 2),
        table(&["likeliest cause", "where", "size", "ln evidence"], &rows)
    )
}

fn row(cause: &Hypothesis) -> Vec<String> {
    let place = match cause.place {
        Some(Place::Channel(dof)) => dof.to_string(),
        Some(Place::Mode(hz)) => format!("{hz:.1} Hz"),
        Some(Place::Point([x, y])) => format!("x {x:.3} m, y {y:.3} m"),
        None => String::new(),
    };
    let size = match (cause.kind.as_str(), cause.value) {
        (_, None) | ("dead" | "reversed", _) => String::new(),
        ("load", Some([re, im])) => format!("{re:.2}{im:+.2}j N s/m"),
        ("gain" | "channel", Some([re, im])) => format!("factor {:.3}{im:+.3}j", 1.0 + re),
        ("channels", Some([re, _])) => format!("{:.1} % rms", 100.0 * re),
        (_, Some([re, _])) => format!("{:+.2} %", 100.0 * re),
    };
    vec![
        cause.kind.clone(),
        place,
        size,
        format!("{:.1}", cause.ln_evidence),
    ]
}
