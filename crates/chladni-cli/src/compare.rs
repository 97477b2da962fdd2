//! `chladni compare`: two models side by side, or a mode followed through many.

use crate::limits::LONGEST_HEADING;
use chladni_console::input::{source, warn_of_files};
use chladni_console::table::{bounded, counted, significant, table, SIGMAS_95};
use chladni_console::{Console, Outcome};
use chladni_frf::{Result, ShapeSet, Source};
use chladni_rfp::{
    track, CompareOptions, Comparison, LoneMode, ModePair, PairDofs, TrackAgainst, Tracking,
};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::path::PathBuf;

/// Value of `format` in the JSON object.
const FORMAT: &str = "chladni.comparison";

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
#[command(
    before_help = "Examples:
  chladni compare monday.json tuesday.json                  modes paired, MAC, shifts in standard deviations
  chladni compare model.json shapes.unv                     against the modes of a finite-element program (55, 2414)
  chladni compare 20C.json 30C.json 40C.json --against previous    each mode followed through all",
    after_help = "Modes are paired by their shapes at the DOFs that both have; frequencies decide where shapes cannot. The MAC of the exact
shapes lies within the bound given in 95 % of cases. It only reports: models that differ are no error."
)]
pub struct Args {
    /// Model, or file with mode shapes, that the others are compared with
    #[arg(value_name = "MODEL")]
    first: PathBuf,
    /// Models, or files with mode shapes
    #[arg(value_name = "MODEL|SHAPES", required = true)]
    others: Vec<PathBuf>,
    /// How DOFs find their partners: by name, by the nearest node, or by name where names
    /// stand for the same places
    #[arg(long, value_name = "HOW", default_value = "auto",
        value_parser = PossibleValuesParser::new(PairDofs::ALL.map(PairDofs::as_str)).try_map(|text| text.parse::<PairDofs>()))]
    pair_dofs: PairDofs,
    /// Least MAC of two modes that are one
    #[arg(long, value_name = "0..1", default_value = "0.5", value_parser = parse_mac)]
    least_mac: f64,
    /// What each file is compared with: the first, or the one before it
    #[arg(long, value_name = "WHICH", default_value = "first", value_parser = PossibleValuesParser::new(["first", "previous"]))]
    against: String,
}

fn parse_mac(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(mac) if (0.0..=1.0).contains(&mac) => Ok(mac),
        _ => Err("no MAC from 0 to 1, such as 0.8".into()),
    }
}

/// Runs the command.
///
/// # Errors
/// Those of reading; files without modes, or without a DOF in common.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    console.stage("reading");
    let files: Vec<PathBuf> = std::iter::once(&args.first)
        .chain(&args.others)
        .cloned()
        .collect();
    let mut sets = Vec::new();
    for file in &files {
        let (set, warnings) = chladni_io::read_shape_set(file)?;
        warn_of_files(std::slice::from_ref(file), warnings, console);
        sets.push(set);
    }
    let sources: Vec<Source> = files
        .iter()
        .map(|file| source(file))
        .collect::<Result<_>>()?;

    console.stage("comparing");
    let options = CompareOptions {
        pair_dofs: args.pair_dofs,
        least_mac: args.least_mac,
    };
    let against = if args.against == "previous" {
        TrackAgainst::Previous
    } else {
        TrackAgainst::First
    };
    let tracking = track(&sets, against, &options)
        .map_err(|error| error.file(args.others.first().unwrap_or(&args.first)))?;
    for comparison in &tracking.comparisons {
        console.find_all(&comparison.findings);
    }
    let json = json!({
        "format": FORMAT,
        "version": 1,
        "created_by": chladni_frf::CREATED_BY,
        "source": sources,
        "options": {"pair_dofs": args.pair_dofs.as_str(), "least_mac": args.least_mac, "against": args.against},
        "comparisons": tracking.comparisons.iter().map(Comparison::to_json).collect::<Vec<_>>(),
        "tracks": tracking.tracks.iter().map(|track| &track.modes).collect::<Vec<_>>(),
    });
    let text = match tracking.comparisons.as_slice() {
        [one] => of_two(one, &sources),
        _ => of_many(&tracking, &sets, &sources, against),
    };
    Ok(Outcome::shown(json, text))
}

/// Two models: their pairs, and the modes without a partner.
fn of_two(comparison: &Comparison, sources: &[Source]) -> String {
    const HEADER: [&str; 9] = [
        "a",
        "b",
        "frequency a, Hz",
        "b − a, Hz",
        "in σ",
        "loss factor a",
        "b − a",
        "in σ",
        "MAC, 95 %",
    ];
    let rows: Vec<Vec<String>> = comparison.pairs.iter().map(row).collect();
    let [a, b] = [0, 1].map(|k| sources[k].file.as_str());
    format!(
        "a: {a}\nb: {b}\n{}, {}\n\n{}{}{}",
        counted(comparison.pairs.len(), "pair"),
        dofs(comparison),
        table(&HEADER, &rows),
        alone("a", "b", &comparison.only_in_a),
        alone("b", "a", &comparison.only_in_b),
    )
}

fn row(pair: &ModePair) -> Vec<String> {
    let optional = |value: Option<f64>, digits: i32| {
        value.map_or_else(String::new, |value| significant(value, digits))
    };
    vec![
        pair.a.to_string(),
        pair.b.to_string(),
        significant(pair.frequency_hz[0], 6),
        significant(pair.frequency_shift_hz, 3),
        optional(pair.frequency_shift_sigmas, 2),
        optional(pair.loss_factor[0], 4),
        optional(pair.loss_factor_shift, 3),
        optional(pair.loss_factor_shift_sigmas, 2),
        mac(pair),
    ]
}

/// The MAC, corrected for the bias that noise causes, and its bound.
fn mac(pair: &ModePair) -> String {
    if SIGMAS_95 * pair.mac_std < f64::EPSILON {
        return significant(pair.mac, 6);
    }
    bounded(
        (pair.mac - pair.mac_noise_bias).min(1.0),
        SIGMAS_95 * pair.mac_std,
    )
}

fn dofs(comparison: &Comparison) -> String {
    let by = match (comparison.paired_by, comparison.largest_distance_m) {
        (PairDofs::Nearest, Some(distance)) => {
            let distance = significant(1e3 * distance, 2);
            format!("paired by place, at most {distance} mm apart")
        }
        _ => "paired by name".into(),
    };
    format!("{} in common, {by}", counted(comparison.common_dofs, "DOF"))
}

fn alone(here: &str, there: &str, modes: &[LoneMode]) -> String {
    let mode = |mode: &LoneMode| {
        let alike = mode.most_alike.map_or_else(String::new, |(number, mac)| {
            format!("; most like {number} of {there}, MAC {mac:.2}")
        });
        let frequency = significant(mode.frequency_hz, 6);
        format!("  {} ({frequency} Hz{alike})\n", mode.mode)
    };
    if modes.is_empty() {
        return String::new();
    }
    let lines: String = modes.iter().map(mode).collect();
    format!("\nonly in {here}:\n{lines}")
}

/// Many models: a row for each mode, a column for each file, frequency and its change.
fn of_many(
    tracking: &Tracking,
    sets: &[ShapeSet],
    sources: &[Source],
    against: TrackAgainst,
) -> String {
    let mut header = vec!["mode".to_owned()];
    header.extend(sources.iter().map(|source| heading(&source.file)));
    header.push("least MAC".into());
    let rows: Vec<Vec<String>> = tracking
        .tracks
        .iter()
        .enumerate()
        .map(|(k, track)| {
            let mut first = None;
            let mut row = vec![(k + 1).to_string()];
            row.extend((track.modes.iter().zip(sets)).map(|(number, set)| {
                let Some(number) = number else {
                    return String::new();
                };
                let hz = set.modes[number - 1].frequency_hz;
                let start = *first.get_or_insert(hz);
                let change = match start == hz {
                    true => String::new(),
                    false => format!(" ({:+.2} %)", 100.0 * (hz / start - 1.0)),
                };
                format!("{}{change}", significant(hz, 6))
            }));
            let links = tracking.comparisons.iter().enumerate();
            let least = links
                .filter_map(|(k, comparison)| {
                    let number = track.modes[k + 1]?;
                    let pair = comparison.pairs.iter().find(|pair| pair.b == number)?;
                    Some(pair.mac)
                })
                .reduce(f64::min);
            row.push(least.map_or_else(String::new, |mac| format!("{mac:.4}")));
            row
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let against = match against {
        TrackAgainst::First => "the first file",
        TrackAgainst::Previous => "the file before it",
    };
    format!(
        "{} followed through {}, Hz; each file against {against}\n\n{}",
        counted(rows.len(), "mode"),
        counted(sets.len(), "file"),
        table(&header, &rows)
    )
}

fn heading(file: &str) -> String {
    let name = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    name.chars().take(LONGEST_HEADING).collect()
}
