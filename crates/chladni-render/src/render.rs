//! From a model and a scene to weights: the whole of rendering in one function.

use crate::covariance::Covariance;
use crate::field::{AreaField, AreaGrid, Field};
use crate::indices::{check_zones, AreaIndices, Indices, PointIndices};
use crate::methods::{mls, modal, pressure_matching, Method, Solution};
use crate::operator::Operator;
use crate::options::RenderOptions;
use crate::plane::{Position, Rectangle};
use crate::problem::{Problem, Rows};
use crate::scene::{Limits, Scene, DEFAULT_MAX_FORCE_N};
use crate::tolerances;
use crate::weights::{weight_list, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
use crate::zones::{Ground, ZoneMap};
use chladni_frf::{Error, ModalModel, ReferenceUnit, Result, CREATED_BY};
use ndarray::Axis;
use num_complex::Complex64;

/// Weights, and the field that they make in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// What the weights file holds.
    pub weights: Weights,
    /// Velocities at the responses.
    pub field: Field,
    /// Velocities between them; `None` where they carry no area.
    pub area: Option<AreaField>,
    /// The zones, laid over the panel.
    pub zones: ZoneMap,
    /// Velocity limits.
    pub limits: Limits,
}

/// Finds the weights that move the hot zone of `scene` and keep the cold one quiet, by the model alone.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`]: no threshold at the drive frequency, an unknown actuator, no hot or no cold response, NaN
/// in the model, a force limit for actuators in volts. A scene that cannot be met is no error: `feasible` says so.
pub fn render(model: &ModalModel, scene: &Scene, options: &RenderOptions) -> Result<Rendering> {
    let limits = scene.limits()?;
    let operator = Operator::of_model(model, scene.frequency_hz, scene.actuators.only.as_deref())?;
    let zones = lay_zones(scene, &operator);
    let (judged, hot) = judged_rows(&operator, &zones)?;
    let mut warnings = scene_warnings(scene, &operator, &zones);
    let (max_drive, warning) = drive_limit(scene, operator.unit)?;
    warnings.extend(warning);
    warnings.extend(controllability(model, &operator));

    let covariance = Covariance::of_model(model, &operator, &judged, &options.drift);
    let rows = Rows {
        mobility: operator.mobility.select(Axis(0), &judged),
        hot,
        positions_m: judged.iter().map(|&row| operator.positions_m[row]).collect(),
    };
    let problem = Problem::new(rows, covariance, limits, max_drive);
    let Solution { drive, warnings: said } = match options.method {
        Method::PressureMatching => pressure_matching::solve(&problem)?,
        Method::Mls => mls::solve(&problem, between_rows(&operator, &zones).as_ref())?,
        Method::Modal => modal::solve(&problem, model, &operator, &judged)?,
    };
    warnings.extend(said);

    let field = Field::new(&operator, &zones, &drive);
    let area = field.area(&zones);
    let points = PointIndices::of_field(&field, &limits, &drive, operator.unit)?;
    let indices = Indices { points, area: area.as_ref().map(|area| AreaIndices::of_area(area, &limits)) };
    let feasible = points.min_ratio == 1.0;
    if !feasible {
        warnings.push(shortfall(&points, scene, options.method));
    }
    warnings.extend(strength(&field, &limits));
    let weights = Weights {
        format: WEIGHTS_FORMAT.into(),
        version: WEIGHTS_VERSION,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: options.to_json(),
        frequency_hz: scene.frequency_hz,
        method: options.method.to_string(),
        scene: scene.name(),
        weights: weight_list(&operator.references, &drive, operator.unit),
        modes_used: model.in_band_modes().count(),
        actuators_used: drive.iter().filter(|weight| weight.norm() > 0.0).count(),
        feasible,
        kappa: Some(problem.score(&drive).kappa).filter(|kappa| kappa.is_finite()),
        indices,
        warnings,
    };
    Ok(Rendering { weights, field, area, zones, limits })
}

/// The scene's zones over the responses of the operator.
pub(crate) fn lay_zones(scene: &Scene, operator: &Operator) -> ZoneMap {
    let around = Rectangle::around(&operator.positions_m).expect("an operator has at least one response");
    scene.zones.over(around)
}

/// The judged rows of the operator, hot ones first, and the number of those.
fn judged_rows(operator: &Operator, zones: &ZoneMap) -> Result<(Vec<usize>, usize)> {
    let (rows, hot) = hot_then_cold(&operator.positions_m, zones);
    check_zones(hot, rows.len() - hot)?;
    Ok((rows, hot))
}

/// Indices of the hot places, then of the cold ones, and the number of hot ones.
fn hot_then_cold(places: &[Position], zones: &ZoneMap) -> (Vec<usize>, usize) {
    let on = |wanted| (0..places.len()).filter(move |&k| zones.classify(places[k]) == wanted);
    let hot = on(Ground::Hot).count();
    (on(Ground::Hot).chain(on(Ground::Cold)).collect(), hot)
}

/// Rows of the operator interpolated between the responses, for methods that also look there.
fn between_rows(operator: &Operator, zones: &ZoneMap) -> Option<Rows> {
    let scanned = Rectangle::around(&operator.positions_m)?;
    let ground_m2 = (scanned.x_max - scanned.x_min) * (scanned.y_max - scanned.y_min);
    let step_m = tolerances::BETWEEN_SPACING * (ground_m2 / operator.responses.len() as f64).sqrt();
    let grid = AreaGrid::new(&operator.positions_m, zones.area(), step_m)?;
    let places: Vec<Position> = grid.places.iter().map(|place| place.1).collect();
    let (rows, hot) = hot_then_cold(&places, zones);
    let mobility = grid.interpolation.select(&rows).apply(operator.mobility.view());
    Some(Rows { mobility, hot, positions_m: rows.iter().map(|&k| places[k]).collect() })
}

/// What is to be known of a scene on these responses, whatever the drive.
pub(crate) fn scene_warnings(scene: &Scene, operator: &Operator, zones: &ZoneMap) -> Vec<String> {
    let mut warnings = operator.warnings.clone();
    warnings.extend(scene.threshold.warning(scene.frequency_hz));
    let (area, e) = (zones.area(), tolerances::POSITION_M);
    let scanned = Rectangle::around(&operator.positions_m).expect("an operator has at least one response");
    if area.x_min < scanned.x_min - e || area.y_min < scanned.y_min - e || area.x_max > scanned.x_max + e || area.y_max > scanned.y_max + e
    {
        warnings.push(format!(
            "area_m goes beyond the responses, which cover x {} to {} m, y {} to {} m; nothing outside them is judged",
            scanned.x_min, scanned.x_max, scanned.y_min, scanned.y_max
        ));
    }
    if operator.references.len() == 1 {
        warnings.push(format!("a single actuator ({}) can only scale one pattern, not shape it", operator.references[0]));
    }
    warnings
}

/// The largest |A_i| that the scene allows, N or V.
fn drive_limit(scene: &Scene, unit: ReferenceUnit) -> Result<(f64, Option<String>)> {
    let actuators = &scene.actuators;
    match unit {
        ReferenceUnit::Newton => Ok((actuators.max_force_n.unwrap_or(DEFAULT_MAX_FORCE_N), None)),
        ReferenceUnit::Volt => match (actuators.max_voltage_v, actuators.max_force_n) {
            (Some(limit), _) => Ok((limit, None)),
            (None, Some(limit)) => Err(Error::bad_data("a force limit cannot be kept: the references of the model are volts")
                .field("actuators.max_force_n")
                .found(limit)
                .expected("actuators.max_voltage_v")
                .help("give the limit in volts peak, or leave both out")),
            (None, None) => Ok((
                f64::INFINITY,
                Some("the references are volts and the scene gives no actuators.max_voltage_v: no limit was kept".into()),
            )),
        },
    }
}

/// Modes that no actuator in use can drive.
fn controllability(model: &ModalModel, operator: &Operator) -> Vec<String> {
    let strength = |participation: &[Complex64]| operator.reference_columns.iter().map(|&j| participation[j].norm()).fold(0.0, f64::max);
    let largest = model.in_band_modes().map(|mode| strength(&mode.participation.0)).fold(0.0, f64::max);
    let idle = model.in_band_modes().filter(|mode| strength(&mode.participation.0) <= tolerances::NO_PARTICIPATION * largest);
    idle.map(|mode| format!("the mode at {:.1} Hz has zero participation: no actuator in use can drive or stop it", mode.frequency_hz))
        .collect()
}

/// What an infeasible scene got instead, and what could help.
fn shortfall(points: &PointIndices, scene: &Scene, method: Method) -> String {
    let contrast = points.contrast_db.map_or("no contrast".into(), |db| format!("a contrast of {db:.1} dB"));
    let better = if method == Method::Mls { "" } else { ", or take method `mls`" };
    format!(
        "the scene is not met: {:.1} % of the hot and {:.1} % of the cold responses keep their limit, with {contrast} where {:.1} dB \
         are needed; try a wider transition_m, more of the actuators, another frequency_hz{better}",
        100.0 * points.hot_ratio,
        100.0 * points.cold_ratio,
        2.0 * scene.limen_db
    )
}

/// Warns of motion far above the threshold.
pub(crate) fn strength(field: &Field, limits: &Limits) -> Option<String> {
    let largest = field.velocity_m_per_s.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let level = 20.0 * (largest / limits.threshold_m_per_s).log10();
    (level > tolerances::STRONG_DB)
        .then(|| format!("the panel moves {level:.0} dB above the threshold somewhere: check limits of exposure and of the actuators"))
}
