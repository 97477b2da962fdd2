//! `chladni bench accuracy`.

use super::{names, own_data, shown, Place};
use chladni_bench::{
    accuracy, accuracy_csv, accuracy_figures, accuracy_modes_csv, scene_figures, scene_knobs,
    scenes, AccuracyOptions, AccuracyRow, Case, Means, PeerRow, SceneCase, SceneOptions, SceneRow,
    Solver, CASES, SCENE_CASES,
};
use chladni_console::input::Reading;
use chladni_console::output::{Output, FRF, MODEL};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use chladni_io::{write_contents, write_model, Contents};
use chladni_rfp::ShapeModel;
use chladni_text::read_text;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The tables: a row for each case and method, a row for each of their modes.
const TABLES: [&str; 2] = ["accuracy.csv", "accuracy-modes.csv"];
/// Seeds of a full run.
const SEEDS: usize = 100;
/// Seeds of a quick run.
const QUICK_SEEDS: usize = 3;

/// Scenes of a quick run: the panel is measured and fitted once for both.
const QUICK_SCENES: [&str; 2] = ["quarter-1", "ninth-5"];
/// Above the figures of the page.
const WORDS: &str = "Each method on cases whose truth is known: error against time. Both scales are logarithmic, lower left is better, the line joins what \
nothing else beats in both. Times are medians of this run; on a shared machine only their ratios mean something.";

/// Arguments of `bench accuracy`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench accuracy -o bench --quick
  chladni bench accuracy -o bench --case panel --method auto --seeds 100
  chladni bench accuracy -o bench --case quarter-1
  chladni bench accuracy -o bench --input scan.uff --frf-kind mobility

Writes accuracy.csv (a row for each case and method, scenes of rendering among them), accuracy-modes.csv (a row for each mode),
accuracy-CASE.svg/png (error against time with the Pareto front), accuracy-CASE-knobs (one option turned), scene-CASE (ground lost against time),
scene-CASE-knobs (how far κ is searched for) and accuracy.html. With --input: accuracy-input.csv (a row for each setting, beside the
default fit of the same data), accuracy-input.svg/png and accuracy-input-knobs. An interrupted run goes on where it stopped.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Methods to run, of identification and of rendering; may be repeated [default: all]
    #[arg(long = "method", value_name = "METHOD", value_parser = PossibleValuesParser::new(Solver::names())
        .try_map(|name| Solver::named(&name).ok_or("no such method")))]
    methods: Vec<Solver>,
    /// Noise seeds of each case for the methods that maximise the likelihood; others take
    /// a tenth of them [default: 100; quick: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: Option<u32>,
    /// First noise seed; the others follow it
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// What shapes may be while poles are refined, as in `fit`
    #[arg(long, value_name = "MODEL", default_value = "auto", value_parser = PossibleValuesParser::new(ShapeModel::ALL.map(ShapeModel::as_str))
        .try_map(|name| name.parse::<ShapeModel>()))]
    shapes: ShapeModel,
    /// Also write the FRFs of the first fits whose count of modes or damping law is
    /// wrong, frf-CASE-SEED.h5, and truth-CASE.json
    #[arg(long)]
    export_wrong: bool,
    /// Also write the FRFs of every case and seed, frf-CASE-SEED.h5, and truth-CASE.json:
    /// what benches/peers/peers.py reads
    #[arg(long)]
    export: bool,
    /// A table of other tools on these cases, from benches/peers/peers.py, to stand on
    /// the charts
    #[arg(long, value_name = "CSV")]
    peers: Option<PathBuf>,
    /// Leave every option as it is: no knobs
    #[arg(long)]
    no_knobs: bool,
    /// FRFs of your own; may be repeated: one set. What cheaper methods and settings lose
    /// beside the default, in its error bars
    #[arg(long, value_name = "FILE", conflicts_with_all = ["cases", "seeds", "seed", "shapes", "export", "export_wrong", "peers"])]
    input: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
    /// Cases and scenes to run; may be repeated [default: all cases, and five scenes]
    #[arg(long = "case", value_name = "CASE", value_parser = PossibleValuesParser::new(
        CASES.iter().map(|case| case.name).chain(SCENE_CASES.iter().map(|case| case.name))))]
    cases: Vec<String>,
}

impl Args {
    /// The fits and the renderings of the `chosen` methods.
    fn asked(&self, chosen: &[Solver], knobs: bool) -> (AccuracyOptions, SceneOptions) {
        let quick = self.place.quick;
        let names = || self.cases.iter();
        let (cases, scene_cases): (Vec<&Case>, Vec<&SceneCase>) = match self.cases.is_empty() {
            true => (
                CASES.iter().filter(|case| case.quick || !quick).collect(),
                SCENE_CASES
                    .iter()
                    .filter(|case| case.quick && (!quick || QUICK_SCENES.contains(&case.name)))
                    .collect(),
            ),
            false => (
                names().filter_map(|name| Case::named(name)).collect(),
                names().filter_map(|name| SceneCase::named(name)).collect(),
            ),
        };
        let of_fits = chosen.iter().filter_map(|solver| match solver {
            Solver::Identify(method) => Some(*method),
            Solver::Render(_) => None,
        });
        let of_scenes = chosen.iter().filter_map(|solver| match solver {
            Solver::Render(method) => Some(*method),
            Solver::Identify(_) => None,
        });
        let usual = if quick { QUICK_SEEDS } else { SEEDS };
        let options = AccuracyOptions {
            cases,
            methods: of_fits.collect(),
            shapes: self.shapes,
            seeds: self.seeds.map_or(usual, |seeds| seeds as usize),
            first_seed: self.seed,
            knobs,
        };
        let of_scenes = SceneOptions {
            cases: scene_cases,
            methods: of_scenes.collect(),
            means: vec![Means::default()],
            by_measured_line: false,
        };
        (options, of_scenes)
    }

    /// The other tools that stand beside our methods.
    fn peers(&self) -> Result<Vec<PeerRow>> {
        let Some(file) = &self.peers else {
            return Ok(Vec::new());
        };
        PeerRow::parse(&read_text(file, "a table of other tools, CSV")?)
            .map_err(|error| error.file(file))
    }

    /// Writes the measurements that are to be exported: of all seeds, or of the wrong ones.
    fn export(
        &self,
        rows: &[AccuracyRow],
        seeds: usize,
        console: &Console,
    ) -> Result<Vec<PathBuf>> {
        if !self.export && !self.export_wrong {
            return Ok(Vec::new());
        }
        let all = (self.seed..self.seed + seeds as u64).collect::<Vec<_>>();
        let wrong =
            |row: &AccuracyRow| [row.wrong_seeds.clone(), row.wrong_law_seeds.clone()].concat();
        let seeds = |row: &AccuracyRow| if self.export { all.clone() } else { wrong(row) };
        export(rows, &seeds, &self.place.output, console)
    }
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if !args.input.is_empty() {
        let asked = own_data::Asked {
            place: &args.place,
            input: &args.input,
            reading: &args.reading,
            methods: &args.methods,
            knobs: !args.no_knobs && !args.place.quick,
        };
        return own_data::run(&asked, console);
    }
    let peers = args.peers()?;
    args.place.prepare(&TABLES, console)?;
    let quick = args.place.quick;
    let chosen = match args.methods.is_empty() {
        true => Solver::all(),
        false => args.methods.clone(),
    };
    let knobs = !args.no_knobs && (!quick || !args.cases.is_empty());
    let (options, of_scenes) = args.asked(&chosen, knobs);
    let seeds = options.seeds;
    let purpose = format!(
        "{:?} {} {:?} {chosen:?}",
        options.shapes, options.first_seed, args.cases
    );
    let mut journal = args.place.journal("accuracy", &purpose, console)?;
    let rows = accuracy(&options, &mut journal, &|stage| console.stage(stage))?;
    let mut drives = scenes(&of_scenes, &mut journal, &|stage| console.stage(stage))?;
    if knobs {
        drives.extend(scene_knobs(&of_scenes, &mut journal, &|stage| {
            console.stage(stage)
        })?);
    }
    let tables = [
        (TABLES[0], accuracy_csv(&rows, &drives)),
        (TABLES[1], accuracy_modes_csv(&rows)),
    ];
    let figures = [accuracy_figures(&rows, &peers), scene_figures(&drives)].concat();
    let mut files = args.place.finish(
        ("accuracy", "Speed against accuracy", WORDS),
        &tables,
        &figures,
        journal,
        console,
    )?;
    files.extend(args.export(&rows, seeds, console)?);
    let wrong = |row: &AccuracyRow| row.on_target() == Some(false);
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": names(&files),
        "seeds": seeds,
        "rows": rows.len() + drives.len(),
        "off_target": rows.iter().filter(|row| wrong(row)).map(|row| json!({"case": row.case.name, "method": row.method.as_str()})).collect::<Vec<_>>(),
    });
    let folder = args.place.output.display();
    Ok(Outcome::written(
        &args.place.output,
        json,
        format!(
            "{}{}\nthe rest stands in {folder}/accuracy.csv\n",
            text(&rows),
            scene_text(&drives)
        ),
    ))
}

/// Writes the measurements of these seeds, so that they can be fitted and looked at as
/// any other.
fn export(
    rows: &[AccuracyRow],
    seeds: &dyn Fn(&AccuracyRow) -> Vec<u64>,
    folder: &Path,
    console: &Console,
) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for case in CASES {
        let seeds: BTreeSet<u64> = rows
            .iter()
            .filter(|row| row.case.name == case.name)
            .flat_map(seeds)
            .collect();
        if seeds.is_empty() {
            continue;
        }
        let problem = case.problem()?;
        let truth = folder.join(format!("truth-{}.json", case.name));
        Output::new(&truth, MODEL, &[], console)?
            .write(|path, force| write_model(path, &problem.truth, force))?;
        files.push(truth);
        for seed in seeds {
            let contents = Contents {
                frf: Some(problem.measured(seed)),
                ..Contents::default()
            };
            let path = folder.join(format!("frf-{}-{seed}.h5", case.name));
            Output::new(&path, FRF, &[], console)?
                .write(|path, force| write_contents(path, &contents, force))?;
            files.push(path);
        }
    }
    Ok(files)
}

fn text(rows: &[AccuracyRow]) -> String {
    const HEADER: [&str; 13] = [
        "case",
        "method",
        "time, s",
        "f: median",
        "worst",
        "η: median",
        "worst",
        "f, real",
        "f covered",
        "missed",
        "spurious",
        "exact",
        "wrong law",
    ];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let [frequency, loss_factor] = row.over_free;
            let [missed, sure, weak] = row.miscounts;
            let numbers = [
                shown(row.time_s[0], 3),
                shown(frequency.median, 2),
                shown(frequency.worst, 2),
                shown(loss_factor.median, 2),
                shown(loss_factor.worst, 2),
                shown(row.over_real[0].median, 2),
                shown(row.coverage[0], 3),
                shown(missed, 2),
                shown(sure + weak, 2),
                shown(row.exact, 2),
                shown(row.wrong_law, 2),
            ];
            [row.case.name.to_owned(), row.name()]
                .into_iter()
                .chain(numbers)
                .collect()
        })
        .collect();
    format!(
        "errors as root mean square over the Cramér-Rao bound of free residues (real: of one real \
         shape per mode), by modes\n{}",
        table(&HEADER, &cells)
    )
}

/// Time and ground served of each rendering method.
fn scene_text(drives: &[SceneRow]) -> String {
    let cells: Vec<Vec<String>> = drives
        .iter()
        .map(|row| {
            let numbers = [
                shown(row.drive.time_s[0], 4),
                shown(row.drive.window.least(), 3),
                shown(row.drive.drifted[0], 3),
            ];
            [row.case.name.to_owned(), row.name()]
                .into_iter()
                .chain(numbers)
                .collect()
        })
        .collect();
    match cells.is_empty() {
        true => String::new(),
        false => format!(
            "\n{}",
            table(
                &["scene", "method", "time, s", "ground served", "after drift"],
                &cells
            )
        ),
    }
}
