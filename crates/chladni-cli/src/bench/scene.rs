//! `chladni bench scene`.

use super::{shown, Place};
use crate::console::Console;
use crate::outcome::Outcome;
use crate::table::{significant, table};
use chladni_bench::{scene_csv, scenes, SceneCase, SceneOptions, SceneRow, SCENE_CASES};
use chladni_frf::Result;
use chladni_render::{Count, Method, MethodChoice};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::json;

/// The table.
const TABLE: &str = "scene.csv";

/// Arguments of `bench scene`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench scene -o bench --quick
  chladni bench scene -o bench --case quarter-1 --method robust --modes 4,6,8,10,14,all
  chladni bench scene -o bench --case quarter-1 --actuators 3,5,7,9,12,20,all

Simulates panels with 40 dB of noise, fits them, renders every scene by every method, and judges the drives on the true plate: at the
responses, on a 4 mm grid, after random drift, and with a finger in the hot zone. Writes scene.csv.")]
pub struct Args {
    #[command(flatten)]
    place: Place,
    /// Methods to run; may be repeated [default: all]
    #[arg(long = "method", value_name = "METHOD", value_parser = PossibleValuesParser::new(MethodChoice::names())
        .try_map(|name| name.parse::<MethodChoice>()))]
    methods: Vec<MethodChoice>,
    /// Scenes to run; may be repeated [default: all]
    #[arg(long = "case", value_name = "CASE", value_parser = PossibleValuesParser::new(SCENE_CASES.map(|case| case.name))
        .try_map(|name| SceneCase::named(&name).ok_or("no such scene")))]
    cases: Vec<&'static SceneCase>,
    /// Numbers of modes, with commas: all, auto, or numbers
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "all")]
    modes: Vec<Count>,
    /// Numbers of actuators, with commas: all, auto, or numbers
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "all")]
    actuators: Vec<Count>,
    /// Judge `--modes auto` by the measured line instead of the whole model
    #[arg(long)]
    measured: bool,
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    args.place.prepare(&[TABLE], console)?;
    let options = SceneOptions {
        cases: match args.cases.is_empty() {
            true => SCENE_CASES.iter().filter(|case| case.quick || !args.place.quick).collect(),
            false => args.cases.clone(),
        },
        methods: match args.methods.is_empty() {
            true => Method::ALL.map(MethodChoice::Only).into_iter().chain([MethodChoice::Best]).collect(),
            false => args.methods.clone(),
        },
        modes: args.modes.clone(),
        actuators: args.actuators.clone(),
        by_measured_line: args.measured,
    };
    let rows = scenes(&options, &|stage| console.stage(stage))?;
    let files = args.place.write(&[(TABLE, scene_csv(&rows))], &[], console)?;
    let json = json!({
        "output": args.place.output.display().to_string(),
        "files": files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        "rows": rows.len(),
        "warnings": console.warnings(),
    });
    Ok(Outcome::written(&args.place.output, json, text(&rows)))
}

fn text(rows: &[SceneRow]) -> String {
    const HEADER: [&str; 13] =
        ["scene", "method", "modes", "actuators", "time, ms", "kappa", "points", "hot", "cold", "total", "drifted", "touched", "force, mN"];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let weights = &row.rendering.weights;
            let method =
                if row.asked[0] == weights.method { weights.method.clone() } else { format!("{} ({})", row.asked[0], weights.method) };
            let force = weights.indices.points.max_force_n.map_or(f64::NAN, |force| 1e3 * force);
            let ratios = [row.points.total, row.window.hot, row.window.cold, row.window.total, row.drifted[0], row.touched];
            [row.case.name.to_owned(), method, weights.modes_used.to_string(), weights.actuators_used.to_string()]
                .into_iter()
                .chain([significant(1e3 * row.time_s, 3), shown(weights.kappa.unwrap_or(f64::NAN), 2)])
                .chain(ratios.map(|ratio| shown(ratio, 3)))
                .chain([significant(force, 3)])
                .collect()
        })
        .collect();
    table(&HEADER, &cells)
}
