//! `chladni render`: weights that move a panel here and keep it quiet there.

mod drive;
mod frequency;
mod next_step;
mod text;

use crate::blame::blame_model;
use crate::limits::SWEEP_HZ;
use crate::signal_files::SignalFiles;
use chladni_console::input::{expand, read_frf, source, Reading};
use chladni_console::output::{Output, SIGNAL_OR_TABLE, WEIGHTS};
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result, Severity, Source};
use chladni_io::{is_same_place, read_model};
use chladni_render::{
    render_with_others, stress, sweep, Count, Method, MethodChoice, RenderOptions, Rendering,
    Scene, StressOptions, Weights,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use drive::Drive;
use frequency::{Frequency, RangeSweep};
use next_step::next_step;
use serde_json::{json, Map, Value};
use std::path::{Path, PathBuf};

/// Arguments of `render`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni render model.json corner.toml                     the weights and how well they do
  chladni render model.json corner.toml -o weights.json
  chladni render model.json corner.toml --method fast
  chladni render model.json corner.toml --modes auto --actuators auto --measured panel.h5
  chladni render model.json corner.toml --actuators auto --also centre.toml edge.toml
  chladni render model.json corner.toml --sweep 250:350 --stress
  chladni render model.json corner.toml -o weights.json --wav drive.wav")]
pub struct Args {
    /// Model file, as `chladni fit` writes it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Scene file: drive frequency, threshold, zones, actuators
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Weights file to write, .json
    #[arg(short, long, value_name = "WEIGHTS")]
    output: Option<PathBuf>,
    /// How the weights are found
    #[arg(long, value_name = "METHOD", default_value = "default", value_parser = PossibleValuesParser::new(MethodChoice::names())
        .try_map(|name| name.parse::<MethodChoice>()))]
    method: MethodChoice,
    /// Modes to sum: all, as few as the scene needs, or so many; the others are folded
    /// into residual terms
    #[arg(long, value_name = "all|auto|N", default_value = "all")]
    modes: Count,
    /// Actuators to use: all, as few as the scene needs, or so many
    #[arg(long, value_name = "all|auto|N", default_value = "all")]
    actuators: Count,
    /// Other scenes that the actuators chosen by `--actuators auto` (or N) must serve
    /// too; each of the scenes rendered with the rest beside it gets the same actuators
    #[arg(long, value_name = "SCENE.toml", num_args = 1..)]
    also: Vec<PathBuf>,
    /// Measured FRFs whose line at the drive frequency judges `--modes auto`; without
    /// them the whole model does
    #[arg(long, value_name = "FRF", num_args = 1..)]
    measured: Vec<PathBuf>,
    /// Try the weights on a panel that errs, drifts, is touched, loses an actuator
    #[arg(long)]
    stress: bool,
    /// Method modal in one step, without singular values below this share of the largest
    #[arg(long, value_name = "X", value_parser = parse_share)]
    cut: Option<f64>,
    /// Try other drive frequencies and suggest the best, Hz
    #[arg(long, value_name = "LO:HI", value_parser = parse_range)]
    sweep: Option<[f64; 2]>,
    /// Drive frequency in place of the scene's, Hz; auto: the one that --sweep suggests, from
    /// 30 Hz below to 30 Hz above the scene's where no range is given
    #[arg(long, value_name = "auto|HZ")]
    frequency: Option<Frequency>,
    /// Drive signals to write: .wav, as `chladni play` makes it of the scene's table `time` or
    /// of two steady seconds, or .csv (a table of amplitude and phase)
    #[arg(long, value_name = "FILE")]
    wav: Option<PathBuf>,
    /// Seed of the stress table's draws
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    reading: Reading,
}

/// The content of the files that a rendering starts from.
struct Given {
    model: ModalModel,
    scene: Scene,
    /// Scenes that the chosen actuators must serve too.
    others: Vec<Scene>,
    sources: Vec<Source>,
    measured: Option<FrfSet>,
}

impl Args {
    /// Refuses options that do not go together.
    fn check(&self) -> Result<()> {
        if self.cut.is_none() || self.method == MethodChoice::Only(Method::Modal) {
            return Ok(());
        }
        Err(
            Error::new(ErrorKind::Usage, "only method modal has a cut-off")
                .field("--cut")
                .found("another method")
                .expected("--method modal")
                .help("leave --cut out, or add --method modal"),
        )
    }

    /// Notes on options that have no effect here.
    fn without_effect(&self) -> Vec<Finding> {
        let all_actuators = self.actuators == Count::All;
        let mut notes = Vec::new();
        if !self.also.is_empty() && all_actuators {
            let words = "the scenes of --also change nothing where all actuators are used";
            let help = "add --actuators auto, or leave --also out";
            notes.push(Finding::note("also-of-all", words).help(help));
        }
        let sweeps = self.sweep.is_some() || matches!(self.frequency, Some(Frequency::Auto));
        if sweeps && !(all_actuators && self.modes == Count::All) {
            let words = "the sweep drives all actuators and sums all modes at each frequency";
            notes.push(Finding::note("sweep-of-all", words));
        }
        notes
    }

    fn read(&self, console: &Console) -> Result<Given> {
        let model = read_model(&self.model)?;
        let scene = Scene::read(&self.scene)?;
        let others = self
            .also
            .iter()
            .map(|file| Scene::read(file))
            .collect::<Result<Vec<_>>>()?;
        let mut sources = [&self.model, &self.scene]
            .into_iter()
            .chain(&scene.actuators.calibration_file)
            .chain(&self.also)
            .map(|file| source(file))
            .collect::<Result<Vec<_>>>()?;
        let mut measured = None;
        if !self.measured.is_empty() {
            let files = expand(&self.measured, console)?;
            let (frf, read) = read_frf(&files, &self.reading, console)?;
            sources.extend(read);
            measured = Some(frf);
        }
        Ok(Given {
            model,
            scene,
            others,
            sources,
            measured,
        })
    }

    fn options(&self) -> RenderOptions {
        RenderOptions {
            method: self.method,
            modes: self.modes,
            actuators: self.actuators,
            cut: self.cut,
            ..RenderOptions::default()
        }
    }

    /// Sets the scene to the frequency of `--frequency`. Returns the sweep that suggested it.
    fn set_frequency(
        &self,
        model: &ModalModel,
        scene: &mut Scene,
        options: &RenderOptions,
        console: &Console,
    ) -> Result<Option<RangeSweep>> {
        match self.frequency {
            Some(Frequency::Auto) => self
                .better_frequency(model, scene, options, console)
                .map(Some),
            Some(Frequency::Hertz(hz)) if scene.other_tones.is_empty() => {
                scene.frequency_hz = hz;
                Ok(None)
            }
            Some(Frequency::Hertz(_)) => Err(scene.blame(
                Error::new(
                    ErrorKind::Usage,
                    "one frequency cannot replace several tones",
                )
                .field("--frequency")
                .found(format!("{} tones in the scene", scene.tones().len()))
                .expected("a scene of one frequency")
                .help("leave --frequency out, or give a scene with one of the tones"),
            )),
            None => Ok(None),
        }
    }

    /// Sets the scene to the frequency that a sweep suggests, and returns the sweep.
    fn better_frequency(
        &self,
        model: &ModalModel,
        scene: &mut Scene,
        options: &RenderOptions,
        console: &Console,
    ) -> Result<RangeSweep> {
        console.stage("sweeping frequencies");
        let hz = scene.frequency_hz;
        let range_hz = self
            .sweep
            .unwrap_or([(hz - SWEEP_HZ).max(1.0), hz + SWEEP_HZ]);
        let sweep = sweep(model, scene, options, range_hz)
            .map_err(|error| scene.blame(blame_model(error, &self.model)))?;
        scene.frequency_hz = sweep.suggested_hz.unwrap_or(hz);
        Ok(RangeSweep { range_hz, sweep })
    }

    /// Puts every tone of `weights` to the trials that are asked for. `swept` is the sweep that
    /// was made before the rendering.
    fn try_out(
        &self,
        weights: &mut Weights,
        swept: Option<RangeSweep>,
        model: &ModalModel,
        scene: &Scene,
        console: &Console,
    ) -> Result<()> {
        let options = self.options();
        let trials = Trials {
            stress_seed: self.stress.then_some(self.seed),
            sweep_hz: self.sweep.filter(|_| swept.is_none()),
        };
        trials.on(weights, model, scene, &options, console)?;
        if let Some(RangeSweep { range_hz, sweep }) = swept {
            let echo = &mut weights.options;
            echo.insert("frequency".into(), "auto".into());
            echo.insert("sweep_hz".into(), range_hz.to_vec().into());
            weights.sweep = Some(sweep);
        }
        for tone in &mut weights.other_tones {
            trials.on(tone, model, scene, &options, console)?;
        }
        Ok(())
    }

    /// The files of drive signals, where these are asked for.
    fn signals(&self, inputs: &[PathBuf], console: &Console) -> Result<Option<SignalFiles>> {
        let signals = self
            .wav
            .as_deref()
            .map(|path| SignalFiles::new("--wav", path, SIGNAL_OR_TABLE, inputs, console))
            .transpose()?;
        let sidecar = signals.as_ref().and_then(SignalFiles::sidecar);
        let outputs = sidecar.zip(self.output.as_deref());
        if outputs.is_some_and(|(one, other)| is_same_place(one, other)) {
            return Err(
                Error::new(ErrorKind::Usage, "two outputs would be one file")
                    .field("--wav")
                    .found("a sound file whose sidecar has the name of the weights file")
                    .expected("another name: the sidecar is the sound file with .json"),
            );
        }
        Ok(signals)
    }
}

fn parse_range(text: &str) -> std::result::Result<[f64; 2], String> {
    let ends: Option<Vec<f64>> = text
        .split(':')
        .map(|end| end.trim().parse().ok().filter(|hz: &f64| hz.is_finite()))
        .collect();
    match ends.as_deref() {
        Some(&[low, high]) if low < high => Ok([low, high]),
        Some(&[_, _]) => Err("the range does not rise, as 250:350 does".into()),
        _ => Err("no range LO:HI, as in 250:350".into()),
    }
}

fn parse_share(text: &str) -> std::result::Result<f64, String> {
    let share = text.parse().ok().filter(|share| (0.0..1.0).contains(share));
    share.ok_or_else(|| "no share from 0 to below 1, as in 0.01".into())
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, and of a scene that does not fit the model. A scene that
/// cannot be met is a result.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let inputs = [args.model.clone(), args.scene.clone()];
    args.check()?;
    let output = Output::asked("-o", args.output.as_deref(), WEIGHTS, &inputs, console)?;
    let signals = args.signals(&inputs, console)?;
    console.stage("reading");
    let Given {
        model,
        mut scene,
        others,
        sources,
        measured,
    } = args.read(console)?;

    console.stage("rendering");
    let options = args.options();
    let swept = args.set_frequency(&model, &mut scene, &options, console)?;
    let blame = |error: Error| scene.blame(blame_model(error, &args.model));
    let rendered =
        render_with_others(&model, &scene, &others, &options, measured.as_ref()).map_err(blame)?;
    let mut weights = rendered.weights.clone();
    weights.source = sources;
    if !others.is_empty() {
        weights
            .options
            .insert("also".into(), others.iter().map(Scene::name).collect());
    }
    args.reading.echo(&mut weights.options);
    weights.findings.extend(args.without_effect());
    let kept = |swept: &RangeSweep| swept.finding(scene.frequency_hz, model.band_hz);
    weights.findings.extend(swept.as_ref().and_then(kept));
    args.try_out(&mut weights, swept, &model, &scene, console)
        .map_err(|error| blame_model(error, &args.model))?;
    console.find_all(weights.findings.iter());
    let drive = match &signals {
        Some(files) => Some((files, Drive::of(files, &model, &scene, &weights, blame)?)),
        None => None,
    };
    if let Some(output) = &output {
        console.stage("writing");
        write_weights(output, &weights)?;
    }
    if let Some((files, drive)) = drive {
        drive.write(files)?;
    }
    let doubt = doubt(weights.feasible, &weights.findings);
    let text = text::text(&weights, &rendered, console.verbose);
    let outcome = match &args.output {
        Some(path) => Outcome::written(path, summary(&weights, path)?, text),
        None => Outcome::shown(value_of(&weights)?, text),
    };
    Ok(Outcome {
        next: next_step(args, &weights, model.band_hz),
        ..outcome.doubted(doubt)
    })
}

/// The reason why a drive does not serve its scene, or may not; `None` where it serves.
pub fn doubt(feasible: bool, findings: &[Finding]) -> Option<String> {
    let has = |code: &str| findings.iter().any(|finding| finding.code == code);
    let is_fault =
        |finding: &Finding| finding.code == "replayed-worse" && finding.severity == Severity::Fault;
    match (feasible, has("untrusted-model")) {
        (false, _) if findings.iter().any(is_fault) => {
            Some("the scene is not met in the whole model: see above".into())
        }
        (false, _) => Some("the scene is not met: see above".into()),
        (true, true) => Some("the model is not to be trusted: see above".into()),
        (true, false) => None,
    }
}

/// Renders one scene; the weights name `sources` as theirs.
///
/// # Errors
/// Those of the scene, with its file.
pub fn render_scene(
    model: &ModalModel,
    scene: &Scene,
    options: &RenderOptions,
    measured: Option<&FrfSet>,
    sources: Vec<Source>,
) -> Result<Rendering> {
    let mut rendering = chladni_render::render_measured(model, scene, options, measured)
        .map_err(|error| scene.blame(error))?;
    rendering.weights.source = sources;
    Ok(rendering)
}

/// Trials of weights on other panels and at other frequencies.
pub struct Trials {
    /// Seed of the stress table; `None`: no table.
    pub stress_seed: Option<u64>,
    /// Drive frequencies to try, Hz.
    pub sweep_hz: Option<[f64; 2]>,
}

impl Trials {
    /// Puts `weights` to the trials and stores the outcome in them.
    ///
    /// # Errors
    /// A range of frequencies that cannot be swept.
    pub fn on(
        &self,
        weights: &mut Weights,
        model: &ModalModel,
        scene: &Scene,
        options: &RenderOptions,
        console: &Console,
    ) -> Result<()> {
        if let Some(seed) = self.stress_seed {
            console.stage("stress");
            let (rows, findings) = stress(
                weights,
                scene,
                model,
                &StressOptions {
                    seed,
                    ..StressOptions::default()
                },
            )?;
            weights.options.insert("stress_seed".into(), seed.into());
            weights.stress = Some(rows);
            weights.findings.extend(findings);
        }
        if let Some(range) = self.sweep_hz {
            console.stage("sweeping frequencies");
            weights
                .options
                .insert("sweep_hz".into(), range.to_vec().into());
            weights.sweep = Some(sweep(model, scene, options, range)?);
        }
        Ok(())
    }
}

/// Writes a weights file.
///
/// # Errors
/// Those of writing.
pub fn write_weights(output: &Output, weights: &Weights) -> Result<()> {
    output.write_bytes(weights.to_json()?)
}

/// The weights as in their file.
///
/// # Errors
/// [`ErrorKind::Internal`] where they have no JSON.
pub fn value_of(weights: &Weights) -> Result<Value> {
    serde_json::to_value(weights).map_err(|error| {
        Error::new(
            ErrorKind::Internal,
            format!("the weights have no JSON: {error}"),
        )
    })
}

/// The content of a weights file without the weights themselves.
fn summary(weights: &Weights, output: &Path) -> Result<Value> {
    let mut summary = Map::from_iter([("output".to_owned(), json!(output.display().to_string()))]);
    if let Value::Object(fields) = value_of(weights)? {
        summary.extend(light(fields));
        if let Some(Value::Array(tones)) = summary.get_mut("other_tones") {
            tones.iter_mut().for_each(|tone| {
                if let Value::Object(fields) = tone {
                    *fields = light(std::mem::take(fields)).collect();
                }
            });
        }
    }
    Ok(summary.into())
}

/// The fields of weights without the heavy ones.
fn light(fields: Map<String, Value>) -> impl Iterator<Item = (String, Value)> {
    const HEAVY: [&str; 4] = ["format", "version", "created_by", "weights"];
    fields
        .into_iter()
        .filter(|(key, _)| !HEAVY.contains(&key.as_str()))
}
