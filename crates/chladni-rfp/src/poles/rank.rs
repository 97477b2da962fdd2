//! Number of directions of the data that stand out of the noise.

use crate::data::columns::Columns;
use crate::poles::limits;
use chladni_linalg::blocked::{blocked_gram, tall_r};
use chladni_linalg::{cholesky, singular_values, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;

/// Number of singular values above the noise; and true if the noise floor is seen.
pub(crate) fn visible_rank(work: &Columns) -> Result<(usize, bool), LinalgError> {
    let values = if work.lines() > work.columns() {
        singular_values(triangle(&work.b)?.view())?
    } else {
        singular_values(work.b.view())?
    };
    Ok(rank_over_noise(&values.to_vec(), work.lines()))
}

/// A small matrix with the singular values of `b`: the Cholesky factor of its Gram matrix if every
/// column stands outside those before it by more than the rounding of these sums. Else it is R, for
/// a Gram matrix squares the condition.
fn triangle(b: &Array2<Complex64>) -> Result<Array2<Complex64>, LinalgError> {
    let gram = blocked_gram(b.view());
    let well_conditioned = |lower: &Array2<Complex64>| {
        let mut pivots = lower.diag().into_iter().zip(gram.diag());
        pivots.all(|(pivot, whole)| pivot.norm_sqr() > limits::GRAM_TELLS_RANK * whole.re)
    };
    match cholesky(gram.view()).ok().filter(well_conditioned) {
        Some(lower) => Ok(lower),
        None => tall_r(b.view()),
    }
}

/// Number of singular values above the noise; and true if the noise floor is seen.
///
/// * `singular_values`: of columns with `lines` lines, falling
pub(crate) fn rank_over_noise(singular_values: &[f64], lines: usize) -> (usize, bool) {
    let count = singular_values.len();
    let (part, whole) = limits::BEFORE_NOISE;
    let tail = &singular_values[count * part / whole..];
    let noise = tail.iter().map(|v| v * v).sum::<f64>() / tail.len().max(1) as f64;
    // the largest singular value of noise alone over the smallest: (1 + √(r/N))/(1 − √(r/N))
    let ratio = (count as f64 / lines as f64).sqrt();
    let limit = limits::RANK_OVER_TAIL * noise.sqrt() * (1.0 + ratio)
        / (1.0 - ratio).abs().max(limits::SQUARE_LEAST);
    let rank = singular_values.iter().filter(|v| **v > limit).count();
    (rank, rank * whole < count * part)
}
