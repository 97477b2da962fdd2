//! The poles beside those that have their shapes, as the model is saved: one place each for
//! all FRFs (theory.md, section 4).

use crate::damping::saved;
use crate::damping::structural::basis;
use crate::poles::refine::refine;
use crate::poles::settle::places_beyond;
use crate::shapes::limits;
use crate::shapes::step::State;
use crate::shapes::target::Target;
use crate::tolerances as tol;
use chladni_frf::Damping;
use chladni_linalg::blocked::{blocked_matmul, blocked_matmul_mixed};
use chladni_linalg::{matmul_h, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;

/// True where pole `n` is so close to one before it that their residues are large and
/// cancel.
pub(crate) fn fused(poles: &[Complex64], n: usize) -> bool {
    let close = |b: &Complex64| (poles[n] - b).norm() < limits::FUSED * (poles[n].im + b.im);
    poles[..n].iter().any(close)
}

/// The one that leaves least; of equal ones the first.
fn least(tried: impl ParallelIterator<Item = Around>) -> Option<Around> {
    let tried: Vec<Around> = tried.collect();
    tried.into_iter().min_by(|a, b| a.sse.total_cmp(&b.sse))
}

/// The poles beside those that have their shapes, with free residues.
pub(crate) struct Around {
    /// Poles in the x plane.
    pub poles: Vec<Complex64>,
    /// Sum of squares that all together leave.
    pub sse: f64,
}

impl Around {
    /// The poles `outside` refined on what those of `state` leave. The search lets them
    /// follow each FRF by itself, to first order; here they have one place for all. More
    /// are added until `holds`, while one takes more than `limit` out of the sum of
    /// squares.
    pub fn new(
        whole: &Target,
        state: &State,
        (outside, powers): (&[Complex64], &[i32]),
        limit: f64,
        holds: &dyn Fn(f64) -> bool,
    ) -> Result<Self, LinalgError> {
        let work = whole.work;
        let residues = state.residues();
        let columns = basis(work, &state.lambda, &[]);
        let gram = matmul_h(columns.view(), columns.view());
        let energy = |residues: &Array2<Complex64>| -> f64 {
            let along = blocked_matmul(gram.view(), residues.view());
            let terms = along.iter().zip(residues);
            terms.map(|(a, r)| (r.conj() * a).re).sum()
        };
        let compressed = blocked_matmul_mixed(&residues, whole.back.t());
        // the part that the compressed data cannot hold
        let beside = (energy(&residues) - energy(&compressed)).max(0.0);
        let explained = blocked_matmul(columns.view(), compressed.view());
        let left = work.with_columns(&work.b - &explained);
        let at = |poles: &[Complex64], steps: usize| -> Result<Self, LinalgError> {
            let refined = refine(&left, poles, powers, steps, tol::FINE_STEP)?;
            let residual = refined.projection.residual.iter();
            let (poles, sse) = match work.law {
                Damping::Structural => {
                    let sse = residual.map(|v| v.norm_sqr()).sum();
                    (refined.lambda, sse)
                }
                Damping::Viscous => saved::refined(&left, refined.lambda, powers, steps)?,
            };
            Ok(Self {
                sse: sse + beside,
                poles,
            })
        };
        let sound = |around: &Self| {
            let stays = |pole: &Complex64| !work.in_band(*pole) && pole.re > 0.0 && pole.im > 0.0;
            let apart = |n: usize| !fused(&around.poles, n);
            around.poles.iter().all(stays) && (0..around.poles.len()).all(apart)
        };
        let apart: Vec<Complex64> = (0..outside.len())
            .filter(|&n| !fused(outside, n))
            .map(|n| outside[n])
            .collect();
        let mut best = at(&apart, 0)?;
        let refined = at(&apart, tol::REFINE_FINE)?;
        if refined.sse < best.sse && sound(&refined) {
            best = refined;
        }
        for _ in 0..limits::AROUND_MOST {
            if holds(best.sse) || best.poles.len() + state.lambda.len() >= work.lines() / 2 {
                break;
            }
            let from = |poles: Vec<Complex64>| at(&poles, tol::REFINE_FINE).ok().filter(sound);
            let one_more = |start: &Complex64| {
                let more = from([&best.poles[..], &[*start]].concat())?;
                let added = more.poles[more.poles.len() - 1];
                let loss = added.im / added.re;
                limits::LOSS_ADDED.contains(&loss).then_some(more)
            };
            // a pole may be held by a hill between it and its place
            let moved = |n: usize, to: &Complex64| {
                let mut poles = best.poles.clone();
                poles[n] = *to;
                from(poles)
            };
            let places: Vec<Complex64> = places_beyond(work).collect();
            let moves = (0..best.poles.len()).flat_map(|n| places.iter().map(move |to| (n, to)));
            let moves: Vec<(usize, &Complex64)> = moves.collect();
            let nearer = least(moves.into_par_iter().filter_map(|(n, to)| moved(n, to)));
            if let Some(nearer) = nearer.filter(|one| one.sse < best.sse - limit) {
                best = nearer;
                continue;
            }
            // beside a pole that is there, the two stand for it and its derivative
            let beside = best.poles.iter().map(|pole| pole + 2.0 * pole.im);
            let places: Vec<Complex64> = places.iter().copied().chain(beside).collect();
            match least(places.par_iter().filter_map(one_more)) {
                Some(more) if more.sse < best.sse - limit => best = more,
                _ => break,
            }
        }
        Ok(best)
    }
}
