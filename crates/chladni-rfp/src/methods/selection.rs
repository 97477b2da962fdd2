//! Choice of the poles that are modes, for methods that find them in the plane x: the
//! significance of their residues.

use super::limits::{HELPERS_AT, MOST_INFLATION};
use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::law::RATIONAL;
use crate::damping::places::s_of_structural;
use crate::data::columns::Columns;
use crate::data::options::FitOptions;
use crate::methods::found::negative_damping;
use crate::methods::found::MethodPoles;
use crate::methods::survey::Survey;
use crate::poles::estimate::fewer_modes;
use crate::poles::noise_variance::noise_variance;
use crate::poles::prune::{narrower_than_a_line, redundant_pole, Patience};
use crate::poles::refine::{refine, removable, Projection};
use crate::poles::removal::{rise_without, Removable};
use crate::poles::scan::usual_loss;
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_frf::Finding;
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use std::ops::RangeInclusive;

/// Noise variance that so many poles leave unexplained.
pub(crate) fn variance_left(work: &Columns, lambda: &[Complex64]) -> Result<f64, LinalgError> {
    Ok(left_by(
        work,
        Projection::new(work, lambda, &RESIDUAL_POWERS)?.sse,
        lambda.len() + RESIDUAL_POWERS.len(),
    ))
}

/// The same of a fit with so many unknowns that leaves `sse`.
pub(crate) fn left_by(work: &Columns, sse: f64, unknowns: usize) -> f64 {
    let size = (work.lines(), work.columns());
    // below it rounding begins to look like modes
    let floor = tol::ROUNDING_VARIANCE * work.energy() / (work.lines() * work.columns()) as f64;
    noise_variance(sse, size, unknowns, floor)
}

/// Removes insignificant poles (theory.md, eq. 8), the weakest first, but keeps the number of
/// in-band poles within `modes`. Also returns the noise variance left by all poles.
pub(crate) fn select(
    work: &Columns,
    lambda: &[Complex64],
    modes: RangeInclusive<usize>,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    let all = removable(work, lambda, &RESIDUAL_POWERS)?;
    let variance = left_by(work, all.sse, all.unknowns());
    let limit = threshold(work.columns(), work.lines()) * variance;
    let physical: Vec<Complex64> = lambda
        .iter()
        .copied()
        .filter(|pole| !narrower_than_a_line(work, *pole))
        .collect();
    let all = if physical.len() == lambda.len() {
        all
    } else {
        removable(work, &physical, &RESIDUAL_POWERS)?
    };
    Ok((thin_to(work, all, &physical, modes, limit), variance))
}

/// Removes poles of the fit `all` whose rise is below `least_rise`, the weakest first, but keeps
/// the number of in-band poles within `modes`. Poles whose residue is unknown go in any case.
pub(crate) fn thin_to(
    work: &Columns,
    all: Removable,
    lambda: &[Complex64],
    modes: RangeInclusive<usize>,
    least_rise: f64,
) -> Vec<Complex64> {
    all.thin_out(lambda, |candidate| {
        let rise = candidate.rise;
        let inside = candidate
            .kept
            .iter()
            .filter(|&&k| work.in_band(lambda[k]))
            .count();
        match work.in_band(lambda[candidate.pole]) {
            _ if candidate.inflation > MOST_INFLATION => true,
            true => inside > *modes.end() || (inside > *modes.start() && rise < least_rise),
            false => rise < least_rise,
        }
    })
}

/// Poles beyond both ends of the band for modes that lie there, two mean distances of modes away,
/// unless a pole of `lambda` is within the part `taken` of that distance.
pub(crate) fn poles_beyond_ends(
    work: &Columns,
    lambda: &[Complex64],
    taken: f64,
) -> Vec<Complex64> {
    let (low, high) = work.range();
    let loss = usual_loss(work, lambda);
    let reach = HELPERS_AT * (high - low) / lambda.len().max(1) as f64;
    let is_taken = |x: f64| {
        lambda
            .iter()
            .any(|pole| (pole.re - x).abs() < taken * reach)
    };
    [low - reach, high + reach]
        .into_iter()
        .filter(|x| *x > 0.0 && !is_taken(*x))
        .map(|x| Complex64::new(1.0, loss) * x)
        .collect()
}

/// The poles as the method found them, without those of the band that become redundant once
/// the others are refined.
fn without_redundant_poles(
    work: &Columns,
    mut lambda: Vec<Complex64>,
    variance: f64,
) -> Result<Vec<Complex64>, LinalgError> {
    let limit = threshold(work.columns(), work.lines()) * variance;
    let mut needed = Vec::new();
    loop {
        let moved = refine(work, &lambda, &RESIDUAL_POWERS, tol::ROUGH)?;
        let may_go = |pole| work.in_band(pole);
        let patience = Patience::SHORT;
        match redundant_pole(work, &moved, limit, may_go, &mut needed, patience)? {
            Some((q, _)) => lambda.remove(q),
            None => return Ok(lambda),
        };
    }
}

/// So many modes are wanted: all that matter where no number was given.
pub(crate) fn wanted(options: &FitOptions) -> RangeInclusive<usize> {
    options.modes.map_or(0..=usize::MAX, |modes| modes..=modes)
}

/// Modes among the poles of a method: stable, significant, as many as asked for. The
/// sketch decides: the compressed columns were chosen by the data themselves, so that
/// noise weighs more in them than its variance says.
///
/// * `lambda`: poles in x = ω²/ω_max², either sign of Im λ
/// * `how`: the method, in words
pub(crate) fn modes_of(
    survey: &Survey,
    lambda: &[Complex64],
    options: &FitOptions,
    how: &'static str,
) -> Result<MethodPoles, LinalgError> {
    let work = &survey.sketch;
    let (stable, unstable): (Vec<Complex64>, Vec<Complex64>) =
        lambda.iter().partition(|pole| pole.im > 0.0);
    let (mut chosen, variance) = select(work, &stable, wanted(options))?;
    if options.modes.is_none() {
        chosen = without_redundant_poles(work, chosen, variance)?;
    }
    let mut warnings = Vec::new();
    let (turning, all) = (
        inside(work, &unstable),
        inside(work, &unstable) + inside(work, &stable),
    );
    if 2 * turning > all {
        warnings.push(negative_damping("", turning, all));
    }
    warnings.extend(fewer(options, inside(work, &chosen)));
    Ok(MethodPoles {
        poles: chosen.into_iter().map(s_of_structural).collect(),
        deviation: None,
        law: RATIONAL,
        warnings,
        how,
        stabilization: None,
    })
}

/// Poles in the band.
pub(crate) fn inside(work: &Columns, lambda: &[Complex64]) -> usize {
    lambda.iter().filter(|pole| work.in_band(**pole)).count()
}

/// Fewer modes than asked for, in words.
pub(crate) fn fewer(options: &FitOptions, found: usize) -> Option<Finding> {
    options
        .modes
        .filter(|asked| *asked > found)
        .map(|asked| fewer_modes(asked, found, ""))
}

/// Rise of the sum of squares without each of the poles (theory.md, eq. 8).
pub(crate) fn rises(work: &Columns, lambda: &[Complex64]) -> Result<Vec<f64>, LinalgError> {
    let projection = Projection::new(work, lambda, &RESIDUAL_POWERS)?;
    let (coefficients, inverse) = (projection.coefficients()?, projection.gram_inverse()?);
    let rises = (0..lambda.len()).map(|n| rise_without(n, &inverse, &coefficients));
    Ok(rises.collect())
}
