//! `chladni select`: keep or drop modes by hand, reproducibly.

use crate::explain::explain;
use crate::fit::written_model;
use crate::report::{measured_beside, measured_by_user};
use chladni_console::input::source;
use chladni_console::output::{Output, MODEL};
use chladni_console::table::{counted, significant};
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::{Error, ModalModel, Result, Selected, Source, Trust};
use chladni_io::read_model;
use chladni_rfp::{fit_watched, CancelToken, FitOptions, Method};
use std::path::{Path, PathBuf};

/// Arguments of `select`.
#[derive(Debug, clap::Args)]
#[command(
    before_help = "Examples:
  chladni select model.json selection.toml -o selected.json

  selection.toml:
    drop = [3, 7]          # numbers as in the table of `chladni fit`, from 1
                           # (or keep = [1, 2, 4]: all others go;
                           # or keep = \"sure\": all weak ones go)
    add = [{frequency_hz = 123.4}]     # a mode that the fit did not take: fitted anew with it
    [[mode]]               # one more of those above, by its frequency
    near_hz = 54.4
    within_hz = 0.5",
    after_help = "With [[mode]] tables alone, these modes are kept. Out-of-band poles (residual terms) stay.
Without `add` nothing is fitted again: what the dropped modes explained counts as residual. With it the FRFs are fitted
anew, and the added modes are graded like all others; numbers are still those of MODEL."
)]
pub struct Args {
    /// Model file, as `chladni fit` writes it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Selection: which modes to keep or to drop
    #[arg(value_name = "SELECTION.toml")]
    selection: PathBuf,
    /// Model file to write, .json or .h5
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    /// FRFs that the model was fitted to, for `add`, where they lie elsewhere now
    #[arg(long, value_name = "FRF", num_args = 1..)]
    measured: Vec<PathBuf>,
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
    let of_file = |error: Error| error.file(&args.selection);
    let (selection, whole) = match selection.added_hz() {
        [] => (selection, whole),
        added_hz => {
            let again = args.fitted_with(&whole, added_hz, console)?;
            (selection.carried(&whole, &again).map_err(of_file)?, again)
        }
    };
    let Selected { mut model, dropped } = selection.apply(&whole).map_err(of_file)?;
    // the sources of the fit stay, so that a report finds the FRFs
    let inputs: Vec<Source> = inputs
        .iter()
        .map(|file| source(file))
        .collect::<Result<_>>()?;
    model.source.extend(inputs);

    console.stage("writing");
    let outcome = written_model(&model, &args.output, &output, console)?;
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
    let added: String = selection
        .added_hz()
        .iter()
        .map(|&hz| format!("{}\n", outcome_of_added(&whole, hz)))
        .collect();
    let text = format!(
        "{}\n{added}{}: {kept} kept, {dropped}\n",
        outcome.text,
        args.output.display()
    );
    Ok(Outcome { text, ..outcome })
}

impl Args {
    /// Fits the FRFs of `model` anew, with additional modes at these frequencies.
    fn fitted_with(
        &self,
        model: &ModalModel,
        added_hz: &[f64],
        console: &Console,
    ) -> Result<ModalModel> {
        let frf = match self.measured.as_slice() {
            [] => measured_beside(&self.model, model, console),
            files => Some(measured_by_user(files, model, console)?),
        };
        let frf = frf.ok_or_else(|| {
            Error::bad_data("a mode is added by a new fit, and the FRFs are not at hand")
                .file(&self.model)
                .field("add")
                .expected("the FRFs that the model was fitted to, beside it")
                .help("name them: --measured FRF")
        })?;
        let options = options_adding(model, added_hz, &self.model)?;
        let stage = |name: &str| console.stage(name);
        let fit = fit_watched(&frf, &options, &stage, &CancelToken::new())
            .map_err(|error| explain(&error, &options, &self.model))?;
        Ok(again(fit.model, model, &options))
    }
}

/// The options of a fit like that of `model`, which is in `file`, with additional modes.
///
/// # Errors
/// A model that another method fitted.
pub fn options_adding(model: &ModalModel, added_hz: &[f64], file: &Path) -> Result<FitOptions> {
    let options = FitOptions::adding_to(model, added_hz);
    if options.method == Method::Auto {
        return Ok(options);
    }
    Err(
        Error::bad_data("modes are added to fits of the method auto")
            .file(file)
            .field("method")
            .found(options.method)
            .expected("auto")
            .help("fit again without --method"),
    )
}

/// The new fit with the sources and options of `before`, and the added modes.
pub fn again(mut model: ModalModel, before: &ModalModel, options: &FitOptions) -> ModalModel {
    model.source.clone_from(&before.source);
    model.options.clone_from(&before.options);
    let added = options.added_hz.clone();
    model.options.insert("added_hz".into(), added.into());
    model
}

/// The mode that came of adding one at `hz`, in words.
fn outcome_of_added(model: &ModalModel, hz: f64) -> String {
    let place = significant(hz, 6);
    let Some(mode) = model.mode_seen_at(hz) else {
        return format!("added at {place} Hz: no mode came of it");
    };
    let grade = match mode.trust {
        Trust::Sure => "sure",
        Trust::Weak => "weak",
        Trust::Rejected => "rejected: more likely absent than present",
    };
    let reasons = mode.reasons.sentences();
    let why = if reasons.is_empty() {
        String::new()
    } else {
        format!(" ({})", reasons.join("; "))
    };
    let found = significant(mode.frequency_hz, 6);
    format!("added at {place} Hz: {found} Hz, {grade}{why}")
}
