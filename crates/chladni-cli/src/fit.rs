//! `chladni fit`: modes from FRFs.

mod following;
mod scale;
mod text;

pub use text::text;

use crate::asked_model::AskedModel;
use crate::blame::blame_model;
use crate::explain::explain;
use crate::limits::MOST_FILES;
use crate::plan::Plan;
use crate::scene_band::SceneBand;
use crate::streaming::{too_large, Resume, Stream};
use chladni_console::input::{expand, read_frf, DofFile, Reading};
use chladni_console::memory::{parse_memory, MEMORY};
use chladni_console::next_step::report;
use chladni_console::output::{Output, MODEL};
use chladni_console::quoting::shell_path;
use chladni_console::table::significant;
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result, Source, Trust};
use chladni_io::{frf_bytes, same_files, write_model, FrfParts};
use chladni_report::better_band;
use chladni_rfp::{CancelToken, FitOptions, Method, RfpOptions, RfpWeight, Window};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{json, Map, Value};
use std::path::{Path, PathBuf};

/// Arguments of `fit`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni fit panel.h5                                 a table of the modes
  chladni fit panel.h5 -o model.json --band 10:700     save the model of one band
  chladni fit panel.h5 -o model.json --scene corner.toml     only the band that a scene needs
  chladni fit panel.h5 -o model.json --panel panel.toml      shapes scaled by the panel, without a driving point
  chladni fit few.h5 -o today.json --poles-of model.json     shapes as they were, poles of six FRFs
  chladni fit field.csv -o today.json --poles-of model.json --weights w.json     the same by a field that weights made
  chladni fit scan_*.uff --frf-kind mobility -o model.json")]
pub struct Args {
    /// FRF files, folders of them, or patterns; all are merged into one set. - is the
    /// standard input
    #[arg(required = true, value_name = "FRF")]
    files: Vec<PathBuf>,
    /// Model file to write, .json or .h5
    #[arg(short, long, value_name = "MODEL")]
    output: Option<PathBuf>,
    /// Band to fit, Hz [default: all lines]
    #[arg(long, value_name = "LO:HI", value_parser = parse_band, allow_hyphen_values = true)]
    band: Option<[f64; 2]>,
    /// Scene that the model is for: only the band that it needs is fitted, the modes
    /// outside are residual terms
    #[arg(long, value_name = "SCENE.toml", conflicts_with = "band")]
    scene: Option<PathBuf>,
    /// Identification method
    #[arg(long, value_name = "METHOD", default_value = "auto", value_parser = PossibleValuesParser::new(Method::ALL.map(Method::as_str))
        .try_map(|name| name.parse::<Method>()))]
    method: Method,
    /// Window of the records that the FRFs were averaged from: the fit has its line shape.
    /// Continuous random force: rectangular, hann, hamming, blackman, flattop, kaiser:BETA;
    /// noise in a part of each record: burst:PART, with Hann's window hann-burst:PART; hammer:
    /// transient; sine: none [default: as the file says, else not known, and the possible bias is
    /// named]
    #[arg(long, value_name = "WINDOW")]
    window: Option<Window>,
    /// Seed of the random mixtures inside the fit
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    seed: u64,
    /// Memory to keep within, bytes, or with K, M, G, T (powers of 1024): a larger set is
    /// read part by part, twice
    #[arg(long, value_name = "SIZE", default_value = MEMORY, value_parser = parse_memory)]
    memory: u64,
    /// Go on where an interrupted fit with the same files, options and output ended (a set
    /// read part by part)
    #[arg(long, requires = "output")]
    resume: bool,
    /// Say what would be read and written, and in which way, and end
    #[arg(long)]
    dry_run: bool,
    /// What the polynomials of rfp are fitted by: the equation error of 1985 (linear),
    /// divided by the denominator of the step before (sk), and from there to the likeliest
    /// poles by instrumental variables (iv) or Gauss-Newton steps (gn) [default: iv]
    #[arg(long, value_name = "WEIGHT", value_parser = PossibleValuesParser::new(RfpWeight::ALL.map(RfpWeight::as_str))
        .try_map(|name| name.parse::<RfpWeight>()))]
    rfp_weight: Option<RfpWeight>,
    /// Bands in which rfp looks for poles; auto: one for every eight visible peaks
    /// [default: auto]
    #[arg(long, value_name = "auto|N", value_parser = parse_bands, allow_negative_numbers = true)]
    rfp_bands: Option<BandCount>,
    /// The form of 1982 of rfp: each FRF by itself, linear, poles in s; modes are the
    /// poles that FRFs agree on
    #[arg(long, conflicts_with_all = ["rfp_weight", "rfp_bands"])]
    rfp_local: bool,
    #[command(flatten)]
    scale: scale::Args,
    #[command(flatten)]
    following: following::Args,
    #[command(flatten)]
    asked: AskedModel,
    #[command(flatten)]
    reading: Reading,
}

/// `--rfp-bands`: a number, or none for `auto`.
#[derive(Debug, Clone, Copy)]
struct BandCount(Option<usize>);

fn parse_bands(text: &str) -> std::result::Result<BandCount, String> {
    match text {
        "auto" => Ok(BandCount(None)),
        _ => match text.parse() {
            Ok(count) if (1..=1000).contains(&count) => Ok(BandCount(Some(count))),
            _ => Err("neither auto nor a number of bands from 1 to 1000".into()),
        },
    }
}

/// `LO:HI` in Hz as its ends.
pub fn parse_band(text: &str) -> std::result::Result<[f64; 2], String> {
    let ends = text
        .split_once(':')
        .map(|(low, high)| (low.trim().parse::<f64>(), high.trim().parse::<f64>()));
    match ends {
        Some((Ok(low), Ok(high)))
            if low.is_finite() && high.is_finite() && 0.0 <= low && low < high =>
        {
            Ok([low, high])
        }
        Some((Ok(low), Ok(high))) if low >= high => Err("the band ends before it begins".into()),
        _ => Err("no band in Hz such as 10:700".into()),
    }
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, and of a fit that cannot be made. A fit that cannot be
/// trusted is a result.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    let output = Output::asked("-o", args.output.as_deref(), MODEL, &files, console)?;
    let options = args.fit_options()?;
    let panel = args.scale.panel(args.memory)?;
    let frf_bytes = frf_bytes(&files)?;
    let in_parts = too_large(frf_bytes, args.memory);
    if args.dry_run {
        let stream = in_parts.then(|| stream(args, &files, &options, console));
        let plan = Plan {
            files: &files,
            frf_bytes,
            parts: stream.transpose()?.map(|stream| stream.count()),
            memory: args.memory,
            outputs: args.output.as_deref().into_iter().collect(),
        };
        return Ok(plan.outcome());
    }
    if let Some(model) = args.following.followed_by_fields(&files, console)? {
        return written(args, model, output.as_ref(), console);
    }
    if in_parts && args.following.is_given() {
        return Err(args.following.too_large());
    }
    if in_parts {
        let (model, resume) = streamed(args, &files, &options, console)?;
        let model = args.scale.scaled(model, panel.as_ref())?;
        let outcome = written(args, model, output.as_ref(), console)?;
        resume.done();
        return Ok(outcome);
    }
    let (frf, sources) = read_frf(&files, &args.reading, console)
        .map_err(|error| args.following.explained(error, &files))?;
    let model = match args.following.followed(&frf, &sources, console)? {
        Some(followed) => followed,
        None => {
            let model = fitted(args, &frf, sources, options, &files[0], console)?;
            drop(frf);
            args.scale.scaled(model, panel.as_ref())?
        }
    };
    written(args, model, output.as_ref(), console)
}

/// The model of a set in memory, in the band of the scene where one is given.
fn fitted(
    args: &Args,
    frf: &FrfSet,
    mut sources: Vec<Source>,
    mut options: FitOptions,
    file: &Path,
    console: &Console,
) -> Result<ModalModel> {
    let scene = args
        .scene
        .as_deref()
        .map(|scene| SceneBand::of(scene, frf, &options))
        .transpose()
        .map_err(|error| {
            let listed = args.reading.dofs.as_ref();
            blame_model(error, listed.map_or(file, DofFile::path))
        })?;
    if let Some(scene) = &scene {
        options.band_hz = Some(scene.band_hz());
        sources.push(scene.source.clone());
    }
    let mut model = fit_model(frf, &options, sources, file, console)?;
    args.reading.echo(&mut model.options);
    model.quality.findings.splice(0..0, console.findings());
    if let Some(scene) = &scene {
        let said = Finding::note("scene-band", scene.said(&model, frf));
        model.quality.findings.push(said);
    }
    Ok(model)
}

/// Writes the model where a file is given, and says what came of it and what is next.
fn written(
    args: &Args,
    model: ModalModel,
    output: Option<&Output>,
    console: &Console,
) -> Result<Outcome> {
    let outcome = match (&args.output, output) {
        (Some(path), Some(output)) => {
            console.stage("writing");
            written_model(&model, path, output, console)?
        }
        _ => {
            console.find_all(&model.quality.findings);
            let text = text(&model, console.verbose);
            Outcome::shown(whole(&model)?, text).doubted(doubt_of(&model))
        }
    };
    Ok(Outcome {
        next: next_step(args, &model),
        ..outcome
    })
}

/// Writes a model to `path`, and describes it.
///
/// # Errors
/// Those of writing.
pub fn written_model(
    model: &ModalModel,
    path: &Path,
    output: &Output,
    console: &Console,
) -> Result<Outcome> {
    console.find_all(&model.quality.findings);
    output.write(|path, force| write_model(path, model, force))?;
    let text = text(model, console.verbose);
    Ok(Outcome::written(path, summary(model, path)?, text).doubted(doubt_of(model)))
}

/// The doubt of a model that cannot be trusted.
fn doubt_of(model: &ModalModel) -> Option<String> {
    (!model.quality.trusted).then(|| distrust(model))
}

/// The next command: a fit of a better band where one is known, else the report.
fn next_step(args: &Args, model: &ModalModel) -> Option<String> {
    let output = args.output.as_deref().map(shell_path);
    if model
        .quality
        .findings
        .iter()
        .any(|finding| finding.code == MOSTLY_UNEXPLAINED)
    {
        let [low, high] = better_band(model)?.hz.map(|hz| significant(hz, 6));
        let files: Vec<String> = args.files.iter().map(|file| shell_path(file)).collect();
        let own = [files, args.reading.flags()].concat().join(" ");
        let output = output.map_or(String::new(), |file| format!(" -o {file} --force"));
        return (args.files.len() <= MOST_FILES)
            .then(|| format!("chladni fit {own} --band {low}:{high}{output}"));
    }
    let output = output.filter(|_| model.quality.trusted)?;
    Some(report(&[output]))
}

/// Code of the finding that modes explain less than half of the data.
const MOSTLY_UNEXPLAINED: &str = "mostly-unexplained";

/// The parts of a set larger than memory.
fn stream<'a>(
    args: &Args,
    files: &[PathBuf],
    options: &'a FitOptions,
    console: &'a Console,
) -> Result<Stream<'a>> {
    let needs_whole_set = |field: &str, found: &str| {
        Err(Error::new(
            ErrorKind::Usage,
            "the set is larger than half of the memory allowed, and is read part by part: this \
             needs it whole",
        )
        .field(field)
        .found(found)
        .expected("--method auto, and a band in place of a scene")
        .help("raise --memory where the machine has it"))
    };
    if options.method != Method::Auto {
        return needs_whole_set("--method", options.method.as_str());
    }
    if let Some(scene) = &args.scene {
        return needs_whole_set("--scene", &scene.display().to_string());
    }
    let data = FrfParts::open(files, &args.reading.options())?;
    Stream::new(data, files, args.memory, options, console)
}

/// Fits a set larger than memory part by part.
fn streamed(
    args: &Args,
    files: &[PathBuf],
    options: &FitOptions,
    console: &Console,
) -> Result<(ModalModel, Resume)> {
    let stream = stream(args, files, options, console)?;
    let mut echo = echo_of(options);
    args.reading.echo(&mut echo);
    let mut resume = Resume::new(
        args.output.as_deref(),
        files,
        args.memory,
        echo.clone(),
        args.resume,
    )?;
    let (fit, sources) = stream.with_sources(|| stream.fit(&mut resume))?;
    console.find_all(&same_files(&sources));
    let mut model = fit.model;
    model.source = sources;
    model.options = echo;
    model.quality.findings.splice(0..0, console.findings());
    Ok((model, resume))
}

/// Fits a set; the model names its sources and the options.
///
/// # Errors
/// Those of a fit that cannot be made, naming `file`.
pub fn fit_model(
    frf: &FrfSet,
    options: &FitOptions,
    sources: Vec<Source>,
    file: &Path,
    console: &Console,
) -> Result<ModalModel> {
    let progress = |stage: &str| console.stage(stage);
    let fit = chladni_rfp::fit_watched(frf, options, &progress, &CancelToken::new())
        .map_err(|error| explain(&error, options, file))?;
    let mut model = fit.model;
    model.source = sources;
    model.options = echo_of(options);
    Ok(model)
}

/// The options that can change the result.
pub fn echo_of(options: &FitOptions) -> Map<String, Value> {
    let mut echo = Map::new();
    echo.insert("band_hz".into(), json!(options.band_hz));
    echo.insert(
        "modes".into(),
        options.modes.map_or("auto".into(), Value::from),
    );
    echo.insert(
        "damping".into(),
        options.damping.map_or("auto".into(), |law| json!(law)),
    );
    echo.insert("method".into(), options.method.as_str().into());
    if options.method.is_fraction() {
        let RfpOptions {
            weight,
            bands,
            local,
        } = options.rfp;
        echo.insert("rfp_local".into(), local.into());
        if !local {
            echo.insert("rfp_weight".into(), weight.as_str().into());
            let bands = bands.map_or("auto".into(), Value::from);
            echo.insert("rfp_bands".into(), bands);
        }
    }
    echo.insert("shapes".into(), options.shapes.as_str().into());
    if let Some(window) = options.window {
        echo.insert("window".into(), window.to_string().into());
    }
    if let Some(decay) = options.exponential_window_per_s {
        echo.insert("exponential_window_per_s".into(), decay.into());
    }
    if !options.added_hz.is_empty() {
        echo.insert("added_hz".into(), json!(options.added_hz));
    }
    echo.insert("seed".into(), options.seed.into());
    echo
}

impl Args {
    fn fit_options(&self) -> Result<FitOptions> {
        Ok(FitOptions {
            band_hz: self.band,
            method: self.method,
            window: self.window,
            seed: self.seed,
            rfp: self.rfp_options()?,
            ..self.asked.options()
        })
    }

    /// The options of `rfp`, refused where another method would leave them unread.
    fn rfp_options(&self) -> Result<RfpOptions> {
        let given = [
            (self.rfp_weight.is_some(), "--rfp-weight"),
            (self.rfp_bands.is_some(), "--rfp-bands"),
            (self.rfp_local, "--rfp-local"),
        ];
        let named = given.iter().find(|(given, _)| *given);
        if let Some((_, flag)) = named.filter(|_| !self.method.is_fraction()) {
            return Err(Error::new(
                ErrorKind::Usage,
                format!("{flag} is an option of the methods rfp and grfp alone"),
            )
            .field("--method")
            .found(self.method.as_str())
            .expected("rfp")
            .help(format!("add --method rfp, or leave {flag} out")));
        }
        Ok(RfpOptions {
            weight: self.rfp_weight.unwrap_or_default(),
            bands: self.rfp_bands.and_then(|count| count.0),
            local: self.rfp_local,
        })
    }
}

/// The reason that a model is not to be trusted.
pub fn distrust(model: &ModalModel) -> String {
    let reason = match model.in_band_modes().any(|mode| mode.trust == Trust::Sure) {
        true => "the data as a whole contradict the model, see above",
        false => "no mode is sure",
    };
    format!("the fit is not to be trusted: {reason}")
}

fn value_of(model: &ModalModel) -> Result<Value> {
    serde_json::to_value(model).map_err(|error| {
        Error::new(
            ErrorKind::Internal,
            format!("the model has no JSON: {error}"),
        )
    })
}

/// The whole model as in its file, with warnings and findings at the top level too.
fn whole(model: &ModalModel) -> Result<Value> {
    let mut value = value_of(model)?;
    value["warnings"] = json!(model.quality.warnings());
    value["findings"] = json!(model.quality.findings);
    Ok(value)
}

/// The model without shapes, participations and residual terms.
pub fn summary(model: &ModalModel, output: &Path) -> Result<Value> {
    let mut value = value_of(model)?;
    for mode in value["modes"]
        .as_array_mut()
        .into_iter()
        .flatten()
        .filter_map(Value::as_object_mut)
    {
        ["shape", "shape_std", "participation"]
            .iter()
            .for_each(|key| drop(mode.remove(*key)));
    }
    let keys = [
        "source",
        "options",
        "frf_kind",
        "reference_unit",
        "band_hz",
        "damping",
        "scaling",
        "method",
        "modes",
        "quality",
    ];
    let mut summary = Map::from_iter([("output".to_owned(), json!(output.display().to_string()))]);
    summary.extend(keys.iter().map(|&key| (key.to_owned(), value[key].take())));
    summary.insert("warnings".into(), json!(model.quality.warnings()));
    summary.insert("findings".into(), json!(model.quality.findings));
    Ok(summary.into())
}
