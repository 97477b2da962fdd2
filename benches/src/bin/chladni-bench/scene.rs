//! `chladni bench scene`.

use super::{paper, shown, Place};
use chladni_bench::{
    scene_csv, scene_figures, scenes, touch, touch_csv, Means, SceneCase, SceneOptions, SceneRow,
    SCENE_CASES,
};
use chladni_console::table::{significant, table};
use chladni_console::Console;
use chladni_console::Outcome;
use chladni_frf::Result;
use chladni_render::{Count, Method, MethodChoice};
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// The table.
const TABLE: &str = "scene.csv";
/// The table of `--touch`.
const TOUCH_TABLE: &str = "touch.csv";

/// Numbers of modes, of actuators and of residual terms where they are turned.
const MODES: [usize; 8] = [1, 2, 4, 6, 8, 11, 15, 20];
const ACTUATORS: [usize; 8] = [2, 3, 5, 7, 9, 12, 17, 25];
const RESIDUAL_TERMS: usize = 3;
/// Above the figures of the page.
const WORDS: &str = "From 40 dB FRFs through the fit to a drive that the true plate judges. Ground lost is the larger share of hot and of cold ground beyond \
its limit, on a 4 mm grid.";

/// Arguments of `bench scene`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni bench scene -o bench --quick
  chladni bench scene -o bench --case quarter-1 --method robust --modes 4,6,8,10,14,all
  chladni bench scene -o bench --case quarter-1 --actuators 3,5,7,9,12,20,all
  chladni bench scene -o bench --paper
  chladni bench scene -o bench --touch

Simulates panels with 40 dB of noise, fits them, renders every scene by every method, and judges the drives on the true plate: at the
responses, on a 4 mm grid, after random drift, and with a finger in the hot zone. Writes scene.csv,
scene-CASE.svg/png (ground lost against time), scene-CASE-means (what each mode, residual term and actuator buys) and scene.html.
With --paper: paper.csv, paper-NAME.svg/png and paper.html (docs/paper.md).")]
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
    /// Numbers of modes, with commas: all, auto, or numbers [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    modes: Vec<Count>,
    /// Numbers of actuators, with commas: all, auto, or numbers [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    actuators: Vec<Count>,
    /// Also turn modes, actuators and residual terms, one at a time, on the first scene
    /// with the default method
    #[arg(long)]
    means: bool,
    /// Judge `--modes auto` by the measured line instead of the whole model
    #[arg(long)]
    measured: bool,
    /// Reproduce the seed paper: its two steps with the lowest modes, for every place of
    /// the hot zone, beside the default method
    #[arg(long, conflicts_with_all = ["methods", "cases", "modes", "actuators", "means", "measured"])]
    paper: bool,
    /// Scenes that light and mid fingers touch, from 300 to 340 Hz, with a drive that expects
    /// them and one that does not
    #[arg(long, conflicts_with_all = ["methods", "cases", "modes", "actuators", "means", "measured", "paper"])]
    touch: bool,
}

/// Runs the command.
///
/// # Errors
/// Those of writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    if args.paper {
        return paper::run(&args.place, console);
    }
    if args.touch {
        return touched(&args.place, console);
    }
    args.place.prepare(&[TABLE], console)?;
    let options = SceneOptions {
        cases: match args.cases.is_empty() {
            true => SCENE_CASES
                .iter()
                .filter(|case| case.quick || !args.place.quick)
                .collect(),
            false => args.cases.clone(),
        },
        methods: match args.methods.is_empty() {
            true => Method::ALL
                .map(MethodChoice::Only)
                .into_iter()
                .chain([MethodChoice::Best])
                .collect(),
            false => args.methods.clone(),
        },
        means: product(&args.modes, &args.actuators),
        by_measured_line: args.measured,
    };
    let mut journal = args
        .place
        .journal("scene", &format!("{}", args.measured), console)?;
    let mut rows = scenes(&options, &mut journal, &|stage| console.stage(stage))?;
    let plain = args.modes.is_empty() && args.actuators.is_empty();
    if args.means || (plain && !args.place.quick && args.cases.is_empty()) {
        let turned = SceneOptions {
            cases: options.cases[..1].to_vec(),
            methods: vec![MethodChoice::Default],
            means: turned(),
            by_measured_line: false,
        };
        rows.extend(scenes(&turned, &mut journal, &|stage| {
            console.stage(stage)
        })?);
    }
    let figures = scene_figures(&rows);
    let files = args.place.finish(
        (
            "scene",
            "Scenes: speed, success, and what each means buys",
            WORDS,
        ),
        &[(TABLE, scene_csv(&rows))],
        &figures,
        journal,
        console,
    )?;
    Ok(args.place.answer(&files, rows.len(), text(&rows)))
}

/// Runs `bench scene --touch`.
fn touched(place: &Place, console: &Console) -> Result<Outcome> {
    place.prepare(&[TOUCH_TABLE], console)?;
    let rows = touch(place.quick, &|stage| console.stage(stage))?;
    let files = place.write(&[(TOUCH_TABLE, touch_csv(&rows))], &[], console)?;
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.scene.to_owned(),
                significant(row.frequency_hz, 6),
                (if row.touch { "yes" } else { "no" }).to_owned(),
                row.firmest.clone(),
                shown(row.kappa, 1),
                shown(1e3 * row.max_force_n, 1),
                shown(row.total, 3),
                shown(row.least, 2),
                shown(row.area, 3),
                shown(row.time_s, 1),
            ]
        })
        .collect();
    const HEADER: [&str; 10] = [
        "scene",
        "Hz",
        "touch",
        "tolerates",
        "kappa",
        "mN",
        "total",
        "least",
        "ground",
        "s",
    ];
    Ok(place.answer(&files, rows.len(), table(&HEADER, &cells)))
}

/// Every number of modes with every number of actuators.
fn product(modes: &[Count], actuators: &[Count]) -> Vec<Means> {
    let or_all = |counts: &[Count]| {
        if counts.is_empty() {
            vec![Count::All]
        } else {
            counts.to_vec()
        }
    };
    let (modes, actuators) = (or_all(modes), or_all(actuators));
    modes
        .iter()
        .flat_map(|&modes| {
            actuators.iter().map(move |&actuators| Means {
                modes,
                actuators,
                ..Means::default()
            })
        })
        .collect()
}

/// Modes, actuators and residual terms one at a time, the others all.
fn turned() -> Vec<Means> {
    let modes = MODES.map(|count| Means {
        modes: Count::Number(count),
        ..Means::default()
    });
    let actuators = ACTUATORS.map(|count| Means {
        actuators: Count::Number(count),
        ..Means::default()
    });
    let terms = (0..=RESIDUAL_TERMS).map(|count| Means {
        residual_terms: Some(count),
        ..Means::default()
    });
    modes
        .into_iter()
        .chain(actuators)
        .chain(terms)
        .chain([Means::default()])
        .collect()
}

fn text(rows: &[SceneRow]) -> String {
    const HEADER: [&str; 13] = [
        "scene",
        "method",
        "modes",
        "actuators",
        "time, ms",
        "kappa",
        "points",
        "hot",
        "cold",
        "total",
        "drifted",
        "touched",
        "force, mN",
    ];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let drive = &row.drive;
            let asked = row.name();
            let method = if row.asked.to_string() == drive.method {
                asked
            } else {
                format!("{asked} ({})", drive.method)
            };
            let ratios = [
                drive.points.total,
                drive.window.hot,
                drive.window.cold,
                drive.window.total,
                drive.drifted[0],
                drive.touched,
            ];
            [
                row.case.name.to_owned(),
                method,
                drive.modes.to_string(),
                drive.actuators.to_string(),
            ]
            .into_iter()
            .chain([significant(1e3 * drive.time_s[0], 3), shown(drive.kappa, 2)])
            .chain(ratios.map(|ratio| shown(ratio, 3)))
            .chain([significant(1e3 * drive.max_force_n, 3)])
            .collect()
        })
        .collect();
    table(&HEADER, &cells)
}
