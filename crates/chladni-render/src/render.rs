//! From a model and a scene to weights: the whole of rendering in one function.

use crate::judging::ceiling::Ceiling;
use crate::judging::endurance::Endurance;
use crate::judging::frequency_sweep::{less_sensitive_frequency, mode_near};
use crate::judging::second_search::better_solution;
use crate::judging::shortcomings::{ground_lost, replayed_worse, strength, Replay, Shortfall};
use crate::methods::choice::MethodChoice;
use crate::methods::drive_error;
use crate::methods::method::Method;
use crate::methods::options::RenderOptions;
use crate::methods::solution::Solution;
use crate::panel::drive::Drive;
use crate::panel::field::{AreaField, Field};
use crate::problems::setup::Setup;
use crate::reduction::fewest_actuators::{self, Choice};
use crate::reduction::fewest_modes::{self, Judge, Reduced};
use crate::results::outcome::Outcome;
use crate::results::weights::Weights;
use crate::rig::Calibrated;
use crate::scene::actuators::Actuators;
use crate::scene::count::Count;
use crate::scene::drift::Drift;
use crate::scene::limits::Limits;
use crate::scene::scene_file::Scene;
use crate::scene::zones::ZoneMap;
use crate::tolerances;
use crate::touch::{findings as touch_findings, judged, TouchIndices, TouchPlan};
use chladni_frf::{numbered, Error, Finding, FrfSet, ModalModel, Result};

/// Weights, and the field that they make in the model.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
#[non_exhaustive]
pub struct Rendering {
    /// The content of the weights file.
    pub weights: Weights,
    /// Velocities at the responses.
    pub field: Field,
    /// Velocities between them; `None` where they carry no area.
    pub area: Option<AreaField>,
    /// The zones, laid over the panel.
    pub zones: ZoneMap,
    /// Velocity limits.
    pub limits: Limits,
    /// The same of the other tones of the scene.
    pub other_tones: Vec<Rendering>,
}

/// As [`render_measured`], judged by the model alone.
///
/// # Errors
/// As [`render_measured`].
pub fn render(model: &ModalModel, scene: &Scene, options: &RenderOptions) -> Result<Rendering> {
    render_measured(model, scene, options, None)
}

/// Finds the weights that move the hot zone of `scene` and keep the cold one quiet. A scene
/// with several tones gets weights for each tone; counted actuators
/// ([`RenderOptions::actuators`]) are the same for all tones.
///
/// * `measured`: FRFs whose line at the drive frequency judges how many modes are enough;
///   without them the whole model does
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`]: no threshold at the drive frequency, an unknown
/// actuator, no hot or no cold response, NaN in the model, a force limit for actuators in
/// volts. A scene that cannot be met is no error: `feasible` says so.
pub fn render_measured(
    model: &ModalModel,
    scene: &Scene,
    options: &RenderOptions,
    measured: Option<&FrfSet>,
) -> Result<Rendering> {
    render_with_others(model, scene, &[], options, measured)
}

/// As [`render_measured`]. If actuators are counted ([`RenderOptions::actuators`]), one set is
/// chosen that serves `scene` and all `others`. Each of these scenes gets the same set when it is
/// rendered with the rest as `others`.
///
/// # Errors
/// As [`render_measured`]; scenes that allow different actuators.
pub fn render_with_others(
    model: &ModalModel,
    scene: &Scene,
    others: &[Scene],
    options: &RenderOptions,
    measured: Option<&FrfSet>,
) -> Result<Rendering> {
    let tones = scene.tones();
    let chosen = together(model, &tones, others, options)?;
    let render_one = |tone| render_tone(model, tone, chosen.as_ref(), options, measured);
    let first = render_one(&tones[0])?;
    let other_tones = tones[1..]
        .iter()
        .map(render_one)
        .collect::<Result<Vec<_>>>()?;
    Ok(first.with_tones(other_tones))
}

/// Chooses the actuators for all `tones` and `others`: a rig has one set of them. `None` for one
/// scene of one tone, whose actuators are chosen after its modes. All modes are summed here,
/// because each scene keeps other modes.
fn together(
    model: &ModalModel,
    tones: &[Scene],
    others: &[Scene],
    options: &RenderOptions,
) -> Result<Option<Choice>> {
    let of_others = others.iter().flat_map(Scene::tones);
    let scenes: Vec<Scene> = tones.iter().cloned().chain(of_others).collect();
    if scenes.len() == 1 {
        return Ok(None);
    }
    let setups = set_up(model, &scenes, options)?;
    check_actuators(&setups)?;
    let setups: Vec<&Setup> = setups.iter().collect();
    fewest_actuators::choose(&setups, options.actuators).map(Some)
}

/// Renders a scene with one tone.
fn render_tone(
    model: &ModalModel,
    scene: &Scene,
    chosen: Option<&Choice>,
    options: &RenderOptions,
    measured: Option<&FrfSet>,
) -> Result<Rendering> {
    let calibration = scene.actuators.calibration.as_deref();
    let gain_error = calibration.and_then(|known| known.gain_error(scene.frequency_hz));
    // at other frequencies the rig has other gains
    let asked = (model, scene);
    let Calibrated {
        model,
        scene,
        mut findings,
    } = Calibrated::new(model, scene, Some(scene.frequency_hz), &options.drift)?;
    let (model, scene) = (&*model, &*scene);
    let measured = measured.map(|frf| (frf, &asked.1.actuators));
    let (mut solved, mut outcome) = SolvedDrive::judged(model, scene, chosen, options, measured)?;
    let is_measured = measured.is_some();
    if options.modes == Count::Auto
        && solved.needs_more_modes(&outcome, is_measured, chosen.is_some())
    {
        let all_modes = RenderOptions {
            modes: Count::All,
            ..options.clone()
        };
        (solved, outcome) = SolvedDrive::judged(model, scene, chosen, &all_modes, measured)?;
        findings.push(all_modes_for_fewer_actuators());
    }
    findings.append(&mut solved.findings);
    let feasible = outcome.is_feasible();
    let ceiling = solved.ceiling(feasible, options)?;
    let replay = solved.replay(is_measured);
    let counted = options.actuators != Count::All;
    findings.extend(solved.shortcomings(&outcome, ceiling.as_ref(), counted, replay));
    let refuted = replay.refutes(&outcome.indices.points);
    let (setup, drive, method) = (&solved.setup, &solved.drive, solved.method);
    // a scene that is not met has no use for it
    let endurance = match feasible && !refuted {
        true => solved.endurance(model, gain_error),
        false => None,
    };
    findings.extend(endurance.iter().filter_map(Endurance::finding));
    let tolerated = solved.tolerated.filter(|_| feasible);
    findings.extend(tolerated.and_then(drive_error::finding));
    let touch = under_fingers(model, scene, setup, drive);
    if let Some(told) = &touch {
        let touched_db = solved.solution.touched_db;
        findings.extend(of_fingers(told, asked, setup, touched_db, options)?);
    }
    findings.append(&mut solved.judge.findings);
    findings.extend(strength(&outcome.field, &setup.limits));
    numbered(&mut findings, &in_band_hz(model));
    let weights = Weights {
        options: options.to_json(&solved.drift(scene, options)),
        ceiling,
        endurance,
        modal: solved.solution.modal,
        feasible: feasible && !refuted,
        touch,
        findings: findings.into(),
        ..outcome.weights(setup, scene, drive, method)
    };
    Ok(Rendering {
        weights,
        field: outcome.field,
        area: outcome.area,
        limits: setup.limits,
        zones: solved.setup.zones,
        other_tones: Vec::new(),
    })
}

/// A drive, and the setup that it was solved on.
struct SolvedDrive {
    setup: Setup,
    judge: Judge,
    /// Number of the modes that could be summed.
    all_modes: usize,
    /// With the actuators chosen, where these are not all.
    fewer: Option<Setup>,
    /// Number of the actuators chosen.
    actuators: usize,
    /// Error of each actuator's force, relative, that the scene or the options name.
    named: Option<f64>,
    /// The one that the drive tolerates where none is named; `None` where that is not sought.
    tolerated: Option<f64>,
    method: Method,
    /// The drive of the actuators chosen.
    solution: Solution,
    /// The ceiling of a scene that the first search did not meet.
    ceiling: Option<Ceiling>,
    /// The drive of all actuators, the others still.
    drive: Drive,
    findings: Vec<Finding>,
}

impl SolvedDrive {
    /// Chooses modes, and actuators where they are not `chosen` yet, and solves.
    fn new(
        model: &ModalModel,
        scene: &Scene,
        chosen: Option<&Choice>,
        options: &RenderOptions,
        measured: Option<(&FrfSet, &Actuators)>,
    ) -> Result<Self> {
        let whole = Setup::new(model, scene, &options.drift)?;
        let judge = match measured {
            Some((frf, actuators)) => Judge::of_line(&whole, frf, actuators)?,
            None => Judge::of_model(&whole, options.modes == Count::Auto),
        };
        let all_modes = whole.modes.len();
        let Reduced {
            setup,
            finding: of_modes,
        } = fewest_modes::choose(whole, model, &judge, options)?;
        let chosen = match chosen {
            Some(chosen) => chosen.clone(),
            None => fewest_actuators::choose(&[&setup], options.actuators)?,
        };
        let all = setup.operator.references.len();
        let fewer = (chosen.columns.len() < all).then(|| setup.with_actuators(&chosen.columns));
        let used = fewer.as_ref().unwrap_or(&setup);
        let decision = options.method.decide(&used.problem, options.effort);
        let named = scene.drift.unwrap_or(options.drift).drive_relative;
        // fingers and events in time take the margin that there is: then no error is assumed
        let asks_more = scene.touch.is_some() || scene.time.is_some();
        let is_open = named.is_none() && scene.learned.is_none() && !asks_more;
        let tolerated = match is_open && decision.method == Method::Robust {
            true => Some(drive_error::tolerated_error(used)?),
            false => None,
        };
        let fewer = fewer.map(|fewer| fewer.with_drive_error(tolerated.unwrap_or(0.0)));
        let setup = setup.with_drive_error(tolerated.unwrap_or(0.0));
        let used = fewer.as_ref().unwrap_or(&setup);
        let (method, first) = decision.run(used, model, options.cut)?;
        let thorough = options.method == MethodChoice::Best;
        let (mut solution, ceiling) =
            better_solution(used, method, first, decision.effort, thorough)?;
        let mut findings = setup.findings.clone();
        findings.extend(of_modes);
        findings.extend(chosen.finding);
        findings.append(&mut solution.findings);
        Ok(Self {
            drive: spread(&solution.drive, &chosen.columns, all),
            actuators: chosen.columns.len(),
            setup,
            judge,
            all_modes,
            fewer,
            named,
            tolerated,
            method,
            solution,
            ceiling,
            findings,
        })
    }

    /// Solves, and judges the drive.
    fn judged(
        model: &ModalModel,
        scene: &Scene,
        chosen: Option<&Choice>,
        options: &RenderOptions,
        measured: Option<(&FrfSet, &Actuators)>,
    ) -> Result<(Self, Outcome)> {
        let solved = Self::new(model, scene, chosen, options, measured)?;
        let outcome = Outcome::of(&solved.setup, &solved.drive)?;
        Ok((solved, outcome))
    }

    /// The drive replayed through the whole model, or through the measured line.
    fn replay(&self, is_measured: bool) -> Replay {
        let [_, success_ratio, _] = self.judge.served(&self.drive);
        Replay {
            is_measured,
            success_ratio,
        }
    }

    /// True where few modes served the drive of all actuators, and do not serve that of fewer: the
    /// whole model misses limits that they keep, or they miss limits with actuators that were
    /// chosen on the whole model (`is_given`). A measured line refutes no drive.
    fn needs_more_modes(&self, outcome: &Outcome, is_measured: bool, is_given: bool) -> bool {
        let is_reduced = self.setup.modes.len() < self.all_modes && self.fewer.is_some();
        let replay = self.replay(is_measured);
        let is_missed = match outcome.is_feasible() {
            true => replay.refutes(&outcome.indices.points),
            false => is_given,
        };
        is_reduced && is_missed
    }

    /// Proves what no drive can do. The proof takes as long as a conic program: it is made for
    /// `best`, and for scenes that a conic method does not meet.
    fn ceiling(&self, feasible: bool, options: &RenderOptions) -> Result<Option<Ceiling>> {
        if !feasible || options.method != MethodChoice::Best {
            return Ok(self.ceiling.filter(|_| !feasible));
        }
        let used = self.fewer.as_ref().unwrap_or(&self.setup);
        let proven = Ceiling::of(&used.problem, &self.solution.drive, false)?;
        Ok(proven.map(|(ceiling, _)| ceiling))
    }

    /// The endurance of the drive; `None` for methods that stay quick without it.
    fn endurance(&self, model: &ModalModel, gain_error: Option<f64>) -> Option<Endurance> {
        let is_asked = matches!(
            self.method,
            Method::Mls | Method::Robust | Method::MinEffort
        );
        is_asked.then(|| Endurance::of(&self.setup, model, &self.drive, gain_error))
    }

    /// The drift that was allowed for.
    fn drift(&self, scene: &Scene, options: &RenderOptions) -> Drift {
        Drift {
            drive_relative: self.named.or(self.tolerated),
            ..scene.drift.unwrap_or(options.drift)
        }
    }

    /// Findings of what the drive does not serve: in this model, in its replay, and between
    /// the responses.
    ///
    /// * `counted`: true where fewer actuators than all were asked for; only then is ground
    ///   between the responses looked at
    fn shortcomings(
        &self,
        outcome: &Outcome,
        ceiling: Option<&Ceiling>,
        counted: bool,
        replay: Replay,
    ) -> Vec<Finding> {
        let (setup, points) = (&self.setup, &outcome.indices.points);
        let feasible = outcome.is_feasible();
        let mut findings = Vec::new();
        if !feasible {
            let of_some = self.fewer.is_some().then_some(self.actuators);
            let used = self.fewer.as_ref().unwrap_or(setup);
            let room = used.problem.drive_limits.allowed_gain(&self.solution.drive);
            let short = Shortfall {
                points,
                ceiling,
                of_some,
                limits: &setup.limits,
                method: self.method,
                at_drive_limit: room < tolerances::AT_DRIVE_LIMIT,
            };
            findings.push(short.finding());
        }
        let modes = [setup.modes.len(), self.all_modes];
        findings.extend(replayed_worse(replay, points, modes));
        let area = outcome.indices.area.filter(|_| feasible && counted);
        findings.extend(area.and_then(|area| ground_lost(&area, self.actuators)));
        findings
    }
}

fn all_modes_for_fewer_actuators() -> Finding {
    Finding::note(
        "all-modes-needed",
        "all modes are summed: fewer serve the drive of all actuators, and not that of the actuators \
         chosen",
    )
}

/// The scenes, set up as their renderings do, with all modes.
fn set_up(model: &ModalModel, scenes: &[Scene], options: &RenderOptions) -> Result<Vec<Setup>> {
    let set_up = |scene: &Scene| {
        let Calibrated { model, scene, .. } =
            Calibrated::new(model, scene, Some(scene.frequency_hz), &options.drift)?;
        Setup::new(&model, &scene, &options.drift)
    };
    let named = |scene: &Scene| set_up(scene).map_err(|error| scene.blame(error));
    scenes.iter().map(named).collect()
}

fn check_actuators(setups: &[Setup]) -> Result<()> {
    let references = &setups[0].operator.references;
    let other = setups
        .iter()
        .find(|other| other.operator.references != *references);
    other.map_or(Ok(()), |other| {
        Err(Error::bad_data("the scenes allow different actuators")
            .field("actuators.use")
            .found(format!(
                "{} and {} actuators",
                references.len(),
                other.operator.references.len()
            ))
            .expected("the same actuators in every scene"))
    })
}

impl Rendering {
    /// The same with what sounds at other frequencies.
    fn with_tones(mut self, other_tones: Vec<Self>) -> Self {
        let weights = &mut self.weights;
        for Self { weights: tone, .. } in &other_tones {
            weights.feasible &= tone.feasible;
            weights.add_findings_of(tone);
        }
        weights.other_tones = other_tones
            .iter()
            .map(|tone| tone.weights.clone())
            .collect();
        Self {
            other_tones,
            ..self
        }
    }
}

/// Judges a drive under the fingers that the scene expects, at places between those that
/// it was made for.
pub(crate) fn under_fingers(
    model: &ModalModel,
    scene: &Scene,
    setup: &Setup,
    drive: &Drive,
) -> Option<TouchIndices> {
    let (plan, touch) = (setup.touch.as_deref()?, scene.touch.as_ref()?);
    let between = TouchPlan::new(model, &setup.operator, &setup.zones, touch, true);
    let tried = between.as_ref().unwrap_or(plan);
    Some(TouchIndices::of(
        &setup.problem,
        judged(setup),
        [plan, tried],
        drive,
    ))
}

/// Findings on what fingers do to a drive. If it does not tolerate the firmest finger, they name
/// a less sensitive frequency.
fn of_fingers(
    told: &TouchIndices,
    (model, scene): (&ModalModel, &Scene),
    setup: &Setup,
    touched_db: Option<f64>,
    options: &RenderOptions,
) -> Result<Vec<Finding>> {
    let Some(plan) = &setup.touch else {
        return Ok(Vec::new());
    };
    let asked = [scene.frequency_hz, setup.limits.apart_db()];
    let is_tolerated = told.firmest == plan.touch.impedances.last().map(|t| t.name.clone());
    let elsewhere = match is_tolerated {
        true => None,
        false => less_sensitive_frequency(model, scene, options, told.firmest.as_deref())?,
    };
    let mode_hz = mode_near(model, scene.frequency_hz);
    Ok(touch_findings(
        told, plan, asked, touched_db, mode_hz, elsewhere,
    ))
}

/// The drive of some actuators as a drive of all, the others still.
fn spread(drive: &Drive, columns: &[usize], actuators: usize) -> Drive {
    let mut all = Drive::zeros(actuators);
    for (&column, &weight) in columns.iter().zip(drive) {
        all[column] = weight;
    }
    all
}

/// Frequencies of the modes that count, Hz, in the order of the table.
fn in_band_hz(model: &ModalModel) -> Vec<f64> {
    model
        .in_band_modes()
        .map(|mode| mode.frequency_hz)
        .collect()
}
