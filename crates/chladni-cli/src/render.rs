//! `chladni render`: weights that move a panel here and keep it quiet there.

use crate::console::Console;
use crate::indices::{indices_table, weights_table};
use crate::input::source;
use crate::outcome::Outcome;
use crate::output::{Output, WEIGHTS};
use crate::table::{counted, significant};
use chladni_frf::io::{read_model, write_atomically};
use chladni_frf::{Error, ErrorKind, ModalModel, Result, Source};
use chladni_render::{Method, RenderOptions, Rendering, Scene, Weights};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{json, Map, Value};
use std::path::{Path, PathBuf};

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni render model.json corner.toml                     the weights and how well they do
  chladni render model.json corner.toml -o weights.json
  chladni render model.json corner.toml --method fast")]
pub struct Args {
    /// Model file, as `chladni fit` writes it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Scene file: drive frequency, threshold, zones, actuators
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Weights file to write, .json
    #[arg(short, value_name = "WEIGHTS")]
    output: Option<PathBuf>,
    /// How the weights are found
    #[arg(long, value_name = "METHOD", default_value = "default", value_parser = PossibleValuesParser::new(method_names())
        .try_map(|name| name.parse::<Method>()))]
    method: Method,
}

fn method_names() -> Vec<&'static str> {
    ["default", "fast"].into_iter().chain(Method::ALL.map(Method::as_str)).collect()
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, and of a scene that does not fit the model. A scene that cannot be met is a result.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let inputs = [args.model.clone(), args.scene.clone()];
    let output = args.output.as_deref().map(|path| Output::new(path, WEIGHTS, &inputs, console)).transpose()?;
    console.stage("reading");
    let model = read_model(&args.model)?;
    let scene = Scene::read(&args.scene)?;
    let sources = vec![source(&args.model)?, source(&args.scene)?];

    console.stage("rendering");
    let options = RenderOptions { method: args.method, ..RenderOptions::default() };
    let weights = render_scene(&model, &scene, &options, sources)?.weights;
    console.warn_all(weights.warnings.iter().cloned());
    if let Some(output) = &output {
        console.stage("writing");
        write_weights(output, &weights)?;
    }
    let doubt = (!weights.feasible).then(|| "the scene is not met: see the warnings".to_owned());
    let text = text(&weights);
    let outcome = match &args.output {
        Some(path) => Outcome::written(path, summary(&weights, path)?, text),
        None => Outcome::shown(value_of(&weights)?, text),
    };
    Ok(outcome.doubted(doubt))
}

/// Renders one scene; the weights know their sources.
///
/// # Errors
/// Those of the scene, with its file.
pub fn render_scene(model: &ModalModel, scene: &Scene, options: &RenderOptions, sources: Vec<Source>) -> Result<Rendering> {
    let mut rendering = chladni_render::render(model, scene, options).map_err(|error| match &scene.file {
        Some(file) => error.file(file),
        None => error,
    })?;
    rendering.weights.source = sources;
    Ok(rendering)
}

/// Writes a weights file.
///
/// # Errors
/// Those of writing.
pub fn write_weights(output: &Output, weights: &Weights) -> Result<()> {
    let text = weights.to_json()?;
    output.write(|path, force| write_atomically(path, force, |out| out.write_all(text.as_bytes())))
}

fn value_of(weights: &Weights) -> Result<Value> {
    serde_json::to_value(weights).map_err(|error| Error::new(ErrorKind::Internal, format!("the weights have no JSON: {error}")))
}

/// What fits on a screen: everything but the weights themselves.
fn summary(weights: &Weights, output: &Path) -> Result<Value> {
    let mut summary = Map::from_iter([("output".to_owned(), json!(output.display().to_string()))]);
    if let Value::Object(fields) = value_of(weights)? {
        let heavy = ["format", "version", "created_by", "weights"];
        summary.extend(fields.into_iter().filter(|(key, _)| !heavy.contains(&key.as_str())));
    }
    Ok(summary.into())
}

fn text(weights: &Weights) -> String {
    let scene = if weights.scene.is_empty() { "scene" } else { &weights.scene };
    format!(
        "{scene} at {} Hz, method {}, {}, {}: {}\n{}\n{}",
        significant(weights.frequency_hz, 6),
        weights.method,
        counted(weights.modes_used, "mode"),
        counted(weights.actuators_used, "actuator"),
        if weights.feasible { "feasible" } else { "not feasible" },
        indices_table(&weights.indices),
        weights_table(weights)
    )
}
