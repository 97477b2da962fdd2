//! The seed paper on the virtual panel: its two steps (method `modal`) with the lowest
//! modes of the plate, for every place of the hot zone, beside the default method.
//!
//! The modes are exact, the three rigid-body modes among them, or those of a fit to FRFs
//! of 40 dB, which finds the elastic ones. The gain of each drive is the one that serves
//! most responses in the model, and the paper's drive has no limit of force. Where the
//! modes are exact the panel itself is the model.

use super::{measured_and_fitted, MeasuredPanel, SceneCase, ScenePanel, Served, SCENE_CASES};
use crate::countdown::Countdown;
use chladni_frf::{ComplexVector, ModalModel, Mode, Result};
use chladni_render::{
    evaluate, render, Evaluation, Method, MethodChoice, ModalSteps, On, PointIndices,
    RenderOptions, Scene, Weights,
};
use ndarray::Array1;
use num_complex::Complex64;

/// As many modes as the paper takes, and actuators.
pub const PAPER_MODES: usize = 34;
/// Numbers of exact modes beyond those.
const MORE_MODES: [usize; 4] = [40, 50, 60, 80];
/// Shares of the largest singular value below which those of the two steps as one are left
/// out; the second is drawn.
pub const PAPER_CUTS: [f64; 3] = [1e-3, 3e-3, 1e-2];
/// Methods on the first place, each of which takes one step away from the paper.
const STEPS: [Method; 3] = [Method::Tikhonov, Method::PressureMatching, Method::Mls];
/// The first place with every response judged, those on the border of the zones too.
const NO_TRANSITION: SceneCase = SceneCase {
    name: "quarter-1-no-transition",
    transition_m: 0.0,
    ..SCENE_CASES[0]
};

/// Whose modes a drive was made with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaperModes {
    /// Those of the plate, rigid-body modes first.
    Exact,
    /// The elastic ones of the plate; the rigid body is a residual term, as in a fit.
    Elastic,
    /// Those of a fit, all elastic.
    Fitted,
}

impl PaperModes {
    /// Name in the table.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Elastic => "elastic",
            Self::Fitted => "fitted",
        }
    }
}

/// One drive, judged by the true plate.
#[derive(Debug, Clone)]
pub struct PaperRow {
    /// The place of the hot zone.
    pub case: SceneCase,
    /// The method asked for.
    pub asked: MethodChoice,
    scene: Scene,
    /// Whose modes it was made with.
    pub modes_of: PaperModes,
    /// Singular values left out of the two steps as one; `None`: one after the other.
    pub cut: Option<f64>,
    /// The drive, and the model's judgement of it.
    pub weights: Weights,
    /// Performance of the two steps where no other mode than those that were summed
    /// moves.
    pub alone: Option<PointIndices>,
    /// Highest natural frequency among the modes that were summed, Hz.
    pub highest_hz: f64,
    /// Shares of responses served on the true plate.
    pub points: Served,
    /// The same of the ground between them, on a 4 mm grid.
    pub window: Served,
}

/// All drives, and the panel that judges them.
#[derive(Debug, Clone)]
pub struct PaperRun {
    /// All drives.
    pub rows: Vec<PaperRow>,
    /// The panel with its exact modes.
    pub exact: ModalModel,
}

impl PaperRow {
    /// Modal coefficients, where the method goes through them.
    pub(crate) fn steps(&self) -> Option<&ModalSteps> {
        self.weights.modal.as_ref()
    }
}

impl PaperRun {
    /// The two steps on a scene, by rising number of modes; with a cut as one.
    pub(crate) fn two_steps<'a>(
        &'a self,
        scene: &'a str,
        modes_of: PaperModes,
        cut: Option<f64>,
    ) -> impl Iterator<Item = &'a PaperRow> {
        self.rows.iter().filter(move |row| {
            row.case.name == scene
                && row.modes_of == modes_of
                && row.cut == cut
                && row.steps().is_some()
        })
    }

    /// The default method on a scene.
    pub(crate) fn ours(&self, scene: &str) -> Option<&PaperRow> {
        self.rows
            .iter()
            .find(|row| row.case.name == scene && row.asked == MethodChoice::Default)
    }

    /// A drive on the true plate.
    ///
    /// # Errors
    /// None for rows of this run.
    pub(crate) fn on_the_panel(&self, row: &PaperRow) -> Result<Evaluation> {
        evaluate(&row.weights, &row.scene, On::Model(&self.exact))
    }
}

/// Runs the two steps with 1 to 34 modes, and more where they are exact, and the default
/// method, on every place of the hot zone.
///
/// # Errors
/// None for these scenes.
pub fn paper(progress: &dyn Fn(&str)) -> Result<PaperRun> {
    progress("measuring and fitting the panel");
    let (panel, fitted) = measured_and_fitted(ScenePanel::ManyModes)?;
    let exact = with_rigid_modes(&panel)?;
    let elastic = all_counted(panel.exact.clone());
    let cases: Vec<SceneCase> = places().chain([NO_TRANSITION]).collect();
    let mut countdown = Countdown::new(cases.len(), progress);
    let mut rows = Vec::new();
    for case in cases {
        countdown.next(case.name, false);
        let scene = case.scene(&panel)?;
        for (modes_of, model) in [
            (PaperModes::Exact, &exact),
            (PaperModes::Elastic, &elastic),
            (PaperModes::Fitted, &fitted),
        ] {
            let unlimited = unlimited(&scene);
            let more = MORE_MODES
                .iter()
                .copied()
                .filter(|_| modes_of == PaperModes::Exact);
            for count in (1..=PAPER_MODES).chain(more) {
                let lowest = lowest_modes(model, count);
                let alone = without_others(lowest.clone());
                for cut in std::iter::once(None).chain(PAPER_CUTS.map(Some)) {
                    let options = RenderOptions {
                        cut,
                        ..options(Method::Modal.into())
                    };
                    let row = judged(case, &panel, &lowest, modes_of, &unlimited, &options)?;
                    let alone = render(&alone, &unlimited, &options)?;
                    rows.push(PaperRow {
                        alone: Some(alone.weights.indices.points),
                        ..row
                    });
                }
            }
        }
        let steps = STEPS
            .map(MethodChoice::Only)
            .into_iter()
            .filter(|_| case.name == SCENE_CASES[0].name);
        for asked in steps.chain([MethodChoice::Default]) {
            let options = options(asked);
            rows.push(judged(
                case,
                &panel,
                &fitted,
                PaperModes::Fitted,
                &scene,
                &options,
            )?);
        }
    }
    Ok(PaperRun { rows, exact })
}

/// The four quarters and nine ninths of the paper's panel.
pub(crate) fn places() -> impl Iterator<Item = SceneCase> {
    let first = SCENE_CASES[0];
    let alike = move |case: &&SceneCase| {
        case.panel == first.panel
            && case.frequency_hz == first.frequency_hz
            && case.transition_m == first.transition_m
    };
    SCENE_CASES.iter().filter(alike).copied()
}

/// The same scene without a limit of force: the paper has none.
fn unlimited(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.actuators.max_force_n = Some(f64::INFINITY);
    scene
}

/// The exact model with its rigid-body modes as modes at 0 Hz, where a residual term
/// stood for them, and every mode counted.
fn with_rigid_modes(panel: &MeasuredPanel) -> Result<ModalModel> {
    let mut model = panel.exact.clone();
    let places = |dofs: &[chladni_frf::Dof]| -> Vec<[f64; 2]> {
        let of = |dof: &chladni_frf::Dof| {
            panel
                .exact
                .nodes
                .iter()
                .find(|node| node.label == dof.node)
                .map(|node| node.xyz_m)
        };
        dofs.iter().filter_map(of).map(|[x, y, _]| [x, y]).collect()
    };
    let shapes = panel.truth.modes().evaluate(&places(&model.responses))?;
    let participations = panel.truth.modes().evaluate(&places(&model.references))?;
    let column = |table: &ndarray::Array2<f64>, n: usize| {
        ComplexVector(table.column(n).iter().map(|&v| v.into()).collect())
    };
    let rigid = (0..panel.truth.modes().rigid_count()).map(|n| Mode {
        frequency_hz: 0.0,
        loss_factor: 0.0,
        damping_ratio: 0.0,
        shape: column(&shapes, n),
        participation: column(&participations, n),
        ..model.modes[0].clone()
    });
    model.modes = rigid.chain(model.modes.iter().cloned()).collect();
    model.residual_terms.terms.clear();
    Ok(all_counted(model))
}

fn all_counted(mut model: ModalModel) -> ModalModel {
    model.modes.iter_mut().for_each(|mode| mode.in_band = true);
    model
}

/// The model with its lowest `count` modes counted; the others stay what they are to the
/// field, and are none to the two steps.
fn lowest_modes(model: &ModalModel, count: usize) -> ModalModel {
    let mut model = model.clone();
    let counted = model.modes.iter_mut().filter(|mode| mode.counts());
    counted.skip(count).for_each(|mode| mode.in_band = false);
    model
}

/// The model with nothing but its counted modes.
fn without_others(mut model: ModalModel) -> ModalModel {
    model.modes.retain(|mode| mode.in_band);
    model.residual_terms.terms.clear();
    model
}

fn options(method: MethodChoice) -> RenderOptions {
    RenderOptions {
        method,
        ..RenderOptions::default()
    }
}

fn judged(
    case: SceneCase,
    panel: &MeasuredPanel,
    model: &ModalModel,
    modes_of: PaperModes,
    scene: &Scene,
    options: &RenderOptions,
) -> Result<PaperRow> {
    let rendering = render(model, scene, options)?;
    let drive: Array1<Complex64> = rendering
        .weights
        .weights
        .iter()
        .map(|weight| weight.value())
        .collect();
    let (zones, limits) = (&rendering.zones, &rendering.limits);
    Ok(PaperRow {
        case,
        scene: scene.clone(),
        asked: options.method,
        modes_of,
        cut: options.cut,
        alone: None,
        highest_hz: model
            .in_band_modes()
            .map(|mode| mode.frequency_hz)
            .fold(0.0, f64::max),
        points: panel
            .truth
            .at(&drive, case.frequency_hz, &rendering.field, limits)?,
        window: panel.truth.free(&drive, case.frequency_hz, zones, limits),
        weights: rendering.weights,
    })
}
