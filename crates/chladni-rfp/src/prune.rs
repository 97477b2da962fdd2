//! Which poles the data can tell from noise (theory.md, eq. 8).

use crate::refine::{refine, Projection, Refined};
use crate::tolerances as tol;
use crate::work::Work;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Rise of the sum of squares, in units of σ², that one more pole over r columns must bring: the tail of χ² with K looks.
pub(crate) fn threshold(columns: usize, lines: usize) -> f64 {
    let r = columns as f64;
    let looks = (4.0 * lines as f64).ln();
    r + tol::SIGNIFICANCE * (2.0 * (r * looks).sqrt() + 2.0 * looks)
}

/// A pole that one bad line makes.
pub(crate) fn unphysical(work: &Work, lambda: Complex64) -> bool {
    work.in_band(lambda) && lambda.im < tol::SPIKE_SPACINGS * work.spacing(lambda.re)
}

/// Takes poles out one by one, the least significant first, residues refitted exactly after each, until all that are left
/// matter. Out-of-band poles have to earn their place in the same way.
pub(crate) fn prune(work: &Work, lambda: &[Complex64], powers: &[i32], variance: f64) -> Result<Vec<Complex64>, LinalgError> {
    let limit = threshold(work.columns(), work.lines()) * variance;
    thin_out(work, lambda, powers, |_, _, rise, _| rise < limit)
}

/// The same with a rule of its own: `may_go(kept, q, rise, inflation)` says whether pole q may be taken out of those `kept`,
/// where that makes the sum of squares rise by `rise`; `inflation` is the variance of its residue relative to that of a pole
/// alone. A pole whose rise is not finite always goes.
pub(crate) fn thin_out(
    work: &Work,
    lambda: &[Complex64],
    powers: &[i32],
    may_go: impl Fn(&[usize], usize, f64, f64) -> bool,
) -> Result<Vec<Complex64>, LinalgError> {
    let projection = Projection::new(work, lambda, powers)?;
    let mut inverse = projection.gram_inverse()?;
    let mut coefficients = projection.coefficients()?;
    let alone: Vec<f64> = projection.r.columns().into_iter().map(|column| column.iter().map(|v| v.norm_sqr()).sum()).collect();
    let mut kept: Vec<usize> = (0..lambda.len()).collect();
    loop {
        let weakest = kept
            .iter()
            .map(|&q| (q, coefficients.row(q).iter().map(|v| v.norm_sqr()).sum::<f64>() / inverse[[q, q]].re))
            .filter(|&(q, rise)| !rise.is_finite() || may_go(&kept, q, rise, inverse[[q, q]].re * alone[q]))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((q, _)) = weakest else {
            return Ok(kept.into_iter().map(|q| lambda[q]).collect());
        };
        // exact removal of column q: Schur complement of the inverse Gram
        let pivot = inverse[[q, q]];
        let column = inverse.column(q).to_owned();
        let row = inverse.row(q).to_owned();
        let own = coefficients.row(q).to_owned();
        for i in 0..inverse.nrows() {
            let factor = column[i] / pivot;
            if factor.norm() == 0.0 {
                continue;
            }
            for j in 0..inverse.ncols() {
                inverse[[i, j]] -= factor * row[j];
            }
            coefficients.row_mut(i).zip_mut_with(&own, |v, o| *v -= factor * o);
        }
        kept.retain(|&k| k != q);
    }
}

/// Poles by what the fit loses without them, the least first.
pub(crate) fn weakest_first(rises: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..rises.len()).collect();
    order.sort_by(|&a, &b| rises[a].total_cmp(&rises[b]));
    order
}

/// The fit without pole q, the others roughly refined.
pub(crate) fn without(work: &Work, refined: &Refined, q: usize) -> Result<Refined, LinalgError> {
    let mut fewer = refined.lambda.clone();
    fewer.remove(q);
    refine(work, &fewer, &refined.powers, tol::REFINE_ROUGH, tol::ROUGH_STEP)
}

/// A weak pole that matters only because the others do not stand quite where they should, and the fit without it: once they are free
/// to move, the sum of squares rises by less than `limit`. Those found `needed` are not judged twice.
pub(crate) fn crutch(
    work: &Work,
    refined: &Refined,
    limit: f64,
    may_go: impl Fn(Complex64) -> bool,
    needed: &mut Vec<Complex64>,
) -> Result<Option<(usize, Refined)>, LinalgError> {
    let rises = refined.significance()?;
    for q in weakest_first(&rises).into_iter().take_while(|&q| rises[q] < tol::LEANING * limit) {
        let pole = refined.lambda[q];
        if !may_go(pole) || needed.iter().any(|known| (known - pole).norm() < pole.im) {
            continue;
        }
        let fewer = without(work, refined, q)?;
        if fewer.projection.sse - refined.projection.sse < limit {
            return Ok(Some((q, fewer)));
        }
        needed.push(pole);
    }
    Ok(None)
}
