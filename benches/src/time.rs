//! Bursts: rise time, force and cold overshoot of each way of ramping, beside the
//! spatio-temporal inverse filter.

mod fitted;
mod inverse_filter;

pub use fitted::{fitted_csv, fitted_verdict, FittedRow};

use crate::csv::{number, table};
use crate::journal::Journal;
use crate::scene::ScenePanel;
use chladni_frf::{Error, ModalModel, Result};
use chladni_plate::{simulate, LossFactor};
use chladni_render::{
    evaluate_signal, play, render, PlayOptions, Ramps, RenderOptions, Scene, TimeEvent, Weights,
};
use chladni_report::{Axis, Chart, Colour, Figure, Mark, Place, Stroke};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;

/// Rises that are tried, ms.
const RISES_MS: [f64; 5] = [3.0, 5.0, 8.0, 10.0, 15.0];
/// Force limits under which envelope programs are tried, N.
const FORCES_N: [f64; 2] = [0.1, 0.002];
/// Rises beyond which programs are not tried, ms, and beyond which the smaller of the
/// limits is not.
const PROGRAM_MS: [f64; 2] = [10.0, 5.0];
/// Longest ramp that is to be found, ms.
const AUTO_MS: f64 = 10.0;
/// Length of the bursts, s.
const BURST_S: f64 = 0.1;
/// Their beginning, s: room for what an inverse filter does before.
const START_S: f64 = 0.25;
/// Width of a picture, px.
const WIDTH_PX: f64 = 720.0;

/// A scene on a panel with one loss factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeCase {
    /// Name in tables.
    pub name: &'static str,
    panel: ScenePanel,
    grid: usize,
    hot: usize,
    frequency_hz: f64,
    loss_factor: f64,
}

/// One way of ramping in one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeRow {
    /// Case.
    pub case: String,
    /// `plain`, `modal`, `program`, `inverse-filter` or `inverse-filter-cut`.
    pub ramps: String,
    /// Seconds that it took to find, steady drive included.
    pub time_s: f64,
    /// Loss factor of all modes.
    pub loss_factor: f64,
    /// Hz.
    pub frequency_hz: f64,
    /// Rise and fall, ms; of `modal auto` what was found.
    pub rise_ms: f64,
    /// Force limit of each actuator, N.
    pub limit_n: f64,
    /// Worst cold ground over its limit at any instant, dB.
    pub worst_cold_db: f64,
    /// Weakest hot ground over its limit in the hold, dB.
    pub worst_hot_db: f64,
    /// Largest force, N.
    pub peak_n: f64,
    /// The same of the steady drive.
    pub steady_n: f64,
    /// Time from the drive's beginning to the burst, ms.
    pub ahead_ms: f64,
}

/// The case of the whole way.
const GLASS_QUARTER: TimeCase = TimeCase {
    name: "glass-quarter",
    panel: ScenePanel::Glass,
    grid: 2,
    hot: 1,
    frequency_hz: 300.0,
    loss_factor: 0.01,
};

/// Every case: quarters and the ninth in the middle of two panels.
pub fn time_cases(quick: bool) -> Vec<TimeCase> {
    let scenes = [
        ("glass-quarter", ScenePanel::Glass, 2, 1),
        ("glass-centre", ScenePanel::Glass, 3, 5),
        ("aluminium-quarter", ScenePanel::Aluminium, 2, 1),
        ("aluminium-centre", ScenePanel::Aluminium, 3, 5),
    ];
    let mut cases = Vec::new();
    for (name, panel, grid, hot) in scenes {
        for frequency_hz in [300.0, 330.0] {
            for loss_factor in [0.005, 0.01, 0.03] {
                cases.push(TimeCase {
                    name,
                    panel,
                    grid,
                    hot,
                    frequency_hz,
                    loss_factor,
                });
            }
        }
    }
    if quick {
        cases.retain(|case| case.panel == ScenePanel::Glass && case.loss_factor == 0.01);
    }
    cases
}

impl TimeCase {
    fn label(&self) -> String {
        format!("{}-{}-hz", self.name, self.frequency_hz)
    }

    fn model(&self) -> Result<ModalModel> {
        let mut panel = self.panel.panel();
        panel.plate.loss_factor = LossFactor::Common(self.loss_factor);
        // few lines, the last one at 1000 Hz
        panel.frf.step_hz = 99.8;
        Ok(simulate(&panel, None, None)?.truth)
    }

    fn scene(&self, rise: &str, limit_n: f64) -> Result<Scene> {
        let plate = self.panel.panel().plate;
        Scene::parse(
            &format!(
                "frequency_hz = {:?}\n[zones]\ngrid = [{g}, {g}]\nhot = [{}]\ncells_m = [0.0, 0.0, {:?}, \
                 {:?}]\n[actuators]\nmax_force_n = {limit_n:?}\n[time]\n[[time.burst]]\nstart_s = \
                 {START_S:?}\nduration_s = {BURST_S:?}\nramp_s = {rise}\n",
                self.frequency_hz,
                self.hot,
                plate.length_m,
                plate.width_m,
                g = self.grid,
            ),
            Path::new(""),
        )
    }
}

/// All ways of ramping in all `cases`; `quick` takes two rises and one force limit.
///
/// # Errors
/// Those of simulating and rendering: a bug.
pub fn time(
    cases: &[TimeCase],
    quick: bool,
    journal: &mut Journal,
    stage: &dyn Fn(&str),
) -> Result<Vec<TimeRow>> {
    let mut rows = Vec::new();
    for case in cases {
        let key = format!("{} {}", case.label(), case.loss_factor);
        stage(&key);
        rows.extend(journal.once(&key, || of_case(case, quick))?);
    }
    Ok(rows)
}

/// The whole way from noisy FRFs to the true plate.
///
/// # Errors
/// Those of fitting and playing: a bug.
pub fn time_fitted(journal: &mut Journal, stage: &dyn Fn(&str)) -> Result<Vec<FittedRow>> {
    stage("fitted");
    journal.once("fitted", fitted::fitted)
}

fn of_case(case: &TimeCase, quick: bool) -> Result<Vec<TimeRow>> {
    let model = case.model()?;
    let mut rows = Vec::new();
    let forces = if quick { &FORCES_N[..1] } else { &FORCES_N[..] };
    let rises = if quick {
        &RISES_MS[1..4]
    } else {
        &RISES_MS[..]
    };
    let within = |limit_n: f64| -> Result<Weights> {
        let scene = case.scene("0.01", limit_n)?;
        Ok(render(&model, &scene, &RenderOptions::default())?.weights)
    };
    let widest = within(FORCES_N[0])?;
    for &limit_n in forces {
        // what has to be held is the same, so that ramps alone are compared
        let steady = match largest_n(&widest) <= limit_n {
            true => widest.clone(),
            false => within(limit_n)?,
        };
        let run = |ramps: Ramps, rise: &str| of_ramps(case, &model, &steady, ramps, rise, limit_n);
        if limit_n == FORCES_N[0] {
            rows.push(TimeRow {
                ramps: "modal auto".into(),
                ..run(Ramps::Modal, "\"auto\"")?
            });
        }
        for &rise_ms in rises.iter().filter(|&&rise_ms| !quick || rise_ms != 8.0) {
            let rise = format!("{}", 1e-3 * rise_ms);
            if limit_n == FORCES_N[0] {
                rows.push(run(Ramps::Plain, &rise)?);
                rows.push(run(Ramps::Modal, &rise)?);
                rows.extend(filtered(case, &model, &steady, rise_ms, limit_n)?);
            }
            let most_ms = PROGRAM_MS[usize::from(limit_n != FORCES_N[0])];
            if rise_ms <= most_ms {
                rows.push(run(Ramps::Program, &rise)?);
            }
        }
    }
    Ok(rows)
}

/// Largest force of weights, N.
fn largest_n(weights: &Weights) -> f64 {
    let sizes = weights.weights.iter().map(|weight| weight.amplitude);
    sizes.fold(0.0, f64::max)
}

fn of_ramps(
    case: &TimeCase,
    model: &ModalModel,
    steady: &Weights,
    ramps: Ramps,
    rise: &str,
    limit_n: f64,
) -> Result<TimeRow> {
    let scene = case.scene(rise, limit_n)?;
    let options = PlayOptions {
        ramps: Some(ramps),
        ..PlayOptions::default()
    };
    let before = Instant::now();
    let played = play(model, &scene, Some(steady), &options)?;
    let indices = &played.indices;
    Ok(TimeRow {
        case: case.label(),
        ramps: ramps.as_str().into(),
        time_s: before.elapsed().as_secs_f64(),
        loss_factor: case.loss_factor,
        frequency_hz: case.frequency_hz,
        rise_ms: 1e3 * indices.ramp_s,
        limit_n,
        worst_cold_db: indices.peak.worst_cold_db.unwrap_or(f64::NAN),
        worst_hot_db: indices.peak.worst_hot_db.unwrap_or(f64::NAN),
        peak_n: indices.peak_drive,
        steady_n: indices.steady_drive,
        ahead_ms: 0.0,
    })
}

/// The baseline, whole and with what comes before the burst cut off.
fn filtered(
    case: &TimeCase,
    model: &ModalModel,
    steady: &Weights,
    rise_ms: f64,
    limit_n: f64,
) -> Result<Vec<TimeRow>> {
    let rise_s = 1e-3 * rise_ms;
    let scene = case.scene(&format!("{rise_s}"), limit_n)?;
    let burst = inverse_filter::Burst {
        start_s: START_S,
        duration_s: BURST_S,
        ramp_s: rise_s,
    };
    let before = Instant::now();
    let whole = inverse_filter::drive(model, steady, &burst)
        .map_err(|error| Error::new(chladni_frf::ErrorKind::Internal, error.to_string()))?;
    let time_s = before.elapsed().as_secs_f64();
    let events = [TimeEvent {
        event: "[[time.burst]] 1".into(),
        start_s: START_S,
        end_s: START_S + BURST_S,
        ramp_s: rise_s,
        gain: 1.0,
    }];
    let mut rows = Vec::new();
    for (ramps, recorded) in [
        ("inverse-filter", whole.clone()),
        ("inverse-filter-cut", inverse_filter::cut(whole, START_S)),
    ] {
        let peak = evaluate_signal(&recorded, &events, &scene, model)?.0;
        let largest = |k: usize| {
            recorded
                .drive
                .row(k)
                .iter()
                .fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        // what is a thousandth of the peak is no drive
        let most = (0..recorded.drive.nrows()).map(largest).fold(0.0, f64::max);
        let first = (0..recorded.drive.nrows()).find(|&k| largest(k) > 1e-2 * most);
        let first_s = first.unwrap_or(0) as f64 / recorded.rate_hz;
        rows.push(TimeRow {
            case: case.label(),
            ramps: ramps.into(),
            time_s,
            loss_factor: case.loss_factor,
            frequency_hz: case.frequency_hz,
            rise_ms,
            limit_n,
            worst_cold_db: peak.peak.worst_cold_db.unwrap_or(f64::NAN),
            worst_hot_db: peak.peak.worst_hot_db.unwrap_or(f64::NAN),
            peak_n: peak.peak_drive,
            steady_n: largest_n(steady),
            ahead_ms: 1e3 * (START_S - first_s).max(0.0),
        });
    }
    Ok(rows)
}

/// The table.
pub fn time_csv(rows: &[TimeRow]) -> String {
    let header = [
        "case",
        "ramps",
        "time_s",
        "loss_factor",
        "frequency_hz",
        "rise_ms",
        "limit_n",
        "worst_cold_db",
        "worst_hot_db",
        "peak_n",
        "steady_n",
        "ahead_ms",
    ];
    let line = |row: &TimeRow| {
        let mut cells = vec![row.case.clone(), row.ramps.clone()];
        cells.extend(
            [
                row.time_s,
                row.loss_factor,
                row.frequency_hz,
                row.rise_ms,
                row.limit_n,
                row.worst_cold_db,
                row.worst_hot_db,
                row.peak_n,
                row.steady_n,
                row.ahead_ms,
            ]
            .map(number),
        );
        cells
    };
    table(
        "bursts of 100 ms in the model's truth, at the responses, at each instant",
        &header,
        rows.iter().map(line),
    )
}

/// Count of the glass panel's cases that keep every limit, by the ways that promise it.
pub fn time_verdict(rows: &[TimeRow]) -> String {
    let glass: Vec<&TimeRow> = rows
        .iter()
        .filter(|row| row.case.starts_with("glass"))
        .collect();
    let autos: Vec<&TimeRow> = glass
        .iter()
        .copied()
        .filter(|row| row.ramps == "modal auto")
        .collect();
    let fast = autos
        .iter()
        .filter(|row| row.rise_ms <= AUTO_MS + 1e-6 && row.holds());
    let mut lines = vec![format!(
        "modal ramps of at most {AUTO_MS} ms, found by themselves: {} of {}",
        fast.count(),
        autos.len()
    )];
    for rise_ms in RISES_MS {
        for limit_n in FORCES_N {
            let tried: Vec<&TimeRow> = glass
                .iter()
                .copied()
                .filter(|row| row.ramps == "program" && (row.rise_ms - rise_ms).abs() < 1e-6)
                .filter(|row| row.limit_n == limit_n)
                .collect();
            if tried.is_empty() {
                continue;
            }
            let count = tried.len();
            let (kept, missed): (Vec<&TimeRow>, Vec<&TimeRow>) =
                tried.into_iter().partition(|row| row.holds());
            let figures: Vec<String> = missed.iter().map(|row| row.miss()).collect();
            lines.push(format!(
                "programs of {rise_ms} ms within {} mN: {} of {}{}{}",
                1e3 * limit_n,
                kept.len(),
                count,
                if figures.is_empty() { "" } else { "; " },
                figures.join(", ")
            ));
        }
    }
    lines.join("\n") + "\n"
}

impl TimeRow {
    /// True where no response misses its limit.
    fn holds(&self) -> bool {
        self.worst_cold_db <= 0.0 && self.worst_hot_db >= 0.0
    }

    /// By how much one does.
    fn miss(&self) -> String {
        let worst_db = self.worst_cold_db.max(-self.worst_hot_db);
        let loss = 100.0 * self.loss_factor;
        format!("{} at {loss} % misses by {worst_db:.2} dB", self.case)
    }
}

/// Cold overshoot over the rise, one figure for each case and loss factor of 1 %.
pub fn time_figures(rows: &[TimeRow]) -> Vec<Figure> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.case.as_str()) {
            names.push(&row.case);
        }
    }
    names.into_iter().map(|name| figure(name, rows)).collect()
}

fn figure(name: &str, rows: &[TimeRow]) -> Figure {
    let ways = [
        "plain",
        "modal",
        "program",
        "inverse-filter",
        "inverse-filter-cut",
    ];
    let mut chart = Chart::new(
        Axis::linear("rise", "ms"),
        Axis::linear("worst cold ground over its limit", "dB"),
    );
    for (k, way) in ways.into_iter().enumerate() {
        let points: Vec<Place> = rows
            .iter()
            .filter(|row| {
                row.case == name
                    && row.ramps == way
                    && row.loss_factor == 0.01
                    && row.limit_n == FORCES_N[0]
            })
            .map(|row| [row.rise_ms, row.worst_cold_db])
            .collect();
        let colour = Colour::Series(k as u8);
        chart = chart
            .line("", points.clone(), Stroke::new(colour, 1.6))
            .marks(way, points, Mark::of_series(k), colour, 8.0);
    }
    Figure {
        name: format!("time-{name}"),
        title: format!("Bursts of 100 ms, {name}"),
        caption: "Worst cold ground over its limit at any instant against the rise; below 0 it is \
                  quiet."
            .into(),
        width: WIDTH_PX,
        charts: vec![chart],
    }
}
