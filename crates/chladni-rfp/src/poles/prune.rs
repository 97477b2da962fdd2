//! Choice of the poles that the data can tell from noise (theory.md, eq. 8).

use crate::data::columns::Columns;
use crate::poles::descent::{Descent, SearchData};
use crate::poles::limits;
use crate::poles::normal::NormalPoint;
use crate::poles::refine::{on_orthonormal_basis, refine_below, refined_poles, Refined};
use crate::poles::removal::Removable;
use crate::poles::significance::threshold;
use crate::tolerances::{self as tol, Precision};
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// True for an in-band pole that is narrower than a fifth of the line spacing: one bad line may
/// have made it.
pub(crate) fn narrower_than_a_line(work: &Columns, lambda: Complex64) -> bool {
    work.in_band(lambda) && lambda.im < tol::SPIKE_SPACINGS * work.spacing(lambda.re)
}

/// True for a pole that stands for one bad line. Its half-bandwidth is far below the line spacing;
/// or it is narrow, and the sum of squares over the other lines rises by less than `least_rise`
/// without it. A resonance has skirts there: at the next line, half-bandwidth over spacing of its
/// peak.
pub(crate) fn is_one_bad_line(
    work: &Columns,
    refined: &Refined,
    q: usize,
    least_rise: f64,
) -> Result<bool, LinalgError> {
    let pole = refined.lambda[q];
    if !narrower_than_a_line(work, pole) {
        return Ok(false);
    }
    let spacing = work.spacing(pole.re);
    if pole.im < limits::NARROWEST * spacing {
        return Ok(true);
    }
    let projection = &refined.projection;
    let outside = projection.outside_of_others(q)?;
    let residues = refined.coefficients.row(q);
    let reach = limits::OWN_LINES * spacing;
    let rise: f64 = (0..work.lines())
        .filter(|&k| (work.x[k] - pole.re).abs() > reach)
        .map(|k| {
            let row = projection.residual.row(k);
            row.iter()
                .zip(residues)
                .map(|(value, residue)| {
                    (value + outside[k] * residue).norm_sqr() - value.norm_sqr()
                })
                .sum::<f64>()
        })
        .sum();
    Ok(rise < least_rise)
}

/// Takes poles out one by one, the least significant first, residues refitted exactly
/// after each, until all that are left are significant; these are roughly refined. The same holds
/// for out-of-band poles.
///
/// * `mixed`: a few mixtures of the columns, on which the poles are refined in between
/// * `removable`: the fit with `lambda` and `powers`
/// * `variance`: of the noise
///
/// # Errors
/// A kernel that fails.
pub(crate) fn pruned(
    work: &Columns,
    mixed: &Columns,
    removable: Removable,
    lambda: &[Complex64],
    powers: &[i32],
    variance: f64,
) -> Result<Refined, LinalgError> {
    let least_rise = threshold(work.columns(), work.lines()) * variance;
    let significant = removable.thin_out(lambda, |candidate| candidate.rise < least_rise);
    // a pole of noise follows the noise of few mixtures, and then explains less of all columns
    let moved = match mixed.columns() < work.columns() {
        true => refined_poles(mixed, &significant, powers, tol::ROUGH).unwrap_or(significant),
        false => significant,
    };
    let data = SearchData::new(work, powers);
    let mut descent = Descent::new(&data, &moved, 0);
    let point = thinned(&mut descent, least_rise);
    if !descent.lambda.is_empty() {
        descent.steps = tol::ROUGH.steps;
    }
    let end = point.and_then(|(mut point, ended)| {
        (ended || descent.ends(&mut point, tol::ROUGH.tolerance)).then_some(point)
    });
    on_orthonormal_basis(descent, end, tol::ROUGH)
}

/// Thins poles out before and after every few steps, as long as that takes some out: fewer poles
/// make the later steps cheaper. Returns the last point, and true if the search has ended there;
/// `None` where normal equations do not serve.
fn thinned(descent: &mut Descent, least_rise: f64) -> Option<(NormalPoint, bool)> {
    let (mut rounds_in_vain, mut ended) = (0, false);
    let mut point = descent.point::<NormalPoint>()?;
    loop {
        let removable = point.fit.removable().ok()?;
        let kept = removable.thin_out(&descent.lambda, |candidate| candidate.rise < least_rise);
        if kept.len() < descent.lambda.len() {
            (descent.lambda, rounds_in_vain, ended) = (kept, 0, false);
            point = descent.point()?;
        } else if ended || rounds_in_vain == limits::THINNING_ROUNDS {
            return Some((point, ended));
        } else {
            descent.steps = limits::THINNING_STEPS;
            ended = descent.run(&mut point, tol::ROUGH.tolerance);
            rounds_in_vain += 1;
        }
    }
}

/// Indices of poles by the rise of the sum of squares without them, the least first.
fn weakest_first(rises: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rises.len()).collect();
    order.sort_by(|&a, &b| rises[a].total_cmp(&rises[b]));
    order
}

/// The trouble taken to find that a pole is redundant.
#[derive(Clone, Copy)]
pub(crate) struct Patience {
    /// Poles are tried whose rise of the sum of squares, before the others are refined again, is
    /// below this, in units of the least rise.
    leaning: f64,
    /// Of the refinement of the others.
    precision: Precision,
}

impl Patience {
    /// Enough for poles that lean on a neighbour.
    pub const SHORT: Self = Self {
        leaning: limits::LEANING,
        precision: tol::ROUGH,
    };
    /// Enough for all others to find their places, too.
    pub const LONG: Self = Self {
        leaning: f64::INFINITY,
        precision: Precision {
            tolerance: tol::ROUGH.tolerance,
            ..tol::FINE
        },
    };
}

/// A pole that becomes redundant once the others are refined again, and the fit without it: the
/// sum of squares rises by less than `least_rise`. Poles found to be `needed` are noted there, and
/// not judged twice.
pub(crate) fn redundant_pole(
    work: &Columns,
    refined: &Refined,
    least_rise: f64,
    may_go: impl Fn(Complex64) -> bool,
    needed: &mut Vec<Complex64>,
    patience: Patience,
) -> Result<Option<(usize, Refined)>, LinalgError> {
    let rises = refined.significance()?;
    for q in weakest_first(&rises)
        .into_iter()
        .take_while(|&q| rises[q] < patience.leaning * least_rise)
    {
        let pole = refined.lambda[q];
        if !may_go(pole) || needed.iter().any(|known| (known - pole).norm() < pole.im) {
            continue;
        }
        let mut fewer = refined.lambda.clone();
        fewer.remove(q);
        let sse_limit = refined.projection.sse + least_rise;
        match refine_below(work, &fewer, &refined.powers, patience.precision, sse_limit)? {
            Some(fewer) => return Ok(Some((q, fewer))),
            None => needed.push(pole),
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::basis::RESIDUAL_POWERS;
    use crate::poles::refine::tests::two_resonances;
    use crate::poles::refine::{refine, removable};

    /// Two poles on each other are none for normal equations.
    #[test]
    fn poles_are_refined_where_normal_equations_do_not_serve() {
        let poles = [Complex64::new(0.3, 0.01), Complex64::new(0.6, 0.02)];
        let work = two_resonances(poles, 1e-3);
        let off = poles[0] + 0.8 * poles[0].im;
        let start = [off, off + 1e-9, poles[1] + 0.5 * poles[1].im];
        let powers = &RESIDUAL_POWERS;
        let all = removable(&work, &start, powers).unwrap();
        let found = pruned(&work, &work, all, &start, powers, 1e-6).unwrap();
        let expected = refine(&work, &start, powers, tol::ROUGH).unwrap();
        let (sse, expected) = (found.projection.sse, expected.projection.sse);
        assert!(sse < 1.1 * expected, "{sse}, not {expected}");
    }
}
