//! Poles that several orders and both halves of the lines agree on.

use super::limits::{
    AGREED_LEAST, LADDER, LADDER_EXTRA, LINES_PER_POLE, NUISANCE_MOST, SAME_POLE, STRONG_EXTRA,
    VOTE_SEED,
};
use crate::data::columns::Columns;
use crate::measured::candidates::Origin;
use crate::poles::pool::{mixtures, starts, vector_fit, StepBasis};
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use rayon::prelude::*;

/// A pole with what the runs say of it.
pub(crate) type Voted = (Complex64, Origin);

struct Run {
    poles: Vec<Complex64>,
    half: Half,
}

#[derive(Clone, Copy, PartialEq)]
enum Half {
    All,
    Odd,
    Even,
}

/// Runs vector fitting at three orders (per ladder of `seeds`) on all, odd and even
/// lines, and counts votes: in-band poles that at least half the runs agree on (medians
/// over the runs), then the out-of-band or overdamped ones of the middle run.
pub(crate) fn consensus(
    work: &Columns,
    seeds: &[Complex64],
    base: usize,
    strong: Option<&[Complex64]>,
    powers: &[i32],
) -> Result<Vec<Voted>, LinalgError> {
    let n = work.lines();
    let odd = work.select(&(0..n).filter(|k| k % 2 == 1).collect::<Vec<_>>());
    let even = work.select(&(0..n).filter(|k| k % 2 == 0).collect::<Vec<_>>());
    let mut ladders: Vec<(&[Complex64], [usize; 3])> = vec![(
        seeds,
        LADDER.map(|f| (f * base as f64) as usize + LADDER_EXTRA),
    )];
    ladders.extend(strong.map(|strong| (strong, STRONG_EXTRA.map(|extra| strong.len() + extra))));
    let halves = [(work, Half::All), (&odd, Half::Odd), (&even, Half::Even)];
    let plan: Vec<(usize, usize, usize)> = (0..ladders.len())
        .flat_map(|l| (0..3).flat_map(move |step| (0..3).map(move |half| (l, step, half))))
        .collect();
    let pools: Vec<Result<Vec<Complex64>, LinalgError>> = plan
        .par_iter()
        .map(|&(ladder, step, half)| {
            let (seeds, orders) = ladders[ladder];
            stable(halves[half].0, seeds, orders[step], powers)
        })
        .collect();
    let mut runs = Vec::new();
    let mut nuisance = Vec::new();
    for (&(ladder, step, half), poles) in plan.iter().zip(pools) {
        let poles = poles?;
        let half = halves[half].1;
        if ladder == 0 && step == 1 && half == Half::All {
            nuisance = poles
                .iter()
                .copied()
                .filter(|p| !is_candidate(work, *p))
                .collect();
        }
        runs.push(Run {
            poles: poles
                .into_iter()
                .filter(|p| is_candidate(work, *p))
                .collect(),
            half,
        });
    }
    let runs_per_ladder = runs.len() / ladders.len();
    nuisance.sort_by(|a, b| distance_outside(work, *a).total_cmp(&distance_outside(work, *b)));
    let mut voted = vote(work, &runs, runs_per_ladder);
    voted.extend(
        nuisance
            .into_iter()
            .take(NUISANCE_MOST)
            .map(|pole| (pole, Origin::Nuisance)),
    );
    Ok(voted)
}

/// Inside the band and lightly enough damped to be a mode.
fn is_candidate(work: &Columns, pole: Complex64) -> bool {
    work.in_band(pole) && pole.im < tol::BACKGROUND_LOSS * pole.re
}

fn distance_outside(work: &Columns, pole: Complex64) -> f64 {
    let (low, high) = work.range();
    (low - pole.re).max(pole.re - high).max(0.0)
}

/// Same pole: closer than half a half-bandwidth or half a line.
fn same(work: &Columns, a: Complex64, b: Complex64) -> bool {
    (a - b).norm() < SAME_POLE * a.im.max(b.im).max(work.spacing(a.re))
}

/// Stable poles of one run of vector fitting, of `order` or what the lines bear.
fn stable(
    part: &Columns,
    seeds: &[Complex64],
    order: usize,
    powers: &[i32],
) -> Result<Vec<Complex64>, LinalgError> {
    let order = order.min(part.lines() / LINES_PER_POLE).max(1);
    let mixed = mixtures(part, tol::POOL_MIXTURES, VOTE_SEED);
    let pool = vector_fit(
        &mixed,
        &starts(part, seeds, order),
        powers,
        tol::VOTE_ITERATIONS,
        StepBasis::PartialFractions,
    )?;
    let poles = pool.lambda.iter().zip(&pool.flipped);
    Ok(poles.filter(|(_, f)| !**f).map(|(p, _)| *p).collect())
}

/// Greedy clustering: the candidate that most runs share comes first. A ladder votes by
/// itself: the better score counts.
fn vote(work: &Columns, runs: &[Run], runs_per_ladder: usize) -> Vec<Voted> {
    let mut open: Vec<Vec<Option<Complex64>>> = runs
        .iter()
        .map(|r| r.poles.iter().copied().map(Some).collect())
        .collect();
    let mut agreed = Vec::new();
    while let Some((count, centre)) = most_shared(work, &open, runs_per_ladder) {
        let score = count as f64 / runs_per_ladder as f64;
        if score < AGREED_LEAST {
            break;
        }
        let mut members = Vec::new();
        let (mut odd, mut even) = (Vec::new(), Vec::new());
        for (run, poles) in runs.iter().zip(open.iter_mut()) {
            let nearest = poles
                .iter_mut()
                .filter(|p| p.is_some_and(|p| same(work, p, centre)))
                .min_by(|a, b| {
                    (a.unwrap_or(centre) - centre)
                        .norm()
                        .total_cmp(&(b.unwrap_or(centre) - centre).norm())
                });
            if let Some(slot) = nearest {
                let pole = slot.take().unwrap_or(centre);
                members.push(pole);
                match run.half {
                    Half::Odd => odd.push(pole),
                    Half::Even => even.push(pole),
                    Half::All => {}
                }
            }
        }
        let odd_even =
            (!odd.is_empty() && !even.is_empty()).then(|| (middle(&odd) - middle(&even)).norm());
        agreed.push((middle(&members), Origin::Agreed { score, odd_even }));
    }
    agreed.sort_by(|a, b| a.0.re.total_cmp(&b.0.re));
    agreed
}

/// The candidate that most runs of one ladder share, the closest among equals, and their
/// number.
fn most_shared(
    work: &Columns,
    open: &[Vec<Option<Complex64>>],
    runs_per_ladder: usize,
) -> Option<(usize, Complex64)> {
    let mut best: Option<(usize, f64, Complex64)> = None;
    for candidate in open.iter().flatten().flatten().copied() {
        let mut votes = vec![0; open.len() / runs_per_ladder];
        let mut spread = 0.0;
        for (r, run) in open.iter().enumerate() {
            let nearest = run
                .iter()
                .flatten()
                .map(|p| (p - candidate).norm())
                .fold(f64::MAX, f64::min);
            if run.iter().flatten().any(|p| same(work, *p, candidate)) {
                votes[r / runs_per_ladder] += 1;
                spread += nearest;
            }
        }
        let count = votes.into_iter().max().unwrap_or(0);
        if best.is_none_or(|(c, s, _)| count > c || (count == c && spread < s)) {
            best = Some((count, spread, candidate));
        }
    }
    best.map(|(count, _, centre)| (count, centre))
}

/// Median of real and imaginary parts.
fn middle(poles: &[Complex64]) -> Complex64 {
    let part = |f: fn(&Complex64) -> f64| {
        let mut values: Vec<f64> = poles.iter().map(f).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Complex64::new(part(|p| p.re), part(|p| p.im))
}
