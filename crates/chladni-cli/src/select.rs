//! `chladni select`: keep or drop modes by hand, reproducibly.

use crate::fit::{distrust, summary, text};
use chladni_console::input::source;
use chladni_console::output::{Output, MODEL};
use chladni_console::table::{counted, significant};
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::{Result, Selected, Source};
use chladni_io::{read_model, write_model};
use std::path::PathBuf;

/// Arguments of `select`.
#[derive(Debug, clap::Args)]
#[command(
    before_help = "Examples:
  chladni select model.json selection.toml -o selected.json

  selection.toml:
    drop = [3, 7]          # numbers as in the table of `chladni fit`, from 1
                           # (or keep = [1, 2, 4]: all others go;
                           # or keep = \"sure\": all weak ones go)
    [[mode]]               # one more of them, by its frequency
    near_hz = 54.4
    within_hz = 0.5",
    after_help = "With [[mode]] tables alone, these modes are kept. Out-of-band poles (residual terms) stay.
Nothing is fitted again: what the dropped modes explained counts as residual."
)]
pub struct Args {
    /// Model file, as `chladni fit` writes it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Selection: which modes to keep or to drop
    #[arg(value_name = "SELECTION.toml")]
    selection: PathBuf,
    /// Model file to write, .json or .h5
    #[arg(short, value_name = "MODEL")]
    output: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing; a selection that names no mode of the model.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let inputs = [args.model.clone(), args.selection.clone()];
    let output = Output::new(&args.output, MODEL, &inputs, console)?;
    console.stage("reading");
    let whole = read_model(&args.model)?;
    let selection = chladni_io::read_selection(&args.selection)?;
    let Selected { mut model, dropped } = selection
        .apply(&whole)
        .map_err(|error| error.file(&args.selection))?;
    // what the model was fitted to stays named, so that a report finds the FRFs
    let inputs: Vec<Source> = inputs
        .iter()
        .map(|file| source(file))
        .collect::<Result<_>>()?;
    model.source.extend(inputs);
    console.find_all(&model.quality.findings);

    console.stage("writing");
    output.write(|path, force| write_model(path, &model, force))?;
    let gone: Vec<String> = dropped
        .iter()
        .map(|(number, hz)| format!("{number} ({} Hz)", significant(*hz, 6)))
        .collect();
    let kept = counted(model.in_band_modes().count(), "mode");
    let dropped = if gone.is_empty() {
        "none dropped".into()
    } else {
        format!("dropped {}", gone.join(", "))
    };
    let text = format!(
        "{}\n{}: {kept} kept, {dropped}\n",
        text(&model, console.verbose),
        args.output.display()
    );
    let doubt = (!model.quality.trusted).then(|| distrust(&model));
    Ok(Outcome::written(&args.output, summary(&model, &args.output)?, text).doubted(doubt))
}
