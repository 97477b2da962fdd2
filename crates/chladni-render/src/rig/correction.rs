//! A drive corrected by measured fields.
//!
//! Two estimators keep an operator each: the structured update (gains and poles, then an
//! operator update on what they leave) and the operator Kalman update alone. The one counts
//! that foretold the newest field better; of a first field the structured one, unless its
//! modes want to move by the largest scale. Then the robust program runs on that operator
//! and its posterior covariance.

use super::calibrated::{dead_of, movable_modes, Calibrated};
use super::calibration::{
    scan_due, CalibratedMode, CalibratedOperator, Calibration, ChannelGain, Estimator,
    CALIBRATION_FORMAT, CALIBRATION_VERSION,
};
use super::field::{noise_assumed, LaidField};
use super::kalman::KalmanOperator;
use super::structured::{Parts, Seen, Structured};
use crate::covariance::Covariance;
use crate::drift::Drift;
use crate::evaluate::{laid, Laid, On};
use crate::field::Field;
use crate::indices::{AreaIndices, Indices, PointIndices};
use crate::methods::Method;
use crate::operator::Operator;
use crate::options::RenderOptions;
use crate::problem::{chance_above, Drive};
use crate::scene::Scene;
use crate::setup::Setup;
use crate::tolerances;
use crate::weights::{weight_list, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
use chladni_frf::{
    ComplexMatrix, Dof, Error, Finding, MeasuredField, ModalModel, Result, CREATED_BY,
};
use ndarray::{Array1, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Input and result of a correction; `/correction` of a weights file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[must_use]
pub struct Correction {
    /// Number of fields that were taken in.
    pub iteration: usize,
    /// The operator that the drive was made for.
    pub estimator: Estimator,
    /// Smaller of hot and cold ratio to be expected under the error bars of the corrected
    /// operator; as measured where a measured drive is given again.
    pub predicted: f64,
    /// A new scan of FRFs is due.
    pub scan_due: bool,
    /// The reason that it is due.
    pub scan_reason: Option<String>,
    /// The measured fields, in order.
    pub fields: Vec<TakenField>,
    /// The field, from 1, of the best measured drive.
    pub best_measured: Option<usize>,
    /// True where that drive is given again, since no better one is foretold.
    pub kept: bool,
    /// Gains that the fields tell, channel by channel.
    pub gains: Vec<ChannelGain>,
    /// Relative shift of all natural frequencies that they tell.
    pub common_shift: f64,
}

/// A field that was taken in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TakenField {
    /// mean |v − v̂|²/(‖L·A‖² + σ²) against what was foretold before it was taken in.
    pub nis: f64,
    /// Smaller of hot and cold ratio as measured; `None` where it holds no hot or no cold
    /// response.
    pub min_ratio: Option<f64>,
}

/// The two estimators after some fields.
struct Estimators {
    structured: Structured,
    /// The structured operator, updated on what it leaves.
    remainder: KalmanOperator,
    kalman: KalmanOperator,
}

impl Estimators {
    fn operator(&self, estimator: Estimator) -> &KalmanOperator {
        match estimator {
            Estimator::Structured => &self.remainder,
            Estimator::Kalman => &self.kalman,
        }
    }
}

/// The result of all fields together.
struct Learned {
    estimators: Estimators,
    /// The estimator that counts.
    chosen: Estimator,
    /// NIS of each field against what was foretold of it.
    nis: Vec<f64>,
}

/// A drive for `scene`, corrected by the fields that were measured under earlier weights,
/// oldest first.
///
/// # Errors
/// As [`crate::evaluate_field`]; no field, a scene of several tones, weights of another
/// frequency than the scene's.
pub fn correct(
    model: &ModalModel,
    scene: &Scene,
    played: &[(Weights, MeasuredField, Option<String>)],
    options: &RenderOptions,
) -> Result<Weights> {
    calibrate(model, scene, played, options).map(|(weights, _)| weights)
}

/// The same, and what the fields taught of the rig. A calibration that the scene names is
/// where it starts: give the fields that came after it.
///
/// # Errors
/// As [`correct`].
pub fn calibrate(
    model: &ModalModel,
    scene: &Scene,
    played: &[(Weights, MeasuredField, Option<String>)],
    options: &RenderOptions,
) -> Result<(Weights, Calibration)> {
    if !scene.other_tones.is_empty() {
        return Err(Error::bad_data("a correction is of one tone")
            .field("frequency_hz")
            .found(format!("{} tones", scene.tones().len()))
            .expected("one frequency")
            .help("correct the tones one by one"));
    }
    let (own, asked) = (model, scene);
    let before = asked.actuators.calibration.as_deref();
    let Calibrated {
        model,
        scene,
        mut findings,
    } = Calibrated::new(own, asked, Some(asked.frequency_hz), &options.drift)?;
    let model = &*model;
    let drift = prior_drift(asked, &scene, options.drift);
    let scene = &Scene {
        drift: Some(drift),
        ..scene.into_owned()
    };
    let setup = Setup::new(model, scene, &drift)?;
    findings.extend(setup.findings.iter().cloned());
    let seen = see(
        &setup,
        scene,
        model,
        played,
        &dead_of(&asked.actuators),
        &mut findings,
    )?;
    let learned = Learned::of(model, &setup, scene, &seen)?;
    let operator = learned.estimators.operator(learned.chosen);
    let covariance = operator
        .covariance
        .mapv(|value| value * learned.inflation());
    let corrected = setup.with_operator(operator.mobility.clone(), covariance)?;
    let solution = Method::Robust.solve(&corrected, model, options.effort, None)?;
    findings.extend(solution.findings);
    let measured: Vec<Option<f64>> = seen
        .iter()
        .map(|seen| measured_ratio(&setup, seen, Count::Plain))
        .collect();
    let given = best_of(&corrected, solution.drive, &seen);
    let structured = &learned.estimators.structured;
    let scan_reason = scan(&learned.nis, structured);
    findings.retain(|finding| finding.code != "scan-due");
    findings.extend(scan_reason.as_deref().map(scan_due));
    let fields = learned.nis.iter().zip(&measured);
    let correction = Correction {
        iteration: seen.len(),
        estimator: learned.chosen,
        predicted: given.predicted,
        scan_due: scan_reason.is_some(),
        scan_reason,
        fields: fields
            .map(|(&nis, &min_ratio)| TakenField { nis, min_ratio })
            .collect(),
        best_measured: given.best_measured.map(|best| best + 1),
        kept: given.kept,
        gains: gains(&setup, structured),
        common_shift: structured.common,
    };
    let calibration = learned.calibration([own, model], &corrected, before, &correction);
    let weights = weights_of(&corrected, scene, &given.drive)?;
    let weights = Weights {
        options: options.to_json(&drift),
        correction: Some(correction),
        findings: findings.into(),
        ..weights
    };
    Ok((weights, calibration))
}

/// The drift with at least the error of amplifiers that every rig has.
fn rig_drift(drift: Drift) -> Drift {
    Drift {
        drive_relative: drift.drive_relative.max(tolerances::RIG_DRIVE_ERROR),
        ..drift
    }
}

/// The drift that a prediction has: of a rig that no field has calibrated at least the
/// usual error of amplifiers.
///
/// * `asked`, `scene`: the scene as it was given, and as its calibration makes it
pub(crate) fn prior_drift(asked: &Scene, scene: &Scene, default: Drift) -> Drift {
    let drift = scene.drift.unwrap_or(default);
    match asked.actuators.calibration {
        Some(_) => drift,
        None => rig_drift(drift),
    }
}

/// Error of a prediction before any new field: what earlier fields have left, or that of
/// the model under `drift`.
///
/// # Errors
/// Those of the factorisation.
pub(crate) fn design(
    model: &ModalModel,
    operator: &Operator,
    scene: &Scene,
    drift: &Drift,
) -> Result<Covariance> {
    let learned = scene.learned.as_deref();
    if let Some(gram) = learned.and_then(|known| known.covariance_of(operator)) {
        return Covariance::of_gram(gram);
    }
    let all: Vec<usize> = (0..operator.responses.len()).collect();
    Ok(Covariance::of_model(model, operator, &all, drift))
}

impl Learned {
    /// Takes in the fields one by one: each is foretold from those before it.
    fn of(model: &ModalModel, setup: &Setup, scene: &Scene, seen: &[Seen]) -> Result<Self> {
        let drift = &scene.drift.unwrap_or_default();
        let all: Vec<usize> = (0..setup.operator.responses.len()).collect();
        let design = design(model, &setup.operator, scene, drift)?;
        let parts = Parts::new(model, &setup.operator);
        let first = KalmanOperator {
            mobility: setup.operator.mobility.clone(),
            covariance: design.gram().clone(),
        };
        let mut learned: Option<Self> = None;
        for (count, newest) in (1..).zip(seen) {
            let whole = newest.rows.len() == all.len();
            let (mut chosen, mut nis) = (Estimator::Structured, Vec::new());
            let mut before = None;
            match learned {
                Some(known) => {
                    chosen = known.chosen;
                    if whole {
                        let error = |of| miss(known.estimators.operator(of), newest);
                        let other = error(Estimator::Kalman) < error(Estimator::Structured);
                        chosen = [Estimator::Structured, Estimator::Kalman][usize::from(other)];
                    }
                    nis = known.nis;
                    nis.push(score(known.estimators.operator(chosen), newest));
                    before = Some(known.estimators.structured);
                }
                None => nis.push(score(&first, newest)),
            }
            let estimators = estimate(&parts, &first, &seen[..count], before.as_ref())?;
            let largest = tolerances::MODE_SCALES[tolerances::MODE_SCALES.len() - 1];
            if count == 1 && whole && estimators.structured.scales.modes >= largest {
                chosen = Estimator::Kalman;
            }
            learned = Some(Self {
                estimators,
                chosen,
                nis,
            });
        }
        learned.ok_or_else(|| {
            Error::bad_data("no field to correct by")
                .field("field")
                .found("none")
                .expected("at least one pair of weights and measured field")
                .help("play the weights, measure the field, and give both")
        })
    }

    /// Factor on the covariance: where the newest field was not what was foretold, the
    /// error bars were too small by that much. Of a first field nothing is known.
    fn inflation(&self) -> f64 {
        match self.nis.as_slice() {
            [_, .., newest] => newest.max(1.0),
            _ => 1.0,
        }
    }

    /// The present knowledge of the rig.
    ///
    /// * `own`, `model`: the model as it was fitted, and as the calibration before made it
    fn calibration(
        &self,
        [own, model]: [&ModalModel; 2],
        corrected: &Setup,
        before: Option<&Calibration>,
        told: &Correction,
    ) -> Calibration {
        let frequency_hz = corrected.operator.frequency_hz;
        let structured = &self.estimators.structured;
        let holds = self.chosen == Estimator::Structured;
        let gain_before = |dof| before.map_or(Complex64::ONE, |known| known.gain_of(dof));
        let mut gains: Vec<ChannelGain> = Vec::new();
        for gain in &told.gains {
            let known = gain_before(gain.reference);
            let factor = match holds || gain.odd {
                true => known * Complex64::new(gain.re, gain.im),
                false => known,
            };
            gains.push(ChannelGain {
                re: factor.re,
                im: factor.im,
                ..*gain
            });
        }
        let mut dead: Vec<Dof> = before.map_or(Vec::new(), |known| known.dead.clone());
        dead.extend(
            gains
                .iter()
                .filter(|gain| gain.is_dead())
                .map(|gain| gain.reference),
        );
        let at = |n: usize| [&own.modes[n], &model.modes[n]];
        let modes = movable_modes(own).into_iter().enumerate().map(|(k, n)| {
            let [fitted, known] = at(n);
            let (frequency_hz, loss_factor) = match holds {
                true => structured.moved_pole(k, known, model.damping, frequency_hz),
                false => (known.frequency_hz, known.loss_factor),
            };
            CalibratedMode {
                model_hz: fitted.frequency_hz,
                frequency_hz,
                loss_factor,
                std: structured.shift_std[k],
            }
        });
        let operator = CalibratedOperator {
            frequency_hz,
            fields: told.iteration
                + before
                    .and_then(|known| known.at(frequency_hz))
                    .map_or(0, |known| known.fields),
            estimator: self.chosen,
            responses: corrected.operator.responses.clone(),
            references: corrected.operator.references.clone(),
            mobility: ComplexMatrix(corrected.operator.mobility.clone()),
            covariance: ComplexMatrix(corrected.problem.covariance.gram().clone()),
        };
        let mut operators = vec![operator];
        let elsewhere = |known: &&CalibratedOperator| {
            let distance = (known.frequency_hz - frequency_hz).abs();
            distance > tolerances::SAME_FREQUENCY * frequency_hz
        };
        operators.extend(
            before
                .iter()
                .flat_map(|known| &known.operators)
                .filter(elsewhere)
                .cloned(),
        );
        operators.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        Calibration {
            format: CALIBRATION_FORMAT.into(),
            version: CALIBRATION_VERSION,
            created_by: CREATED_BY.into(),
            source: before.map_or(Vec::new(), |known| known.source.clone()),
            unit: corrected.operator.unit,
            fields: told.iteration + before.map_or(0, |known| known.fields),
            scan_due: told.scan_due,
            scan_reason: told.scan_reason.clone(),
            gains,
            dead,
            modes: modes.collect(),
            operators,
        }
    }
}

/// The weights file of a drive that keeps `setup`.
fn weights_of(setup: &Setup, scene: &Scene, drive: &Drive) -> Result<Weights> {
    let unit = setup.operator.unit;
    let field = Field::new(&setup.operator, &setup.zones, drive);
    let points = PointIndices::of_field(&field, &setup.zones, &setup.limits, drive, unit)?;
    let area = setup
        .nodes()
        .and_then(|nodes| field.area_from(nodes, &setup.zones))
        .map(|area| AreaIndices::of_area(&area, &setup.zones, &setup.limits));
    Ok(Weights {
        format: WEIGHTS_FORMAT.into(),
        version: WEIGHTS_VERSION,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: Default::default(),
        frequency_hz: scene.frequency_hz,
        method: "robust".into(),
        scene: scene.name(),
        weights: weight_list(&setup.operator.references, drive, unit),
        modes_used: setup.modes.len(),
        actuators_used: drive.iter().filter(|weight| weight.norm() > 0.0).count(),
        feasible: points.min_ratio == 1.0,
        ceiling: None,
        kappa: Some(setup.problem.score(drive).kappa).filter(|kappa| kappa.is_finite()),
        endurance: None,
        modal: None,
        indices: Indices { points, area },
        stress: None,
        touch: None,
        sweep: None,
        correction: None,
        findings: Default::default(),
        other_tones: Vec::new(),
    })
}

/// The fields laid over the operator, each with its drive.
fn see(
    setup: &Setup,
    scene: &Scene,
    model: &ModalModel,
    played: &[(Weights, MeasuredField, Option<String>)],
    dead: &[Dof],
    findings: &mut Vec<Finding>,
) -> Result<Vec<Seen>> {
    let mut assumed = false;
    let mut all = Vec::with_capacity(played.len());
    for (weights, field, sha256) in played {
        let asked = scene.frequency_hz;
        if (weights.frequency_hz - asked).abs() > tolerances::SAME_FREQUENCY * asked {
            return Err(Error::bad_data("the weights are for another frequency")
                .field("frequency_hz")
                .found(format!("{} Hz", weights.frequency_hz))
                .expected(format!("{asked} Hz, as the scene"))
                .help("give weights that were rendered for this scene"));
        }
        let Laid {
            operator, drive, ..
        } = laid(weights, scene, On::Model(model))?;
        let mut whole = Drive::zeros(setup.operator.references.len());
        for (reference, &weight) in operator.references.iter().zip(&drive) {
            // what was played into a dead channel moved nothing
            if dead.iter().any(|dead| dead.same_axis(*reference)) {
                continue;
            }
            let place = setup
                .operator
                .references
                .iter()
                .position(|known| known == reference);
            let place = place.ok_or_else(|| {
                Error::bad_data("the weights drive an actuator that the scene does not use")
                    .field("weights")
                    .found(reference)
                    .expected("the actuators of the scene")
                    .help("use the same actuators in the scene, or render its weights anew")
            })?;
            whole[place] = weight;
        }
        let field = LaidField::new(field, &setup.operator, sha256.as_deref())?;
        assumed |= field.noise_assumed;
        let square = field.std.iter().map(|std| std * std).sum::<f64>() / field.std.len() as f64;
        all.push(Seen {
            drive: whole,
            rows: field.rows,
            velocity: field.velocity,
            noise: square.sqrt(),
            magnitudes_only: field.magnitudes_only,
        });
    }
    if assumed {
        findings.push(noise_assumed());
    }
    Ok(all)
}

/// Both estimators from all fields so far; `first` is the model with its error bars.
fn estimate(
    parts: &Parts,
    first: &KalmanOperator,
    seen: &[Seen],
    before: Option<&Structured>,
) -> Result<Estimators> {
    let structured = parts.update(seen, before)?;
    let share = Complex64::from(tolerances::DESIGN_SHARE);
    let mut remainder = KalmanOperator {
        mobility: structured.mobility.clone(),
        covariance: &structured.covariance + &first.covariance.mapv(|value| value * share),
    };
    let mut kalman = first.clone();
    for seen in seen {
        for operator in [&mut remainder, &mut kalman] {
            let velocity = seen.phased(&operator.mobility);
            operator.update(&seen.drive, &seen.rows, &velocity, seen.noise);
        }
    }
    Ok(Estimators {
        structured,
        remainder,
        kalman,
    })
}

fn difference(operator: &KalmanOperator, seen: &Seen) -> Array1<Complex64> {
    let foretold = operator
        .mobility
        .select(Axis(0), &seen.rows)
        .dot(&seen.drive);
    seen.phased(&operator.mobility) - foretold
}

/// Squared error of what an operator foretells of a field.
fn miss(operator: &KalmanOperator, seen: &Seen) -> f64 {
    difference(operator, seen)
        .iter()
        .map(Complex64::norm_sqr)
        .sum()
}

/// The same over what its error bars allow.
fn score(operator: &KalmanOperator, seen: &Seen) -> f64 {
    let through = operator.covariance.dot(&seen.drive);
    let own: Complex64 = seen
        .drive
        .iter()
        .zip(&through)
        .map(|(a, g)| a.conj() * g)
        .sum();
    let bar = own.re.max(0.0) + seen.noise * seen.noise;
    miss(operator, seen) / bar / seen.rows.len() as f64
}

/// The rule by which a measured response counts as inside its limit.
#[derive(Clone, Copy)]
enum Count {
    /// As it was measured.
    Plain,
    /// By the chance that it is, given the noise of the field.
    Expected,
}

/// Smaller of hot and cold ratio of a field as measured; `None` where it holds too little.
fn measured_ratio(setup: &Setup, seen: &Seen, count: Count) -> Option<f64> {
    let (rows, limits) = (&setup.problem.rows, &setup.limits);
    let mut shares = [[0.0; 2]; 2];
    for (number, row) in setup.judged.iter().enumerate() {
        let Some(place) = seen.rows.iter().position(|seen| seen == row) else {
            continue;
        };
        let level = rows.levels[number];
        let speed = seen.velocity[place].norm() / level;
        let (kind, inside, slack) = match number < rows.hot {
            true => (0, limits.is_felt(speed), speed - limits.hot_m_per_s),
            false => (1, limits.is_quiet(speed), limits.cold_m_per_s - speed),
        };
        let noise = (seen.noise / level).max(f64::MIN_POSITIVE);
        shares[kind][0] += match count {
            Count::Plain => f64::from(u8::from(inside)),
            Count::Expected => chance_above(slack, noise),
        };
        shares[kind][1] += 1.0;
    }
    let ratio = |[inside, all]: [f64; 2]| (all > 0.0).then(|| inside / all);
    Some(ratio(shares[0])?.min(ratio(shares[1])?))
}

/// The drive to give.
struct Given {
    drive: Drive,
    /// The smaller of hot and cold ratio to be expected of it.
    predicted: f64,
    /// The best measured field, from 0.
    best_measured: Option<usize>,
    /// True where its drive is given again.
    kept: bool,
}

/// The new drive, or the best measured one where no better is to be expected.
fn best_of(corrected: &Setup, new: Drive, seen: &[Seen]) -> Given {
    let whole = corrected.operator.responses.len();
    let best = (0..seen.len())
        .filter(|&k| seen[k].rows.len() == whole)
        .filter_map(|k| Some((measured_ratio(corrected, &seen[k], Count::Expected)?, k)))
        .max_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let expected = corrected.problem.expected_ratio(&new);
    match best {
        Some((ratio, k)) if ratio >= expected => Given {
            drive: seen[k].drive.clone(),
            predicted: ratio,
            best_measured: Some(k),
            kept: true,
        },
        _ => Given {
            drive: new,
            predicted: expected,
            best_measured: best.map(|(_, k)| k),
            kept: false,
        },
    }
}

/// The reason that a new scan is due; `None` where it is not.
fn scan(nis: &[f64], structured: &Structured) -> Option<String> {
    let beyond = |nis: &f64| *nis > tolerances::SCAN_NIS;
    if nis.len() > 2 && nis[nis.len() - 2..].iter().all(beyond) {
        return Some(format!(
            "the last two fields were not what the correction foretold (NIS {:.1} and {:.1})",
            nis[nis.len() - 2],
            nis[nis.len() - 1]
        ));
    }
    (structured.scales.unexplained >= tolerances::SCAN_UNEXPLAINED && nis.len() > 1).then(|| {
        format!(
            "gains and natural frequencies leave {:.0} % of the mobility unexplained",
            100.0 * structured.scales.unexplained
        )
    })
}

fn gains(setup: &Setup, structured: &Structured) -> Vec<ChannelGain> {
    let gain = |(i, &reference): (usize, &Dof)| ChannelGain {
        reference,
        re: 1.0 + structured.gains[i].re,
        im: structured.gains[i].im,
        std: structured.gain_std[i],
        odd: structured.odd.contains(&i),
    };
    setup
        .operator
        .references
        .iter()
        .enumerate()
        .map(gain)
        .collect()
}
