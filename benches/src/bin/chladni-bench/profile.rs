//! `chladni bench profile`.

use super::{names, shown, Place};
use chladni_bench::{
    profile, profile_csv, profile_figure, scaling, scaling_csv, scaling_figure, ProfileCase,
    ProfileOptions, ProfileRow, ProfileSource, ScalingRow, PROFILE_CASES,
};
use chladni_console::input::{expand, read_frf, Reading};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use chladni_rfp::Method;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::path::PathBuf;

/// The tables: stages, and how times grow.
const TABLES: [&str; 2] = ["profile.csv", "profile-scaling.csv"];

/// Arguments of `bench profile`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench profile -o bench --quick
  chladni bench profile -o bench --case panel --method auto
  chladni bench profile -o bench --input scan.uff --frf-kind mobility
  chladni bench profile -o bench --growth

Writes profile.csv (a row for each stage), profile.svg/png, and profile-scaling.csv/svg/png (how the time grows with FRFs, lines, modes and threads, and what becomes of it where the panel is cut).
The large sets take up to 3.2 GB of memory. An interrupted run goes on where it stopped.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Methods to run; may be repeated [default: lean, auto; with --input: auto]
    #[arg(long = "method", value_name = "METHOD", value_parser = PossibleValuesParser::new(Method::ALL.map(Method::as_str))
        .try_map(|name| name.parse::<Method>()))]
    methods: Vec<Method>,
    /// FRFs of your own to profile; may be repeated: one set
    #[arg(long, value_name = "FILE")]
    input: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Only how the time grows with FRFs, lines, modes and threads, and where data are cut
    #[arg(long, conflicts_with_all = ["cases", "input"])]
    growth: bool,
    /// Sets to run; may be repeated [default: all]
    #[arg(long = "case", value_name = "CASE", value_parser = PossibleValuesParser::new(PROFILE_CASES.map(|case| case.name))
        .try_map(|name| PROFILE_CASES.iter().find(|case| case.name == name).ok_or("no such set")))]
    cases: Vec<&'static ProfileCase>,
}

impl Args {
    /// The sets to time fits on.
    fn sources(&self, console: &Console) -> Result<Vec<ProfileSource>> {
        let named: Vec<&ProfileCase> = match (self.cases.is_empty(), self.input.is_empty()) {
            (true, true) if self.growth => Vec::new(),
            (true, true) => PROFILE_CASES
                .iter()
                .filter(|case| case.quick || !self.place.quick)
                .collect(),
            _ => self.cases.clone(),
        };
        let mut cases: Vec<ProfileSource> = named.into_iter().map(ProfileSource::Named).collect();
        if !self.input.is_empty() {
            let files = expand(&self.input, console)?;
            let (frf, _) = read_frf(&files, &self.reading, console)?;
            cases.push(ProfileSource::Given(
                chladni_text::file_name(&files[0]),
                Box::new(frf),
            ));
        }
        Ok(cases)
    }
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.refuse_tables(&TABLES, console)?;
    let cases = args.sources(console)?;
    args.place.prepare(&TABLES, console)?;
    let methods = match (args.methods.is_empty(), args.input.is_empty()) {
        (true, true) => vec![Method::Lean, Method::Auto],
        (true, false) => vec![Method::Auto],
        _ => args.methods.clone(),
    };
    let purpose = format!(
        "{} {methods:?} {:?} {}",
        args.place.quick, args.input, args.growth
    );
    let mut journal = args.place.journal("profile", &purpose, console)?;
    let rows = profile(
        &ProfileOptions {
            cases,
            methods: methods.clone(),
        },
        &mut journal,
        &|stage| console.stage(stage),
    )?;
    let (mut tables, mut figures) = (Vec::new(), Vec::new());
    if !args.growth {
        tables.push((TABLES[0], profile_csv(&rows)));
        figures.push(profile_figure(&rows));
    }
    let mut grown = Vec::new();
    if args.cases.is_empty() && args.input.is_empty() {
        grown = scaling(&methods, args.place.quick, &mut journal, &|stage| {
            console.stage(stage)
        })?;
        tables.push((TABLES[1], scaling_csv(&grown)));
        figures.extend(scaling_figure(&grown));
    }
    let files = args.place.write(&tables, &figures, console)?;
    journal.finish();
    let fits = rows.iter().filter(|row| row.stage == "fit");
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": names(&files),
        "fits": fits.map(|row| json!({
            "case": row.case, "method": row.method.as_str(), "time_s": row.time_s, "over_floor": row.over_floor,
            "target": row.target(), "memory_over_data": row.memory_over_data, "peak_bytes": row.peak_bytes,
        })).collect::<Vec<_>>(),
    });
    Ok(Outcome::written(
        &args.place.output,
        json,
        stages_text(&rows) + &growth_text(&grown),
    ))
}

/// Exponent of each method along each axis.
fn growth_text(rows: &[ScalingRow]) -> String {
    let mut lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.axis.to_owned(),
                row.method.to_string(),
                shown(row.exponent, 2),
            ]
        })
        .collect();
    lines.dedup();
    match lines.is_empty() {
        true => String::new(),
        false => format!(
            "\n{}",
            table(&["time over number of", "method", "exponent"], &lines)
        ),
    }
}

fn stages_text(rows: &[ProfileRow]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let numbers = [
                shown(row.time_s, 4),
                shown(row.part, 3),
                shown(row.over_floor, 2),
                shown(1e-9 * row.rate[0], 1),
                shown(1e-9 * row.rate[1], 1),
                shown(row.memory_over_data, 2),
            ];
            [row.case.clone(), row.method.to_string(), row.stage.clone()]
                .into_iter()
                .chain(numbers)
                .collect()
        })
        .collect();
    table(
        &[
            "set",
            "method",
            "stage",
            "time, s",
            "part of the fit",
            "over the floor",
            "Gflop/s",
            "GB/s",
            "memory over data",
        ],
        &cells,
    )
}
