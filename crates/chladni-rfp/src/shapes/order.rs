//! The number of modes where each has one shape: modes that only the common structure
//! shows are added, those that the others explain are taken out, and two that cannot be
//! told apart become one repeated pole (theory.md, section 4).

use crate::poles::limits::UNCERTAIN;
use crate::shapes::growth::candidate;
use crate::shapes::limits;
use crate::shapes::step::{Enough, State};
use crate::shapes::target::Target;
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use ndarray::Axis;
use num_complex::Complex64;

/// Modes that share their poles.
pub(super) struct Merged {
    /// The mode whose pole each has.
    pub owner: Vec<usize>,
    /// Variances of Re λ and Im λ of each for unit noise variance.
    pub spread: Vec<[f64; 2]>,
}

/// Adds modes to a state that is refined already until `holds`, while one more takes more
/// than `limit` out of the sum of squares.
pub(super) fn grown(
    target: &Target,
    mut state: State,
    limit: f64,
    settled: Enough,
    holds: &dyn Fn(&State) -> bool,
) -> Result<State, LinalgError> {
    let before = state.lambda.len();
    for _ in 0..limits::GROWTH_MOST {
        if holds(&state) {
            break;
        }
        let Some((pole, along)) = candidate(target, &state, limit)? else {
            break;
        };
        let mut lambda = state.lambda.clone();
        lambda.push(pole);
        let mut participation = state.participation.clone();
        participation
            .push(Axis(0), along.view())
            .expect("one value per reference");
        let Ok(more) = State::new(target, lambda, participation, false) else {
            break;
        };
        let more = more.refined(target, Enough::Rough);
        let physical = more
            .lambda
            .iter()
            .all(|l| l.im > tol::SPIKE_SPACINGS * target.work.spacing(l.re));
        if !physical || state.sse - more.sse < limit {
            break;
        }
        state = more;
    }
    if state.lambda.len() == before {
        return Ok(state);
    }
    Ok(state.refined(target, settled))
}

/// Takes out modes that are uncertain because the others explain the data as well without
/// them: to `limit` of the sum of squares.
pub(super) fn shed(target: &Target, mut state: State, variance: f64, limit: f64) -> State {
    let mut spread = state.spread();
    for n in (0..state.lambda.len()).rev() {
        if (variance * spread[n].iter().sum::<f64>()).sqrt() <= UNCERTAIN * state.lambda[n].im {
            continue;
        }
        let Ok(fewer) = state.without(target, n) else {
            continue;
        };
        let fewer = fewer.refined(target, Enough::Fine);
        if fewer.sse - state.sse < limit {
            spread = fewer.spread();
            state = fewer;
        }
    }
    state
}

/// Poles with their shapes. Of two that lie nearer than their error bars, the second goes where
/// the first explains the data as well by itself; else they become one of rank two where the sum
/// of squares does not mind: the pole of each mode and its variances are those of its owner, a
/// mode of its own or an earlier one.
pub(super) fn merged(target: &Target, mut state: State, variance: f64) -> (State, Merged) {
    let mut owner: Vec<usize> = (0..state.lambda.len()).collect();
    let mut spread = state.spread();
    let limit = limits::REPEATED_SIGMAS * variance + limits::STRUCTURE_ROUNDING * target.energy;
    let mut next = 1;
    while next < owner.len() {
        let n = next;
        next += 1;
        let near = (0..n).filter(|&m| owner[m] == m).find(|&m| {
            let allowed =
                variance * (spread[m].iter().sum::<f64>() + spread[n].iter().sum::<f64>());
            (state.lambda[m] - state.lambda[n]).norm_sqr() < limits::REPEATED_SIGMAS * allowed
        });
        let Some(m) = near else { continue };
        let alone = state
            .without(target, n)
            .ok()
            .filter(|fewer| fewer.sse - state.sse < limit);
        if let Some(fewer) = alone {
            // the one that stays had its place beside the other
            let fewer = fewer.refined(target, Enough::Fine);
            spread = fewer.spread();
            state = fewer;
            // those from here on own themselves
            owner.pop();
            next = n;
            continue;
        }
        let share = [0, 1].map(|d| spread[n][d] / (spread[m][d] + spread[n][d]));
        let delta = state.lambda[m] - state.lambda[n];
        let mut lambda = state.lambda.clone();
        lambda[m] = lambda[n] + Complex64::new(delta.re * share[0], delta.im * share[1]);
        lambda[n] = lambda[m];
        let Ok(one) = State::new(target, lambda, state.participation.clone(), state.real) else {
            continue;
        };
        if one.sse - state.sse < limit {
            state = one;
            spread = state.spread();
            owner[n] = m;
        }
    }
    (state, Merged { owner, spread })
}
