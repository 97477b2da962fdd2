//! `chladni bench time`.

use super::{shown, Place};
use chladni_bench::{
    fitted_csv, fitted_verdict, time, time_cases, time_csv, time_figures, time_fitted,
    time_verdict, TimeCase, TimeRow,
};
use chladni_console::table::table;
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, Result};

/// The table.
const TABLE: &str = "time.csv";
/// That of the whole way.
const FITTED_TABLE: &str = "time-fitted.csv";
/// Its case.
const FITTED: &str = "fitted";
/// Above the figures of the page.
const WORDS: &str = "Bursts of 100 ms in the model's truth: how far cold ground goes over its \
limit, at any instant, by each way of ramping.";

/// Arguments of `bench time`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench time -o bench --quick
  chladni bench time -o bench
  chladni bench time -o bench --case glass              the twelve cases on glass

Plays bursts on quarters and the ninth in the middle of two panels, at 300 and 330 Hz, with loss factors of 0.5, 1 and 3 %, by plain, modal
and program ramps and by the spatio-temporal inverse filter; then one of them the whole way, from FRFs with noise through the fit to the true
plate, as it is and drifted. Writes time.csv, time-fitted.csv, time-CASE.svg/png and time.html.")]
pub struct Args {
    /// Only cases whose name begins so, as glass, aluminium-centre or fitted
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    #[command(flatten)]
    place: Place,
}

/// Runs the command.
///
/// # Errors
/// No such case; those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let wanted = args.case.as_deref().unwrap_or("");
    let cases: Vec<TimeCase> = time_cases(args.place.quick)
        .into_iter()
        .filter(|case| case.name.starts_with(wanted))
        .collect();
    let whole_way = FITTED.starts_with(wanted) && !args.place.quick;
    if cases.is_empty() && !whole_way {
        return Err(Error::new(ErrorKind::Usage, "no such case")
            .field("--case")
            .found(wanted)
            .expected("the beginning of a name, as glass-quarter, aluminium-centre or fitted"));
    }
    args.place.prepare(&[TABLE, FITTED_TABLE], console)?;
    let options = format!("{} {wanted}", args.place.quick);
    let mut journal = args.place.journal("time", &options, console)?;
    let rows = time(&cases, args.place.quick, &mut journal, &|stage| {
        console.stage(stage)
    })?;
    let fitted = match whole_way {
        true => time_fitted(&mut journal, &|stage| console.stage(stage))?,
        false => Vec::new(),
    };
    let figures = time_figures(&rows);
    let mut tables = vec![(TABLE, time_csv(&rows))];
    if whole_way {
        tables.push((FITTED_TABLE, fitted_csv(&fitted)));
    }
    let files = args.place.finish(
        ("time", "Bursts, by every way of ramping", WORDS),
        &tables,
        &figures,
        journal,
        console,
    )?;
    let text = format!(
        "{}\n{}{}",
        text(&rows),
        time_verdict(&rows),
        fitted_verdict(&fitted)
    );
    Ok(args.place.answer(&files, rows.len(), text))
}

fn text(rows: &[TimeRow]) -> String {
    const HEADER: [&str; 10] = [
        "case",
        "loss, %",
        "ramps",
        "limit, mN",
        "rise, ms",
        "cold, dB",
        "hot, dB",
        "force, mN",
        "steady, mN",
        "time, s",
    ];
    let line = |row: &TimeRow| {
        vec![
            row.case.clone(),
            shown(100.0 * row.loss_factor, 1),
            row.ramps.clone(),
            shown(1e3 * row.limit_n, 0),
            shown(row.rise_ms, 1),
            shown(row.worst_cold_db, 2),
            shown(row.worst_hot_db, 2),
            shown(1e3 * row.peak_n, 2),
            shown(1e3 * row.steady_n, 2),
            shown(row.time_s, 2),
        ]
    };
    table(&HEADER, &rows.iter().map(line).collect::<Vec<_>>())
}
