//! `chladni bench accuracy --input`.

use super::{names, shown, Place};
use chladni_bench::{own_csv, own_data, own_figures, OwnRow, Solver};
use chladni_console::input::{expand, read_frf, Reading};
use chladni_console::table::table;
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_rfp::{fit, FitOptions, Method};
use serde_json::json;
use std::path::PathBuf;

/// A row for each setting.
const TABLE: &str = "accuracy-input.csv";
/// Above the figures of the page.
const WORDS: &str = "Each setting on the same data, beside the default fit and in its error bars. Both scales are logarithmic, lower left is \
better, the line joins what nothing else beats in both. Times are medians of this run; on a shared machine only their ratios mean something.";

/// The part of `bench accuracy` that asks for data of one's own.
pub struct Asked<'a> {
    pub place: &'a Place,
    pub input: &'a [PathBuf],
    pub reading: &'a Reading,
    /// Methods of identification; empty: all.
    pub methods: &'a [Solver],
    /// True where options are turned, too.
    pub knobs: bool,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing; data that the default cannot fit, or without a mode.
pub fn run(args: &Asked, console: &Console) -> Result<Outcome> {
    args.place.refuse_tables(&[TABLE], console)?;
    let methods: Vec<Method> = match args.methods.is_empty() {
        true => Method::ALL.to_vec(),
        false => identifying(args.methods)?,
    };
    let knobs = args.knobs;
    let files = expand(args.input, console)?;
    let (frf, _) = read_frf(&files, args.reading, console)?;
    console.stage("the default fit");
    let options = FitOptions::default();
    let default = fit(&frf, &options)
        .map_err(|error| {
            error
                .told(&options, |name| format!("--{name}"))
                .file(&files[0])
        })?
        .model;
    if default.in_band_modes().next().is_none() {
        return Err(
            Error::bad_data("the default fit finds no mode: nothing to compare with")
                .file(&files[0])
                .help("`chladni fit` says what it found in these data"),
        );
    }
    args.place.prepare(&[TABLE], console)?;
    let purpose = format!("{:?} {methods:?} {knobs}", args.input);
    let mut journal = args.place.journal("accuracy-input", &purpose, console)?;
    let say = |stage: &str| console.stage(stage);
    let rows = own_data(&frf, &default, (&methods, knobs), &mut journal, &say)?;
    let figures = own_figures(&rows, &chladni_text::file_name(&files[0]));
    let words = ("accuracy-input", "What cheaper settings lose", WORDS);
    let tables = [(TABLE, own_csv(&rows))];
    let files = args
        .place
        .finish(words, &tables, &figures, journal, console)?;
    let folder = &args.place.output;
    let json = json!({
        "output": folder.display().to_string(),
        "files": names(&files),
        "modes": default.in_band_modes().count(),
        "rows": rows.len(),
    });
    Ok(Outcome::written(folder, json, text(&rows)))
}

/// Methods of identification alone: FRFs without a scene have no drive.
fn identifying(solvers: &[Solver]) -> Result<Vec<Method>> {
    let method = |solver: &Solver| match solver {
        Solver::Identify(method) => Ok(*method),
        Solver::Render(method) => {
            let words = "FRFs without a scene have no drive: a method of `chladni fit` is needed";
            Err(Error::new(ErrorKind::Usage, words)
                .field("--method")
                .found(method))
        }
    };
    solvers.iter().map(method).collect()
}

fn text(rows: &[OwnRow]) -> String {
    const HEADER: [&str; 8] = [
        "method",
        "time, s",
        "× default",
        "missed",
        "extra",
        "f: median",
        "largest",
        "η: median",
    ];
    let default_s = rows.first().map_or(f64::NAN, |row| row.time_s[0]);
    let cells = |row: &OwnRow| {
        let [frequency, loss_factor] = row.over_bars;
        let numbers = match &row.failed {
            Some(_) => vec!["no fit".to_owned()],
            None => vec![
                shown(row.time_s[0], 3),
                shown(row.time_s[0] / default_s, 2),
                row.missed.to_string(),
                row.extra.to_string(),
                shown(frequency[0], 2),
                shown(frequency[1], 2),
                shown(loss_factor[0], 2),
            ],
        };
        let mut cells = [vec![row.name()], numbers].concat();
        cells.resize(HEADER.len(), String::new());
        cells
    };
    let cells: Vec<Vec<String>> = rows.iter().map(cells).collect();
    format!(
        "differences from the default fit of the same data, over its error bars, by modes\n{}",
        table(&HEADER, &cells)
    )
}
