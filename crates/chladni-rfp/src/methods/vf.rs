//! Relaxed vector fitting alone, in the plane x = ω² ([`crate::poles::pool`]).
//!
//! Poles start at the visible peaks and evenly between, move to the zeros of σ eight
//! times, and the residues decide which of them are modes. The equation error is weighted
//! by |σ|², which tends to one as the poles settle: with poles to spare the estimate is
//! nearly unbiased, and its scatter is that of the few mixtures it looks at.
//!
//! Cost: 8·8·N·m²·(r + 2) flop for N lines, m unknowns, r mixtures and eight steps; no
//! pass over the data of its own.
//!
//! Avoid it for the last digit. It stands at two to five times the Cramér–Rao bound, and
//! [`super::lean`] needs only one refinement more to reach it. On a wide band with a
//! linear axis, where low modes are narrower than the line spacing, it misses some.
//!
//! B. Gustavsen, A. Semlyen, IEEE Trans. Power Delivery 14 (1999) 1052; B. Gustavsen,
//! ibid. 21 (2006) 1587 (relaxed).

use super::limits::MIXTURES;
use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::methods::found::MethodPoles;
use crate::methods::selection::modes_of;
use crate::methods::survey::{Compressed, Survey};
use crate::poles::pool::{mixtures, starts, vector_fit, Pool, StepBasis};
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Poles by relaxed vector fitting.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn vf(
    survey: &Survey,
    columns: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    let size = survey.pool_size(survey.expected(columns, options));
    let pool = pool(
        survey,
        &columns.work,
        MIXTURES,
        size,
        options,
        StepBasis::Orthonormal,
    )?;
    Ok(modes_of(
        survey,
        &signed(&pool),
        options,
        "relaxed vector fitting, poles chosen by their residues",
    )?)
}

/// `size` poles by vector fitting on some mixtures of `work`, from the visible peaks.
pub(crate) fn pool(
    survey: &Survey,
    work: &Columns,
    count: usize,
    size: usize,
    options: &FitOptions,
    step_basis: StepBasis,
) -> Result<Pool, LinalgError> {
    let rows = survey.rows();
    let mixed = mixtures(work, count, options.seed);
    let mixed = if rows.len() < mixed.lines() {
        mixed.select(&rows)
    } else {
        mixed
    };
    vector_fit(
        &mixed,
        &starts(&mixed, &survey.seeds(), size),
        &RESIDUAL_POWERS,
        options.effort.pool_iterations,
        step_basis,
    )
}

/// Poles of the pool with the sign of damping that they left with.
pub(crate) fn signed(pool: &Pool) -> Vec<Complex64> {
    pool.lambda
        .iter()
        .zip(&pool.flipped)
        .map(|(pole, flipped)| if *flipped { pole.conj() } else { *pole })
        .collect()
}
