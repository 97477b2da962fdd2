//! `chladni bench solvers`.

use super::{names, shown, Place};
use chladni_bench::{kernels, kernels_csv, kernels_figure};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use serde_json::json;

/// The table.
const TABLE: &str = "solvers.csv";

/// Arguments of `bench solvers`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Example:
  chladni bench solvers -o bench

Times dense kernels (products, QR, SVD, eigenvalues, least squares) at the sizes of a fit. Built with `--features system`, faer and LAPACK run by
turns in one run; the build without it has faer alone. Writes solvers.csv and solvers.svg/png.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.prepare(&[TABLE], console)?;
    let rows = kernels(args.place.quick, &|stage| console.stage(stage));
    let files = args.place.write(
        &[(TABLE, kernels_csv(&rows))],
        &[kernels_figure(&rows)],
        console,
    )?;
    let mut backends: Vec<&str> = rows.iter().map(|row| row.backend).collect();
    backends.sort_unstable();
    backends.dedup();
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": names(&files),
        "rows": rows.len(),
        "backends": backends,
    });
    let cells = rows.iter().map(|row| {
        let numbers = [
            shown(1e3 * row.time_s[0], 3),
            shown(1e3 * row.time_s[1], 3),
            shown(1e-9 * row.flop_per_s, 2),
        ];
        [
            row.kernel.to_owned(),
            row.size.clone(),
            row.backend.to_owned(),
        ]
        .into_iter()
        .chain(numbers)
        .chain([row.about.to_owned()])
        .collect()
    });
    let header = [
        "kernel",
        "size",
        "back end",
        "time, ms",
        "least",
        "Gflop/s",
        "what uses it",
    ];
    Ok(Outcome::written(
        &args.place.output,
        json,
        table(&header, &cells.collect::<Vec<Vec<String>>>()),
    ))
}
