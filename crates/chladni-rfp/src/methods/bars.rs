//! From the poles of one method of the family to a model: damping law, error bars, residues
//! of every FRF, grades.
//!
//! A method other than maximum likelihood has a bias that its own scatter does not show. The
//! bars here hold two parts (theory.md, eq. 43): the scatter of an efficient estimator at this
//! residual, and the first steps of [`crate::poles::refine`] from the method's poles. These
//! steps are not taken.

use super::limits::{METHOD_ERROR_MOST, SAME_POLE};
use crate::damping::bars::UncertainPole;
use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::places::{lambda_of_s, s_of_structural};
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::grade::Grade;
use crate::data::information::covariance;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::data::watch::Watch;
use crate::methods::found::{Finder, MethodPoles, Stabilization};
use crate::methods::selection::{rises, variance_left};
use crate::methods::survey::{Compressed, Survey};
use crate::model::build::Shaped;
use crate::model::decide::note_law;
use crate::model::identified::{Identified, LawOpen};
use crate::poles::estimate;
use crate::poles::limits::UNCERTAIN;
use crate::poles::pole::Pole;
use crate::poles::refine::{refine, Projection, Refined};
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_frf::{Damping, Finding, ModalModel, Reason, Trust};
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use std::iter::zip;

/// The model of poles by `method`, residues of every FRF by least squares at these poles;
/// poles by order where the method looks at several.
///
/// # Errors
/// Those of the method; fewer lines than the poles need.
pub(crate) fn fit_by_method(
    data: &Screened,
    options: &FitOptions,
    method: Finder,
    watch: &Watch,
) -> Result<(ModalModel, Option<Stabilization>), FitError> {
    watch.stage("sketch")?;
    let survey = Survey::new(data, options.seed);
    watch.stage("compression")?;
    let columns = survey.compress()?;
    watch.stage("poles")?;
    let mut found = method(&survey, &columns, options)?;
    watch.stage("residues")?;
    let mut how = String::from("no maximum-likelihood step");
    if data.leakage.is_some() {
        off_window(&columns.work, &mut found)?;
        how = "then maximum likelihood with the line shape of the window".into();
    }
    merge_equal(&mut found);
    let (lines, modes) = (data.lines.len(), found.poles.len());
    let needed = modes + RESIDUAL_POWERS.len() + 1;
    if lines < needed {
        let [low_hz, high_hz] = data.band_hz;
        return Err(FitError::TooFewLines {
            lines,
            low_hz,
            high_hz,
            modes,
            needed,
        });
    }
    let law = columns.work.law;
    let of_law: Vec<Complex64> = found.poles.iter().map(|&s| lambda_of_s(law, s)).collect();
    let beyond_noise = beyond_noise(&survey, law, &of_law)?;
    // poles of noise would lengthen the search of both laws and tell nothing
    let telling: Vec<Complex64> = zip(&of_law, &beyond_noise)
        .filter_map(|(&pole, &beyond)| beyond.then_some(pole))
        .collect();
    let verdict = columns.law_verdict(data, &telling, options)?;
    let damping = options.damping.or(verdict.law()).unwrap_or(found.law);
    let (poles, variance) = graded(&survey, &columns, &found, damping)?;
    let mut identified = Identified {
        damping,
        poles,
        powers: RESIDUAL_POWERS.to_vec(),
        work: columns.work.in_law(damping),
        back: columns.back,
        variance,
        path: format!("{}: {}, {how}", options.method, found.how),
        warnings: found.warnings,
        consistent: true,
        real_shapes: false,
        law_open: LawOpen::No,
        fitted: true,
        residual_is_noise: true,
    };
    let on_law = note_law(&mut identified, data, verdict, options, false);
    identified.warnings.extend(on_law);
    let shaped = Shaped::new(data, identified, options.most_modes())?;
    let residual_energy = shaped.residual_energy(data);
    let mut model = shaped.model(data, options, &residual_energy)?;
    let unexplained = model.quality.relative_error;
    if unexplained > METHOD_ERROR_MOST {
        model.quality.trusted = false;
        let finding = method_failed(unexplained);
        model.quality.findings.push(finding);
    }
    Ok((model, found.stabilization))
}

/// The finding of a method that misses more of the data than one that works does.
fn method_failed(relative_error: f64) -> Finding {
    let words = format!(
        "{:.0} % of the data are left unexplained: modes are missing or wrong",
        100.0 * relative_error
    );
    Finding::fault("mostly-unexplained", words)
        .value("relative_error", relative_error)
        .help("use the method auto, or fit a narrower band")
}

/// Takes poles of pure resonances to those of the lines that a window broadens: no method
/// but maximum likelihood has its line shape.
fn off_window(work: &Columns, found: &mut MethodPoles) -> Result<(), LinalgError> {
    let lambda: Vec<Complex64> = found
        .poles
        .iter()
        .map(|&s| lambda_of_s(Damping::Structural, s))
        .collect();
    let refined = refine(work, &lambda, &RESIDUAL_POWERS, tol::FINE)?;
    let poles = refined.lambda.iter().copied().map(s_of_structural);
    found.poles = poles.collect();
    Ok(())
}

/// Drops poles that stand on another one.
fn merge_equal(found: &mut MethodPoles) {
    let same = |a: Complex64, b: Complex64| (a - b).norm() < SAME_POLE * a.re.abs().min(b.re.abs());
    let kept: Vec<usize> = (0..found.poles.len())
        .filter(|&n| {
            !found.poles[..n]
                .iter()
                .any(|other| same(*other, found.poles[n]))
        })
        .collect();
    if let Some(deviation) = &mut found.deviation {
        *deviation = kept.iter().map(|&n| deviation[n]).collect();
    }
    found.poles = kept.iter().map(|&n| found.poles[n]).collect();
}

/// For each pole of the plane of `law`: whether it explains more of the data than noise would.
/// Poles at or below 0 Hz are background, which is not judged.
fn beyond_noise(
    survey: &Survey,
    law: Damping,
    lambda: &[Complex64],
) -> Result<Vec<bool>, LinalgError> {
    let sketch = &survey.sketch.clone().in_law(law);
    let rises = rises(sketch, lambda)?;
    let limit = threshold(sketch.columns(), sketch.lines()) * variance_left(sketch, lambda)?;
    let beyond = |(pole, &rise): (&Complex64, &f64)| !(rise < limit && pole.re > 0.0);
    Ok(zip(lambda, &rises).map(beyond).collect())
}

/// Poles with bars and grades, and the noise variance of one value that they leave.
fn graded(
    survey: &Survey,
    columns: &Compressed,
    found: &MethodPoles,
    damping: Damping,
) -> Result<(Vec<Pole>, f64), LinalgError> {
    let work = &columns.work.clone().in_law(damping);
    let lambda: Vec<Complex64> = found
        .poles
        .iter()
        .map(|&s| lambda_of_s(damping, s))
        .collect();
    let sse = Projection::new(work, &lambda, &RESIDUAL_POWERS)?.sse;
    let variance = columns.variance(survey.data, sse, lambda.len() + RESIDUAL_POWERS.len());
    let ahead = refine(
        work,
        &lambda,
        &RESIDUAL_POWERS,
        tol::ROUGH.within(tol::STEPS_AHEAD),
    )?;
    let spread = spread(work, &ahead, &lambda, variance);
    let beyond_noise = beyond_noise(survey, damping, &lambda)?;
    let poles = (0..lambda.len())
        .map(|n| {
            let pole = UncertainPole::alike(damping, found.poles[n], lambda[n], spread[n]);
            let mut pole = Pole::new(pole, Grade::SURE);
            if let Some(own) = &found.deviation {
                pole.omega_std = pole.omega_std.max(own[n][0]);
                pole.loss_factor_std = pole.loss_factor_std.max(own[n][1]);
            }
            pole.grade = grade(&pole, beyond_noise[n]);
            pole
        })
        .collect();
    Ok((poles, variance))
}

fn grade(pole: &Pole, beyond_noise: bool) -> Grade {
    let mut reasons = Vec::new();
    let uncertain = 2.0 * pole.omega_std / (pole.omega * pole.loss_factor);
    if uncertain > UNCERTAIN {
        reasons.push(estimate::uncertain(uncertain));
    }
    if !beyond_noise {
        reasons.push(Reason::new(
            "no-gain",
            "explains no more of the data than noise would",
        ));
    }
    Grade {
        trust: match reasons.is_empty() {
            true => Trust::Sure,
            false => Trust::Weak,
        },
        reasons,
    }
}

/// E|δλ|² per pole: the inverse information at this variance, and the square of the way
/// to the likelier pole.
fn spread(work: &Columns, ahead: &Refined, lambda: &[Complex64], variance: f64) -> Vec<f64> {
    let inverse = covariance(ahead.information(work).view());
    let scatter = |n: usize| variance * inverse[[n, n]].re.max(0.0);
    (0..lambda.len())
        .map(|n| scatter(n) + (ahead.lambda[n] - lambda[n]).norm_sqr())
        .collect()
}
