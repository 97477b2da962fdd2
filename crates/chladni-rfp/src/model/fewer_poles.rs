//! The damping law by the poles that each law needs (theory.md, section 2).
//!
//! Poles can make good what the wrong law misses: with enough of them both leave noise alone. The
//! right law needs fewer, or leaves less with as many. No phase and no complex shape changes that.

use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::places::in_plane_of;
use crate::damping::verdict::shift;
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::grade::Grade;
use crate::data::watch::Watch;
use crate::model::limits;
use crate::poles::estimate::{graded, PoleEstimate};
use crate::poles::prune::{redundant_pole, Patience};
use crate::poles::refine::{refine, Refined};
use crate::poles::settle::settle;
use crate::poles::significance::threshold;
use crate::tolerances as tol;
use chladni_frf::{Damping, Trust};
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Name of the decision on the law as a stage of the fit.
pub(crate) const STAGE: &str = "damping law";

/// True if the numbers of poles can tell: the residual is noise, and so small that a mode of the
/// band is far from itself in the other law.
pub(crate) fn may_tell(found: &PoleEstimate) -> bool {
    let poles = found.refined.lambda.iter().zip(&found.grades);
    let mut poles = poles.zip(&found.spread);
    let is_far = |((pole, grade), spread): ((&Complex64, &Grade), &f64)| {
        let deviation = (0.5 * spread).sqrt() / pole.re;
        grade.trust == Trust::Sure
            && found.work.in_band(*pole)
            && shift(pole.im / pole.re, 0.5 * deviation, deviation) > limits::LAW_COSTS_POLES
    };
    found.residual_is_noise && found.work.leakage.is_none() && poles.any(is_far)
}

/// The law in which few poles explain the data clearly better; `None` where neither is clearly
/// better. Both are searched on the same columns. A pole more counts as much as it must explain to
/// be significant.
///
/// * `frfs`: number of FRFs behind the columns
///
/// # Errors
/// A kernel that fails; a watch that ends it.
pub(crate) fn law_of_fewer_poles(
    found: &PoleEstimate,
    frfs: usize,
    watch: &Watch,
) -> Result<Option<Damping>, FitError> {
    let (own, variance) = with_some_noise(found, frfs);
    let other = own.clone().in_law(own.law.other());
    let cost = |found: &Refined| cost(found, threshold(frfs, own.lines()) * variance);
    watch.stage(STAGE)?;
    let first = fewest(&own, &found.refined.lambda, variance, frfs)?;
    let in_other = |pole: &Complex64| in_plane_of(other.law, *pole);
    let start: Vec<Complex64> = first.lambda.iter().filter_map(in_other).collect();
    watch.stage(STAGE)?;
    let second = fewest(&other, &start, variance, frfs)?;
    let lead = cost(&second) - cost(&first);
    Ok(match lead.abs() > limits::LEAD_THAT_TELLS {
        true if lead > 0.0 => Some(own.law),
        true => Some(other.law),
        false => None,
    })
}

/// The columns and their noise variance. Noise is added to data that have less than
/// [`limits::NOISE_THAT_TELLS`]: without it a search ends anywhere, since many poles that nearly
/// cancel leave as little as the few of the structure.
fn with_some_noise(found: &PoleEstimate, frfs: usize) -> (Columns, f64) {
    let mut work = found.work.clone();
    let mean_square = work.energy() / (work.lines() * frfs) as f64;
    let added = limits::NOISE_THAT_TELLS * mean_square;
    if found.variance >= added {
        return (work, found.variance);
    }
    let mut random = ChaCha8Rng::seed_from_u64(limits::SEED_OF_ADDED_NOISE);
    work.b.mapv_inplace(|value| {
        let (u, turn): (f64, f64) = (random.random(), random.random());
        value + Complex64::from_polar((-added * (1.0 - u).ln()).sqrt(), TAU * turn)
    });
    (work, added + found.variance)
}

/// Cost of poles: what they leave in units of the `price` of a pole, and their number.
fn cost(found: &Refined, price: f64) -> f64 {
    found.projection.sse / price + found.lambda.len() as f64
}

/// As few poles as explain the columns up to noise of this variance. A search that ends at a higher cost
/// than it began with went astray: its start is kept.
fn fewest(
    work: &Columns,
    start: &[Complex64],
    variance: f64,
    frfs: usize,
) -> Result<Refined, LinalgError> {
    let mut refined = refine(work, start, &RESIDUAL_POWERS, tol::FINE)?;
    let least_rise = threshold(frfs, work.lines()) * variance;
    let (mut level, mut history) = (variance, Vec::new());
    let began = refined.clone();
    settle(work, &mut refined, &mut level, frfs, &mut history)?;
    let is_no_worse = cost(&refined, least_rise) <= cost(&began, least_rise);
    if !is_no_worse {
        refined = began;
    }
    let mut needed = Vec::new();
    loop {
        let may_go = |_| true;
        let patience = Patience::LONG;
        match redundant_pole(work, &refined, least_rise, may_go, &mut needed, patience)? {
            Some((_, fewer)) => refined = fewer,
            None => return refine(work, &refined.lambda, &RESIDUAL_POWERS, tol::FINE),
        }
    }
}

/// The poles without those beside the sure modes that are not needed to explain the data to
/// rounding; the same poles where noise is left.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn without_needless_poles(
    mut found: PoleEstimate,
    frfs: usize,
) -> Result<PoleEstimate, LinalgError> {
    if !found.is_rounding() || found.work.leakage.is_some() {
        return Ok(found);
    }
    let mut needed = Vec::new();
    loop {
        let PoleEstimate {
            refined,
            work,
            grades,
            ..
        } = &found;
        let modes = refined.lambda.iter().zip(grades);
        let modes =
            modes.filter(|(pole, grade)| grade.trust == Trust::Sure && work.in_band(**pole));
        let modes: Vec<Complex64> = modes.map(|(pole, _)| *pole).collect();
        let may_go = |pole: Complex64| !modes.contains(&pole);
        let left = found.room_to_rounding();
        let patience = Patience::LONG;
        let gone = redundant_pole(work, refined, left, may_go, &mut needed, patience)?;
        let Some((_, fewer)) = gone else {
            return Ok(found);
        };
        let fewer = refine(work, &fewer.lambda, &fewer.powers, tol::FINE)?;
        let rise = fewer.projection.sse - refined.projection.sse;
        let rise_of_variance = rise / (work.lines() * frfs) as f64;
        let variance = (found.variance + rise_of_variance).max(f64::MIN_POSITIVE);
        let (grades, spread) = graded(&fewer, work, variance);
        found = PoleEstimate {
            refined: fewer,
            grades,
            spread,
            variance,
            ..found
        };
    }
}
