//! `chladni simulate`: FRFs of a virtual panel, and the model behind them.

use chladni_console::input::source;
use chladni_console::memory::{parse_memory, MEMORY};
use chladni_console::output::{Output, FRF, MODEL};
use chladni_console::table::{counted, significant};
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_io::is_same_place;
use chladni_io::{write_contents, write_model, Contents};
use chladni_plate::{simulate, Panel};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni simulate panel.toml -o panel.h5
  chladni simulate panel.toml -o noisy.uff --truth truth.json --snr-db 20 --seed 7")]
pub struct Args {
    /// Panel file: plate, measured grid, driven points, frequency axis, noise
    #[arg(value_name = "PANEL.toml")]
    panel: PathBuf,
    /// FRF file to write: .h5 (exact), .uff (binary), .unv (text) or .csv
    #[arg(short, value_name = "FRF")]
    output: PathBuf,
    /// Also write the modal model behind the FRFs, .json or .h5
    #[arg(long, value_name = "MODEL.json")]
    truth: Option<PathBuf>,
    /// Noise level in place of the panel's; inf: no noise
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = parse_snr)]
    snr_db: Option<f64>,
    /// Seed of the noise in place of the panel's
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Refuse at once what needs more memory: bytes, or with K, M, G, T (powers of 1024)
    #[arg(long, value_name = "SIZE", default_value = MEMORY, value_parser = parse_memory)]
    memory: u64,
}

fn parse_snr(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() || value == f64::INFINITY => Ok(value),
        _ => Err("not a number of decibels".into()),
    }
}

/// Runs the command.
///
/// # Errors
/// Those of the panel and of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let inputs = std::slice::from_ref(&args.panel);
    let output = Output::new(&args.output, FRF, inputs, console)?;
    if args
        .truth
        .as_deref()
        .is_some_and(|truth| is_same_place(truth, &args.output))
    {
        return Err(Error::new(
            ErrorKind::Usage,
            "the FRFs and the model behind them are two files",
        )
        .file(&args.output)
        .field("--truth")
        .found("the name of the other output")
        .expected("a name of its own")
        .help("give --truth another name"));
    }
    let truth_output = args
        .truth
        .as_ref()
        .map(|path| Output::new(path, MODEL, inputs, console))
        .transpose()?;
    let panel = Panel::read(&args.panel, args.memory)?;
    let sources = vec![source(&args.panel)?];

    console.stage("simulating the panel");
    let simulation =
        simulate(&panel, args.seed, args.snr_db).map_err(|error| error.file(&args.panel))?;
    console.find_all(&simulation.findings);

    console.stage("writing");
    let mut truth = simulation.truth;
    let (responses, references, lines) = simulation.frf.values.dim();
    let frequency_hz = &simulation.frf.frequency_hz;
    let [first_hz, last_hz] = [frequency_hz[0], frequency_hz[lines - 1]];
    let contents = Contents {
        frf: Some(simulation.frf),
        sources: sources.clone(),
        ..Contents::default()
    };
    console.find_all(&output.write(|path, force| write_contents(path, &contents, force))?);
    truth.source = sources;
    if let Some(place) = &truth_output {
        place.write(|path, force| write_model(path, &truth, force))?;
    }

    let modes = truth.in_band_modes().count();
    let snr_db = args.snr_db.unwrap_or(panel.frf.snr_db);
    let json = json!({
        "output": args.output.display().to_string(),
        "truth": args.truth.as_ref().map(|path| path.display().to_string()),
        "frf_kind": truth.frf_kind,
        "responses": responses,
        "references": references,
        "lines": lines,
        "axis_hz": [first_hz, last_hz],
        "modes": modes,
        "snr_db": snr_db,
        "seed": args.seed.unwrap_or(panel.frf.seed),
    });
    let text = format!(
        "{}: {} of {} at {}, {} from {} to {} Hz, {}, signal-to-noise ratio {} dB\n",
        args.output.display(),
        truth.frf_kind,
        counted(responses, "response"),
        counted(references, "reference"),
        counted(lines, "line"),
        significant(first_hz, 6),
        significant(last_hz, 6),
        counted(modes, "mode"),
        snr_db
    );
    Ok(Outcome::written(&args.output, json, text))
}
