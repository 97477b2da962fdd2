//! Rendering on virtual panels, from noisy FRFs through the fit to a drive that is judged by the true plate: success against time, modes and actuators.

mod cases;
mod true_panel;

pub use cases::{SceneCase, ScenePanel, SCENE_CASES};
pub use true_panel::Served;

use crate::csv;
use crate::statistics::{mean, median};
pub(crate) use cases::MeasuredPanel;
use chladni_frf::{Error, ErrorKind, ModalModel, Result};
use chladni_render::{render_measured, Count, Finger, MethodChoice, RenderOptions, Rendering};
use chladni_rfp::{fit, FitOptions};
use ndarray::Array1;
use num_complex::Complex64;
use std::time::Instant;

/// Drifts that each drive has to bear.
const DRIFTS: u64 = 10;
/// Repetitions of the clock for methods that take less than this, s.
const SHORT_S: f64 = 0.05;
/// How many.
const REPETITIONS: usize = 5;

/// What to run.
#[derive(Debug, Clone)]
pub struct SceneOptions {
    /// Scenes.
    pub cases: Vec<&'static SceneCase>,
    /// Methods.
    pub methods: Vec<MethodChoice>,
    /// Numbers of modes.
    pub modes: Vec<Count>,
    /// Numbers of actuators.
    pub actuators: Vec<Count>,
    /// Judge `auto` numbers of modes by the measured line instead of the whole model.
    pub by_measured_line: bool,
}

/// One method on one scene.
#[derive(Debug, Clone)]
pub struct SceneRow {
    /// The scene.
    pub case: &'static SceneCase,
    /// What was asked for.
    pub asked: [String; 3],
    /// What came of it in the fitted model.
    pub rendering: Rendering,
    /// Time, s.
    pub time_s: f64,
    /// Shares of measured responses served on the true plate.
    pub points: Served,
    /// Shares of the dense window served on the true plate.
    pub window: Served,
    /// The same after random drift: mean and least of the total.
    pub drifted: [f64; 2],
    /// The same with a finger at each of three places: least of the total.
    pub touched: f64,
}

/// Renders every scene by every method with every number of modes and actuators.
///
/// # Errors
/// None for the named scenes.
pub fn scenes(options: &SceneOptions, progress: &dyn Fn(&str)) -> Result<Vec<SceneRow>> {
    let mut rows = Vec::new();
    let mut panels: Vec<ScenePanel> = Vec::new();
    for case in &options.cases {
        if !panels.contains(&case.panel) {
            panels.push(case.panel);
        }
    }
    for kind in panels {
        progress(&format!("measuring and fitting the panel {kind:?}"));
        let panel = kind.measure()?;
        let model = fit(&panel.frf, &FitOptions::default(), &|_| {})
            .map_err(|error| Error::new(ErrorKind::Internal, format!("the fit of {kind:?} fails: {error}")))?
            .model;
        for case in options.cases.iter().filter(|case| case.panel == kind) {
            for &method in &options.methods {
                for &modes in &options.modes {
                    for &actuators in &options.actuators {
                        progress(&format!("{}: {method}", case.name));
                        let render = RenderOptions { method, modes, actuators, ..RenderOptions::default() };
                        rows.push(row(case, &panel, &model, &render, options.by_measured_line)?);
                    }
                }
            }
        }
    }
    Ok(rows)
}

fn row(case: &'static SceneCase, panel: &MeasuredPanel, model: &ModalModel, options: &RenderOptions, by_line: bool) -> Result<SceneRow> {
    let scene = case.scene(panel)?;
    let timed = || {
        let clock = Instant::now();
        let rendering = render_measured(model, &scene, options, by_line.then_some(&panel.frf));
        rendering.map(|rendering| (rendering, clock.elapsed().as_secs_f64()))
    };
    let (rendering, first) = timed()?;
    let mut times = vec![first];
    while times.len() < REPETITIONS && first < SHORT_S {
        times.push(timed()?.1);
    }
    times.sort_by(f64::total_cmp);
    let drive: Array1<Complex64> = rendering.weights.weights.iter().map(|weight| weight.value()).collect();
    let (f, zones, limits, truth) = (case.frequency_hz, &rendering.zones, &rendering.limits, &panel.truth);
    let drifts: Vec<f64> = (1..=DRIFTS).map(|seed| truth.drifted(&drive, f, seed, zones, limits).total).collect();
    let mut touched = f64::INFINITY;
    for place in chladni_render::finger_places(&rendering.field) {
        touched = touched.min(truth.touched(&drive, f, &Finger::default(), place, zones, limits)?.total);
    }
    Ok(SceneRow {
        case,
        asked: [options.method.to_string(), options.modes.to_string(), options.actuators.to_string()],
        time_s: median(&times),
        points: truth.at(&drive, f, &rendering.field, limits)?,
        window: truth.free(&drive, f, zones, limits),
        drifted: [mean(drifts.iter().copied()), drifts.iter().copied().fold(f64::INFINITY, f64::min)],
        touched,
        rendering,
    })
}

/// The table.
pub fn scene_csv(rows: &[SceneRow]) -> String {
    const HEADER: [&str; 23] = [
        "scene",
        "method",
        "modes",
        "actuators",
        "asked_method",
        "asked_modes",
        "asked_actuators",
        "frequency_hz",
        "time_s",
        "feasible",
        "kappa",
        "points_hot",
        "points_cold",
        "points_success",
        "points_silence",
        "window_hot",
        "window_cold",
        "window_total",
        "drift_mean",
        "drift_least",
        "touched_least",
        "max_force_n",
        "possible_db",
    ];
    let cells = rows.iter().map(|row| {
        let weights = &row.rendering.weights;
        let points = &weights.indices.points;
        let [method, modes, actuators] = row.asked.clone();
        let words = [
            row.case.name.to_owned(),
            weights.method.clone(),
            weights.modes_used.to_string(),
            weights.actuators_used.to_string(),
            method,
            modes,
            actuators,
        ];
        let numbers = [row.case.frequency_hz, row.time_s].map(csv::number);
        let judged = [
            weights.kappa.unwrap_or(f64::NAN),
            row.points.hot,
            row.points.cold,
            row.points.total,
            points.silence_ratio,
            row.window.hot,
            row.window.cold,
            row.window.total,
            row.drifted[0],
            row.drifted[1],
            row.touched,
            points.max_force_n.unwrap_or(f64::NAN),
            weights.ceiling.map_or(f64::NAN, |ceiling| ceiling.possible_db),
        ];
        words.into_iter().chain(numbers).chain([weights.feasible.to_string()]).chain(judged.map(csv::number)).collect()
    });
    csv::table("from 40 dB FRFs through the fit to the drive; judged on the true plate, window and drift on a 4 mm grid", &HEADER, cells)
}
