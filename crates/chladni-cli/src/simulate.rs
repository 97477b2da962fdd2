//! `chladni simulate`: FRFs of a virtual panel and the model behind them, or the field that
//! weights make on it.

use crate::extent::Extent;
use crate::plan::Plan;
use crate::scanned::{scanned, ScannerNoise};
use chladni_console::input::{read_weights, source};
use chladni_console::memory::{parse_memory, MEMORY};
use chladni_console::output::{Output, FRF, MODEL, TABLE};
use chladni_console::table::{counted, significant};
use chladni_console::{Console, Outcome};
use chladni_frf::{Dof, Error, ErrorKind, ReferenceUnit, Result};
use chladni_io::{field_csv, is_same_place, sha256_of, write_contents, write_model, Contents};
use chladni_plate::{simulate, DampedPlate, Layout, Panel};
use chladni_render::Weights;
use ndarray::Array1;
use num_complex::Complex64;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni simulate panel.toml -o panel.h5
  chladni simulate panel.toml -o noisy.uff --truth truth.json --snr-db 20 --seed 7
  chladni simulate panel.toml --play weights.json -o field.csv")]
pub struct Args {
    /// Panel file: plate, measured grid, driven points, frequency axis, noise
    #[arg(value_name = "PANEL.toml")]
    panel: PathBuf,
    /// FRF file to write: .h5 (exact), .uff (binary), .unv (text) or .csv; with --play the
    /// field, .csv
    #[arg(short, long, value_name = "FRF")]
    output: PathBuf,
    /// Play these weights on the panel and write the field at its responses, as a scanner
    /// would, for `evaluate --field` and `correct`
    #[arg(long, value_name = "WEIGHTS", conflicts_with = "truth")]
    play: Option<PathBuf>,
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
    /// Say how large the result would be, and end
    #[arg(long, conflicts_with = "play")]
    dry_run: bool,
}

fn parse_snr(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() || value == f64::INFINITY => Ok(value),
        _ => Err("not a number of decibels".into()),
    }
}

/// Bytes of the FRFs of a panel.
fn frf_bytes(panel: &Panel) -> u64 {
    let layout = panel.layout();
    let pairs = layout.response_dofs.len() * layout.reference_dofs.len();
    (pairs * panel.frf.frequency_hz().len() * size_of::<Complex64>()) as u64
}

/// Runs the command.
///
/// # Errors
/// Those of the panel and of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if let Some(weights) = &args.play {
        return play(weights, args, console);
    }
    let inputs = std::slice::from_ref(&args.panel);
    let output = Output::new(&args.output, FRF, inputs, console)?;
    check_truth(args)?;
    let truth_output = Output::asked("--truth", args.truth.as_deref(), MODEL, inputs, console)?;
    let panel = Panel::read(&args.panel, args.memory)?;
    if args.dry_run {
        return Ok(planned(args, &panel));
    }
    let sources = vec![source(&args.panel)?];

    console.stage("simulating the panel");
    let simulation =
        simulate(&panel, args.seed, args.snr_db).map_err(|error| error.file(&args.panel))?;
    console.find_all(&simulation.findings);

    console.stage("writing");
    let mut truth = simulation.truth;
    let extent = Extent::of(&simulation.frf);
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
        "responses": extent.responses,
        "references": extent.references,
        "lines": extent.lines,
        "axis_hz": extent.axis_hz,
        "modes": modes,
        "snr_db": snr_db,
        "seed": args.seed.unwrap_or(panel.frf.seed),
    });
    let text = format!(
        "{}: {extent}, {}, signal-to-noise ratio {snr_db} dB\n",
        args.output.display(),
        counted(modes, "mode"),
    );
    Ok(Outcome::written(&args.output, json, text))
}

/// Refuses one file for FRFs and model.
fn check_truth(args: &Args) -> Result<()> {
    let is_one = |truth: &PathBuf| is_same_place(truth, &args.output);
    if !args.truth.as_ref().is_some_and(is_one) {
        return Ok(());
    }
    Err(Error::new(
        ErrorKind::Usage,
        "the FRFs and the model behind them are two files",
    )
    .file(&args.output)
    .field("--truth")
    .found("the name of the other output")
    .expected("a name of its own")
    .help("give --truth another name"))
}

/// The outcome of a dry run.
fn planned(args: &Args, panel: &Panel) -> Outcome {
    let outputs = std::iter::once(&args.output).chain(&args.truth);
    let plan = Plan {
        files: std::slice::from_ref(&args.panel),
        frf_bytes: frf_bytes(panel),
        parts: None,
        memory: args.memory,
        outputs: outputs.map(PathBuf::as_path).collect(),
    };
    plan.outcome()
}

/// Writes the field that weights make on the panel.
fn play(file: &Path, args: &Args, console: &Console) -> Result<Outcome> {
    let inputs = [args.panel.clone(), file.to_path_buf()];
    let output = Output::new(&args.output, TABLE, &inputs, console)?;
    let panel = Panel::read(&args.panel, args.memory)?;
    let weights = read_weights(file)?;
    let layout = panel.layout();
    let drive = forces(&weights, &layout, &panel).map_err(|error| error.file(file))?;
    console.stage("simulating the field");
    let frequency_hz = weights.frequency_hz;
    let top_hz = panel.frf.stop_hz.max(frequency_hz);
    let plate = DampedPlate::of_panel(&panel, top_hz).map_err(|error| error.file(&args.panel))?;
    let mobility =
        plate.mobility_matrix(&layout.responses_m, &layout.references_m, frequency_hz)?;
    let velocities = mobility.dot(&drive);
    let responses = layout.response_dofs.iter().copied();
    let velocities: Vec<(Dof, Complex64)> = responses.zip(velocities).collect();
    let noise = ScannerNoise {
        snr_db: args.snr_db.unwrap_or(panel.frf.snr_db),
        seed: args.seed.unwrap_or(panel.frf.seed),
    };
    let field = scanned(&velocities, frequency_hz, sha256_of(file)?, noise)?;
    console.stage("writing");
    output.write_bytes(field_csv(&field))?;
    let count = field.points.len();
    let json = json!({
        "output": args.output.display().to_string(),
        "weights": file.display().to_string(),
        "frequency_hz": frequency_hz,
        "responses": count,
        "snr_db": noise.snr_db,
        "seed": noise.seed,
    });
    let text = format!(
        "{}: field at {} under {}, {} Hz, signal-to-noise ratio {} dB\n",
        args.output.display(),
        counted(count, "response"),
        file.display(),
        significant(frequency_hz, 6),
        noise.snr_db
    );
    Ok(Outcome::written(&args.output, json, text))
}

/// The weights as forces on the references of the panel, N.
fn forces(weights: &Weights, layout: &Layout, panel: &Panel) -> Result<Array1<Complex64>> {
    let count = layout.reference_dofs.len();
    let per_volt = panel.references.newtons_per_volt.as_ref();
    let (unit, newtons) = match per_volt {
        Some(force) => (ReferenceUnit::Volt, force.of_references(count)),
        None => (ReferenceUnit::Newton, vec![1.0; count]),
    };
    let mut drive = Array1::zeros(count);
    for weight in &weights.weights {
        if weight.unit != unit {
            let (message, help) = match unit {
                ReferenceUnit::Volt => (
                    "this panel is driven by voltages",
                    "render with a model whose references are volts, or take newtons_per_volt out \
                     of the panel",
                ),
                ReferenceUnit::Newton => (
                    "this panel is driven by forces",
                    "give newtons_per_volt under [references] of the panel, or render with a model \
                     whose references are forces",
                ),
            };
            return Err(Error::bad_data(message)
                .field("weights")
                .found(format!("a weight in {}", weight.unit))
                .expected(format!("weights in {unit}"))
                .help(help));
        }
        let same = |dof: &Dof| dof.same_axis(weight.reference);
        let place = layout.reference_dofs.iter().position(same).ok_or_else(|| {
            Error::bad_data("the panel has no such reference")
                .field("weights")
                .found(weight.reference)
                .expected(format!(
                    "one of its {} references, from {} on",
                    layout.reference_dofs.len(),
                    layout.reference_dofs[0]
                ))
                .help("give the panel that the weights were rendered for")
        })?;
        let sense =
            weight.reference.direction.sign() * layout.reference_dofs[place].direction.sign();
        drive[place] += weight.value() * (sense * newtons[place]);
    }
    Ok(drive)
}
