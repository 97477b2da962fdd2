//! Local tests: what a pole's own neighbourhood would lose without it.

use crate::refine::{refine, Refined};
use crate::tolerances as tol;
use crate::work::{basis, Work};
use chladni_linalg::{matmul, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;

/// Relative rise of the local sum of squares below which a pole is not needed.
pub(crate) const NEEDED: f64 = 0.35;
/// One-column gains above this need no refit to be believed.
const CLEAR: f64 = 4.0;

fn local_sse(residual: &Array2<Complex64>, rows: impl Iterator<Item = usize>) -> f64 {
    rows.map(|k| residual.row(k).iter().map(|v| v.norm_sqr()).sum::<f64>()).sum()
}

/// Local gain of each pole by the exact one-column formula: rise of the sum of squares in its window over that sum, the
/// other poles held. An upper bound of what is left after the others adapt. `without` leaves out the lines nearest to it.
pub(crate) fn one_column_gains(work: &Work, refined: &Refined, without: usize) -> Result<Vec<f64>, LinalgError> {
    let inverse = refined.projection.gram_inverse()?;
    let a = basis(work, &refined.lambda, &refined.powers);
    let outside = matmul(a.view(), inverse.view());
    Ok((0..refined.lambda.len())
        .map(|q| {
            let pole = refined.lambda[q];
            let window = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
            let mut near: Vec<usize> = window.clone().collect();
            near.sort_by(|&i, &j| (work.x[i] - pole.re).abs().total_cmp(&(work.x[j] - pole.re).abs()));
            let skipped = &near[..without.min(near.len())];
            let rows = || window.clone().filter(|k| !skipped.contains(k));
            let own = refined.coefficients.row(q);
            let pivot = inverse[[q, q]];
            let (mut with, mut removed) = (0.0, 0.0);
            for k in rows() {
                let column = outside[[k, q]] / pivot;
                for (e, x) in refined.projection.residual.row(k).iter().zip(own) {
                    with += e.norm_sqr();
                    removed += (e + column * x).norm_sqr();
                }
            }
            if with > 0.0 {
                (removed - with) / with
            } else {
                f64::MAX
            }
        })
        .collect())
}

/// Removes, one at a time, poles whose neighbourhood does not need them (`candidate(q)` says which may go). Returns the gain
/// of each pole that stays.
pub(crate) fn remove_unneeded(
    work: &Work,
    refined: &mut Refined,
    keep: &mut Vec<usize>,
    protected: &dyn Fn(usize) -> bool,
) -> Result<Vec<f64>, LinalgError> {
    loop {
        let mut gains = one_column_gains(work, refined, 0)?;
        let mut order: Vec<usize> = (0..gains.len()).filter(|&q| !protected(keep[q])).collect();
        order.sort_by(|&a, &b| gains[a].total_cmp(&gains[b]));
        let mut removed = false;
        for q in order {
            if gains[q] > CLEAR {
                break;
            }
            let mut fewer = refined.lambda.clone();
            let pole = fewer.remove(q);
            let without = refine(work, &fewer, &refined.powers, tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
            let window = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
            let with = local_sse(&refined.projection.residual, window.clone());
            let gain = (local_sse(&without.projection.residual, window) - with) / with.max(1e-300);
            gains[q] = gain;
            if gain < NEEDED {
                *refined = without;
                keep.remove(q);
                removed = true;
                break;
            }
        }
        if !removed {
            return Ok(gains);
        }
    }
}

/// Tries one pole at `start`; keeps it where its neighbourhood gains enough from it.
pub(crate) fn try_add(work: &Work, refined: &mut Refined, start: Complex64) -> Result<bool, LinalgError> {
    let mut more = refined.lambda.clone();
    more.push(start);
    let with = refine(work, &more, &refined.powers, 2 * tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
    let pole = *with.lambda.last().expect("one was added");
    if !work.in_band(pole) {
        return Ok(false);
    }
    let window = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
    let after = local_sse(&with.projection.residual, window.clone());
    let gain = (local_sse(&refined.projection.residual, window) - after) / after.max(1e-300);
    if gain >= NEEDED {
        *refined = with;
    }
    Ok(gain >= NEEDED)
}
