//! `chladni play`: drive signals of a scene in time.

use crate::blame::blame_model;
use crate::limits::{PLAY_FRAMES, PNG_SCALE, STRESS_DRAWS};
use crate::render::doubt;
use crate::signal_files::SignalFiles;
use crate::time_table::{stress_table, time_table};
use chladni_console::input::{read_weights, source};
use chladni_console::output::{make_folder, Output, PICTURE, SIGNALS};
use chladni_console::table::significant;
use chladni_console::{unbroken, whole_number, Console, Outcome};
use chladni_frf::{Error, ModalModel, Result};
use chladni_io::{read_model, try_place};
use chladni_render::{
    play, stress_in_time, ChannelMap, MethodChoice, PlayOptions, Played, Ramps, RenderOptions,
    SampleFormat, Scene, Signal, SignalOptions, StressOptions, TimeStressRow,
};
use chladni_report::{moving_field, time_figure};
use chladni_text::read_text;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `play`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni play model.json bursts.toml -o drive.wav                      [time] of the scene, ramps that stay quiet
  chladni play model.json bursts.toml --weights weights.json -o drive.wav --format i24
  chladni play model.json bursts.toml -o drive.wav --channel-map dac.csv --full-scale 5
  chladni play model.json bursts.toml --charts figures                  hot and cold ground over time, plain ramps behind
  chladni play model.json bursts.toml --stress                          on a panel that errs, drifts, is touched, loses an actuator
  chladni play model.json bursts.toml                                   only how it would be felt")]
pub struct Args {
    /// Model file, as `chladni fit` writes it
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Scene file with a table `time`; without it two steady seconds are played
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Steady weights of the scene's own zones, as `chladni render` wrote them; all others
    /// are rendered
    #[arg(long, value_name = "WEIGHTS")]
    weights: Option<PathBuf>,
    /// Signal to write: .wav (with a .json beside it), .csv or .npz
    #[arg(short, long, value_name = "DRIVE")]
    output: Option<PathBuf>,
    /// How the drive comes and goes, in place of the scene's `ramps`
    #[arg(long, value_name = "RAMPS", value_parser = PossibleValuesParser::new(Ramps::ALL.map(Ramps::as_str)))]
    ramps: Option<String>,
    /// How steady weights are found
    #[arg(long, value_name = "METHOD", default_value = "default", value_parser = PossibleValuesParser::new(MethodChoice::names())
        .try_map(|name| name.parse::<MethodChoice>()))]
    method: MethodChoice,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 48_000, value_parser = parse_rate)]
    rate: u32,
    /// Samples of a sound file: 32-bit float, 24-bit or 16-bit integer
    #[arg(long, value_name = "FORMAT", default_value = "f32", value_parser = PossibleValuesParser::new(SampleFormat::ALL.map(SampleFormat::as_str))
        .try_map(|name| name.parse::<SampleFormat>()))]
    format: SampleFormat,
    /// What a sample of 1 means, N or V: the smallest round number above the peak, or this
    #[arg(
        long,
        value_name = "auto|X",
        default_value = "auto",
        allow_negative_numbers = true
    )]
    full_scale: FullScale,
    /// CSV file channel,reference,gain: which actuator is on which channel, and a factor
    /// on it, as V/N
    #[arg(long, value_name = "FILE")]
    channel_map: Option<PathBuf>,
    /// Try the drive on a panel that errs, drifts, loses an actuator, and under a finger
    /// that comes and goes
    #[arg(long)]
    stress: bool,
    /// Seed of the stress table's draws
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Folder for pictures: hot and cold ground, forces and places over time (SVG, PNG), and
    /// the moving ground (GIF)
    #[arg(long, value_name = "DIR")]
    charts: Option<PathBuf>,
}

/// `--rate` as a number.
fn parse_rate(text: &str) -> Result<u32> {
    whole_number(text, 1..=u32::MAX, " of Hz", "no sampling rate")
        .map_err(|error| error.help("48000 is usual"))
}

/// Value of a sample of 1; `None`: a round number above the peak.
#[derive(Debug, Clone, Copy)]
struct FullScale(Option<f64>);

impl std::str::FromStr for FullScale {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.parse::<f64>()) {
            ("auto", _) => Ok(Self(None)),
            (_, Ok(number)) if number.is_finite() && number > 0.0 => Ok(Self(Some(number))),
            _ => Err("neither `auto` nor a number above 0".into()),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, of a scene that does not fit the model, and of a signal that
/// cannot be made. A scene that cannot be met in time is a result.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let inputs: Vec<PathBuf> = [&args.model, &args.scene]
        .into_iter()
        .chain(&args.weights)
        .chain(&args.channel_map)
        .cloned()
        .collect();
    let files = args
        .output
        .as_deref()
        .map(|path| SignalFiles::new("-o", path, SIGNALS, &inputs, console))
        .transpose()?;
    if let Some(folder) = &args.charts {
        make_folder(folder, "--charts")?;
        unbroken(|| try_place(&folder.join("time"), true))?;
    }
    console.stage("reading");
    let model = read_model(&args.model)?;
    let scene = Scene::read(&args.scene)?;
    let weights = args.weights.as_deref().map(read_weights).transpose()?;
    let channels = args.channel_map.as_deref().map(channel_map).transpose()?;
    let sources = inputs
        .iter()
        .chain(&scene.actuators.calibration_file)
        .map(|file| source(file))
        .collect::<Result<Vec<_>>>()?;
    console.stage("rendering");
    let blame = |error: Error| match (error.field.as_deref(), &args.weights) {
        (Some("weights"), Some(weights)) => error.file(weights),
        _ => scene.blame(blame_model(error, &args.model)),
    };
    let played = play(&model, &scene, weights.as_ref(), &args.options()).map_err(blame)?;
    console.find_all(&played.findings);
    let stress = args
        .stress
        .then(|| tried(&played, &scene, &model, args.seed, console))
        .transpose()?;
    let mut signal = played
        .signal(&args.signal_options(channels), &scene.name())
        .map_err(|error| args.explained(error))?;
    signal.sidecar.source = sources;
    if let Some(files) = &files {
        console.stage("writing");
        files.write(&signal, args.format)?;
    }
    if let Some(folder) = &args.charts {
        console.stage("drawing");
        draw(folder, &scene, &played, console)?;
    }
    let mut json = summary(args, files.as_ref(), &played, &signal);
    let mut text = format!(
        "{}\n{}{}",
        played.indices.sentence(),
        time_table(&played.indices),
        signal_line(&played, &signal, args)
    );
    if let Some(rows) = &stress {
        json["stress"] = json!(rows);
        json["stress_seed"] = json!(args.seed);
        text += &format!("\n{}", stress_table(rows));
    }
    let outcome = match &args.output {
        Some(path) => Outcome::written(path, json, text),
        None => Outcome::shown(json, text),
    };
    Ok(outcome.doubted(doubt(played.feasible, &played.findings)))
}

impl Args {
    fn options(&self) -> PlayOptions {
        let is_named = |ramps: &Ramps| self.ramps.as_deref() == Some(ramps.as_str());
        let draws = self.charts.is_some();
        PlayOptions {
            ramps: Ramps::ALL.into_iter().find(is_named),
            render: RenderOptions {
                method: self.method,
                ..RenderOptions::default()
            },
            frames: if draws { PLAY_FRAMES } else { 0 },
            plain: draws,
            ..PlayOptions::default()
        }
    }

    fn signal_options(&self, channels: Option<ChannelMap>) -> SignalOptions {
        SignalOptions {
            rate_hz: self.rate,
            format: self.format,
            full_scale: self.full_scale.0,
            channels,
        }
    }

    /// The error of a signal with the option that sets the field which it names, or with the
    /// channel map.
    fn explained(&self, error: Error) -> Error {
        match (error.field.as_deref(), &self.channel_map) {
            (Some("rate_hz"), _) => error.field("--rate"),
            (Some("full_scale"), _) => error.field("--full-scale"),
            (Some("reference"), Some(map)) => error.file(map),
            _ => error,
        }
    }
}

fn channel_map(file: &Path) -> Result<ChannelMap> {
    let text = read_text(file, "a channel map, CSV")?;
    ChannelMap::parse(&text).map_err(|error| error.file(file))
}

/// The stress table of the drive in time.
fn tried(
    played: &Played,
    scene: &Scene,
    model: &ModalModel,
    seed: u64,
    console: &Console,
) -> Result<Vec<TimeStressRow>> {
    console.stage("stress");
    let options = StressOptions {
        seed,
        draws: STRESS_DRAWS,
        ..StressOptions::default()
    };
    let (rows, findings) = stress_in_time(played, scene, model, &options)?;
    console.find_all(&findings);
    Ok(rows)
}

/// Writes the chart with plain ramps for comparison, and the moving ground.
fn draw(folder: &Path, scene: &Scene, played: &Played, console: &Console) -> Result<()> {
    let title = format!("{} over time", scene.name());
    let drawing = time_figure("time", &title, played).draw();
    let mut files: Vec<(&str, Vec<u8>)> = vec![
        ("svg", drawing.to_svg().into_bytes()),
        ("png", drawing.to_png(PNG_SCALE)),
    ];
    let moving = played.frames.as_ref().map_or(Ok(None), moving_field)?;
    files.extend(moving.map(|bytes| ("gif", bytes)));
    for (extension, content) in files {
        let path = folder.join(format!("time.{extension}"));
        Output::new(&path, PICTURE, &[], console)?.write_bytes(content)?;
    }
    Ok(())
}

fn summary(
    args: &Args,
    files: Option<&SignalFiles>,
    played: &Played,
    signal: &Signal,
) -> serde_json::Value {
    let shown = |path: &Path| path.display().to_string();
    json!({
        "output": args.output.as_deref().map(shown),
        "sidecar": files.and_then(SignalFiles::sidecar).map(shown),
        "feasible": played.feasible,
        "time": played.indices,
        "signal": signal.sidecar,
        "peak": signal.peak,
    })
}

/// The drive signal in words.
fn signal_line(played: &Played, signal: &Signal, args: &Args) -> String {
    let scales = signal
        .sidecar
        .channels
        .iter()
        .map(|channel| channel.full_scale * channel.gain);
    let full_scale = scales.fold(0.0, f64::max);
    format!(
        "{} channels at {} Hz, {} frames, {}; full scale is {} {}, the peak {:.1} dB below it; ramps of {} ms, force up to {:.2} of the steady one\n",
        signal.sidecar.channels.len(),
        args.rate,
        signal.sidecar.frames,
        args.format.as_str(),
        significant(full_scale, 3),
        played.unit,
        -20.0 * signal.peak.log10(),
        significant(1e3 * played.indices.ramp_s, 3),
        played.indices.peak_drive / played.indices.steady_drive
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_out_of_range_is_told_the_range_in_hz() {
        assert_eq!(parse_rate("4294967295"), Ok(u32::MAX));
        for text in ["0", "4294967296", "-5", "44100.5", "48k"] {
            let expected = parse_rate(text).unwrap_err().expected.unwrap();
            assert_eq!(expected, "a whole number of Hz from 1 to 4294967295");
        }
    }
}
