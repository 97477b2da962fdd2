//! A drive corrected by measured fields: the robust program on the operator that the fields
//! tell, and on its posterior covariance.

use super::calibrated::{dead_of, Calibrated};
use super::calibration::{scan_due, Calibration, ChannelGain};
use super::correction::{Correction, TakenField};
use super::expectation::most_expected;
use super::explained::Unexplained;
use super::given::{best_of, measured_ratio, Count, Given};
use super::learned::Learned;
use super::played_field::PlayedField;
use super::prior::prior_drift;
use super::seen::{see, AllSeen, Seen};
use super::structured::Structured;
use crate::methods::method::Method;
use crate::methods::options::RenderOptions;
use crate::methods::solution::Solution;
use crate::panel::drive::Drive;
use crate::problems::problem::Problem;
use crate::problems::setup::Setup;
use crate::render::under_fingers;
use crate::results::outcome::Outcome;
use crate::results::weights::{Weight, Weights};
use crate::scene::scene_file::Scene;
use crate::tolerances;
use crate::touch::corrected_finding;
use chladni_frf::{Dof, Error, Finding, ModalModel, Result};
use ndarray::Array2;
use num_complex::Complex64;

/// A drive for `scene`, corrected by the fields that were measured under earlier weights,
/// oldest first.
///
/// # Errors
/// As [`crate::evaluate_field`]; no field, a scene of several tones, weights of another
/// frequency than the scene's, fields that tell a gain above 30 dB.
pub fn correct(
    model: &ModalModel,
    scene: &Scene,
    played: &[PlayedField],
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
    played: &[PlayedField],
    options: &RenderOptions,
) -> Result<(Weights, Calibration)> {
    check_one_tone(scene)?;
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
    // learn
    let setup = Setup::new(model, scene, &drift)?;
    findings.extend(setup.findings.iter().cloned());
    let dead = dead_of(&asked.actuators);
    let AllSeen {
        fields: seen,
        swapped,
    } = see(&setup, scene, model, played, &dead, &mut findings)?;
    let learned = Learned::of(model, &setup, scene, &seen)?;
    findings.extend(learned.findings.iter().cloned());
    let known = before.and_then(|known| known.at(asked.frequency_hz));
    let fields = seen.len() + known.map_or(0, |known| known.fields);
    // solve
    let corrected = learned.laid(&setup, 1.0)?;
    let solve = |setup: &Setup| Method::Robust.solve(setup, model, options.effort, None);
    let solution = surest_drive(&corrected, solve, || {
        learned.laid(&setup, tolerances::DARING)
    })?;
    let more = most_expected_drive(&corrected.problem, &solution.drive, &seen, fields)?;
    findings.extend(solution.findings);
    // choose
    let newest = played
        .last()
        .and_then(|newest| newest.weights.correction.as_ref());
    let was_kept = newest.is_some_and(|correction| correction.kept);
    let new = more.unwrap_or(solution.drive);
    let given = best_of(&corrected, new, &seen, (fields, was_kept));
    // tell
    let correction = corrected_by(&setup, &seen, &learned, &given);
    let mobility = &setup.operator.mobility;
    findings_of_correction(&mut findings, &learned, (mobility, &seen), &correction)?;
    let calibration = learned.calibration([own, model], &corrected, before, &correction, swapped);
    calibration.check_learned()?;
    let outcome = Outcome::of(&corrected, &given.drive)?;
    let touch = under_fingers(model, scene, &corrected, &given.drive);
    let fingers = touch.as_ref().zip(corrected.touch.as_deref());
    findings.extend(fingers.and_then(|(told, plan)| corrected_finding(told, plan)));
    let mut weights = Weights {
        options: options.to_json(&drift),
        correction: Some(correction),
        touch,
        findings: findings.into(),
        ..outcome.weights(&corrected, scene, &given.drive, Method::Robust)
    };
    if let Some(pair) = swapped {
        let references = pair.map(|channel| setup.operator.references[channel]);
        exchange(&mut weights.weights, references);
    }
    Ok((weights, calibration))
}

/// Gives each of two channels the weight of the other: what the actuators are to do, behind swapped
/// cables.
fn exchange(weights: &mut [Weight], [one, other]: [Dof; 2]) {
    let value_of = |dof: Dof| {
        let of_dof = weights.iter().find(|weight| weight.reference == dof);
        of_dof.map_or(Complex64::ZERO, Weight::value)
    };
    let values = [(one, value_of(other)), (other, value_of(one))];
    for weight in weights {
        for (dof, value) in values {
            if weight.reference == dof {
                *weight = Weight::new(dof, value, weight.unit);
            }
        }
    }
}

/// Refuses a scene of several tones.
fn check_one_tone(scene: &Scene) -> Result<()> {
    if scene.other_tones.is_empty() {
        return Ok(());
    }
    Err(scene.blame(
        Error::bad_data("a correction is of one tone")
            .field("frequency_hz")
            .found(format!("{} tones", scene.tones().len()))
            .expected("one frequency")
            .help("render and correct each tone as a scene of its own"),
    ))
}

/// The most robust drive on the operator that the fields tell; where it is expected to meet few
/// rows, the drive for a smaller error bar if that one is expected to meet more.
///
/// * `daring`: the scene over the same operator, with a smaller error bar
fn surest_drive(
    corrected: &Setup,
    solve: impl Fn(&Setup) -> Result<Solution>,
    daring: impl FnOnce() -> Result<Setup>,
) -> Result<Solution> {
    let surest = solve(corrected)?;
    let expected = |drive: &Drive| corrected.problem.expected_ratio(drive);
    let ratio = expected(&surest.drive);
    if ratio >= tolerances::DARE_BELOW {
        return Ok(surest);
    }
    let daring = solve(&daring()?)?;
    Ok(match expected(&daring.drive) > ratio {
        true => daring,
        false => surest,
    })
}

/// A drive that gives up a few rows to meet more of the others. It is sought where the fields
/// are enough and `drive` is expected to meet few rows; `None`: no drive is expected to meet
/// more.
fn most_expected_drive(
    problem: &Problem,
    drive: &Drive,
    seen: &[Seen],
    fields: usize,
) -> Result<Option<Drive>> {
    let hope = problem.expected_ratio(drive);
    if fields < tolerances::EXPECTATION_FIELDS || hope >= tolerances::EXPECTATION_BELOW {
        return Ok(None);
    }
    let mut starts: Vec<Drive> = seen.iter().map(|seen| seen.drive.clone()).collect();
    starts.push(drive.clone());
    let most = most_expected(problem, &starts)?;
    Ok(most.filter(|most| problem.expected_ratio(most) > hope))
}

/// Adds the findings of the correction, and takes out those that it explains or renews.
///
/// * `mobility`: before any field
fn findings_of_correction(
    findings: &mut Vec<Finding>,
    learned: &Learned,
    (mobility, seen): (&Array2<Complex64>, &[Seen]),
    correction: &Correction,
) -> Result<()> {
    let structured = &learned.estimators.structured;
    let phases = seen.iter().any(|seen| !seen.magnitudes_only);
    findings.extend(common_factor(structured, phases));
    // one dead channel can leave as little of a field's form: it explains the rest
    let left = seen
        .iter()
        .map(|seen| Unexplained::of(mobility, structured, seen))
        .collect::<Result<Vec<_>>>()?;
    let explained = left.iter().all(Unexplained::is_explained);
    findings.retain(|finding| !(explained && finding.code == "field-unlike"));
    if !findings
        .iter()
        .any(|finding| finding.code == "field-unlike")
    {
        let told = (1..).zip(&left);
        let told = told.filter_map(|(number, left)| Some((number, left.finding()?)));
        findings.extend(
            told.map(|(number, finding): (usize, Finding)| match seen.len() {
                1 => finding,
                _ => finding.about(format_args!("field {number}")),
            }),
        );
    }
    findings.extend(not_better(correction));
    findings.retain(|finding| finding.code != "scan-due");
    findings.extend(correction.scan_reason.as_deref().map(scan_due));
    Ok(())
}

/// The result of the fields `seen`.
fn corrected_by(setup: &Setup, seen: &[Seen], learned: &Learned, given: &Given) -> Correction {
    let structured = &learned.estimators.structured;
    let scan_reason = scan(&learned.nis, structured);
    let taken = |(&nis, seen): (&f64, &Seen)| TakenField {
        nis,
        min_ratio: measured_ratio(setup, seen, Count::Plain),
    };
    Correction {
        iteration: seen.len(),
        estimator: learned.chosen,
        predicted: given.predicted,
        scan_due: scan_reason.is_some(),
        scan_reason,
        fields: learned.nis.iter().zip(seen).map(taken).collect(),
        best_measured: given.best_measured.map(|best| best + 1),
        kept: given.kept,
        gains: gains(setup, structured),
        common_shift: structured.common,
    }
}

/// The finding of a factor that all channels share; its phase is known where a field has phases.
fn common_factor(structured: &Structured, phases: bool) -> Option<Finding> {
    let factor = structured.common_factor()?;
    let told = match phases {
        true => format!("{:.3}{:+.3}j", factor.re, factor.im),
        false => format!("{:.3}", factor.norm()),
    };
    let words = format!(
        "all channels have the factor {told} in common: a trigger, a delay, or the level of all \
         amplifiers"
    );
    let finding = Finding::note("common-factor", words)
        .value("re", factor.re)
        .value("im", factor.im);
    Some(finding.help("nothing to do: the gains hold it"))
}

/// The finding of a drive of which less is expected than the best measured one was seen to serve.
fn not_better(correction: &Correction) -> Option<Finding> {
    let best = correction.best_measured.filter(|_| !correction.kept)?;
    let measured = correction.fields.get(best - 1)?.min_ratio?;
    if correction.predicted >= measured - tolerances::NO_BETTER {
        return None;
    }
    let words = format!(
        "the corrected weights are expected to serve {:.3}, less than the {measured:.3} that field \
         {best} shows: they are no better than those that made it",
        correction.predicted
    );
    let finding = Finding::caution("correction-no-better", words)
        .value("predicted", correction.predicted)
        .value("measured", measured);
    Some(finding.help(
        "play them to measure another field, from which more is learned; until then the weights of \
         that field serve more",
    ))
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
