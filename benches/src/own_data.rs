//! Settings of a fit on data of one's own, whose truth nobody knows: what cheaper ones lose
//! beside the default, and the time that they save.
//!
//! The default fit states an error bar for each mode. A setting that stands `d` bars from
//! it is at √(1 + d²) bars from a truth that both know independently, so that 1 is as good
//! as the default.

use crate::countdown::Countdown;
use crate::csv;
use crate::journal::Journal;
use crate::knobs::{Knob, Setting, FAMILY, KNOBS};
use crate::pareto::{curves, label, pareto_chart, Entry, Point, WIDTH_PX};
use crate::score::{half_half_width_hz, pair};
use crate::solver::Solver;
use crate::statistics::{median, quantile, root_mean_square};
use chladni_frf::{FrfSet, ModalModel, Mode, Result, Trust};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Layer, Stroke};
use chladni_rfp::{fit, FitOptions, Method};
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Fits of one setting; their median is its time.
const REPEATS: usize = 3;
/// A setting whose fits have taken so long is not repeated further, s.
const ENOUGH_S: f64 = 1.0;

/// Runs of one setting on the data.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Trial {
    times_s: Vec<f64>,
    /// For each mode of the default fit: differences of natural frequency and loss factor
    /// over the default's error bars; `None`: not found.
    differences: Vec<Option<[f64; 2]>>,
    /// Modes that the default has not.
    extra: usize,
    /// The reason why there is no fit.
    failed: Option<String>,
}

/// A setting on data of one's own, beside the default.
#[derive(Debug, Clone)]
pub struct OwnRow {
    /// The method.
    pub method: Method,
    /// A knob that is turned; `None`: the method as it is.
    pub setting: Option<Setting>,
    /// Seconds of a fit: median, first and third quartile.
    pub time_s: [f64; 3],
    /// Modes of the default fit that it misses.
    pub missed: usize,
    /// Modes that the default has not.
    pub extra: usize,
    /// |Difference| over the default's error bars: median and largest, of natural
    /// frequencies and of loss factors.
    pub over_bars: [[f64; 2]; 2],
    /// √(1 + d²), where d is the root mean square difference of natural frequencies over
    /// the bars and a missed mode counts as half its half-power bandwidth.
    pub with_missed: f64,
    /// The reason why there is no fit.
    pub failed: Option<String>,
}

impl OwnRow {
    /// Method and setting.
    pub fn name(&self) -> String {
        let method = self.method;
        self.setting.map_or_else(
            || method.to_string(),
            |setting| format!("{method}, {setting}"),
        )
    }
}

/// Fits `frf` with every method and, with `knobs`, every setting of a knob, and holds each
/// against `default`, the fit of the same data by the default; its row is the first.
/// `progress` hears what is being done.
///
/// # Errors
/// Those of the journal.
pub fn own_data(
    frf: &FrfSet,
    default: &ModalModel,
    (methods, knobs): (&[Method], bool),
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<OwnRow>> {
    let variants = variants(methods, knobs);
    let mut countdown = Countdown::new(variants.len(), progress);
    let row = |variant: (Method, Option<Setting>)| {
        let name = format!("own {} {:?}", variant.0, variant.1);
        countdown.next(&name, journal.has(&name));
        let trial = journal.once(&name, || Ok(run(frf, variant, default)))?;
        Ok(trial.row(variant, default))
    };
    variants.into_iter().map(row).collect()
}

/// The default, the methods, and their knobs.
fn variants(methods: &[Method], knobs: bool) -> Vec<(Method, Option<Setting>)> {
    let others = methods
        .iter()
        .filter(|method| **method != Method::default());
    let mut variants: Vec<(Method, Option<Setting>)> = std::iter::once(&Method::default())
        .chain(others)
        .map(|&method| (method, None))
        .collect();
    let of_methods = |knob: &&Knob| knobs && methods.contains(&knob.method);
    let turned = std::iter::once(&FAMILY).chain(&KNOBS).filter(of_methods);
    variants.extend(turned.flat_map(|knob| {
        let turn = |&setting| (knob.method, Some(setting));
        knob.settings.iter().map(turn)
    }));
    variants
}

fn run(frf: &FrfSet, (method, setting): (Method, Option<Setting>), default: &ModalModel) -> Trial {
    let known: Vec<&Mode> = default.in_band_modes().collect();
    // `lean` is for those who know the order
    let options = FitOptions {
        method,
        modes: (method == Method::Lean).then_some(known.len()),
        ..FitOptions::default()
    };
    let (frf, options) = match setting {
        Some(setting) => (
            setting.data(frf.clone()),
            setting.options(options, known.len()),
        ),
        None => (frf.clone(), options),
    };
    let mut trial = Trial {
        times_s: Vec::new(),
        differences: vec![None; known.len()],
        extra: 0,
        failed: None,
    };
    for repeat in 0..REPEATS {
        let start = Instant::now();
        let fitted = fit(&frf, &options);
        trial.times_s.push(start.elapsed().as_secs_f64());
        match fitted {
            Ok(fitted) if repeat == 0 => trial.compare(&known, &fitted.model),
            Ok(_) => {}
            Err(error) => {
                trial.failed = Some(error.to_string());
                break;
            }
        }
        if trial.times_s.iter().sum::<f64>() > ENOUGH_S {
            break;
        }
    }
    trial
}

impl Trial {
    fn compare(&mut self, known: &[&Mode], model: &ModalModel) {
        let modes = model.modes.iter();
        let found: Vec<&Mode> = modes.filter(|mode| mode.trust != Trust::Rejected).collect();
        let pairs = pair(known, &found);
        for &(k, f) in &pairs {
            let (known, found) = (known[k], found[f]);
            self.differences[k] = Some([
                (found.frequency_hz - known.frequency_hz) / known.frequency_std_hz,
                (found.loss_factor - known.loss_factor) / known.loss_factor_std,
            ]);
        }
        let alone = |f: &usize| found[*f].in_band && pairs.iter().all(|(_, other)| other != f);
        self.extra = (0..found.len()).filter(alone).count();
    }

    fn row(self, (method, setting): (Method, Option<Setting>), default: &ModalModel) -> OwnRow {
        let found = |which: usize| -> Vec<f64> {
            let differences = self.differences.iter().flatten();
            differences.map(|pair| pair[which].abs()).collect()
        };
        let spread = |which| [median(&found(which)), quantile(&found(which), 1.0)];
        let in_bars = |(known, pair): (&Mode, &Option<[f64; 2]>)| match pair {
            Some([frequency, _]) => *frequency,
            None => half_half_width_hz(known) / known.frequency_std_hz,
        };
        let errors = default.in_band_modes().zip(&self.differences).map(in_bars);
        let difference = root_mean_square(errors);
        OwnRow {
            method,
            setting,
            time_s: [0.5, 0.25, 0.75].map(|share| quantile(&self.times_s, share)),
            missed: self
                .differences
                .iter()
                .filter(|pair| pair.is_none())
                .count(),
            extra: self.extra,
            over_bars: [spread(0), spread(1)],
            with_missed: 1f64.hypot(difference),
            failed: self.failed,
        }
    }
}

/// Columns of the table.
const HEADER: [&str; 11] = [
    "method",
    "time_s",
    "time_over_default",
    "missed",
    "extra",
    "frequency_over_bar",
    "frequency_largest_over_bar",
    "loss_factor_over_bar",
    "loss_factor_largest_over_bar",
    "error_over_bar",
    "failed",
];

/// A row for each setting, as CSV.
pub fn own_csv(rows: &[OwnRow]) -> String {
    let comment = "beside the default fit of the same data, differences over its error bars: \
                   median and largest; error: with missed modes, 1 is the default itself";
    let default_s = rows.first().map_or(f64::NAN, |row| row.time_s[0]);
    let cells = |row: &OwnRow| {
        let counts = [row.missed, row.extra].map(|count| count.to_string());
        let [times, errors] = [
            vec![row.time_s[0], row.time_s[0] / default_s],
            [row.over_bars.concat(), vec![row.with_missed]].concat(),
        ]
        .map(|numbers| numbers.into_iter().map(csv::number).collect::<Vec<_>>());
        let failed = row.failed.clone().unwrap_or_default();
        [
            vec![row.name()],
            times,
            counts.to_vec(),
            errors,
            vec![failed],
        ]
        .concat()
    };
    csv::table(comment, &HEADER, rows.iter().map(cells))
}

/// Error against time of every setting; and once more with knobs, where they were turned.
pub fn own_figures(rows: &[OwnRow], data: &str) -> Vec<Figure> {
    let shown: Vec<&OwnRow> = rows.iter().filter(|row| row.failed.is_none()).collect();
    let place = |row: &OwnRow| [row.time_s[0], row.with_missed];
    let entry = |row: &&&OwnRow| Entry {
        at: place(row),
        label: label(&row.method.to_string(), row.missed as f64, row.extra as f64),
        default: Solver::Identify(row.method).is_default(),
    };
    let entries: Vec<Entry> = shown
        .iter()
        .filter(|row| row.setting.is_none())
        .map(|row| entry(&row))
        .collect();
    let point = |row: &&OwnRow| Point {
        method: row.method,
        setting: row.setting,
        at: place(row),
    };
    let turned = curves(&shown.iter().map(point).collect::<Vec<_>>());
    let chart = |curves: &[_]| {
        let limit = Layer::Horizontals {
            name: Some("error bars of the default".into()),
            at: vec![1.0],
            stroke: Stroke::new(Colour::Ink, 1.4).dashed(Dash::Dashed),
        };
        let (x, y) = (
            Axis::log("Time of a fit, median", "s"),
            Axis::log("Rms frequency error over the default's bar", "–"),
        );
        pareto_chart(x, y, &entries, vec![(1.0, limit)], curves)
    };
    let figure = |end: &str, words: &str, charts: Vec<Chart>| {
        (!charts.is_empty()).then(|| Figure {
            name: format!("accuracy-input{end}"),
            title: format!("Error against time: {data}"),
            caption: format!(
                "Beside the default fit of the same data, in its error bars: 1 is as good as the \
                 default. A missed mode counts as half its bandwidth. Lower left is better.{words}"
            ),
            width: WIDTH_PX,
            charts,
        })
    };
    let words = " Dashed: one knob turned, from the least to the most.";
    let knobs = turned.iter().filter_map(|curves| chart(curves)).collect();
    [
        figure("", "", chart(&[]).into_iter().collect()),
        figure("-knobs", words, knobs),
    ]
    .into_iter()
    .flatten()
    .collect()
}
