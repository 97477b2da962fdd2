//! `chladni evaluate`: given weights on other data.

mod field;

use crate::indices::indices_table;
use chladni_console::input::{expand, model_of, read_frf, read_weights, source, Reading};
use chladni_console::table::significant;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::{Error, ErrorKind, Result};
use chladni_render::{Evaluation, On, Scene};
use serde_json::{json, Map, Value};
use std::path::PathBuf;

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni evaluate weights.json --scene corner.toml --on measured.h5     on the measured line at the drive frequency
  chladni evaluate weights.json --scene corner.toml --on other.json      on another model
  chladni evaluate weights.json --scene corner.toml --on model.json --field scan.csv     a measured field, against its
      prediction: how near they are, and what may be wrong with the rig")]
pub struct Args {
    /// Weights file, as `chladni render` writes it
    #[arg(value_name = "WEIGHTS")]
    weights: PathBuf,
    /// Scene file with the zones and limits to judge by
    #[arg(long, value_name = "SCENE.toml")]
    scene: PathBuf,
    /// FRFs or a model to judge on; several FRF files are merged
    #[arg(long, required = true, value_name = "FRF|MODEL")]
    on: Vec<PathBuf>,
    /// Fields measured while the weights were played: rows response,re,im or
    /// response,magnitude, and std where it is known, under the lines `# frequency_hz = ...`
    /// and `# unit = m/s`
    #[arg(long, value_name = "FIELD.csv")]
    field: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command. It only reports: weights that fail are no error.
///
/// # Errors
/// Those of reading, and data that the weights do not fit.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    console.stage("reading");
    let weights = read_weights(&args.weights)?;
    let scene = Scene::read(&args.scene)?;
    let mut sources = vec![source(&args.weights)?, source(&args.scene)?];
    let files = expand(&args.on, console)?;
    let model = match files.as_slice() {
        [one] => model_of(one)?,
        _ => None,
    };
    if !args.field.is_empty() {
        let model = model.ok_or_else(|| {
            Error::new(ErrorKind::Usage, "a measured field is held against a model")
                .field("--on")
                .found("FRFs")
                .expected("the model that the weights were rendered with")
        })?;
        sources.push(source(&files[0])?);
        return field::run(args, &weights, &scene, &model, sources, console);
    }
    let judge = |on: On| {
        console.stage("judging");
        chladni_render::evaluate(&weights, &scene, on).map_err(|error| error.file(&files[0]))
    };
    let evaluation = match model {
        Some(model) => {
            sources.push(source(&files[0])?);
            judge(On::Model(&model))?
        }
        None => {
            let (frf, read) = read_frf(&files, &args.reading, console)?;
            sources.extend(read);
            judge(On::Frf(&frf))?
        }
    };
    console.find_all(&evaluation.findings);
    for tone in &evaluation.other_tones {
        console.find_all(&tone.findings);
    }
    let json = json!({
        "weights": args.weights.display().to_string(),
        "scene": args.scene.display().to_string(),
        "on": files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        "source": sources,
    });
    let mut summary = judged(&evaluation);
    if !evaluation.other_tones.is_empty() {
        summary.insert(
            "other_tones".into(),
            evaluation
                .other_tones
                .iter()
                .map(judged)
                .map(Value::Object)
                .collect(),
        );
    }
    if let Value::Object(fields) = json {
        summary.extend(fields);
    }
    let tones = std::iter::once(&evaluation).chain(&evaluation.other_tones);
    Ok(Outcome::shown(
        summary.into(),
        tones.map(text).collect::<Vec<_>>().join("\n"),
    ))
}

/// Frequency, limits and indices of a tone.
fn judged(evaluation: &Evaluation) -> Map<String, Value> {
    let limits = json!({
        "hot": evaluation.limits.hot_m_per_s,
        "threshold": evaluation.limits.threshold_m_per_s,
        "cold": evaluation.limits.cold_m_per_s,
    });
    let fields = [
        ("frequency_hz", json!(evaluation.frequency_hz)),
        ("limits_m_per_s", limits),
        ("indices", json!(evaluation.indices)),
    ];
    fields
        .map(|(key, value)| (key.to_owned(), value))
        .into_iter()
        .collect()
}

fn text(evaluation: &Evaluation) -> String {
    format!(
        "at {} Hz\n{}",
        significant(evaluation.frequency_hz, 6),
        indices_table(&evaluation.indices)
    )
}
