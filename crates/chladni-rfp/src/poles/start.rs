//! The start of a search: the size of a pool of poles, and its poles that noise cannot make.

use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::law::start_of;
use crate::data::columns::Columns;
use crate::poles::limits;
use crate::poles::noise_variance::noise_variance;
use crate::poles::pool::{starts, vector_fit, StepBasis};
use crate::poles::prune::pruned;
use crate::poles::rank::visible_rank;
use crate::poles::refine::{removable, Refined};
use crate::poles::removal::Removable;
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Poles of a pool that noise alone cannot make, roughly refined.
pub(crate) struct Start {
    pub refined: Refined,
    /// Noise variance of the sketch, from the residual of the whole pool.
    pub variance: f64,
}

/// Finds the poles of a pool: `iterations` of vector fitting with `size` poles on mixtures, then
/// pruning and rough refinement on the sketch.
pub(crate) fn started(
    sketch: &Columns,
    mixed: &Columns,
    seeds: &[Complex64],
    size: usize,
    iterations: usize,
) -> Result<Start, LinalgError> {
    let pool = vector_fit(
        mixed,
        &starts(sketch, seeds, size),
        &RESIDUAL_POWERS,
        iterations,
        StepBasis::PartialFractions,
    )?;
    let lowest_x = limits::FAR_BELOW * sketch.range().0;
    let in_band = |pole| sketch.in_band(pole);
    let stable_start = |(pole, flipped): (&Complex64, &bool)| {
        start_of(sketch.law, *pole, *flipped, in_band, lowest_x)
    };
    let stable: Vec<Complex64> = pool
        .lambda
        .iter()
        .zip(&pool.flipped)
        .filter_map(stable_start)
        .collect();
    let all = removable(sketch, &stable, &RESIDUAL_POWERS)?;
    let variance = pool_variance(sketch, &all);
    Ok(Start {
        refined: pruned(sketch, mixed, all, &stable, &RESIDUAL_POWERS, variance)?,
        variance,
    })
}

/// Number of poles of a pool.
///
/// * `seeds`: number of visible peaks
/// * `asked`: number of modes, if it is fixed
pub(crate) fn pool_size(
    work: &Columns,
    seeds: usize,
    asked: Option<usize>,
) -> Result<usize, LinalgError> {
    let (rank, floor_seen) = visible_rank(work)?;
    let (part, whole) = limits::POOL_OVER_RANK;
    let wanted = match asked {
        Some(modes) => modes + limits::SPARE_ASKED,
        None if floor_seen => (part * rank.max(seeds)) / whole + limits::SPARE_SEEN,
        None => ((part * rank) / whole).max(2 * seeds) + limits::SPARE_UNSEEN,
    };
    Ok(wanted.min(work.lines() / limits::LINES_PER_POLE).max(1))
}

/// Noise variance of the sketch from the over-fitted pool.
pub(crate) fn pool_variance(work: &Columns, pool: &Removable) -> f64 {
    let size = (work.lines(), work.columns());
    // a sketch of exact data leaves rounding alone
    let floor = tol::VARIANCE_LEAST * work.energy() / (work.lines() * work.columns()) as f64;
    noise_variance(pool.sse, size, pool.unknowns(), floor)
}
