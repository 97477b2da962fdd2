//! `chladni report`: models and weights as one HTML page.

use crate::console::Console;
use crate::input::{read_weights, source, Reading};
use crate::outcome::Outcome;
use crate::output::{Output, HTML};
use crate::table::{counted, shortened};
use chladni_frf::io::{self, detect_format, write_atomically, FileFormat};
use chladni_frf::{Error, ErrorKind, FrfSet, ModalModel, Result, Source};
use chladni_render::{evaluate, Evaluation, On, Scene, Weights};
use chladni_report::{html, RenderedScene, ReportInput};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The method of a model that was not fitted: the truth of `simulate`, whose source is a panel.
const SIMULATED: &str = "simulate";

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni report model.json -o report.html
  chladni report model.json weights-*.json -o report.html

Files that the results name as their sources (the measured FRFs, the model, the scene) are shown too where they
still lie beside them, unchanged.")]
pub struct Args {
    /// At most one model, and any number of weights
    #[arg(required = true, value_name = "MODEL|WEIGHTS")]
    files: Vec<PathBuf>,
    /// Page to write
    #[arg(short, value_name = "report.html")]
    output: PathBuf,
}

/// A weights file with the field that it makes, where scene and model are at hand.
struct ShownWeights {
    weights: Weights,
    evaluation: Option<Evaluation>,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing; more than one model.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let output = Output::new(&args.output, HTML, &args.files, console)?;
    console.stage("reading");
    let (mut model_file, weights) = sort(&args.files)?;
    if model_file.is_none() {
        model_file = weights.iter().find_map(|(file, weights)| beside(file, &weights.source).into_iter().find(|path| is_model(path)));
    }
    let model = model_file.as_deref().map(io::read_model).transpose()?;
    let measured = match (&model_file, &model) {
        (Some(file), Some(model)) => measured_of(file, model, console),
        _ => None,
    };
    let shown: Vec<ShownWeights> =
        weights.into_iter().map(|(file, weights)| show(&file, weights, model.as_ref(), console)).collect::<Result<_>>()?;

    console.stage("drawing");
    let page = html(&ReportInput {
        title: io::file_name(&args.files[0]),
        model: model.as_ref(),
        measured: measured.as_ref(),
        scenes: shown.iter().map(ShownWeights::scene).collect(),
        warnings: console.warnings(),
    })?;
    console.stage("writing");
    write_page(&output, &page)?;
    let sources = args.files.iter().map(|file| source(file)).collect::<Result<Vec<_>>>()?;
    let modes = model.as_ref().map_or(0, |model| model.in_band_modes().count());
    let json = json!({
        "output": args.output.display().to_string(),
        "source": sources,
        "modes": modes,
        "measured": measured.is_some(),
        "scenes": shown.len(),
        "warnings": console.warnings(),
    });
    let text = format!("{}: {}, {}\n", args.output.display(), counted(modes, "mode"), counted(shown.len(), "scene"));
    Ok(Outcome::written(&args.output, json, text))
}

/// Writes the page.
///
/// # Errors
/// Those of writing.
pub fn write_page(output: &Output, page: &str) -> Result<()> {
    output.write(|path, force| write_atomically(path, force, |out| out.write_all(page.as_bytes())))
}

type WeightsFile = (PathBuf, Weights);

fn sort(files: &[PathBuf]) -> Result<(Option<PathBuf>, Vec<WeightsFile>)> {
    let (mut model, mut weights) = (None, Vec::new());
    for file in files {
        match detect_format(file)? {
            FileFormat::Weights => weights.push((file.clone(), read_weights(file)?)),
            FileFormat::Model | FileFormat::Hdf5 if model.is_none() => model = Some(file.clone()),
            FileFormat::Model | FileFormat::Hdf5 => {
                return Err(Error::new(ErrorKind::Usage, "a report shows one model")
                    .file(file)
                    .found("a second model")
                    .expected("one model and any number of weights")
                    .help("make one report for each model"))
            }
            FileFormat::Uff | FileFormat::Csv | FileFormat::Matlab | FileFormat::Numpy | FileFormat::Wav => {
                return Err(Error::bad_data("neither a model nor weights")
                    .file(file)
                    .found("measured data")
                    .expected("a model or weights file")
                    .help("fit a model first: chladni fit FRF -o MODEL.json"))
            }
        }
    }
    Ok((model, weights))
}

fn is_model(path: &Path) -> bool {
    matches!(detect_format(path), Ok(FileFormat::Model))
}

/// The sources of a result that lie beside it, unchanged.
fn beside(result: &Path, sources: &[Source]) -> Vec<PathBuf> {
    let folder = result.parent().unwrap_or_else(|| Path::new(""));
    let same = |source: &&Source| io::sha256_of(&folder.join(&source.file)).is_ok_and(|sha256| sha256 == source.sha256);
    sources.iter().filter(same).map(|source| folder.join(&source.file)).collect()
}

/// The FRFs that a model was fitted to, read as they were then; none where one of the files is gone or another.
fn measured_of(file: &Path, model: &ModalModel, console: &Console) -> Option<FrfSet> {
    if model.source.is_empty() || model.method == SIMULATED {
        return None;
    }
    // `select` adds the model it started from and the selection
    let selected = model.options.get("selections").and_then(|list| list.as_array()).map_or(0, Vec::len);
    let fitted = &model.source[..model.source.len().saturating_sub(2 * selected)];
    let files = beside(file, fitted);
    if files.len() < fitted.len() {
        let names: Vec<String> = fitted.iter().map(|source| source.file.clone()).collect();
        let names = shortened(&names, 3);
        console.warn(format!("the measured FRFs ({names}) do not lie beside the model, unchanged: its synthesis alone is shown"));
        return None;
    }
    match io::read_frf(&files, &Reading::from_echo(&model.options).options()) {
        Ok((frf, ..)) => Some(frf),
        Err(error) => {
            console.warn(format!("the measured FRFs cannot be read: {}; the model's synthesis alone is shown", error.message));
            None
        }
    }
}

/// Weights with their field, where the scene lies beside them.
fn show(file: &Path, weights: Weights, model: Option<&ModalModel>, console: &Console) -> Result<ShownWeights> {
    let scene = beside(file, &weights.source).into_iter().find(|path| path.file_name().is_some_and(|name| *name == *weights.scene));
    let evaluation = match (scene, model) {
        (Some(scene), Some(model)) => Some(evaluate(&weights, &Scene::read(&scene)?, On::Model(model)).map_err(|error| error.file(file))?),
        (None, _) => {
            console.warn(format!("{}: this scene does not lie beside the weights, unchanged: no field is shown", weights.scene));
            None
        }
        (Some(_), None) => None,
    };
    Ok(ShownWeights { weights, evaluation })
}

impl ShownWeights {
    fn scene(&self) -> RenderedScene<'_> {
        match &self.evaluation {
            Some(evaluation) => RenderedScene::of_evaluation(&self.weights, evaluation, "the model"),
            None => RenderedScene::of_weights(&self.weights),
        }
    }
}
