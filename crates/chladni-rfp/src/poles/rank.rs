//! How many directions of the data stand out of the noise.

use crate::data::columns::Columns;
use crate::poles::limits;
use chladni_linalg::blocked::tall_r;
use chladni_linalg::{singular_values, LinalgError};

/// Number of singular values above the noise, and whether the noise floor was seen at
/// all.
pub(crate) fn visible_rank(work: &Columns) -> Result<(usize, bool), LinalgError> {
    // eigenvalues of the small Gram would square the condition; a thin QR first keeps the
    // SVD small
    let r = if work.lines() > work.columns() {
        tall_r(work.b.view())?
    } else {
        work.b.clone()
    };
    Ok(rank_over_noise(
        &singular_values(r.view())?.to_vec(),
        work.lines(),
    ))
}

/// The same of falling singular values of columns with `lines` lines.
pub(crate) fn rank_over_noise(singular_values: &[f64], lines: usize) -> (usize, bool) {
    let count = singular_values.len();
    let (part, whole) = limits::BEFORE_NOISE;
    let tail = &singular_values[count * part / whole..];
    let noise = tail.iter().map(|v| v * v).sum::<f64>() / tail.len().max(1) as f64;
    // the largest singular value of noise alone is (1 + √(r/N)) times the typical one
    let ratio = (count as f64 / lines as f64).sqrt();
    let limit = limits::RANK_OVER_TAIL * noise.sqrt() * (1.0 + ratio)
        / (1.0 - ratio).abs().max(limits::SQUARE_LEAST);
    let rank = singular_values.iter().filter(|v| **v > limit).count();
    (rank, rank * whole < count * part)
}
