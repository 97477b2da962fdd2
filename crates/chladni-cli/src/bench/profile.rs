//! `chladni bench profile`.

use super::{shown, Methods, Place};
use crate::console::Console;
use crate::outcome::Outcome;
use crate::table::table;
use chladni_bench::{profile, profile_csv, profile_figure, ProfileCase, ProfileOptions, ProfileRow, PROFILE_CASES};
use chladni_frf::Result;
use chladni_rfp::Method;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;

/// The table.
const TABLE: &str = "profile.csv";
/// Methods that a profile times unless told otherwise: those that stand beside the floor.
const METHODS: [&str; 2] = ["lean", "auto"];

/// Arguments of `bench profile`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench profile -o bench --quick
  chladni bench profile -o bench --case panel --method auto

Writes profile.csv (a row for each stage) and profile.svg/png. The large sets take up to 3.2 GB of memory.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    methods: Methods,
    /// Sets to run; may be repeated [default: all]
    #[arg(long = "case", value_name = "CASE", value_parser = PossibleValuesParser::new(PROFILE_CASES.map(|case| case.name))
        .try_map(|name| PROFILE_CASES.iter().find(|case| case.name == name).ok_or("no such set")))]
    cases: Vec<&'static ProfileCase>,
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.prepare(&[TABLE], console)?;
    let cases = if args.cases.is_empty() {
        PROFILE_CASES.iter().filter(|case| case.quick || !args.place.quick).collect()
    } else {
        args.cases.clone()
    };
    let methods = match args.methods.methods.is_empty() {
        true => Method::ALL.into_iter().filter(|method| METHODS.contains(&method.as_str())).collect(),
        false => args.methods.methods.clone(),
    };
    let rows = profile(&ProfileOptions { cases, methods }, &|stage| console.stage(stage))?;
    let files = args.place.write(&[(TABLE, profile_csv(&rows))], &[profile_figure(&rows)], console)?;
    let fits = rows.iter().filter(|row| row.stage == "fit");
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        "fits": fits.map(|row| json!({
            "case": row.case, "method": row.method.as_str(), "time_s": row.time_s, "over_floor": row.over_floor,
            "target": row.target(), "memory_over_data": row.memory_over_data,
        })).collect::<Vec<_>>(),
        "warnings": console.warnings(),
    });
    Ok(Outcome::written(&args.place.output, json, text(&rows)))
}

fn text(rows: &[ProfileRow]) -> String {
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let numbers = [shown(row.time_s, 4), shown(row.part, 3), shown(row.over_floor, 2), shown(row.memory_over_data, 2)];
            [row.case.to_owned(), row.method.to_string(), row.stage.clone()].into_iter().chain(numbers).collect()
        })
        .collect();
    table(&["set", "method", "stage", "time, s", "part of the fit", "over the floor", "memory over data"], &cells)
}
