//! Rendering on virtual panels, from noisy FRFs through the fit to a drive that is judged
//! by the true plate: success against time, modes, residual terms and actuators.

mod cases;
mod figures;
mod knobs;
mod paper;
mod paper_figures;
mod tables;
mod touch;
mod true_panel;

pub(crate) use cases::MeasuredPanel;
pub use cases::{SceneCase, ScenePanel, SCENE_CASES};
pub use figures::scene_figures;
pub(crate) use figures::scenes_on_front;
pub use paper::{paper, PaperModes, PaperRow, PaperRun, PAPER_CUTS, PAPER_MODES};
pub use paper_figures::paper_figures;
pub use tables::{paper_csv, scene_csv};
pub use touch::{touch, touch_csv, TouchRow};
pub use true_panel::Served;

use crate::countdown::Countdown;
use crate::journal::{nan, Journal};
use crate::statistics::{distinct, mean, quantile};
use chladni_frf::{Error, ErrorKind, FrfKind, ModalModel, Result};
use chladni_linalg::svd_thin;
use chladni_render::{
    render_measured, Count, Effort, Finger, MethodChoice, RenderOptions, Rendering,
};
use chladni_rfp::{fit, FitOptions};
use ndarray::Array1;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Scenes on which the search for κ is turned: one that is easy, one near what is
/// possible.
const KNOB_SCENES: [&str; 2] = ["quarter-1", "ninth-5"];
/// Drifts that each drive has to bear.
const DRIFTS: u64 = 10;
/// Repetitions of the clock for methods that take less than so long, s.
const REPETITIONS: [(f64, usize); 3] = [(0.05, 5), (2.0, 3), (f64::INFINITY, 1)];

/// The part of a model and of a panel that a drive may use, and how long it is looked
/// for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Means {
    /// Modes summed explicitly.
    pub modes: Count,
    /// Actuators.
    pub actuators: Count,
    /// Residual terms of the model, the first so many; `None`: all.
    pub residual_terms: Option<usize>,
    /// Effort spent on the search.
    pub effort: Effort,
}

impl Default for Means {
    fn default() -> Self {
        Self {
            modes: Count::All,
            actuators: Count::All,
            residual_terms: None,
            effort: Effort::default(),
        }
    }
}

/// Settings of the runs.
#[derive(Debug, Clone)]
pub struct SceneOptions {
    /// Scenes.
    pub cases: Vec<&'static SceneCase>,
    /// Methods.
    pub methods: Vec<MethodChoice>,
    /// Means, each of them with each method on each scene.
    pub means: Vec<Means>,
    /// Judge `auto` numbers of modes by the measured line instead of the whole model.
    pub by_measured_line: bool,
}

/// One method on one scene.
#[derive(Debug, Clone)]
pub struct SceneRow {
    /// The scene.
    pub case: &'static SceneCase,
    /// The method asked for.
    pub asked: MethodChoice,
    /// The means given.
    pub means: Means,
    /// The outcome.
    pub drive: SceneDrive,
}

impl SceneRow {
    /// Method, and the knob of its search that is turned.
    pub fn name(&self) -> String {
        let setting = knobs::words(&self.means.effort);
        setting.map_or_else(
            || self.asked.to_string(),
            |setting| format!("{}, {setting}", self.asked),
        )
    }
}

/// A drive, as the fitted model and as the true plate judge it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SceneDrive {
    /// The method that ran.
    pub method: String,
    /// Modes summed explicitly.
    pub modes: usize,
    /// Actuators that move.
    pub actuators: usize,
    /// Residual terms of the model.
    pub residual_terms: usize,
    /// Time, s: median, first and third quartile.
    pub time_s: [f64; 3],
    /// Every response keeps its limit in the model.
    pub feasible: bool,
    /// Standard deviations of model errors that every response bears.
    #[serde(deserialize_with = "nan")]
    pub kappa: f64,
    /// Condition number of the mobility from the actuators to the responses.
    #[serde(deserialize_with = "nan")]
    pub condition: f64,
    /// Largest force, N.
    #[serde(deserialize_with = "nan")]
    pub max_force_n: f64,
    /// The limit of physics, where it was proved, dB.
    #[serde(deserialize_with = "nan")]
    pub possible_db: f64,
    /// Share of responses that silence serves.
    pub silence: f64,
    /// Shares of measured responses served on the true plate.
    pub points: Served,
    /// Shares of the dense window served on the true plate.
    pub window: Served,
    /// The same after random drift: mean and least of the total.
    pub drifted: [f64; 2],
    /// The same with a finger at each of three places: least of the total.
    pub touched: f64,
}

/// Turns the knobs of the search for κ on those scenes of `options` that are meant for
/// it, where its method takes part.
///
/// # Errors
/// As [`scenes`].
pub fn scene_knobs(
    options: &SceneOptions,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<SceneRow>> {
    let cases = options
        .cases
        .iter()
        .copied()
        .filter(|case| KNOB_SCENES.contains(&case.name))
        .collect();
    let methods = options
        .methods
        .iter()
        .copied()
        .filter(|method| *method == knobs::SEARCHES)
        .collect();
    scenes(
        &SceneOptions {
            cases,
            methods,
            means: knobs::settings(),
            ..*options
        },
        journal,
        progress,
    )
}

/// Renders every scene by every method with all means.
///
/// # Errors
/// None for the named scenes, but those of the journal.
pub fn scenes(
    options: &SceneOptions,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<SceneRow>> {
    let mut rows = Vec::new();
    let mut countdown = Countdown::new(
        options.cases.len() * options.methods.len() * options.means.len(),
        progress,
    );
    for kind in distinct(options.cases.iter().map(|case| case.panel)) {
        let mut stage: Option<(MeasuredPanel, ModalModel)> = None;
        for case in options.cases.iter().filter(|case| case.panel == kind) {
            for &asked in &options.methods {
                for &means in &options.means {
                    let name = format!(
                        "{}: {asked}, {means:?}, {}",
                        case.name, options.by_measured_line
                    );
                    let done = journal.has(&name);
                    if stage.is_none() && !done {
                        progress(&format!("measuring and fitting the panel {kind:?}"));
                        stage = Some(measured_and_fitted(kind)?);
                    }
                    countdown.next(&format!("{}: {asked}", case.name), done);
                    let drive = journal.once(&name, || {
                        let (panel, model) = stage.as_ref().ok_or_else(|| {
                            let words = "the journal forgot a finished scene";
                            Error::new(ErrorKind::Internal, words)
                        })?;
                        let by_line = options.by_measured_line;
                        drive(
                            case,
                            panel,
                            &means.of(model),
                            &means.options(asked),
                            by_line,
                        )
                    })?;
                    rows.push(SceneRow {
                        case,
                        asked,
                        means,
                        drive,
                    });
                }
            }
        }
    }
    Ok(rows)
}

pub(crate) fn measured_and_fitted(kind: ScenePanel) -> Result<(MeasuredPanel, ModalModel)> {
    let panel = kind.measure()?;
    let fitted = fit(&panel.frf, &FitOptions::default());
    let model = fitted
        .map_err(|error| {
            Error::new(
                ErrorKind::Internal,
                format!("the fit of {kind:?} fails: {error}"),
            )
        })?
        .model;
    Ok((panel, model))
}

impl Means {
    fn options(&self, method: MethodChoice) -> RenderOptions {
        RenderOptions {
            method,
            modes: self.modes,
            actuators: self.actuators,
            effort: self.effort,
            ..RenderOptions::default()
        }
    }

    /// The model with so many residual terms.
    fn of(&self, model: &ModalModel) -> ModalModel {
        let mut model = model.clone();
        model
            .residual_terms
            .terms
            .truncate(self.residual_terms.unwrap_or(usize::MAX));
        model
    }
}

/// The rendering and the seconds that it took; repeated where it takes little.
fn timed(render: impl Fn() -> Result<Rendering>) -> Result<(Rendering, Vec<f64>)> {
    let timed = || {
        let clock = Instant::now();
        render().map(|rendering| (rendering, clock.elapsed().as_secs_f64()))
    };
    let (rendering, first) = timed()?;
    let mut times = vec![first];
    let repetitions = REPETITIONS
        .iter()
        .find(|(longest_s, _)| first < *longest_s)
        .map_or(1, |(_, count)| *count);
    while times.len() < repetitions {
        times.push(timed()?.1);
    }
    Ok((rendering, times))
}

fn drive(
    case: &SceneCase,
    panel: &MeasuredPanel,
    model: &ModalModel,
    options: &RenderOptions,
    by_line: bool,
) -> Result<SceneDrive> {
    let scene = case.scene(panel)?;
    let (rendering, times) =
        timed(|| render_measured(model, &scene, options, by_line.then_some(&panel.frf)))?;
    let weights = &rendering.weights;
    let drive: Array1<Complex64> = weights
        .weights
        .iter()
        .map(|weight| weight.value())
        .collect();
    let (f, zones, limits, truth) = (
        case.frequency_hz,
        &rendering.zones,
        &rendering.limits,
        &panel.truth,
    );
    let drifts: Vec<f64> = (1..=DRIFTS)
        .map(|seed| truth.drifted(&drive, f, seed, zones, limits).total)
        .collect();
    let finger = Finger::default();
    let mut touched = f64::INFINITY;
    for place in chladni_render::finger_places(&rendering.field) {
        let served = truth.touched(&drive, f, &finger, place, zones, limits)?;
        touched = touched.min(served.total);
    }
    Ok(SceneDrive {
        method: weights.method.clone(),
        modes: weights.modes_used,
        actuators: weights.actuators_used,
        residual_terms: model.residual_terms.terms.len(),
        time_s: [0.5, 0.25, 0.75].map(|share| quantile(&times, share)),
        feasible: weights.feasible,
        kappa: weights.kappa.unwrap_or(f64::NAN),
        condition: condition(model, &drive, f),
        max_force_n: weights.indices.points.max_force_n.unwrap_or(f64::NAN),
        possible_db: weights
            .ceiling
            .map_or(f64::NAN, |ceiling| ceiling.possible_db),
        silence: weights.indices.points.silence_ratio,
        points: truth.at(&drive, f, &rendering.field, limits)?,
        window: truth.free(&drive, f, zones, limits),
        drifted: [
            mean(drifts.iter().copied()),
            drifts.iter().copied().fold(f64::INFINITY, f64::min),
        ],
        touched,
    })
}

/// Condition number of the mobility from the actuators that move to all responses; NaN
/// where none moves.
pub(crate) fn condition(model: &ModalModel, drive: &Array1<Complex64>, frequency_hz: f64) -> f64 {
    let moving: Vec<usize> = (0..drive.len())
        .filter(|&k| drive[k].norm() > 0.0)
        .collect();
    let mobility = model
        .frf_matrix(FrfKind::Mobility, frequency_hz)
        .select(ndarray::Axis(1), &moving);
    let values = svd_thin::<Complex64>(mobility.view()).map(|(_, values, _)| values);
    values
        .ok()
        .and_then(|values| Some(values.first()? / values.last()?))
        .unwrap_or(f64::NAN)
}
