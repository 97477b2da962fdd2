//! `chladni bench measured`.

use super::{names, shown, Place};
use chladni_bench::{
    measured, measured_cells, measured_csv, measured_figures, measured_summary, MeasuredOptions,
    MeasuredSummary,
};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use serde_json::json;

/// The table.
const TABLE: &str = "measured.csv";
/// Tests of each cell of a full run, and of a quick one, which takes every n-th cell.
const SEEDS: u32 = 100;
const QUICK: (u32, usize) = (6, 3);
/// Above the figures of the page.
const WORDS: &str = "Tests simulated in time: a structure under noise, bursts or blows, its force \
and velocities cut into windowed blocks, estimated and fitted as the program does by itself.";

/// Arguments of `bench measured`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench measured -o bench --quick
  chladni bench measured -o bench --seeds 100

Tests simulated in time, over excitation, window, averages, overlap, lines per bandwidth, drop of the force at resonances and its noise: bias and
error of damping, coverage of error bars, and whether errors of neighbouring lines tell the window, for a fit that is told the window, one of pure
resonances, one that is told nothing, and the local rational method. Writes measured.csv,
measured.svg/png and measured.html. An interrupted run goes on where it stopped.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Tests of each cell [default: 100; quick: 6 of every third cell]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: Option<u32>,
    /// Only cases whose name holds this text, such as `hann` or `b=2`
    #[arg(long, value_name = "TEXT")]
    case: Option<String>,
    /// First seed; the others follow it
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
}

/// Runs the command.
///
/// # Errors
/// No such case; those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let (seeds, every) = if args.place.quick { QUICK } else { (SEEDS, 1) };
    let options = MeasuredOptions {
        cells: measured_cells(every, args.case.as_deref())?,
        seeds: args.seeds.unwrap_or(seeds) as usize,
        first_seed: args.seed,
    };
    args.place.prepare(&[TABLE], console)?;
    let mut journal = args.place.journal("measured", "tests", console)?;
    let rows = measured(&options, &mut journal, &|stage| console.stage(stage))?;
    let summaries = measured_summary(&rows);
    let figures = measured_figures(&summaries);
    let tables = [(TABLE, measured_csv(&summaries))];
    let mut files = args.place.write(&tables, &figures, console)?;
    let title = "Damping of tests simulated in time";
    files.push(
        args.place
            .page("measured", title, WORDS, &figures, console)?,
    );
    journal.finish();
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": names(&files),
        "rows": summaries.len(),
    });
    Ok(Outcome::written(&args.place.output, json, text(&summaries)))
}

fn text(summaries: &[MeasuredSummary]) -> String {
    const HEADER: [&str; 10] = [
        "test",
        "way",
        "found, %",
        "spurious",
        "loss bias, %",
        "rmse, %",
        "f in 95 %",
        "loss in 95 %",
        "shape in 95 %",
        "decisions",
    ];
    let cells: Vec<Vec<String>> = summaries
        .iter()
        .map(|row| {
            let [frequency, loss, shape] = row.coverage.map(|share| shown(100.0 * share, 0));
            vec![
                row.cell.name(),
                row.way.name().to_owned(),
                shown(100.0 * row.found, 0),
                shown(row.spurious[0], 2),
                shown(100.0 * row.loss_bias, 1),
                shown(100.0 * row.loss_rmse, 1),
                frequency,
                loss,
                shape,
                match row.decisions {
                    [0, 0, 0] => String::new(),
                    [right, wrong, open] => format!("{right} / {wrong} / {open}"),
                },
            ]
        })
        .collect();
    let count = |which: usize| -> usize { summaries.iter().map(|row| row.decisions[which]).sum() };
    format!(
        "{}\nwindow told by errors of neighbouring lines: {} right, {} wrong, {} open\n",
        table(&HEADER, &cells),
        count(0),
        count(1),
        count(2)
    )
}
