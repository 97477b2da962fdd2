//! The fast chain: sketch, pool, prune, refine, project, refine, and the loop that settles the order.
//!
//! What counts as a mode here is what white noise cannot make; whether the residual *is* white is judged at the end
//! ([`crate::whiteness`]), and where it is not the measured-data path takes over.

use crate::faults::outliers::single_lines;
use crate::first_look::first_look;
use crate::pool::{mixtures, starts, vector_fit};
use crate::project::{energies, project, Projected};
use crate::prune::{crutch, prune, threshold, unphysical, weakest_first, without};
use crate::refine::{refine, Projection, Refined};
use crate::scan::{residual_peak, scan};
use crate::screen::Screened;
use crate::seeds::{fourth_difference_noise, peaks, thinned};
use crate::tolerances as tol;
use crate::whiteness::{judge, judge_columns, Whiteness};
use crate::wide::projected;
use crate::work::{basis, line_energy, Work};
use chladni_linalg::{qr_thin, svd_thin, LinalgError};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// Powers of x of the residual terms: one lower (1/ω²), three upper (constant, ω², ω⁴).
pub(crate) const POWERS: [i32; 4] = [-1, 0, 1, 2];

/// What the fast chain came to.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// The residual is white: poles at the statistical limit.
    White(Box<Chain>),
    /// It is not; the evidence in words.
    NotWhite(String),
    /// It is not, and single lines that no neighbour supports are to blame.
    Outliers(Vec<usize>),
    /// The conjugate of the data is explained far better: they follow e^{−jωt}.
    Conjugated,
}

/// What the fast chain found.
#[derive(Debug)]
pub(crate) struct Chain {
    /// Refined on the compressed columns of all FRFs.
    pub refined: Refined,
    /// Compressed data and the way back to FRFs.
    pub projected: Projected,
    /// Noise variance of one work value.
    pub variance: f64,
    /// Whether the residual is white.
    pub whiteness: Whiteness,
    /// What was tried: (poles, residual variance), in order.
    pub history: Vec<(usize, f64)>,
}

/// Number of singular values above the noise, and whether the noise floor was seen at all.
fn visible_rank(work: &Work) -> Result<(usize, bool), LinalgError> {
    // eigenvalues of the small Gram would square the condition; a thin QR first keeps the SVD small
    let r = if work.lines() > work.columns() { chladni_linalg::qr_r(work.b.view())? } else { work.b.clone() };
    Ok(rank_over_noise(&svd_thin(r.view())?.1.to_vec(), work.lines()))
}

/// The same of falling singular values of columns with `lines` lines.
pub(crate) fn rank_over_noise(singular_values: &[f64], lines: usize) -> (usize, bool) {
    let count = singular_values.len();
    let tail = &singular_values[count * 3 / 4..];
    let noise = tail.iter().map(|v| v * v).sum::<f64>() / tail.len().max(1) as f64;
    // the largest singular value of noise alone is (1 + √(r/N)) times the typical one; 1.6 covers the tail's own bias
    let ratio = (count as f64 / lines as f64).sqrt();
    let limit = 1.6 * noise.sqrt() * (1.0 + ratio) / (1.0 - ratio).abs().max(0.2);
    let rank = singular_values.iter().filter(|v| **v > limit).count();
    (rank, rank * 4 < count * 3)
}

/// Starting order of the pool.
pub(crate) fn pool_size(work: &Work, seeds: usize, asked: Option<usize>) -> Result<usize, LinalgError> {
    let (rank, floor_seen) = visible_rank(work)?;
    let wanted = match asked {
        Some(modes) => modes + 6,
        None if floor_seen => (13 * rank.max(seeds)) / 10 + 6,
        None => ((13 * rank) / 10).max(2 * seeds) + 8,
    };
    Ok(wanted.min(work.lines() / 3).max(1))
}

/// Runs the chain. `asked` fixes the number of in-band modes.
pub(crate) fn fast_chain(data: &Screened, seed: u64, asked: Option<usize>, progress: &dyn Fn(&str)) -> Result<Outcome, LinalgError> {
    progress("sketch");
    let hz = data.omega_max / std::f64::consts::TAU;
    let (sketch, energy) = data.sketch(seed);
    let noise = fourth_difference_noise(&sketch.b, 40);
    let peaks = peaks(&sketch, &line_energy(&sketch.b), &noise);
    let seeds: Vec<Complex64> = peaks.iter().map(|p| p.lambda).collect();

    progress("pole pool");
    let size = pool_size(&sketch, seeds.len(), asked)?;
    let rows = thinned(&sketch, &peaks);
    let sketch = if rows.len() < sketch.lines() { sketch.select(&rows) } else { sketch };
    if let Some(evidence) = first_look(&sketch, &peaks, seed, hz)? {
        return Ok(Outcome::NotWhite(evidence));
    }
    let mixed = mixtures(&sketch, tol::POOL_MIXTURES, seed);
    let mut start = started(&sketch, &mixed, &seeds, size)?;
    let look = |refined: &Refined| judge_columns(&sketch, &refined.lambda, &refined.projection.residual, hz);
    let spoilt = spoilt_lines(&sketch, &start.refined)?;
    if !spoilt.is_empty() {
        return Ok(Outcome::Outliers(spoilt.into_iter().map(|row| rows[row]).collect()));
    }
    // a missing mode leaves its mark in one place and in the shape of the residual; misfit around most modes, or misfit without
    // shape, is no question of order
    let mut first = look(&start.refined);
    if first.misfit_share > tol::MISFIT_SHARE && asked.is_none() {
        // unless a larger pool takes it away: many modes hide behind few peaks, or few FRFs
        let larger = started(&sketch, &mixed, &seeds, (2 * size).min(sketch.lines() / 3))?;
        if larger.variance < tol::LARGER_POOL_GAIN * start.variance {
            start = larger;
            first = look(&start.refined);
        }
    }
    let Start { mut refined, mut variance } = start;
    let mut history = vec![(refined.lambda.len(), refined.variance(&sketch))];
    if first.misfit_share > tol::MISFIT_SHARE || refined.lambda.is_empty() {
        if conjugate_fits_better(&mixed, &seeds, size)? {
            return Ok(Outcome::Conjugated);
        }
        if first.misfit_share > tol::MISFIT_SHARE {
            return Ok(Outcome::NotWhite(first.evidence));
        }
    }
    if first.shapeless {
        return Ok(Outcome::NotWhite(first.evidence));
    }
    settle(&sketch, &mut refined, &mut variance, sketch.columns(), &mut history)?;
    let settled = look(&refined);
    if settled.shapeless {
        return Ok(Outcome::NotWhite(settled.evidence));
    }

    progress("projection");
    // what the second pass keeps depends on these poles: converged, they are the same to the last digits however they were found
    refined = refine(&sketch, &refined.lambda, &POWERS, tol::REFINE_FINE, tol::FINE_STEP)?;
    let mut projected = project_all(data, &refined, &energy)?;
    let frfs = data.pairs.len();
    let mut tried = Vec::new();
    for extra_passes in 0.. {
        let work = &projected.work;
        let mut fine = refine(work, &refined.lambda, &POWERS, tol::REFINE_FINE, tol::FINE_STEP)?;
        let projected_poles = fine.lambda.len();
        let mut sigma2 = full_variance(data, &projected, &fine);
        settle(work, &mut fine, &mut sigma2, frfs, &mut history)?;
        refined = refine(work, &fine.lambda, &POWERS, tol::REFINE_FINE, tol::FINE_STEP)?;
        variance = full_variance(data, &projected, &refined);
        if extra_passes == tol::EXTRA_PASSES || asked.is_some() {
            break;
        }
        // a mode that the sketch did not show stands out of the residual over all FRFs, or out of the compressed columns
        let missed = match residual_peak(work, &projected.line_noise(&refined.projection), frfs, &refined.lambda) {
            None if work.columns() < frfs => {
                let places = scan(work, &refined, threshold(work.columns(), work.lines()) * variance, &tried);
                confirmed(data, work, &refined, variance, &places[..places.len().min(tol::PLACES)])
            }
            peak => peak,
        };
        if let Some(pole) = missed {
            tried.push(pole);
            let mut more = refined.lambda.clone();
            more.push(pole);
            refined = refine(&sketch, &more, &POWERS, tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
        } else if refined.lambda.len() >= projected_poles || work.columns() == frfs {
            break;
        }
        // columns compressed with poles that are gone would keep their noise
        projected = project_all(data, &refined, &energy)?;
    }
    if let Some(modes) = asked {
        keep_strongest(&projected.work, &mut refined, modes)?;
    }
    let line_residual = projected.line_residual(&refined.projection.residual);
    let whiteness = judge(&projected.work, &refined.lambda, &line_residual, frfs, &refined.projection.residual, hz);
    if !whiteness.white {
        let left = line_residual.to_vec();
        let fitted: Vec<f64> = energy.iter().zip(&left).map(|(all, left)| (all - left).max(0.0)).collect();
        let outliers = single_lines(&left, &fitted);
        return Ok(if outliers.is_empty() { Outcome::NotWhite(whiteness.evidence) } else { Outcome::Outliers(outliers) });
    }
    Ok(Outcome::White(Box::new(Chain { refined, projected, variance, whiteness, history })))
}

/// Poles of a pool that noise alone cannot make, roughly refined.
pub(crate) struct Start {
    pub refined: Refined,
    /// Noise variance of the sketch as the whole pool leaves it.
    pub variance: f64,
}

/// Vector fitting with `size` poles on mixtures, pruning and rough refinement on the sketch.
pub(crate) fn started(sketch: &Work, mixed: &Work, seeds: &[Complex64], size: usize) -> Result<Start, LinalgError> {
    let pool = vector_fit(mixed, &starts(sketch, seeds, size), &POWERS, tol::POOL_ITERATIONS)?;
    let stable: Vec<Complex64> = pool.lambda.iter().zip(&pool.flipped).filter(|(_, flipped)| !**flipped).map(|(pole, _)| *pole).collect();
    let variance = pool_variance(sketch, &stable)?;
    let kept = prune(sketch, &stable, &POWERS, variance)?;
    Ok(Start { refined: refine(sketch, &kept, &POWERS, tol::REFINE_ROUGH, tol::ROUGH_STEP)?, variance })
}

/// Single lines that poles narrower than a line stand for, and those like them.
fn spoilt_lines(work: &Work, refined: &Refined) -> Result<Vec<usize>, LinalgError> {
    let physical: Vec<Complex64> = refined.lambda.iter().copied().filter(|pole| !unphysical(work, *pole)).collect();
    if physical.len() == refined.lambda.len() {
        return Ok(Vec::new());
    }
    let residual = Projection::new(work, &physical, &refined.powers)?.residual;
    let fitted = line_energy(&(&work.b - &residual));
    Ok(single_lines(&line_energy(&residual).to_vec(), &fitted.to_vec()))
}

/// The second pass on all lines, whether or not the poles were found on a thinned record.
fn project_all(data: &Screened, refined: &Refined, energy: &Array1<f64>) -> Result<Projected, LinalgError> {
    if refined.projection.q.nrows() == data.lines.len() {
        return project(data, &refined.projection.q, energy);
    }
    let all = Work { x: data.x.clone(), g: data.g.clone(), b: Array2::zeros((data.lines.len(), 0)) };
    project(data, &qr_thin(basis(&all, &refined.lambda, &refined.powers).view())?.0, energy)
}

/// True where the same number of stable poles explains the conjugate of the data far better than the data: a passive
/// structure measured in e^{−jωt}.
fn conjugate_fits_better(mixed: &Work, seeds: &[Complex64], size: usize) -> Result<bool, LinalgError> {
    let left_over = |work: &Work| -> Result<f64, LinalgError> {
        let pool = vector_fit(work, &starts(work, seeds, size), &POWERS, tol::POOL_ITERATIONS)?;
        let stable: Vec<Complex64> = pool.lambda.iter().zip(&pool.flipped).filter(|(_, f)| !**f).map(|(p, _)| *p).collect();
        Ok(Projection::new(work, &stable, &POWERS)?.sse)
    };
    Ok(left_over(&mixed.with_columns(mixed.b.mapv(|v| v.conj())))? < tol::CONJUGATE_SHARE * left_over(mixed)?)
}

/// Noise variance of the sketch from the over-fitted pool.
pub(crate) fn pool_variance(work: &Work, lambda: &[Complex64]) -> Result<f64, LinalgError> {
    let projection = Projection::new(work, lambda, &POWERS)?;
    let dof = (work.lines() - (lambda.len() + POWERS.len()).min(work.lines() - 1)) * work.columns();
    Ok((projection.sse / dof as f64).max(1e-30 * work.energy() / (work.lines() * work.columns()) as f64))
}

/// Noise variance from the residual of all FRFs.
fn full_variance(data: &Screened, projected: &Projected, refined: &Refined) -> f64 {
    let dof = (data.lines.len() - refined.unknowns().min(data.lines.len() - 1)) * data.pairs.len();
    let left = projected.line_residual(&refined.projection.residual).sum();
    (left / (dof as f64 - refined.lambda.len() as f64).max(1.0)).max(1e-30)
}

/// The first of the `places` where compressed columns show a pole that all FRFs may confirm: with their noise, what it takes out of
/// them comes near what a pole of the model must. A pass with that pole in the basis would have the last word, and costs far more.
fn confirmed(data: &Screened, work: &Work, refined: &Refined, variance: f64, places: &[Complex64]) -> Option<Complex64> {
    if places.is_empty() {
        return None;
    }
    let (_, mut outside) = projected(refined.projection.q.view(), basis(work, places, &[]).view());
    for mut column in outside.columns_mut() {
        let norm = column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        column.mapv_inplace(|v| v / norm);
    }
    let frfs = data.pairs.len();
    let over_noise = |energy: f64| energy / variance - frfs as f64;
    let needed = tol::CONFIRMED * (threshold(frfs, work.lines()) - frfs as f64);
    places.iter().zip(energies(data, &outside)).find(|(_, energy)| over_noise(*energy) > needed).map(|(pole, _)| *pole)
}

/// Drops what cannot be a mode, adds what the residual shows, until neither changes anything.
///
/// `frfs`: FRFs whose noise a pole of the model takes along. On a sketch these are its columns; compressed columns hold all that
/// the basis they were made with takes out of *all* FRFs, noise included.
fn settle(work: &Work, refined: &mut Refined, variance: &mut f64, frfs: usize, history: &mut Vec<(usize, f64)>) -> Result<(), LinalgError> {
    let limit = threshold(frfs, work.lines());
    let (mut tried, mut needed): (Vec<Complex64>, Vec<Complex64>) = (Vec::new(), Vec::new());
    for _ in 0..tol::SCAN_ROUNDS * 3 {
        if let Some((gone, fewer)) = dispensable(work, refined, limit * *variance, &mut needed)? {
            tried.push(gone);
            *refined = fewer;
            history.push((refined.lambda.len(), refined.variance(work)));
            continue;
        }
        let Some(&pole) = scan(work, refined, limit * *variance, &tried).first() else { break };
        tried.push(pole);
        let mut more = refined.lambda.clone();
        more.push(pole);
        let candidate = refine(work, &more, &refined.powers, 2 * tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
        let gain = refined.projection.sse - candidate.projection.sse;
        let new = *candidate.lambda.last().expect("one was added");
        let weakest = candidate.significance()?.into_iter().fold(f64::MAX, f64::min);
        if gain > limit * *variance && weakest > limit * *variance && !unphysical(work, new) {
            *refined = candidate;
            *variance = variance.min(refined.variance(work));
            history.push((refined.lambda.len(), refined.variance(work)));
        }
    }
    Ok(())
}

/// A pole that the data do not need, and the fit without it: it stands for no mode, the sum of squares rises by less than `limit`
/// without it, or it is a [`crutch`].
fn dispensable(
    work: &Work,
    refined: &Refined,
    limit: f64,
    needed: &mut Vec<Complex64>,
) -> Result<Option<(Complex64, Refined)>, LinalgError> {
    let rises = refined.significance()?;
    let useless = weakest_first(&rises).into_iter().find(|&q| unphysical(work, refined.lambda[q]) || rises[q] < limit);
    let found = match useless {
        Some(q) => Some((q, without(work, refined, q)?)),
        None => crutch(work, refined, limit, |_| true, needed)?,
    };
    Ok(found.map(|(q, fewer)| (refined.lambda[q], fewer)))
}

/// Keeps the `modes` in-band poles that matter most (an order given by the user).
fn keep_strongest(work: &Work, refined: &mut Refined, modes: usize) -> Result<(), LinalgError> {
    loop {
        let inside: Vec<usize> = (0..refined.lambda.len()).filter(|&q| work.in_band(refined.lambda[q])).collect();
        if inside.len() <= modes {
            return Ok(());
        }
        let rises = refined.significance()?;
        let weakest = inside.into_iter().min_by(|&a, &b| rises[a].total_cmp(&rises[b])).expect("more than `modes`");
        let mut fewer = refined.lambda.clone();
        fewer.remove(weakest);
        *refined = refine(work, &fewer, &refined.powers, tol::REFINE_FINE, tol::FINE_STEP)?;
    }
}
