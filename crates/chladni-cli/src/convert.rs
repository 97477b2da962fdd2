//! `chladni convert`: measured data and models from any format to any other.

use crate::console::Console;
use crate::input::{expand, model_of, source, warn_of_files, Reading};
use crate::outcome::Outcome;
use crate::output::{Output, FRF, MODEL};
use crate::table::counted;
use chladni_frf::io::{read_contents, write_contents, write_model};
use chladni_frf::{Error, ModalModel, Result};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni convert measurement.uff -o measurement.h5
  chladni convert scan_*.uff --reference 101,102,103 -o all.h5      one file per actuator
  chladni convert model.json -o model.h5")]
pub struct Args {
    /// Input files, folders of them, or patterns; several are merged into one set
    #[arg(required = true, value_name = "IN")]
    files: Vec<PathBuf>,
    /// File to write: .h5 (exact), .uff (binary), .unv (text), .csv; for models .json or .h5
    #[arg(short, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    console.stage("reading");
    if let [file] = files.as_slice() {
        if let Some(model) = model_of(file)? {
            return convert_model(args, &files, &model, console);
        }
    }
    let output = Output::new(&args.output, FRF, &files, console)?;
    let mut contents = read_contents(&files, &args.reading.options())?;
    warn_of_files(&files, std::mem::take(&mut contents.warnings), console);
    warn_of_files(&files, std::mem::take(&mut contents.not_carried), console);

    if contents.frf.is_none() && contents.functions.is_empty() && contents.geometry().nodes.is_empty() {
        return Err(Error::bad_data("nothing in the input can be carried over")
            .file(&args.files[0])
            .found("neither FRFs nor other functions nor nodes")
            .expected("measured data or a model")
            .help("`chladni info` lists what is inside"));
    }
    console.stage("writing");
    console.warn_all(output.write(|path, force| write_contents(path, &contents, force))?);
    let (responses, references, lines) = contents.frf.as_ref().map_or((0, 0, 0), |frf| frf.values.dim());
    let json = json!({
        "output": args.output.display().to_string(),
        "source": contents.sources,
        "frf_kind": contents.frf.as_ref().and_then(|frf| frf.kind),
        "responses": responses,
        "references": references,
        "lines": lines,
        "functions": contents.functions.len(),
        "nodes": contents.geometry().nodes.len(),
        "warnings": console.warnings(),
    });
    let text = format!(
        "{}: {} of {} at {}, {}, {}\n",
        args.output.display(),
        counted(responses, "response"),
        counted(references, "reference"),
        counted(lines, "line"),
        counted(contents.functions.len(), "other function"),
        counted(contents.geometry().nodes.len(), "node")
    );
    Ok(Outcome::written(&args.output, json, text))
}

fn convert_model(args: &Args, files: &[PathBuf], model: &ModalModel, console: &Console) -> Result<Outcome> {
    let output = Output::new(&args.output, MODEL, files, console)?;
    console.stage("writing");
    output.write(|path, force| write_model(path, model, force))?;
    let modes = model.in_band_modes().count();
    let json = json!({
        "output": args.output.display().to_string(),
        "source": [source(&files[0])?],
        "frf_kind": model.frf_kind,
        "responses": model.responses.len(),
        "references": model.references.len(),
        "modes": modes,
        "warnings": console.warnings(),
    });
    Ok(Outcome::written(&args.output, json, format!("{}: model with {}\n", args.output.display(), counted(modes, "mode"))))
}
