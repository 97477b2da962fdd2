//! From a model and a scene to weights: the whole of rendering in one function.

use crate::ceiling::Ceiling;
use crate::count::Count;
use crate::endurance::Endurance;
use crate::fewest_actuators;
use crate::fewest_modes::{self, Judge, Reduced};
use crate::field::{AreaField, Field};
use crate::frequency_sweep::{bearing_frequency, mode_near};
use crate::indices::{AreaIndices, Indices, PointIndices};
use crate::methods::{Method, MethodChoice, Solution};
use crate::options::RenderOptions;
use crate::problem::Drive;
use crate::rig::{Calibrated, Calibration};
use crate::scene::{Limits, Scene};
use crate::setup::Setup;
use crate::tolerances;
use crate::touch::{findings as touch_findings, judged, TouchIndices, TouchPlan};
use crate::weights::{weight_list, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
use crate::zones::ZoneMap;
use chladni_frf::{numbered, Error, Finding, FrfSet, ModalModel, Result, CREATED_BY};
use std::borrow::Cow;

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

/// Finds the weights that move the hot zone of `scene` and keep the cold one quiet; of a
/// scene with several tones those of each, and where they are counted the same actuators
/// for all.
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

/// The same with actuators that, where they are counted, serve the scenes `others` as
/// well: whichever of these scenes is rendered with the rest as `others`, in one order,
/// the same actuators are chosen.
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
    let (tones, of_others): (Vec<Scene>, Vec<Scene>) = (
        scene.tones(),
        others.iter().flat_map(Scene::tones).collect(),
    );
    let render_one = |k: usize| {
        let beside: Vec<Scene> = tones[..k]
            .iter()
            .chain(&tones[k + 1..])
            .chain(&of_others)
            .cloned()
            .collect();
        render_tone(model, &tones[k], &beside, options, measured)
    };
    let first = render_one(0)?;
    let other_tones = (1..tones.len())
        .map(render_one)
        .collect::<Result<Vec<_>>>()?;
    Ok(first.with_tones(other_tones))
}

/// A scene with one tone.
fn render_tone(
    model: &ModalModel,
    scene: &Scene,
    others: &[Scene],
    options: &RenderOptions,
    measured: Option<&FrfSet>,
) -> Result<Rendering> {
    let others = set_up(model, others, options)?;
    let calibration = scene.actuators.calibration.as_deref();
    let gain_error = calibration.and_then(Calibration::gain_error);
    let Calibrated {
        model,
        scene,
        findings: of_rig,
    } = Calibrated::new(model, scene, Some(scene.frequency_hz), &options.drift)?;
    let (model, scene) = (&*model, &*scene);
    let whole = Setup::new(model, scene, &options.drift)?;
    check_actuators(&whole, &others)?;
    let judge = match measured {
        Some(frf) => Judge::of_line(&whole, frf)?,
        None => Judge::of_model(&whole, options.modes == Count::Auto),
    };
    let Reduced {
        setup,
        finding: of_modes,
    } = fewest_modes::choose(whole, model, &judge, options)?;
    let chosen = fewest_actuators::choose(
        &std::iter::once(&setup).chain(&others).collect::<Vec<_>>(),
        options.actuators,
    )?;
    let used = match chosen.columns.len() < setup.operator.references.len() {
        true => Cow::Owned(setup.with_actuators(&chosen.columns)),
        false => Cow::Borrowed(&setup),
    };
    let decision = options.method.decide(&used.problem, options.effort);
    let (method, solution) = decision.run(&used, model, options.cut)?;
    let Solution {
        drive,
        findings: said,
        modal,
        touched_db,
    } = solution;
    let sparse = drive;
    let drive = spread(&sparse, &chosen.columns, setup.operator.references.len());
    let Setup {
        limits,
        operator,
        zones,
        problem,
        ..
    } = &setup;
    let mut findings = [
        of_rig,
        setup.findings.clone(),
        Vec::from_iter(of_modes),
        Vec::from_iter(chosen.finding),
        said,
    ]
    .concat();

    let field = Field::new(operator, zones, &drive);
    let area = setup
        .nodes()
        .and_then(|nodes| field.area_from(nodes, zones));
    let points = PointIndices::of_field(&field, zones, limits, &drive, operator.unit)?;
    let indices = Indices {
        points,
        area: area
            .as_ref()
            .map(|area| AreaIndices::of_area(area, zones, limits)),
    };
    let feasible = points.min_ratio == 1.0;
    // a proof takes as long as a conic program: who asked for less does not wait for it
    let proves = options.method == MethodChoice::Best
        || (!feasible && matches!(method, Method::Robust | Method::MinEffort));
    let thorough = options.method == MethodChoice::Best && !feasible;
    let ceiling = if proves {
        Ceiling::of(&used.problem, &sparse, thorough)?
    } else {
        None
    };
    if !feasible {
        findings.push(shortfall(&points, ceiling.as_ref(), limits, method));
    }
    let through = match measured {
        Some(_) => "measured line",
        None => "whole model",
    };
    let [_, replayed, _] = judge.served(&drive);
    findings.extend(replayed_worse(
        replayed,
        &points,
        setup.modes.len(),
        through,
    ));
    findings.extend(
        indices
            .area
            .filter(|_| feasible && options.actuators != Count::All)
            .and_then(|area| ground_lost(&area, chosen.columns.len())),
    );
    // what is quick must stay so, and what is not met needs no limit of what it endures
    let endures = feasible && matches!(method, Method::Mls | Method::Robust | Method::MinEffort);
    let endurance = endures.then(|| Endurance::of(&setup, model, &drive, gain_error));
    findings.extend(endurance.iter().filter_map(Endurance::finding));
    let touch = under_fingers(model, scene, &setup, &drive);
    if let Some(told) = &touch {
        findings.extend(of_fingers(told, model, scene, &setup, touched_db, options)?);
    }
    findings.extend(judge.findings);
    findings.extend(strength(&field, limits));
    numbered(&mut findings, &in_band_hz(model));
    let weights = Weights {
        format: WEIGHTS_FORMAT.into(),
        version: WEIGHTS_VERSION,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: options.to_json(scene.drift.as_ref().unwrap_or(&options.drift)),
        frequency_hz: scene.frequency_hz,
        method: method.to_string(),
        scene: scene.name(),
        weights: weight_list(&operator.references, &drive, operator.unit),
        modes_used: setup.modes.len(),
        actuators_used: drive.iter().filter(|weight| weight.norm() > 0.0).count(),
        feasible,
        ceiling,
        kappa: Some(problem.score(&drive).kappa).filter(|kappa| kappa.is_finite()),
        endurance,
        modal,
        indices,
        stress: None,
        touch,
        sweep: None,
        correction: None,
        findings: findings.into(),
        other_tones: Vec::new(),
    };
    Ok(Rendering {
        weights,
        field,
        area,
        zones: zones.clone(),
        limits: *limits,
        other_tones: Vec::new(),
    })
}

/// The other scenes, set up as their own renderings do.
fn set_up(model: &ModalModel, others: &[Scene], options: &RenderOptions) -> Result<Vec<Setup>> {
    let set_up = |other: &Scene| {
        let Calibrated { model, scene, .. } =
            Calibrated::new(model, other, Some(other.frequency_hz), &options.drift)?;
        Setup::new(&model, &scene, &options.drift)
    };
    others.iter().map(set_up).collect()
}

fn check_actuators(whole: &Setup, others: &[Setup]) -> Result<()> {
    let references = &whole.operator.references;
    let other = others
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

/// Tells where a drive serves fewer responses than in the model with fewer `modes`.
fn replayed_worse(
    replayed: f64,
    points: &PointIndices,
    modes: usize,
    through: &str,
) -> Option<Finding> {
    (replayed < points.success_ratio).then(|| {
        let words = format!(
            "replayed through the {through}, {:.1} % of the responses keep their limit, where \
             {:.1} % do in the model with {modes} modes",
            100.0 * replayed,
            100.0 * points.success_ratio,
        );
        Finding::caution("replayed-worse", words)
            .value("replayed_ratio", replayed)
            .help("sum more modes")
    })
}

impl Rendering {
    /// The same with what sounds at other frequencies.
    fn with_tones(mut self, other_tones: Vec<Self>) -> Self {
        let weights = &mut self.weights;
        for Self { weights: tone, .. } in &other_tones {
            weights.feasible &= tone.feasible;
            let new: Vec<Finding> = tone
                .findings
                .iter()
                .filter(|finding| !weights.findings.contains(finding))
                .map(|finding| Finding {
                    text: format!("at {} Hz: {}", tone.frequency_hz, finding.text),
                    ..finding.clone()
                })
                .collect();
            weights.findings.extend(new);
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
fn under_fingers(
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

/// Findings on what fingers do to a drive; of one that a firm finger ends, with a frequency
/// that bears it.
fn of_fingers(
    told: &TouchIndices,
    model: &ModalModel,
    scene: &Scene,
    setup: &Setup,
    touched_db: Option<f64>,
    options: &RenderOptions,
) -> Result<Vec<Finding>> {
    let Some(plan) = &setup.touch else {
        return Ok(Vec::new());
    };
    let asked = [scene.frequency_hz, setup.limits.apart_db()];
    let is_borne = told.firmest == plan.touch.impedances.last().map(|t| t.name.clone());
    let elsewhere = match is_borne {
        true => None,
        false => bearing_frequency(model, scene, options, told.firmest.as_deref())?,
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

/// Tells what an infeasible scene got instead, what physics would allow, and what could
/// help.
fn shortfall(
    points: &PointIndices,
    ceiling: Option<&Ceiling>,
    limits: &Limits,
    method: Method,
) -> Finding {
    let contrast = points.contrast_db.map_or("no contrast".into(), |db| {
        format!("a contrast of {db:.1} dB")
    });
    let served = format!(
        "{:.1} % of the hot and {:.1} % of the cold responses keep their limit",
        100.0 * points.hot_ratio,
        100.0 * points.cold_ratio
    );
    let help = "widen transition_m, use more actuators, or another frequency";
    let of_ceiling = |finding: Finding, ceiling: &Ceiling| {
        finding
            .value("possible_db", ceiling.possible_db)
            .value("asked_db", ceiling.asked_db)
    };
    let finding = match ceiling {
        Some(ceiling) if ceiling.forbids() => {
            let [possible, asked] = ceiling.in_words();
            let words = format!(
                "the scene is impossible: possible {possible} dB, asked {asked} dB (certified: no \
                 drive within the limits of the actuators gives more in this model); {served}, \
                 with {contrast}"
            );
            of_ceiling(Finding::fault("scene-impossible", words), ceiling)
        }
        Some(ceiling) => {
            let words = format!(
                "the scene is not met: possible at most {:.1} dB, asked {:.1} dB, found {:.1} dB; \
                 {served}, with {contrast}",
                ceiling.possible_db, ceiling.asked_db, ceiling.reached_db
            );
            of_ceiling(Finding::fault("scene-not-met", words), ceiling)
        }
        None => {
            let words = format!(
                "the scene is not met: {served}, with {contrast} where {:.1} dB are needed",
                limits.apart_db()
            );
            Finding::fault("scene-not-met", words)
        }
    };
    match (ceiling, method) {
        (None, Method::Mls | Method::PressureMatching) => {
            finding.help(format!("{help}; method `robust` says what is possible"))
        }
        _ => finding.help(help),
    }
}

/// Warns where few actuators serve every response and not the ground between them.
fn ground_lost(area: &AreaIndices, actuators: usize) -> Option<Finding> {
    let least = [area.hot_ratio, area.cold_ratio]
        .into_iter()
        .flatten()
        .fold(1.0, f64::min);
    (least < tolerances::SERVES).then(|| {
        let words = format!(
            "{actuators} actuators serve every response, but between the responses only {:.0} % of \
             the hot or of the cold ground",
            100.0 * least
        );
        Finding::caution("ground-between", words)
            .value("least_area_ratio", least)
            .help("use a few more actuators")
    })
}

/// Warns of motion far above the threshold.
pub(crate) fn strength(field: &Field, limits: &Limits) -> Option<Finding> {
    let largest = field
        .velocity_m_per_s
        .iter()
        .map(|v| v.norm())
        .fold(0.0, f64::max);
    let level = 20.0 * (largest / limits.threshold_m_per_s).log10();
    (level > tolerances::STRONG_DB).then(|| {
        let words = format!("the panel moves {level:.0} dB above the threshold somewhere");
        Finding::caution("strong-motion", words)
            .value("level_db", level)
            .help("check the limits of exposure and of the actuators")
    })
}
