//! `chladni estimate`: FRFs and coherence from time records.

use crate::extent::Extent;
use crate::limits;
use chladni_console::input::{expand, warn_of_files};
use chladni_console::output::{Output, FRF};
use chladni_console::table::{counted, significant};
use chladni_console::{Console, Outcome};
use chladni_frf::{
    BlockWindow, Dof, Error, ErrorKind, Estimation, Estimator, Finding, Geometry, Result, Run,
    Source,
};
use chladni_io::{
    read_documents, runs_of, write_contents, ChannelOverride, Contents, FileFormat, ReadOptions,
};
use chladni_signal::{estimate, EstimateOptions};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Arguments of `estimate`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni estimate hammer_*.uff -o frf.h5                                  blows: one record each, averaged
  chladni estimate shaker.uff -o frf.h5                                    continuous random: no leakage
  chladni estimate shaker.uff -o frf.h5 --estimator h1 --block 8192        the same by averaged Hann blocks
  chladni estimate hit_*.csv -o frf.h5 --sample-rate 48000                 columns force_N, acc_g without a time column
  chladni estimate take.wav -o frf.h5 --dofs 101:+Z,1:+Z --units V,m/s --scales 10,0.05")]
pub struct Args {
    /// Time records: universal files, HDF5 of this program, tables (t, then a column per
    /// channel), WAV; folders and patterns too
    #[arg(required = true, value_name = "TIME")]
    files: Vec<PathBuf>,
    /// FRF file to write: .h5 (exact, with variances), .uff (binary), .unv (text), .npz
    /// or .csv
    #[arg(short, long, value_name = "FRF")]
    output: PathBuf,
    /// Averaged blocks with the noise at the responses (h1), at the references (h2), at
    /// both (hv); local rational (lrm) or polynomial (lpm) fits to the transform of the
    /// whole record, free of leakage [default: lrm for one long record of continuous
    /// random excitation without --window and --overlap, else h1]
    #[arg(long, value_name = "WHICH", value_parser = PossibleValuesParser::new(Estimator::ALL.map(Estimator::name)).try_map(|name| name.parse::<Estimator>()))]
    estimator: Option<Estimator>,
    /// Window of each block; exponential needs --exponential-window [default: hann for
    /// one long record, rectangular for several and where the force ends before the record]
    #[arg(long, value_name = "WINDOW", value_parser = PossibleValuesParser::new(["rectangular", "hann", "exponential"]))]
    window: Option<String>,
    /// Decay α of an exponential window e^(-αt) on references and responses, 1/s; a fit of
    /// the same file takes it off
    #[arg(long, value_name = "1/S")]
    exponential_window: Option<f64>,
    /// Samples of a block; with lrm and lpm, sampling rate over distance of lines
    /// [default: the whole record where there are several or the force ends before it, else
    /// about 16 blocks; lrm and lpm: a line of the FRFs for 8 of the record, 11 with two references]
    #[arg(long, value_name = "SAMPLES")]
    block: Option<usize>,
    /// Overlap of blocks, as a part of their length [default: 2/3 with a Hann
    /// window, else 0]
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    overlap: Option<f64>,
    /// DOFs that excite [default: forces; voltages where there is no force]
    #[arg(long, value_name = "DOF", value_delimiter = ',')]
    references: Vec<Dof>,
    /// DOF of each channel, in the order of the file
    #[arg(long, value_name = "DOF", value_delimiter = ',')]
    dofs: Vec<Dof>,
    /// Unit of each channel: N, V, m, m/s, m/s^2, g, ...; - leaves a channel out
    #[arg(
        long,
        value_name = "UNIT",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    units: Vec<String>,
    /// Factor of each channel from the file's numbers to its unit (of full scale, in WAV)
    #[arg(
        long,
        value_name = "FACTOR",
        value_delimiter = ',',
        allow_negative_numbers = true,
        value_parser = factor
    )]
    scales: Vec<f64>,
    /// Samples per second of tables without a time column
    #[arg(long, value_name = "HZ", value_parser = positive)]
    sample_rate: Option<f64>,
    /// Leave out what cannot be read instead of refusing the file
    #[arg(long)]
    lenient: bool,
}

fn factor(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|factor: &f64| factor.is_finite())
        .ok_or_else(|| "no factor; write a finite number, as in 0.05".into())
}

fn positive(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
        .ok_or_else(|| "no rate; write a number above 0, as in 48000".into())
}

impl Args {
    /// The window of `--window` and `--exponential-window`; `None` where none is given.
    fn window(&self) -> Result<Option<BlockWindow>> {
        let wrong = |message: &str, found: String, expected: &str, help: &str| {
            Err(Error::new(ErrorKind::Usage, message)
                .field("--exponential-window")
                .found(found)
                .expected(expected)
                .help(help))
        };
        match (self.window.as_deref(), self.exponential_window) {
            (None | Some("exponential"), Some(rate_per_s))
                if rate_per_s.is_finite() && rate_per_s > 0.0 =>
            {
                Ok(Some(BlockWindow::Exponential { rate_per_s }))
            }
            (None | Some("exponential"), Some(rate)) => wrong(
                "no possible decay",
                rate.to_string(),
                "a rate in 1/s above 0",
                "the rate is ln(1/end value)/record length, in 1/s",
            ),
            (Some(name), Some(_)) => wrong(
                "two windows",
                format!("--window {name} too"),
                "one window",
                "leave one of the two out",
            ),
            (Some("exponential"), None) => wrong(
                "an exponential window needs its decay",
                "none".into(),
                "a rate in 1/s",
                "give --exponential-window RATE, or choose another --window",
            ),
            (Some("hann"), None) => Ok(Some(BlockWindow::Hann)),
            (Some(_), None) => Ok(Some(BlockWindow::Rectangular)),
            (None, None) => Ok(None),
        }
    }
}

/// Time records of all files, with sources and geometry.
#[derive(Default)]
struct Records {
    runs: Vec<Run>,
    sources: Vec<Source>,
    geometry: Geometry,
}

impl Records {
    /// The finding on files of the same content.
    fn copies(&self) -> Option<Finding> {
        let words = format!(
            "{}: its records count as measurements of their own, and error bars are too small",
            Source::copies(&self.sources)?
        );
        Some(Finding::caution("same-records", words).help("leave copies out"))
    }
}

impl Args {
    fn records(&self, files: &[PathBuf], console: &Console) -> Result<Records> {
        let said = ChannelOverride {
            dofs: self.dofs.clone(),
            units: self.units.clone(),
            scales: self.scales.clone(),
            references: self.references.clone(),
        };
        let options = ReadOptions {
            lenient: self.lenient,
            sample_rate_hz: self.sample_rate,
            ..ReadOptions::default()
        };
        let mut records = Records::default();
        let mut warnings = Vec::new();
        for mut document in read_documents(files, &options)? {
            let errors = &document.errors;
            match errors.first() {
                Some(error) if !self.lenient => return Err(error.clone().file(&document.file)),
                _ => warnings.extend(errors.iter().map(|error| {
                    Finding::caution("damaged-left-out", format!("left out: {error}"))
                })),
            }
            let runs = runs_of(&document, &said)?;
            self.check_rate(&runs)
                .map_err(|error| error.file(&document.file))?;
            records.runs.extend(runs);
            // a sound file lacks what the options say here
            let lacks_nothing = document.format == FileFormat::Wav && said.says_all();
            let of_file = document.warnings.iter();
            let of_file =
                of_file.filter(|warning| !lacks_nothing || warning.code != "unit-assumed");
            warnings.extend(of_file.map(|warning| warning.about(document.file.display())));
            records.sources.extend(document.source());
            if records.geometry.nodes.is_empty() {
                records.geometry = std::mem::take(&mut document.geometry);
            }
        }
        self.check_references(&records.runs)?;
        warnings.extend(records.copies());
        warn_of_files(files, warnings, console);
        Ok(records)
    }

    /// Refuses a DOF of `--references` at which nothing excites.
    fn check_references(&self, runs: &[Run]) -> Result<()> {
        let excites = |dof: &Dof| {
            runs.iter()
                .any(|run| run.references().any(|c| c.dof == *dof))
        };
        let mut still = self.references.iter().filter(|dof| !excites(dof));
        let Some(still) = still.next().filter(|_| !runs.is_empty()) else {
            return Ok(());
        };
        let channels = runs.iter().flat_map(|run| &run.channels);
        let could = channels.filter(|channel| channel.unit.frf_kind().is_none());
        let could: BTreeSet<String> = could.map(|channel| channel.dof.to_string()).collect();
        let could = match could.is_empty() {
            true => "a channel of a force or a voltage".to_owned(),
            false => Vec::from_iter(could).join(", "),
        };
        Err(Error::new(ErrorKind::Usage, "no channel excites there")
            .field("--references")
            .found(still.to_string())
            .expected(could)
            .help("name channels of forces or voltages; --units says what a channel measures"))
    }

    /// Refuses `--sample-rate` where the file has another one.
    fn check_rate(&self, runs: &[Run]) -> Result<()> {
        let Some(said) = self.sample_rate else {
            return Ok(());
        };
        let differs = |hz: &f64| (hz / said - 1.0).abs() > limits::SAME_RATE;
        let mut rates = runs.iter().map(|run| run.sample_rate_hz);
        rates.find(differs).map_or(Ok(()), |hz| {
            let message = "the file has a sampling rate of its own";
            Err(Error::new(ErrorKind::Usage, message)
                .field("--sample-rate")
                .found(format!("{said} Hz"))
                .expected(format!(
                    "{} Hz, as the file says",
                    significant(hz, limits::RATE_DIGITS)
                ))
                .help("leave --sample-rate out: it is for tables without a time column"))
        })
    }
}

/// Runs the command.
///
/// # Errors
/// Those of reading, of records that do not fit together, and of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    let output = Output::new(&args.output, FRF, &files, console)?;
    let options = EstimateOptions {
        estimator: args.estimator,
        window: args.window()?,
        block: args.block,
        overlap: args.overlap,
    };
    console.stage("reading");
    let records = args.records(&files, console)?;
    console.stage("estimating FRFs");
    let result = estimate(&records.runs, &options).map_err(with_option)?;
    let made = result.estimation;
    console.find_all(&result.findings);
    let mut frf = result.frf;
    frf.geometry = records.geometry;
    if frf.kind.is_none() {
        console.find(
            &Finding::caution("kind-unknown", "the units do not say the FRF kind")
                .help("other commands need --frf-kind; or name the units here with --units"),
        );
    }
    console.stage("writing");
    let extent = Extent::of(&frf);
    let contents = Contents {
        frf: Some(frf),
        sources: records.sources,
        ..Contents::default()
    };
    console.find_all(&output.write(|path, force| write_contents(path, &contents, force))?);
    let json = json!({
        "output": args.output.display().to_string(),
        "source": contents.sources,
        "frf_kind": extent.kind,
        "responses": extent.responses,
        "references": extent.references,
        "lines": extent.lines,
        "axis_hz": extent.axis_hz,
        "estimator": made.estimator.name(),
        "window": made.window.name(),
        "forcing": made.forcing.map(chladni_frf::Forcing::name),
        "transform_s": made.transform_s,
        "hop_s": made.hop_s,
        "block": (made.transform_s * records.runs[0].sample_rate_hz).round(),
        "overlap": 1.0 - made.hop_s / made.transform_s,
        "averages": made.averages,
        "lines_per_value": made.lines_per_value,
    });
    let text = format!(
        "{}: {extent} by {}, {}\n",
        args.output.display(),
        made.estimator,
        averaged(&made),
    );
    Ok(Outcome::written(&args.output, json, text))
}

/// The error, which names the option where the length of a block is at fault.
fn with_option(error: Error) -> Error {
    match error.field.as_deref() {
        Some("block") => error.field("--block"),
        _ => error,
    }
}

/// The averages of an estimation in words.
fn averaged(made: &Estimation) -> String {
    let word = if made.estimator.is_local() {
        "record"
    } else {
        "block"
    };
    let count = match made.averages {
        [least, most] if least == most => counted(least, word),
        [least, most] => format!("{least} to {most} {word}s"),
    };
    if made.estimator.is_local() {
        format!("{} a value, {count}", counted(made.lines_per_value, "line"))
    } else {
        format!("{count} averaged")
    }
}
