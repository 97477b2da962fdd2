//! A scene laid over a model: the problem that the methods solve, and what is to be said
//! about it.

use crate::panel::covariance::Covariance;
use crate::panel::drive::DriveLimits;
use crate::panel::field::Places;
use crate::panel::interpolation::Nodes;
use crate::panel::operator::{mode_on, Operator};
use crate::problems::problem::{Problem, Rows};
use crate::scene::actuators::DEFAULT_MAX_FORCE_N;
use crate::scene::drift::Drift;
use crate::scene::limits::Limits;
use crate::scene::plane::{Position, Rectangle};
use crate::scene::scene_file::Scene;
use crate::scene::zones::{check_zones, Ground, PolygonKind, ZoneLayout, ZoneMap};
use crate::tolerances;
use crate::touch::TouchPlan;
use chladni_frf::{Error, Finding, ModalModel, ReferenceUnit, Result};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use std::sync::Arc;
use std::sync::OnceLock;

/// A scene over a model.
#[derive(Clone)]
pub(crate) struct Setup {
    /// Velocity limits.
    pub(crate) limits: Limits,
    /// The panel at the drive frequency.
    pub(crate) operator: Operator,
    /// The zones, laid over it.
    pub(crate) zones: ZoneMap,
    /// Rows of the operator that are judged, hot ones first: the rows of the problem.
    pub(crate) judged: Vec<usize>,
    /// Judged rows, limits and error bar.
    pub(crate) problem: Problem,
    /// The responses as nodes of interpolation, where they carry an area; found when a method
    /// first asks. Not safe inside a rayon task: the initialiser runs parallel products, and two
    /// tasks that initialise at once can deadlock.
    nodes: OnceLock<Option<Nodes>>,
    /// Rows between them, coarse and fine; found in the same way.
    between: [OnceLock<Option<Rows>>; 2],
    /// Modes of the model that are summed explicitly, rising.
    pub(crate) modes: Vec<usize>,
    /// Fingers that the scene expects.
    pub(crate) touch: Option<Arc<TouchPlan>>,
    /// Findings that hold whatever the drive.
    pub(crate) findings: Vec<Finding>,
}

impl Setup {
    /// Lays `scene` over `model`; `drift` holds where the scene gives none.
    ///
    /// # Errors
    /// As [`crate::render`].
    pub(crate) fn new(model: &ModalModel, scene: &Scene, drift: &Drift) -> Result<Self> {
        let limits = scene.limits()?;
        let operator =
            Operator::of_model(model, scene.frequency_hz, scene.actuators.only.as_deref())?;
        let zones = lay_zones(scene, &operator);
        let (judged, hot) = judged_rows(&operator, &zones)?;
        let mut findings = scene_findings(scene, &operator, &zones);
        let (drive_limits, unlimited) = drive_limits(scene, operator.unit)?;
        findings.extend(unlimited);
        findings.extend(controllability(model, &operator));
        findings.extend(mode_on(model, scene.frequency_hz).map(|hz| {
            Finding::note(
                "mode-on-drive",
                format!(
                    "the mode at {hz:.1} Hz is {:.1} Hz from the drive",
                    (hz - scene.frequency_hz).abs()
                ),
            )
            .modes_hz([hz])
            .help("choose a less sensitive frequency")
        }));
        let learned = scene.learned.as_deref();
        let told = learned.and_then(|known| known.covariance_of(&operator));
        let measured = told.is_some();
        let covariance = match told {
            Some(gram) => Covariance::of_gram(gram)?,
            None => {
                let drift = scene.drift.as_ref().unwrap_or(drift);
                Covariance::of_model(model, &operator, &judged, drift)
            }
        };
        let positions_m: Vec<Position> = judged
            .iter()
            .map(|&row| operator.positions_m[row])
            .collect();
        let rows = Rows::new(
            operator.mobility.select(Axis(0), &judged),
            hot,
            positions_m,
            &zones,
        );
        let mut problem = Problem::new(rows, covariance, limits, drive_limits);
        if measured {
            problem.require_confident_kappa();
        }
        let counts = |n: &usize| model.modes[*n].counts();
        let modes = (0..model.modes.len()).filter(counts).collect();
        if let Some(touch) = &scene.touch {
            touch.check_places(&operator.positions_m)?;
        }
        let plan = |touch| TouchPlan::new(model, &operator, &zones, touch, false);
        let touch = scene.touch.as_ref().and_then(plan).map(Arc::new);
        let (nodes, between) = Default::default();
        Ok(Self {
            touch,
            limits,
            operator,
            zones,
            judged,
            problem,
            nodes,
            between,
            modes,
            findings,
        })
    }

    /// The same with another mobility of the same responses and actuators, whose errors
    /// `errors` (any × actuators) come on top.
    pub(crate) fn with_model(
        &self,
        mobility: Array2<Complex64>,
        errors: Array2<Complex64>,
        mut modes: Vec<usize>,
    ) -> Self {
        let mut setup = self.clone();
        setup.operator.mobility = mobility;
        let (measured, hot) = (&self.problem.rows, self.problem.rows.hot);
        let rows = Rows::new(
            setup.operator.mobility.select(Axis(0), &self.judged),
            hot,
            measured.positions_m.clone(),
            &self.zones,
        );
        setup.problem = Problem {
            rows,
            covariance: self.problem.covariance.with_errors(errors),
            ..setup.problem
        };
        setup.between = Default::default();
        modes.sort_unstable();
        setup.modes = modes;
        setup
    }

    /// The same with an operator that measured fields have corrected, and its covariance.
    ///
    /// # Errors
    /// Those of the factorisation of the covariance.
    pub(crate) fn with_operator(
        &self,
        mobility: Array2<Complex64>,
        covariance: Array2<Complex64>,
    ) -> Result<Self> {
        let none = Array2::zeros((0, mobility.ncols()));
        let mut setup = self.with_model(mobility, none, self.modes.clone());
        setup.problem.covariance = Covariance::of_gram(covariance)?;
        setup.problem.require_confident_kappa();
        Ok(setup)
    }

    /// The same with an error of each actuator's force for its weight on top, relative.
    pub(crate) fn with_drive_error(mut self, relative: f64) -> Self {
        let covariance = self.problem.covariance;
        self.problem.covariance =
            covariance.with_drive_error(relative, &self.operator, &self.judged);
        self
    }

    /// The responses as nodes of interpolation, where they carry an area.
    pub(crate) fn nodes(&self) -> Option<&Nodes> {
        self.nodes
            .get_or_init(|| Nodes::new(&self.operator.positions_m))
            .as_ref()
    }

    /// Rows between the responses, where these carry an area.
    pub(crate) fn between(&self) -> Option<&Rows> {
        let [coarse, _] = &self.between;
        coarse
            .get_or_init(|| self.between_rows(tolerances::BETWEEN_SPACING))
            .as_ref()
    }

    /// The same, closer together.
    pub(crate) fn finely_between(&self) -> Option<&Rows> {
        let [_, fine] = &self.between;
        fine.get_or_init(|| self.between_rows(tolerances::FINE_SPACING))
            .as_ref()
    }

    /// Rows of the operator interpolated between the responses, for methods that also
    /// look there; `spacing` over that of the responses.
    fn between_rows(&self, spacing: f64) -> Option<Rows> {
        let Self {
            operator, zones, ..
        } = self;
        let scanned = Rectangle::around(&operator.positions_m)?;
        let ground_m2 = (scanned.x_max - scanned.x_min) * (scanned.y_max - scanned.y_min);
        let step_m = spacing * (ground_m2 / operator.responses.len() as f64).sqrt();
        let places: Vec<Position> = Places::new(&operator.positions_m, zones.area(), step_m)?
            .inside
            .into_iter()
            .map(|place| place.1)
            .collect();
        let (rows, hot) = hot_then_cold(&places, zones);
        let places: Vec<Position> = rows.into_iter().map(|k| places[k]).collect();
        let mobility = self.nodes()?.onto(&places)?.apply(operator.mobility.view());
        Some(Rows::new(mobility, hot, places, zones))
    }

    /// The same with the actuators `columns` of the operator alone.
    pub(crate) fn with_actuators(&self, columns: &[usize]) -> Self {
        let mut setup = self.clone();
        setup.operator.mobility = self.operator.mobility.select(Axis(1), columns);
        setup.operator.references = columns
            .iter()
            .map(|&column| self.operator.references[column])
            .collect();
        setup.operator.reference_columns = columns
            .iter()
            .map(|&column| self.operator.reference_columns[column])
            .collect();
        setup.problem = self.problem.with_actuators(columns);
        setup.between = Default::default();
        setup
    }
}

/// The scene's zones over the responses of the operator.
pub(crate) fn lay_zones(scene: &Scene, operator: &Operator) -> ZoneMap {
    let around =
        Rectangle::around(&operator.positions_m).expect("an operator has at least one response");
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
    let ground: Vec<Ground> = places.iter().map(|&place| zones.classify(place)).collect();
    let on = |wanted| {
        (0..places.len())
            .filter(|&k| ground[k] == wanted)
            .collect::<Vec<_>>()
    };
    let (hot, cold) = (on(Ground::Hot), on(Ground::Cold));
    let count = hot.len();
    ([hot, cold].concat(), count)
}

/// Findings about a scene on these responses, whatever the drive.
pub(crate) fn scene_findings(scene: &Scene, operator: &Operator, zones: &ZoneMap) -> Vec<Finding> {
    let mut findings = operator.findings.clone();
    findings.extend(scene.threshold.finding(scene.frequency_hz));
    let (area, e) = (zones.area(), tolerances::POSITION_M);
    let scanned =
        Rectangle::around(&operator.positions_m).expect("an operator has at least one response");
    if area.x_min < scanned.x_min - e
        || area.y_min < scanned.y_min - e
        || area.x_max > scanned.x_max + e
        || area.y_max > scanned.y_max + e
    {
        let words = format!(
            "area_m goes beyond the responses, which cover x {} to {} m, y {} to {} m; nothing \
             outside them is judged",
            scanned.x_min, scanned.x_max, scanned.y_min, scanned.y_max
        );
        findings.push(Finding::caution("area-beyond-responses", words));
    }
    findings.extend(unmeasured_zones(scene, operator, zones));
    let (zone_count, actuators) = (zones.hot_outlines().len(), operator.references.len());
    if actuators > 1 && zone_count > actuators {
        let words = format!(
            "{zone_count} hot cells or polygons for {actuators} actuators: these cannot set them \
             apart from each other"
        );
        let finding = Finding::caution("more-zones-than-actuators", words);
        findings.push(finding.help("mark fewer zones, or use more actuators"));
    }
    if operator.references.len() == 1 {
        let words = format!(
            "a single actuator ({}) can only scale one pattern, not shape it",
            operator.references[0]
        );
        let finding = Finding::caution("one-actuator", words).dofs([operator.references[0]]);
        findings.push(finding.help("use more actuators"));
    }
    findings
}

/// The finding on hot polygons that hold no response: nothing says whether they are felt. Cells of
/// a grid may be finer than the responses.
fn unmeasured_zones(scene: &Scene, operator: &Operator, zones: &ZoneMap) -> Option<Finding> {
    let ZoneLayout::Polygons(polygons) = &scene.zones.layout else {
        return None;
    };
    let is_hot = |k: &usize| polygons[*k].kind == PolygonKind::Hot;
    // as they are counted in the scene
    let hot: Vec<usize> = (0..polygons.len()).filter(is_hot).collect();
    let empty = zones.hot_without(&operator.positions_m);
    let numbers: Vec<String> = empty.iter().map(|&k| (hot[k] + 1).to_string()).collect();
    (!numbers.is_empty()).then(|| {
        let words = format!(
            "no response is judged in hot polygon {}: nothing says whether it is felt",
            numbers.join(", ")
        );
        Finding::caution("zone-without-response", words).help(
            "check its corners against the positions of the nodes (metres), transition_m against \
             their spacing, and area_m and polygons of the kind ignore that cover it",
        )
    })
}

/// Refuses a scene without hot or without cold responses.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`].
pub(crate) fn check_ground(scene: &Scene, operator: &Operator) -> Result<()> {
    judged_rows(operator, &lay_zones(scene, operator)).map(drop)
}

/// The limits of the drive that the scene gives, N or V.
///
/// # Errors
/// A force limit over references in volts.
pub(crate) fn drive_limits(
    scene: &Scene,
    unit: ReferenceUnit,
) -> Result<(DriveLimits, Option<Finding>)> {
    let actuators = &scene.actuators;
    let (each, unlimited) = largest_weight(scene, unit)?;
    // peaks of tones add, their efforts add as squares
    let effort = actuators.max_effort.unwrap_or(f64::INFINITY) * scene.share.peak.sqrt();
    Ok((
        DriveLimits {
            each: each * scene.share.peak,
            effort,
            unit,
        },
        unlimited,
    ))
}

/// The largest |A_i| that the scene allows, N or V.
fn largest_weight(scene: &Scene, unit: ReferenceUnit) -> Result<(f64, Option<Finding>)> {
    let actuators = &scene.actuators;
    let electrical = actuators
        .circuit
        .map(|circuit| circuit.max_voltage_v(scene.frequency_hz));
    match unit {
        ReferenceUnit::Newton if electrical.is_some() => Err(Error::bad_data(
            "a limit of current or power cannot be kept: the references of the model are newtons",
        )
        .field("actuators")
        .found("max_current_a or max_apparent_power_va")
        .expected("max_force_n")
        .help("measure FRFs per volt, or give the force that the current makes")),
        ReferenceUnit::Newton if actuators.max_voltage_v.is_some() => Err(Error::bad_data(
            "a voltage limit cannot be kept: the references of the model are newtons",
        )
        .field("actuators.max_voltage_v")
        .found(actuators.max_voltage_v.unwrap_or_default())
        .expected("actuators.max_force_n")
        .help("measure FRFs per volt, or give the limit in newtons peak")),
        ReferenceUnit::Newton => Ok((actuators.max_force_n.unwrap_or(DEFAULT_MAX_FORCE_N), None)),
        ReferenceUnit::Volt => match (actuators.max_voltage_v, electrical, actuators.max_force_n) {
            (_, _, Some(limit)) => Err(Error::bad_data(
                "a force limit cannot be kept: the references of the model are volts",
            )
            .field("actuators.max_force_n")
            .found(limit)
            .expected("actuators.max_voltage_v")
            .help("give the limit in volts peak alone, or leave both out")),
            (Some(limit), electrical, None) => {
                Ok((electrical.unwrap_or(f64::INFINITY).min(limit), None))
            }
            (None, Some(limit), None) => Ok((limit, None)),
            (None, None, None) => Ok((
                f64::INFINITY,
                Some(
                    Finding::caution(
                        "no-drive-limit",
                        "the references are volts and the scene gives no actuators.max_voltage_v: \
                         no limit was kept",
                    )
                    .help("give the limit in the scene"),
                ),
            )),
        },
    }
}

/// Modes that no actuator in use can drive.
fn controllability(model: &ModalModel, operator: &Operator) -> Option<Finding> {
    let strength = |participation: &[Complex64]| {
        operator
            .reference_columns
            .iter()
            .map(|&j| participation[j].norm_sqr())
            .fold(0.0, f64::max)
            .sqrt()
    };
    let largest = model
        .in_band_modes()
        .map(|mode| strength(&mode.participation.0))
        .fold(0.0, f64::max);
    let idle: Vec<f64> = model
        .in_band_modes()
        .filter(|mode| strength(&mode.participation.0) <= tolerances::NO_PARTICIPATION * largest)
        .map(|mode| mode.frequency_hz)
        .collect();
    let places: Vec<String> = idle.iter().map(|hz| format!("{hz:.1} Hz")).collect();
    (!idle.is_empty()).then(|| {
        let words = format!(
            "no actuator in use can drive or stop the mode at {}",
            places.join(", ")
        );
        Finding::caution("not-driven", words).modes_hz(idle)
    })
}
