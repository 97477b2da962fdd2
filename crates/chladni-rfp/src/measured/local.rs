//! Local tests: what a pole's own neighbourhood would lose without it.
//!
//! A test moves only the poles near its candidate, on the lines near it; the part of all
//! others stands still. That costs the square of a handful of poles on some tens of
//! lines, where a refit of the whole costs the square of all on all.

use super::limits::{
    CLEAR, LOCAL_LINES_TO_SPARE, MOST, NEAR, NEEDED, NEIGHBOUR_WIDTHS, POWERS, REACH,
};
use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::measured::candidates::{Candidates, Change};
use crate::poles::by_hand::held;
use crate::poles::refine::{refine, Projection, Refined};
use crate::tolerances as tol;
use chladni_linalg::{matmul, LinalgError};
use ndarray::{s, Array2, Axis};
use num_complex::Complex64;
use std::ops::Range;

fn energy(residual: &Array2<Complex64>, rows: Range<usize>) -> f64 {
    residual
        .slice(s![rows, ..])
        .iter()
        .map(|v| v.norm_sqr())
        .sum()
}

/// A window, the poles that may move in it, and what they have to explain there.
pub(crate) struct Neighbourhood {
    rows: Range<usize>,
    /// Poles that may move.
    pub near: Vec<usize>,
    /// The lines, and what the near poles and the residual make there.
    pub local: Columns,
}

impl Neighbourhood {
    /// Around `pole`, which may be one of `refined` or not yet.
    pub fn around(work: &Columns, refined: &Refined, pole: Complex64) -> Self {
        let width = pole.im.max(work.spacing(pole.re));
        let distance = |q: usize| (refined.lambda[q].re - pole.re).abs();
        // a broad neighbour is not followed to its ends
        let bounded = |q: usize| refined.lambda[q].im.clamp(0.0, NEIGHBOUR_WIDTHS * width);
        let mut near: Vec<usize> = (0..refined.lambda.len())
            .filter(|&q| {
                work.in_band(refined.lambda[q]) && distance(q) < NEAR * width.max(bounded(q))
            })
            .collect();
        near.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        near.truncate(MOST);
        let mut rows = work.window(pole, REACH.0, REACH.1);
        for &q in &near {
            let own = work.window(
                Complex64::new(refined.lambda[q].re, bounded(q)),
                REACH.0,
                REACH.1,
            );
            rows = rows.start.min(own.start)..rows.end.max(own.end);
        }
        let mut local = work.rows(rows.clone());
        let own = basis(
            &local,
            &near.iter().map(|&q| refined.lambda[q]).collect::<Vec<_>>(),
            &[],
        );
        local.b = matmul(
            own.view(),
            refined.coefficients.select(Axis(0), &near).view(),
        ) + refined.projection.residual.slice(s![rows.clone(), ..]);
        Self { rows, near, local }
    }

    /// Refines `poles` on the window.
    pub fn refit(&self, poles: &[Complex64]) -> Result<Refined, LinalgError> {
        refine(
            &self.local,
            poles,
            &POWERS,
            tol::ROUGH.within(2 * tol::ROUGH.steps),
        )
    }

    /// Sums of squares around `pole` of two fits on the window: (with, without).
    fn compare(
        &self,
        work: &Columns,
        pole: Complex64,
        with: &Projection,
        without: &Projection,
    ) -> (f64, f64) {
        let window = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
        let start = window.start.clamp(self.rows.start, self.rows.end) - self.rows.start;
        let end = window.end.clamp(self.rows.start, self.rows.end) - self.rows.start;
        (
            energy(&with.residual, start..end),
            energy(&without.residual, start..end),
        )
    }

    /// Replaces `old` (some of `near`) by `new` poles: the change, and the refit behind
    /// it.
    pub fn replace(
        &self,
        refined: &Refined,
        old: &[usize],
        new: &[Complex64],
    ) -> Result<(Vec<(usize, Complex64)>, Refined), LinalgError> {
        let kept: Vec<usize> = self
            .near
            .iter()
            .copied()
            .filter(|q| !old.contains(q))
            .collect();
        let start: Vec<Complex64> = kept
            .iter()
            .map(|&q| refined.lambda[q])
            .chain(new.iter().copied())
            .collect();
        let fit = self.refit(&start)?;
        Ok((
            kept.into_iter().zip(fit.lambda.iter().copied()).collect(),
            fit,
        ))
    }
}

/// Local gain of each pole by the exact one-column formula: rise of the sum of squares in
/// its window over that sum, the other poles held. An upper bound of what is left after
/// the others adapt. `without` leaves out the lines nearest to it.
pub(crate) fn one_column_gains(
    work: &Columns,
    refined: &Refined,
    without: usize,
) -> Result<Vec<f64>, LinalgError> {
    let inverse = refined.projection.gram_inverse()?;
    let a = basis(work, &refined.lambda, &refined.powers);
    Ok((0..refined.lambda.len())
        .map(|q| {
            let pole = refined.lambda[q];
            let window = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
            let mut near: Vec<usize> = window.clone().collect();
            near.sort_by(|&i, &j| {
                (work.x[i] - pole.re)
                    .abs()
                    .total_cmp(&(work.x[j] - pole.re).abs())
            });
            let skipped = &near[..without.min(near.len())];
            let own = refined.coefficients.row(q);
            // the column's part that no other column can take over, on the window alone
            let outside = matmul(
                a.slice(s![window.clone(), ..]),
                inverse.slice(s![.., q..q + 1]),
            ) / inverse[[q, q]];
            let (mut with, mut removed) = (0.0, 0.0);
            for (k, column) in window
                .zip(outside.column(0))
                .filter(|(k, _)| !skipped.contains(k))
            {
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

/// Local gain of pole q with its neighbours refitted in its absence, and the change its
/// removal would be.
fn refitted_gain(
    work: &Columns,
    refined: &Refined,
    q: usize,
) -> Result<(f64, Change), LinalgError> {
    let pole = refined.lambda[q];
    let hood = Neighbourhood::around(work, refined, pole);
    let poles: Vec<Complex64> = hood.near.iter().map(|&q| refined.lambda[q]).collect();
    let with = Projection::new(&hood.local, &poles, &POWERS)?;
    let (moved, without) = hood.replace(refined, &[q], &[])?;
    let (with, without) = hood.compare(work, pole, &with, &without.projection);
    Ok((
        (without - with) / with.max(tol::TINY),
        Change {
            removed: Some(q),
            moved,
            added: None,
        },
    ))
}

/// Removes poles whose neighbourhood does not need them, the least needed first; poles
/// that moved in a sweep wait for the next.
pub(crate) fn remove_unneeded(
    work: &Columns,
    candidates: &mut Candidates,
) -> Result<(), LinalgError> {
    // poles known to be needed, by value: they need no second test while nothing near
    // them moves
    let mut needed: Vec<Complex64> = Vec::new();
    loop {
        let refined = &candidates.refined;
        let gains = one_column_gains(work, refined, 0)?;
        let mut order: Vec<usize> = (0..gains.len())
            .filter(|&q| {
                candidates.may_go(q)
                    && work.in_band(refined.lambda[q])
                    && gains[q] <= CLEAR
                    && !needed.contains(&refined.lambda[q])
            })
            .collect();
        order.sort_by(|&a, &b| gains[a].total_cmp(&gains[b]));
        let mut changes: Vec<Change> = Vec::new();
        let mut touched: Vec<usize> = Vec::new();
        for q in order {
            let (gain, change) = refitted_gain(work, refined, q)?;
            let near = || change.moved.iter().map(|m| m.0).chain([q]);
            if near().any(|n| touched.contains(&n)) {
                continue;
            }
            if gain < NEEDED {
                touched.extend(near());
                changes.push(change);
            } else {
                needed.push(refined.lambda[q]);
            }
        }
        if changes.is_empty() {
            return Ok(());
        }
        candidates.apply(work, changes)?;
    }
}

/// Removes one pole, its neighbours refitted.
pub(crate) fn remove(
    work: &Columns,
    candidates: &mut Candidates,
    q: usize,
) -> Result<(), LinalgError> {
    let hood = Neighbourhood::around(work, &candidates.refined, candidates.refined.lambda[q]);
    let (moved, _) = hood.replace(&candidates.refined, &[q], &[])?;
    candidates.apply(
        work,
        vec![Change {
            removed: Some(q),
            moved,
            added: None,
        }],
    )
}

/// Tries one pole at `start`; keeps it where its neighbourhood gains enough from it.
pub(crate) fn try_add(
    work: &Columns,
    candidates: &mut Candidates,
    start: Complex64,
) -> Result<bool, LinalgError> {
    let Some((change, gain)) = tried(work, candidates, start)? else {
        return Ok(false);
    };
    if gain >= NEEDED {
        candidates.apply(work, vec![change])?;
    }
    Ok(gain >= NEEDED)
}

/// Keeps a pole at `start` whatever its neighbourhood gains from it.
pub(crate) fn add(
    work: &Columns,
    candidates: &mut Candidates,
    start: Complex64,
) -> Result<(), LinalgError> {
    let near = tried(work, candidates, start)?.map(|(change, _)| change);
    let stays = |change: &Change| {
        change
            .added
            .is_some_and(|pole| held(work, start, pole) == pole)
    };
    let change = near.filter(stays).unwrap_or(Change {
        added: Some(start),
        ..Change::default()
    });
    candidates.apply(work, vec![change])
}

/// The pole that its neighbourhood makes of `start`, and what it gains from it; `None`
/// where that is no pole of the band.
fn tried(
    work: &Columns,
    candidates: &Candidates,
    start: Complex64,
) -> Result<Option<(Change, f64)>, LinalgError> {
    let refined = &candidates.refined;
    let hood = Neighbourhood::around(work, refined, start);
    if hood.local.lines() < hood.near.len() + POWERS.len() + LOCAL_LINES_TO_SPARE {
        return Ok(None);
    }
    let (_, without) = hood.replace(refined, &[], &[])?;
    let (moved, with) = hood.replace(refined, &[], &[start])?;
    let Some(&pole) = with
        .lambda
        .last()
        .filter(|p| work.in_band(**p) && p.im > 0.0)
    else {
        return Ok(None);
    };
    let (with, without) = hood.compare(work, pole, &with.projection, &without.projection);
    let gain = (without - with) / with.max(tol::TINY);
    let change = Change {
        removed: None,
        moved,
        added: Some(pole),
    };
    Ok(Some((change, gain)))
}
