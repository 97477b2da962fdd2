//! A drive corrected by measured fields.
//!
//! Two estimators keep an operator each: the structured update (gains and poles, then an
//! operator update on what they leave) and the operator Kalman update alone. The one counts
//! that foretold the newest field better; of a first field the structured one, unless its
//! modes want to move by the largest scale. Then the robust program runs on that operator
//! and its posterior covariance.

use super::field::{noise_assumed, LaidField};
use super::kalman::KalmanOperator;
use super::structured::{Parts, Seen, Structured};
use crate::covariance::Covariance;
use crate::evaluate::{laid, Laid, On};
use crate::field::Field;
use crate::indices::{AreaIndices, Indices, PointIndices};
use crate::methods::Method;
use crate::options::{Drift, RenderOptions};
use crate::problem::Drive;
use crate::scene::Scene;
use crate::setup::Setup;
use crate::tolerances;
use crate::weights::{weight_list, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
use chladni_frf::{Dof, Error, Finding, MeasuredField, ModalModel, Result, CREATED_BY};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// What a correction took and found; `/correction` of a weights file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// Number of fields that were taken in.
    pub iteration: usize,
    /// `structured` or `kalman`: which operator the drive was made for.
    pub estimator: String,
    /// Smaller of hot and cold ratio that the corrected operator foretells.
    pub predicted: f64,
    /// A new scan of FRFs is due.
    pub scan_due: bool,
    /// Why it is.
    pub scan_reason: Option<String>,
    /// What each field was, in order.
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

/// The gain of one channel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ChannelGain {
    /// Reference DOF.
    pub reference: Dof,
    /// Real part of the factor on its weight.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Standard deviation of the factor.
    pub std: f64,
    /// True where it lies beyond what the other channels show.
    pub odd: bool,
}

/// The two estimators after some fields.
struct Estimators {
    structured: Structured,
    /// The structured operator, updated on what it leaves.
    remainder: KalmanOperator,
    kalman: KalmanOperator,
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
    if !scene.other_tones.is_empty() {
        return Err(Error::bad_data("a correction is of one tone")
            .field("frequency_hz")
            .found(format!("{} tones", scene.tones().len()))
            .expected("one frequency")
            .help("correct the tones one by one"));
    }
    let drift = scene.drift.unwrap_or(options.drift);
    let drift = Drift {
        drive_relative: drift.drive_relative.max(tolerances::RIG_DRIVE_ERROR),
        ..drift
    };
    let scene = &Scene {
        drift: Some(drift),
        ..scene.clone()
    };
    let setup = Setup::new(model, scene, &drift)?;
    let mut findings = setup.findings.clone();
    let seen = see(&setup, scene, model, played, &mut findings)?;
    let all: Vec<usize> = (0..setup.operator.responses.len()).collect();
    let design = Covariance::of_model(model, &setup.operator, &all, &drift);
    let parts = Parts::new(model, &setup.operator);
    let mut nis = Vec::new();
    let mut chosen = "structured";
    let mut before: Option<Estimators> = None;
    for count in 1..=seen.len() {
        let newest = &seen[count - 1];
        let foretold = match &before {
            Some(known) => {
                let errors =
                    [&known.remainder, &known.kalman].map(|operator| miss(operator, newest));
                let whole = newest.rows.len() == all.len();
                let better = [&known.remainder, &known.kalman];
                let which = usize::from(whole && errors[1] < errors[0]);
                chosen = ["structured", "kalman"][which];
                better[which].clone()
            }
            None => KalmanOperator {
                mobility: setup.operator.mobility.clone(),
                covariance: design.gram().clone(),
            },
        };
        nis.push(score(&foretold, newest));
        let estimators = estimate(&parts, &setup, design.gram(), &seen[..count])?;
        let largest = tolerances::MODE_SCALES[tolerances::MODE_SCALES.len() - 1];
        if count == 1 && newest.rows.len() == all.len() {
            let restless = estimators.structured.scales.modes >= largest;
            chosen = if restless { "kalman" } else { "structured" };
        }
        before = Some(estimators);
    }
    let Some(known) = before else {
        return Err(Error::bad_data("no field to correct by")
            .field("field")
            .found("none")
            .expected("at least one pair of weights and measured field"));
    };
    let operator = match chosen {
        "kalman" => &known.kalman,
        _ => &known.remainder,
    };
    let corrected = setup.with_operator(operator.mobility.clone(), operator.covariance.clone())?;
    let solution = Method::Robust.solve(&corrected, model, options.effort)?;
    findings.extend(solution.findings);
    let measured: Vec<Option<f64>> = seen
        .iter()
        .map(|seen| measured_ratio(&setup, seen))
        .collect();
    let new = corrected.problem.score(&solution.drive);
    let (drive, best, kept) = best_of(&corrected, &solution.drive, &seen, &measured);
    let (scan_due, reason) = scan(&nis, &known.structured);
    let field = Field::new(&corrected.operator, &setup.zones, &drive);
    let unit = setup.operator.unit;
    let points = PointIndices::of_field(&field, &setup.zones, &setup.limits, &drive, unit)?;
    let area = corrected
        .nodes()
        .and_then(|nodes| field.area_from(nodes, &setup.zones))
        .map(|area| AreaIndices::of_area(&area, &setup.zones, &setup.limits));
    if let Some(reason) = &reason {
        let words = format!("a new scan of the FRFs is due: {reason}");
        findings.push(
            Finding::caution("scan-due", words)
                .help("take away what lies on the panel, or measure the FRFs again"),
        );
    }
    let correction = Correction {
        iteration: seen.len(),
        estimator: chosen.into(),
        predicted: if kept {
            points.min_ratio
        } else {
            new.min_ratio
        },
        scan_due,
        scan_reason: reason,
        fields: nis
            .iter()
            .zip(&measured)
            .map(|(&nis, &min_ratio)| TakenField { nis, min_ratio })
            .collect(),
        best_measured: best.map(|best| best + 1),
        kept,
        gains: gains(&setup, &known.structured),
        common_shift: known.structured.common,
    };
    Ok(Weights {
        format: WEIGHTS_FORMAT.into(),
        version: WEIGHTS_VERSION,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: options.to_json(&drift),
        frequency_hz: scene.frequency_hz,
        method: "robust".into(),
        scene: scene.name(),
        weights: weight_list(&setup.operator.references, &drive, unit),
        modes_used: setup.modes.len(),
        actuators_used: drive.iter().filter(|weight| weight.norm() > 0.0).count(),
        feasible: points.min_ratio == 1.0,
        ceiling: None,
        kappa: Some(corrected.problem.score(&drive).kappa).filter(|kappa| kappa.is_finite()),
        endurance: None,
        modal: None,
        indices: Indices { points, area },
        stress: None,
        sweep: None,
        correction: Some(correction),
        findings: findings.into(),
        other_tones: Vec::new(),
    })
}

/// The fields laid over the operator, each with its drive.
fn see(
    setup: &Setup,
    scene: &Scene,
    model: &ModalModel,
    played: &[(Weights, MeasuredField, Option<String>)],
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
                .expected(format!("{asked} Hz, as the scene")));
        }
        let Laid {
            operator, drive, ..
        } = laid(weights, scene, On::Model(model))?;
        let mut whole = Drive::zeros(setup.operator.references.len());
        for (reference, &weight) in operator.references.iter().zip(&drive) {
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

/// Both estimators from all fields so far.
fn estimate(
    parts: &Parts,
    setup: &Setup,
    design: &Array2<Complex64>,
    seen: &[Seen],
) -> Result<Estimators> {
    let structured = parts.update(seen)?;
    let share = Complex64::from(tolerances::DESIGN_SHARE);
    let mut remainder = KalmanOperator {
        mobility: structured.mobility.clone(),
        covariance: &structured.covariance + &design.mapv(|value| value * share),
    };
    let mut kalman = KalmanOperator {
        mobility: setup.operator.mobility.clone(),
        covariance: design.clone(),
    };
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

/// Smaller of hot and cold ratio of a field as measured; `None` where it holds too little.
fn measured_ratio(setup: &Setup, seen: &Seen) -> Option<f64> {
    let rows = &setup.problem.rows;
    let mut counts = [[0usize; 2]; 2];
    for (number, row) in setup.judged.iter().enumerate() {
        let Some(place) = seen.rows.iter().position(|seen| seen == row) else {
            continue;
        };
        let speed = seen.velocity[place].norm() / rows.levels[number];
        let (kind, inside) = match number < rows.hot {
            true => (0, setup.limits.is_felt(speed)),
            false => (1, setup.limits.is_quiet(speed)),
        };
        counts[kind][0] += usize::from(inside);
        counts[kind][1] += 1;
    }
    let ratio = |[inside, all]: [usize; 2]| (all > 0).then(|| inside as f64 / all as f64);
    Some(ratio(counts[0])?.min(ratio(counts[1])?))
}

/// The drive to give: the new one, or the best measured one where no better is foretold.
fn best_of(
    corrected: &Setup,
    new: &Drive,
    seen: &[Seen],
    measured: &[Option<f64>],
) -> (Drive, Option<usize>, bool) {
    let whole = corrected.operator.responses.len();
    let best = (0..seen.len())
        .filter(|&k| seen[k].rows.len() == whole)
        .filter_map(|k| Some((measured[k]?, k)))
        .max_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some((ratio, k)) = best else {
        return (new.clone(), None, false);
    };
    let foretold = corrected.problem.score(new);
    let known = corrected.problem.score(&seen[k].drive);
    let kept = ratio > foretold.min_ratio
        || (ratio == foretold.min_ratio && known.kappa >= foretold.kappa);
    let drive = if kept { &seen[k].drive } else { new };
    (drive.clone(), Some(k), kept)
}

/// Whether a new scan is due, and why.
fn scan(nis: &[f64], structured: &Structured) -> (bool, Option<String>) {
    let beyond = |nis: &f64| *nis > tolerances::SCAN_NIS;
    if nis.len() > 2 && nis[nis.len() - 2..].iter().all(beyond) {
        let words = format!(
            "the last two fields were not what the correction foretold (NIS {:.1} and {:.1})",
            nis[nis.len() - 2],
            nis[nis.len() - 1]
        );
        return (true, Some(words));
    }
    if structured.scales.unexplained >= tolerances::SCAN_UNEXPLAINED && nis.len() > 1 {
        let words = format!(
            "gains and natural frequencies leave {:.0} % of the mobility unexplained",
            100.0 * structured.scales.unexplained
        );
        return (true, Some(words));
    }
    (false, None)
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
