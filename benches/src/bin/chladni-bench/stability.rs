//! `chladni bench stability`.

use super::{names, shown, Place};
use chladni_bench::{
    calibration, calibration_csv, failures_csv, stability, stability_csv, stability_figures,
    Calibration, Map, Solver, StabilityOptions, StabilityRow, MAPS,
};
use chladni_console::output::{Output, FRF, MODEL};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use chladni_io::{write_contents, write_model, Contents};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The tables: cells, tries that went wrong, calibration.
const TABLES: [&str; 3] = [
    "stability.csv",
    "stability-failures.csv",
    "stability-calibration.csv",
];
/// Tries of a full run in each cell.
const SEEDS: u32 = 8;
/// Tries of a quick run.
const QUICK_SEEDS: u32 = 2;
/// FRFs that are exported at most.
const EXPORTED: usize = 20;

/// Above the figures of the page.
const WORDS: &str =
    "Maps over two things at a time, from easy to impossible. What matters is that a wrong result says so: a weak mode, a warning, or a \
refusal. Darker is worse everywhere.";

/// Arguments of `bench stability`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench stability -o bench --quick
  chladni bench stability -o bench --case snr-overlap --case lines-snr --method auto --seeds 30
  chladni bench stability -o bench --case outliers --method auto --seed 5 --seeds 1 --export-silent

Maps over two things at a time, from easy to impossible: what is missed and made up, how large errors are beside what is stated, and whether the
result says that something is wrong. Writes stability.csv (a row for each cell), stability-failures.csv (each try that went wrong, with its seed),
stability-calibration.csv (announced against silent failures, coverage, rank histogram), stability-MAP-METHOD.svg/png and stability.html.
An interrupted run goes on where it stopped.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Methods to run; may be repeated [default: all of identification, and default, mls,
    /// fast of rendering; quick: auto, default]
    #[arg(long = "method", value_name = "METHOD", value_parser = PossibleValuesParser::new(Solver::names())
        .try_map(|name| Solver::named(&name).ok_or("no such method")))]
    methods: Vec<Solver>,
    /// Maps to run; may be repeated [default: all]
    #[arg(long = "case", value_name = "MAP", value_parser = PossibleValuesParser::new(MAPS.map(|map| map.name))
        .try_map(|name| Map::named(&name).ok_or("no such map")))]
    maps: Vec<&'static Map>,
    /// Tries in each cell with the default methods; others take a quarter of them
    /// [default: 8; quick: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: Option<u32>,
    /// First seed; the others follow it
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Also write the FRFs and the truth of the first fits that went wrong without a
    /// word: silent-MAP-X-Y-SEED.h5 and .json
    #[arg(long)]
    export_silent: bool,
}

impl Args {
    fn options(&self) -> StabilityOptions {
        let quick = self.place.quick;
        let usual = if quick { QUICK_SEEDS } else { SEEDS };
        StabilityOptions {
            maps: if self.maps.is_empty() {
                MAPS.iter().collect()
            } else {
                self.maps.clone()
            },
            solvers: if self.methods.is_empty() {
                methods(quick)
            } else {
                self.methods.clone()
            },
            seeds: self.seeds.unwrap_or(usual) as usize,
            first_seed: self.seed,
            coarse: quick,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.prepare(&TABLES, console)?;
    let options = args.options();
    let maps: Vec<&str> = options.maps.iter().map(|map| map.name).collect();
    let purpose = format!(
        "{maps:?} {:?} {} {} {}",
        options.solvers, options.seeds, options.first_seed, options.coarse
    );
    let mut journal = args.place.journal("stability", &purpose, console)?;
    let rows = stability(&options, &mut journal, &|stage| console.stage(stage))?;
    let calibrations = calibration(&rows);
    let tables = [
        (TABLES[0], stability_csv(&rows)),
        (TABLES[1], failures_csv(&rows)),
        (TABLES[2], calibration_csv(&calibrations)),
    ];
    let figures = stability_figures(&rows, &calibrations);
    let mut files = args.place.finish(
        ("stability", "Where methods fail", WORDS),
        &tables,
        &figures,
        journal,
        console,
    )?;
    if args.export_silent {
        files.extend(export_silent(&rows, &args.place.output, console)?);
    }
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": names(&files),
        "seeds": options.seeds,
        "rows": rows.len(),
        "methods": calibrations.iter().filter(|c| c.map.is_none()).map(|c| json!({
            "method": c.solver.to_string(), "right": c.quiet + c.false_alarms, "wrong_announced": c.announced, "wrong_silent": c.silent,
        })).collect::<Vec<_>>(),
    });
    let folder = args.place.output.display();
    Ok(Outcome::written(
        &args.place.output,
        json,
        format!(
            "{}\nthe rest stands in {folder}/stability.csv\n",
            text(&calibrations)
        ),
    ))
}

/// The methods of a run that names none.
fn methods(quick: bool) -> Vec<Solver> {
    let beside = |solver: &Solver| {
        solver.identifies() || ["mls", "fast"].contains(&solver.to_string().as_str())
    };
    Solver::all()
        .into_iter()
        .filter(|solver| solver.is_default() || (!quick && beside(solver)))
        .collect()
}

/// Writes the measurements of silent failures, so that they can be fitted and looked at
/// as any other.
fn export_silent(rows: &[StabilityRow], folder: &Path, console: &Console) -> Result<Vec<PathBuf>> {
    let silent = rows
        .iter()
        .filter(|row| row.map.identifies())
        .flat_map(|row| row.silent().map(move |(seed, _)| (row, *seed)));
    let mut files: Vec<PathBuf> = Vec::new();
    for (row, seed) in silent {
        let stem = format!(
            "silent-{}-{}-{}-{seed}",
            row.map.name, row.cell[0], row.cell[1]
        );
        let [frf, truth] =
            ["h5", "json"].map(|extension| folder.join(format!("{stem}.{extension}")));
        let Some((measured, problem)) = row.measurement(seed)?.filter(|_| !files.contains(&frf))
        else {
            continue;
        };
        let contents = Contents {
            frf: Some(measured),
            ..Contents::default()
        };
        Output::new(&frf, FRF, &[], console)?
            .write(|path, force| write_contents(path, &contents, force))?;
        Output::new(&truth, MODEL, &[], console)?
            .write(|path, force| write_model(path, &problem.truth, force))?;
        files.extend([frf, truth]);
        if files.len() >= 2 * EXPORTED {
            break;
        }
    }
    Ok(files)
}

fn text(calibrations: &[Calibration]) -> String {
    const HEADER: [&str; 10] = [
        "map",
        "method",
        "right",
        "warned",
        "wrong, said",
        "wrong, silent",
        "of these hidden",
        "said, %",
        "f covered",
        "η covered",
    ];
    let cells: Vec<Vec<String>> = calibrations
        .iter()
        .map(|c| {
            let counts = [
                c.quiet,
                c.false_alarms,
                c.announced,
                c.silent,
                c.silent_hidden,
            ]
            .map(|count| count.to_string());
            let shares = [
                shown(100.0 * c.announced_share(), 1),
                shown(c.frequency_coverage[1], 3),
                shown(c.loss_factor_coverage[1], 3),
            ];
            let names = [
                c.map.map_or("all", |map| map.name).to_owned(),
                c.solver.to_string(),
            ];
            names.into_iter().chain(counts).chain(shares).collect()
        })
        .collect();
    format!(
        "tries that are right, right with a warning or a weak mode, wrong and said so, wrong \
         without a word (hidden: the data do not show the mode)\n{}",
        table(&HEADER, &cells)
    )
}
