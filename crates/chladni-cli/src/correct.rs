//! `chladni correct`: a drive corrected by measured fields.

use crate::indices::{indices_table, weights_table};
use crate::render::write_weights;
use chladni_console::input::{read_weights, source};
use chladni_console::output::{Output, WEIGHTS};
use chladni_console::table::significant;
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_io::{read_field, read_model, sha256_of};
use chladni_render::{Correction, RenderOptions, Scene, Weights};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `correct`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni correct model.json corner.toml --weights w0.json --field scan0.csv -o w1.json
  chladni correct model.json corner.toml --weights w0.json --field scan0.csv --weights w1.json --field scan1.csv -o w2.json

A field is a table response,re,im[,std] or response,magnitude[,std] under the lines `# frequency_hz = ...` and
`# unit = m/s`; some of the responses are enough.")]
pub struct Args {
    /// Model file that the weights were rendered with
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Weights that were played, oldest first; one --field each
    #[arg(long, required = true, value_name = "WEIGHTS")]
    weights: Vec<PathBuf>,
    /// The field that was measured under each of them
    #[arg(long, required = true, value_name = "FIELD.csv")]
    field: Vec<PathBuf>,
    /// Weights file to write, .json
    #[arg(short, value_name = "WEIGHTS")]
    output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, and fields that do not belong to their weights.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if args.weights.len() != args.field.len() {
        let found = format!(
            "{} weights and {} fields",
            args.weights.len(),
            args.field.len()
        );
        return Err(
            Error::new(ErrorKind::Usage, "weights and fields are no pairs")
                .field("--field")
                .found(found)
                .expected("one --field for each --weights, in the same order"),
        );
    }
    let inputs = [
        vec![args.model.clone(), args.scene.clone()],
        args.weights.clone(),
        args.field.clone(),
    ]
    .concat();
    let output = args
        .output
        .as_deref()
        .map(|path| Output::new(path, WEIGHTS, &inputs, console))
        .transpose()?;
    console.stage("reading");
    let model = read_model(&args.model)?;
    let scene = Scene::read(&args.scene)?;
    let mut played = Vec::new();
    for (weights, field) in args.weights.iter().zip(&args.field) {
        played.push((
            read_weights(weights)?,
            read_field(field)?,
            Some(sha256_of(weights)?),
        ));
    }
    console.stage("correcting");
    let mut weights = chladni_render::correct(&model, &scene, &played, &RenderOptions::default())?;
    weights.source = inputs
        .iter()
        .map(|file| source(file))
        .collect::<Result<_>>()?;
    console.find_all(weights.findings.iter());
    let text = text(&weights);
    let doubt = (!weights.feasible).then(|| "the scene is not met: see above".to_owned());
    let outcome = match (&args.output, &output) {
        (Some(path), Some(output)) => {
            console.stage("writing");
            write_weights(output, &weights)?;
            let json = json!({
                "output": path.display().to_string(),
                "source": weights.source,
                "frequency_hz": weights.frequency_hz,
                "feasible": weights.feasible,
                "kappa": weights.kappa,
                "indices": weights.indices,
                "correction": weights.correction,
                "warnings": weights.findings.warnings(),
                "findings": weights.findings.0,
            });
            Outcome::written(path, json, text)
        }
        _ => {
            let json = serde_json::to_value(&weights).map_err(|error| {
                Error::new(
                    ErrorKind::Internal,
                    format!("the weights have no JSON: {error}"),
                )
            })?;
            Outcome::shown(json, text)
        }
    };
    Ok(outcome.doubted(doubt))
}

fn text(weights: &Weights) -> String {
    let told = weights
        .correction
        .as_ref()
        .map_or(String::new(), correction);
    format!(
        "{told}{}{}",
        indices_table(&weights.indices),
        weights_table(weights)
    )
}

fn correction(told: &Correction) -> String {
    let fields = told.fields.iter().zip(1..).map(|(field, number)| {
        let ratio = field
            .min_ratio
            .map_or("unknown".into(), |ratio| format!("{ratio:.3}"));
        let nis = significant(field.nis, 2);
        format!("field {number}: smaller of hot and cold {ratio}, NIS {nis}\n")
    });
    let odd = told.gains.iter().filter(|gain| gain.odd).map(|gain| {
        format!(
            "odd channel {}: factor {:.3}{:+.3}j\n",
            gain.reference, gain.re, gain.im
        )
    });
    let drive = match (told.kept, told.best_measured) {
        (true, Some(best)) => {
            format!("no better drive is foretold than that of field {best}: it is given again\n")
        }
        _ => format!("corrected by the {} estimator\n", told.estimator.name()),
    };
    fields.chain(odd).chain([drive]).collect()
}
