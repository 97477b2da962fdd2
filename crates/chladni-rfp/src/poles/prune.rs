//! Choice of the poles that the data can tell from noise (theory.md, eq. 8).

use crate::data::columns::Columns;
use crate::poles::descent::Descent;
use crate::poles::limits;
use crate::poles::normal::Normal;
use crate::poles::refine::{refine_below, Refined};
use crate::poles::removal::Removable;
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// A pole that one bad line may make.
pub(crate) fn unphysical(work: &Columns, lambda: Complex64) -> bool {
    work.in_band(lambda) && lambda.im < tol::SPIKE_SPACINGS * work.spacing(lambda.re)
}

/// A pole that one bad line makes: far narrower than its line, or narrower and without it
/// the sum of squares over all other lines rises by less than `limit`. A resonance has
/// skirts: on the next line, of the part that its half-width is of the spacing.
pub(crate) fn is_spike(
    work: &Columns,
    refined: &Refined,
    q: usize,
    limit: f64,
) -> Result<bool, LinalgError> {
    let pole = refined.lambda[q];
    if !unphysical(work, pole) {
        return Ok(false);
    }
    let spacing = work.spacing(pole.re);
    if pole.im < limits::NARROWEST * spacing {
        return Ok(true);
    }
    let projection = &refined.projection;
    let outside = projection.outside_of_others(q)?;
    let reach = limits::OWN_LINES * spacing;
    let rise: f64 = (0..work.lines())
        .filter(|&k| (work.x[k] - pole.re).abs() > reach)
        .map(|k| {
            let row = projection.residual.row(k);
            let own = refined.coefficients.row(q);
            row.iter()
                .zip(own)
                .map(|(left, residue)| (left + outside[k] * residue).norm_sqr() - left.norm_sqr())
                .sum::<f64>()
        })
        .sum();
    Ok(rise < limit)
}

/// Takes poles out one by one, the least significant first, residues refitted exactly
/// after each, until all that are left matter. Out-of-band poles have to earn their place
/// in the same way.
///
/// `removable`: of `lambda` and `powers`; `variance`: of the noise.
pub(crate) fn prune(
    work: &Columns,
    removable: Removable,
    lambda: &[Complex64],
    powers: &[i32],
    variance: f64,
) -> Vec<Complex64> {
    let limit = threshold(work.columns(), work.lines()) * variance;
    thinned(
        work,
        &removable.thin_out(lambda, |_, _, rise, _| rise < limit),
        powers,
        limit,
    )
}

/// Prunes again after every few steps of refinement, as long as that takes poles out: fewer
/// poles make the later steps cheaper.
fn thinned(work: &Columns, lambda: &[Complex64], powers: &[i32], limit: f64) -> Vec<Complex64> {
    let mut descent = Descent::new(work, lambda, powers, 0);
    let mut rounds = 0;
    let mut here = None;
    while rounds < limits::THINNING_ROUNDS && !descent.lambda.is_empty() {
        let Some(mut point) = here.take().or_else(|| descent.here::<Normal>()) else {
            break;
        };
        descent.steps = limits::THINNING_STEPS;
        let ended = descent.go(&mut point, tol::ROUGH.tolerance);
        let Ok(removable) = point.plain.removable() else {
            break;
        };
        let kept = removable.thin_out(&descent.lambda, |_, _, rise, _| rise < limit);
        if kept.len() < descent.lambda.len() {
            (descent.lambda, rounds) = (kept, 0);
        } else if ended {
            break;
        } else {
            (here, rounds) = (Some(point), rounds + 1);
        }
    }
    descent.lambda
}

/// Poles by what the fit loses without them, the least first.
fn weakest_first(rises: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rises.len()).collect();
    order.sort_by(|&a, &b| rises[a].total_cmp(&rises[b]));
    order
}

/// A pole that becomes redundant once the other poles are refined again, and the fit without
/// it: the sum of squares rises by less than `limit`. Those found `needed` are not judged
/// twice.
pub(crate) fn redundant_pole(
    work: &Columns,
    refined: &Refined,
    limit: f64,
    may_go: impl Fn(Complex64) -> bool,
    needed: &mut Vec<Complex64>,
) -> Result<Option<(usize, Refined)>, LinalgError> {
    let rises = refined.significance()?;
    for q in weakest_first(&rises)
        .into_iter()
        .take_while(|&q| rises[q] < limits::LEANING * limit)
    {
        let pole = refined.lambda[q];
        if !may_go(pole) || needed.iter().any(|known| (known - pole).norm() < pole.im) {
            continue;
        }
        let mut fewer = refined.lambda.clone();
        fewer.remove(q);
        let most = refined.projection.sse + limit;
        match refine_below(work, &fewer, &refined.powers, tol::ROUGH, most)? {
            Some(fewer) => return Ok(Some((q, fewer))),
            None => needed.push(pole),
        }
    }
    Ok(None)
}
