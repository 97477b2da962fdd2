//! `chladni evaluate`: given weights on other data.

mod field;

use crate::blame::blame_model;
use crate::indices::indices_table;
use crate::time_table::time_table;
use chladni_console::input::{expand, model_of, read_frf, read_weights, source, Reading};
use chladni_console::table::significant;
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, ModalModel, Result};
use chladni_io::{detect_format, read_document, Abscissa, FileFormat, Ordinate, ReadOptions};
use chladni_render::{
    evaluate_signal, play, Evaluation, On, PlayOptions, Recorded, Scene, Sidecar, TimeIndices,
    Weights,
};
use chladni_text::read_text;
use ndarray::Array2;
use serde_json::{json, Map, Value};
use std::path::{Path, PathBuf};

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni evaluate weights.json --scene corner.toml --on measured.h5     on the measured line at the drive frequency
  chladni evaluate weights.json --scene corner.toml --on other.json      on another model, in time where the scene has [time]
  chladni evaluate weights.json --scene corner.toml --on model.json --field scan.csv     a measured field, against its
      prediction: how near they are, and what may be wrong with the rig
  chladni evaluate drive.wav --scene corner.toml --on model.json         a drive signal with its sidecar drive.json")]
pub struct Args {
    /// Weights file, as `chladni render` writes it, or a sound file with its sidecar, as
    /// `chladni play` does
    #[arg(value_name = "WEIGHTS|DRIVE.wav")]
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

/// The data to judge on.
struct JudgedOn {
    files: Vec<PathBuf>,
    /// The model in the only file; `None` for FRFs.
    model: Option<ModalModel>,
}

impl JudgedOn {
    fn read(paths: &[PathBuf], console: &Console) -> Result<Self> {
        let files = expand(paths, console)?;
        let model = match files.as_slice() {
            [one] => model_of(one)?,
            _ => None,
        };
        Ok(Self { files, model })
    }
}

/// Runs the command. It only reports: weights that fail are no error.
///
/// # Errors
/// Those of reading, and data that the weights do not fit.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    console.stage("reading");
    if detect_format(&args.weights)? == FileFormat::Wav {
        return of_signal(args, console);
    }
    let weights = read_weights(&args.weights)?;
    let scene = Scene::read(&args.scene)?;
    let mut sources = vec![source(&args.weights)?, source(&args.scene)?];
    if let Some(file) = &scene.actuators.calibration_file {
        sources.push(source(file)?);
    }
    let JudgedOn { files, model } = JudgedOn::read(&args.on, console)?;
    if !args.field.is_empty() {
        let model = model.ok_or_else(needs_model)?;
        sources.push(source(&files[0])?);
        let model = (&model, files[0].as_path());
        return field::run(args, &weights, &scene, model, sources, console);
    }
    let judge = |on: On| {
        console.stage("judging");
        chladni_render::evaluate(&weights, &scene, on).map_err(|error| error.file(&files[0]))
    };
    let mut in_time = None;
    let evaluation = match model {
        Some(model) => {
            sources.push(source(&files[0])?);
            // weights that are not of this model are refused here
            let steady = judge(On::Model(&model))?;
            in_time = indices_in_time((&model, &files[0]), &scene, &weights, console)?;
            steady
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
    let mut summary = judged(&evaluation);
    let tones = &evaluation.other_tones;
    if !tones.is_empty() {
        let tones = tones.iter().map(judged).map(Value::Object).collect();
        summary.insert("other_tones".into(), tones);
    }
    summary.insert("weights".into(), args.weights.display().to_string().into());
    summary.insert("scene".into(), args.scene.display().to_string().into());
    summary.insert("on".into(), names(&files).into());
    summary.insert("source".into(), json!(sources));
    let tones = std::iter::once(&evaluation).chain(tones);
    let mut words = tones.map(text).collect::<Vec<_>>().join("\n");
    if let Some(indices) = &in_time {
        summary.insert("time".into(), json!(indices));
        words += &format!("\n{}", in_words(indices));
    }
    Ok(Outcome::shown(summary.into(), words))
}

/// Indices of the drive over time; `None` for the scene of a steady tone.
fn indices_in_time(
    (model, file): (&ModalModel, &Path),
    scene: &Scene,
    weights: &Weights,
    console: &Console,
) -> Result<Option<TimeIndices>> {
    if scene.time.is_none() {
        return Ok(None);
    }
    let played = play(model, scene, Some(weights), &PlayOptions::default())
        .map_err(|error| scene.blame(blame_model(error, file)))?;
    console.find_all(&played.findings);
    Ok(Some(played.indices))
}

/// The error of a measured field that is judged on FRFs.
fn needs_model() -> Error {
    Error::new(ErrorKind::Usage, "a measured field is held against a model")
        .field("--on")
        .found("FRFs")
        .expected("the model that the weights were rendered with")
}

fn names(files: &[PathBuf]) -> Vec<String> {
    files
        .iter()
        .map(|file| file.display().to_string())
        .collect()
}

/// Judges a drive signal on a model.
fn of_signal(args: &Args, console: &Console) -> Result<Outcome> {
    let file = &args.weights;
    let beside = file.with_extension("json");
    let sidecar = read_text(&beside, "a signal's sidecar, JSON")
        .and_then(|text| Sidecar::parse(&text).map_err(|error| error.file(&beside)))
        .map_err(|error| error.help("the file beside the sound file says which actuator is on which channel; `chladni play` writes both"))?;
    let scene = Scene::read(&args.scene)?;
    let JudgedOn { files, model } = JudgedOn::read(&args.on, console)?;
    let Some(model) = model else {
        return Err(
            Error::new(ErrorKind::Usage, "a signal is judged on a model")
                .file(&files[0])
                .field("--on")
                .found("measured data")
                .expected("one model file")
                .help("fit the data first: chladni fit FRF -o model.json"),
        );
    };
    let (samples, rate_hz) = sound(file)?;
    let recorded =
        Recorded::from_samples(&samples, rate_hz, &sidecar).map_err(|error| error.file(file))?;
    console.stage("judging");
    let blame = |error: Error| match error.field.as_deref() {
        Some("channels") => error.file(&beside),
        _ => scene.blame(blame_model(error, &files[0])),
    };
    let (indices, findings) =
        evaluate_signal(&recorded, &sidecar.events, &scene, &model).map_err(blame)?;
    console.find_all(&findings);
    let sources = [file, &beside, &args.scene, &files[0]]
        .into_iter()
        .map(|file| source(file))
        .collect::<Result<Vec<_>>>()?;
    let json = json!({
        "signal": file.display().to_string(),
        "scene": args.scene.display().to_string(),
        "on": names(&files),
        "time": indices,
        "source": sources,
    });
    Ok(Outcome::shown(json, in_words(&indices)))
}

/// Samples of a sound file, −1 to 1, axes (frame, channel), and the sampling rate, Hz.
fn sound(file: &Path) -> Result<(Array2<f64>, f64)> {
    let document = read_document(file, &ReadOptions::default())?;
    let frames = document
        .functions
        .first()
        .map_or(0, |function| function.ordinate.len());
    let mut samples = Array2::zeros((frames, document.functions.len()));
    let mut rate_hz = 0.0;
    for (mut column, function) in samples.columns_mut().into_iter().zip(&document.functions) {
        match &function.ordinate {
            Ordinate::Real32(values) => column
                .iter_mut()
                .zip(values)
                .for_each(|(to, &v)| *to = v.into()),
            Ordinate::Real64(values) => column.iter_mut().zip(values).for_each(|(to, &v)| *to = v),
            _ => {}
        }
        if let Abscissa::Even { step, .. } = function.abscissa {
            rate_hz = (1.0 / step).round();
        }
    }
    Ok((samples, rate_hz))
}

fn in_words(indices: &TimeIndices) -> String {
    format!("{}\n{}", indices.sentence(), time_table(indices))
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
