//! `chladni bench wild`.

use super::{names, shown, Place};
use chladni_bench::{
    summary, wild, wild_csv, wild_draws_csv, wild_figures, wild_measurement, Criterion, Difficulty,
    WildOptions, WildRow,
};
use chladni_console::output::{Output, FRF, MODEL};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use chladni_io::{write_contents, write_model, Contents};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The tables: a row for each structure, and all that it draws.
const TABLES: [&str; 2] = ["wild.csv", "wild-draws.csv"];
/// Structures of a full run, and of a quick one.
const SEEDS: u32 = 2000;
const QUICK_SEEDS: u32 = 60;
/// Most values of a structure of a quick run.
const QUICK_VALUES: usize = 100_000;
/// Structures that failed and are named on the screen.
const NAMED: usize = 20;

/// Above the figures of the page.
const WORDS: &str =
    "Structures drawn from a seed: either damping law, modes beyond both ends of the band, real and complex shapes, few and many FRFs. Nothing \
is drawn from what the fit assumes. What matters is that a wrong result says so.";

/// Arguments of `bench wild`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench wild -o bench --quick
  chladni bench wild -o bench --seeds 2000
  chladni bench wild -o bench --hard --seeds 1000
  chladni bench wild -o one --seed 17 --seeds 1 --export

Structures that nobody chose, measured and fitted: modes found and made up, whether the result says so, the damping law, error bars. Writes
wild.csv (a row for each structure), wild-draws.csv (all that each draws), wild.svg/png and wild.html (which draws fail). An interrupted run goes
on where it stopped.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Number of structures [default: 2000; quick: 60 small ones]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    seeds: Option<u32>,
    /// First seed; the others follow it
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Wider ranges, heavy modes at the band's edges, and faults of the measurement:
    /// delays, spoilt values, tones, a sensor whose mass moves the modes
    #[arg(long)]
    hard: bool,
    /// Also write the FRFs and the truth of each structure: wild-SEED.h5 and .json
    #[arg(long)]
    export: bool,
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.prepare(&TABLES, console)?;
    let quick = args.place.quick;
    let usual = if quick { QUICK_SEEDS } else { SEEDS };
    let options = WildOptions {
        difficulty: match args.hard {
            true => Difficulty::Hard,
            false => Difficulty::Calm,
        },
        seeds: args.seeds.unwrap_or(usual) as usize,
        first_seed: args.seed,
        most_values: if quick { QUICK_VALUES } else { usize::MAX },
    };
    let mut journal = args
        .place
        .journal("wild", &format!("{quick} {}", args.hard), console)?;
    let rows = wild(&options, &mut journal, &|stage| console.stage(stage))?;
    let criteria = summary(&rows);
    let tables = [
        (TABLES[0], wild_csv(&rows)),
        (TABLES[1], wild_draws_csv(&rows)),
    ];
    let figures = wild_figures(&rows);
    let mut files = args.place.finish(
        ("wild", "Structures that nobody chose", WORDS),
        &tables,
        &figures,
        journal,
        console,
    )?;
    if args.export {
        for row in &rows {
            let seed = row.draw.seed;
            files.extend(export(
                seed,
                options.difficulty,
                &args.place.output,
                console,
            )?);
        }
    }
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": names(&files),
        "seeds": rows.len(),
        "criteria": criteria.iter().map(|c| json!({
            "name": c.name, "of": c.of, "count": c.count, "goal": c.goal, "met": c.met(),
        })).collect::<Vec<_>>(),
        "wrong": wrong(&rows).map(|row| row.draw.seed).collect::<Vec<_>>(),
    });
    Ok(Outcome::written(
        &args.place.output,
        json,
        text(&rows, &criteria),
    ))
}

/// Structures whose fit is wrong without a word, or ended in a bug.
fn wrong(rows: &[WildRow]) -> impl Iterator<Item = &WildRow> {
    rows.iter().filter(|row| {
        let outcome = &row.outcome;
        outcome.internal.is_some() || outcome.silent() || outcome.overconfident()
    })
}

/// Writes a measurement, so that it can be fitted and looked at as any other.
fn export(
    seed: u64,
    difficulty: Difficulty,
    folder: &Path,
    console: &Console,
) -> Result<[PathBuf; 2]> {
    let (measured, truth) = wild_measurement(seed, difficulty)?;
    let [frf, model] = ["h5", "json"].map(|ending| folder.join(format!("wild-{seed}.{ending}")));
    let contents = Contents {
        frf: Some(measured),
        ..Contents::default()
    };
    Output::new(&frf, FRF, &[], console)?
        .write(|path, force| write_contents(path, &contents, force))?;
    Output::new(&model, MODEL, &[], console)?
        .write(|path, force| write_model(path, &truth, force))?;
    Ok([frf, model])
}

fn text(rows: &[WildRow], criteria: &[Criterion]) -> String {
    const HEADER: [&str; 5] = ["", "count", "of", "share, %", "asked for, %"];
    let cells: Vec<Vec<String>> = criteria
        .iter()
        .map(|criterion| {
            let [least, most] = criterion.goal.map(|share| shown(100.0 * share, 1));
            vec![
                criterion.name.to_owned(),
                criterion.count.to_string(),
                criterion.of.to_string(),
                shown(100.0 * criterion.share(), 2),
                format!(
                    "{least} to {most}{}",
                    if criterion.met() { "" } else { " (missed)" }
                ),
            ]
        })
        .collect();
    let named: Vec<String> = wrong(rows)
        .take(NAMED)
        .map(|row| row.draw.seed.to_string())
        .collect();
    let named = match named.is_empty() {
        true => String::new(),
        false => format!(
            "\nwrong without a word, or a bug: seeds {}; again with --seed SEED --seeds 1 --export\n",
            named.join(", ")
        ),
    };
    format!("{}{named}", table(&HEADER, &cells))
}
