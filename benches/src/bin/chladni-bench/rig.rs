//! `chladni bench rig`.

use super::{shown, Place};
use chladni_bench::{median, rig_csv, rig_figures, rigs, RigError, RigOptions, RigRow, RigWay};
use chladni_console::table::table;
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// The table.
const TABLE: &str = "rig.csv";
/// Rigs of each kind of a full run, and of a quick one.
const RIGS: u32 = 200;
const QUICK_RIGS: u32 = 8;
/// A rig counts as served from here on.
const SERVED: f64 = 0.99;
/// Above the figures of the page.
const WORDS: &str = "A drive is rendered for a panel fitted from 40 dB FRFs and played on the true plate with faults that the model does not know: gains, dead \
and reversed channels, masses, fingers, drift, points that the scanner misses by 1 mm, noise of the field. Each measured field corrects it.";

/// Arguments of `bench rig`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench rig -o bench --quick
  chladni bench rig -o bench --rigs 200
  chladni bench rig -o bench --corner --error dead --error finger --rigs 6

Drives corrected by measured fields on rigs drawn from a seed, beside iterative learning and the first drive left as it is. Writes rig.csv,
rig.svg/png and rig.html. An interrupted run goes on where it stopped.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Rigs of each kind [default: 200; quick: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    rigs: Option<u32>,
    /// First seed; the others follow it
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Measured fields of each rig
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=20))]
    fields: u32,
    /// Kind of fault of the rigs; may be repeated [default: mixed]
    #[arg(long = "error", value_name = "KIND", value_parser = PossibleValuesParser::new(RigError::ALL.map(RigError::name))
        .try_map(|name| RigError::named(&name).ok_or("no such kind")))]
    errors: Vec<RigError>,
    /// The corner scene of the glass panel at 300 Hz alone, instead of scenes on four panels
    #[arg(long)]
    corner: bool,
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.prepare(&[TABLE], console)?;
    let usual = if args.place.quick { QUICK_RIGS } else { RIGS };
    let options = RigOptions {
        errors: match args.errors.is_empty() {
            true => vec![RigError::Mixed],
            false => args.errors.clone(),
        },
        rigs: args.rigs.unwrap_or(usual) as usize,
        first_seed: args.seed,
        fields: args.fields as usize,
        corner_only: args.corner,
    };
    let purpose = format!("{} {}", args.corner, args.fields);
    let mut journal = args.place.journal("rig", &purpose, console)?;
    let rows = rigs(&options, &mut journal, &|stage| console.stage(stage))?;
    let figures = rig_figures(&rows);
    let files = args.place.finish(
        ("rig", "Drives corrected by measured fields", WORDS),
        &[(TABLE, rig_csv(&rows))],
        &figures,
        journal,
        console,
    )?;
    Ok(args.place.answer(&files, rows.len(), text(&rows, &options)))
}

fn text(rows: &[RigRow], options: &RigOptions) -> String {
    const HEADER: [&str; 7] = [
        "error",
        "way",
        "fields",
        "mean",
        "least",
        "served, %",
        "time, s",
    ];
    let mut cells = Vec::new();
    for error in &options.errors {
        for way in RigWay::ALL {
            for fields in 0..=options.fields {
                let own: Vec<&RigRow> = rows
                    .iter()
                    .filter(|row| {
                        row.error == error.name() && row.way == way && row.fields == fields
                    })
                    .collect();
                let ratios: Vec<f64> = own.iter().map(|row| row.min_ratio).collect();
                let times: Vec<f64> = own.iter().map(|row| row.time_s).collect();
                let count = ratios.len() as f64;
                let served = ratios.iter().filter(|ratio| **ratio >= SERVED).count() as f64;
                cells.push(vec![
                    error.name().to_owned(),
                    way.name().to_owned(),
                    fields.to_string(),
                    shown(ratios.iter().sum::<f64>() / count, 3),
                    shown(ratios.iter().copied().fold(f64::INFINITY, f64::min), 3),
                    shown(100.0 * served / count, 1),
                    shown(median(&times), 2),
                ]);
            }
        }
    }
    table(&HEADER, &cells)
}
