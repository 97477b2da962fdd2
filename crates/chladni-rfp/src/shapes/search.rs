//! Structured refinement: one shape per mode for all references, real where the data
//! admit it (theory.md, section 4).
//!
//! Free residues spend most of their freedom on differences that no structure has.
//! Rank-one residues R_n = ψ_n·L_nᵀ lower the bound of close poles by up to an order of
//! magnitude, real shapes by √2 in frequency on top. Either is taken only where the sum
//! of squares rises by no more than chance (likelihood ratio); where rank one does not
//! hold, modes may be missing, and one at a time is added while it pays.
//!
//! Needs every pair of response and reference, and the structural law (complex-analytic
//! poles).

use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::data::options::ShapeModel;
use crate::poles::estimate::{PoleEstimate, UNCERTAIN};
use crate::poles::prune::threshold;
use crate::shapes::around::{fused, Around};
use crate::shapes::limits;
use crate::shapes::residues::{beyond_chance, is_too_much, strongest};
use crate::shapes::step::{Enough, State};
use crate::shapes::target::{free_residues, Target};
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::borrow::Cow;

/// One pole with the shapes that belong to it: one row each, more than one for a repeated
/// pole.
#[derive(Debug, Clone)]
pub(crate) struct StructuredPole {
    /// Pole in the x plane.
    pub lambda: Complex64,
    /// Variances of Re λ and Im λ for unit noise variance.
    pub spread: [f64; 2],
    /// (row, response).
    pub shape: Array2<Complex64>,
    /// (row, reference).
    pub participation: Array2<Complex64>,
}

/// The poles of the band that structured refinement found.
#[derive(Debug, Clone)]
pub(crate) struct Structured {
    /// Poles of the band, and of just beyond.
    pub poles: Vec<StructuredPole>,
    /// The poles with free residues that they stand for.
    pub replaced: Vec<Complex64>,
    /// All other poles, and the place of each once these have their shapes; `None` where
    /// its neighbour stands for it.
    pub others: Vec<(Complex64, Option<Complex64>)>,
    /// Poles outside the band that are needed besides.
    pub added: Vec<Complex64>,
    /// True where the model as saved, whose other poles have one place each for all FRFs,
    /// leaves no more than chance.
    pub borne: bool,
    /// True where shapes are real.
    pub real: bool,
    /// The structure taken and the reason for it, for the result.
    pub evidence: String,
}

impl Structured {
    /// True where no pole has come into the band: it would pass for a mode.
    fn stays_outside(&self, work: &Columns) -> bool {
        let outside = |pole: &Complex64| !work.in_band(*pole);
        let before = self.replaced.iter().filter(|pole| outside(pole)).count();
        let now = self.poles.iter().filter(|pole| outside(&pole.lambda));
        now.map(|pole| pole.shape.nrows()).sum::<usize>() >= before
    }
}

/// The result of the search for structure.
#[derive(Debug)]
pub(crate) enum Search {
    /// Not asked for, or nothing to hold against the data.
    Inapplicable,
    /// One shape per mode raises the sum of squares by so many standard deviations of
    /// chance, with all the modes that could be added.
    Refused(f64),
    /// It holds.
    Found(Structured),
}

/// Refines the poles of the band under the shape model asked for; where one just beyond
/// its ends has one shape too, that one with them: left free it takes most of what is
/// known of its neighbour inside.
///
/// `fixed_order`: no mode may be added.
pub(crate) fn structured(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
) -> Result<Search, LinalgError> {
    match attempted(data, found, asked, fixed_order) {
        // columns that cannot be told apart hold nothing against the data
        Err(LinalgError::NotPositiveDefinite { .. }) => Ok(Search::Inapplicable),
        other => other,
    }
}

fn attempted(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
) -> Result<Search, LinalgError> {
    let (work, lambda) = (&found.work, &found.refined.lambda);
    let (low, high) = work.range();
    let beside = |l: &Complex64| (low - l.re).max(l.re - high) < limits::BESIDE_HALF_WIDTHS * l.im;
    if asked == ShapeModel::Auto && lambda.iter().any(|l| beside(l) && !work.in_band(*l)) {
        match searched(data, found, asked, fixed_order, beside)? {
            Search::Found(structured) if structured.borne && structured.stays_outside(work) => {
                return Ok(Search::Found(structured));
            }
            _ => {}
        }
    }
    searched(data, found, asked, fixed_order, |l| work.in_band(*l))
}

/// The search for the poles that `belongs` says; all others stay free.
fn searched(
    data: &DataLayout,
    found: &PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
    belongs: impl Fn(&Complex64) -> bool,
) -> Result<Search, LinalgError> {
    let (responses, references) = (data.responses.len(), data.references.len());
    let work = &found.work;
    let (inside, outside): (Vec<Complex64>, Vec<Complex64>) =
        found.refined.lambda.iter().partition(|l| belongs(l));
    if asked == ShapeModel::Free || inside.is_empty() || data.pairs.len() < responses * references {
        return Ok(Search::Inapplicable);
    }
    // eliminated are the many DOFs, kept in the search the few
    let swapped = references > responses;
    let sides = if swapped {
        [references, responses]
    } else {
        [responses, references]
    };
    let whole = Target::new(
        work,
        &outside,
        &found.refined.powers,
        by_pair(data, found, swapped),
        sides,
    )?;
    let condensed = whole.condensed();
    let target = condensed.as_ref().unwrap_or(&whole);
    let variance = found.variance;
    let rounding = limits::STRUCTURE_ROUNDING * target.energy;
    let (residues, free_sse) = free_residues(target, &inside)?;
    let constraints = |n: usize| 2 * n * (sides[0] - 1) * (sides[1] - 1);
    let rank_one = |state: &State| {
        beyond_chance(
            state.sse - free_sse,
            constraints(state.lambda.len()),
            variance,
            rounding,
        )
    };
    let chance = |sigmas: f64| sigmas <= limits::STRUCTURE_SIGMAS;

    let mut state = State::new(
        target,
        inside.clone(),
        leading_participations(&residues, target.sides)?,
        false,
    )?;
    if sides[1] > 1 || asked == ShapeModel::Rank1 {
        state = state.refined(target, Enough::SumOfSquares(variance));
    }
    let found_free = state.lambda.len();
    if asked == ShapeModel::Auto && !fixed_order && sides[1] > 1 {
        let limit = threshold(sides[0] + sides[1], work.lines()) * variance;
        // residues of each FRF by itself are the model's start
        let free = work.lines().saturating_sub(found.refined.powers.len());
        let most = free.saturating_sub(outside.len() + 1);
        state = grown(
            target,
            state,
            limit,
            Enough::SumOfSquares(variance),
            &|state| state.lambda.len() >= most || chance(rank_one(state)),
        )?;
        state = shed(target, state, variance, limit);
    }
    let sigmas = rank_one(&state);
    if asked == ShapeModel::Auto && !chance(sigmas) {
        return Ok(Search::Refused(sigmas));
    }
    let added = state.lambda.len().saturating_sub(found_free);
    let mut evidence = format!("one shape per mode ({sigmas:+.1} sigma of chance");
    if added > 0 {
        evidence += &format!(", {added} of {} modes seen only so", state.lambda.len());
    }
    evidence.push(')');

    // each mode keeps one complex factor by rank one, two real ones by being real: phases
    // of shape and participation
    let phases = state.lambda.len() * (sides[0] + sides[1] - 1);
    if asked != ShapeModel::Rank1 {
        let start = State::new(
            target,
            state.lambda.clone(),
            state.participation.clone(),
            true,
        )?;
        let real = start.refined(target, Enough::Fine);
        let sigmas = beyond_chance(real.sse - state.sse, phases, variance, rounding);
        if asked == ShapeModel::Real || chance(sigmas) {
            evidence += &format!(", real ({sigmas:+.1} sigma)");
            state = real;
        } else if sides[1] == 1 {
            return Ok(Search::Inapplicable);
        }
    }
    if !state.real {
        state = state.refined(target, Enough::Fine);
    }
    let real = state.real;
    let free = found.refined.projection.residual.iter();
    let free_sse: f64 = free.map(|v| v.norm_sqr()).sum();
    let held = (work, sides[0] * sides[1]);
    let as_saved = |state: State| -> Result<Saved, LinalgError> {
        let (poles, state) = merged([target, &whole], state, variance, swapped)?;
        let bound = constraints(state.lambda.len()) + if real { phases } else { 0 };
        let borne = |sse: f64| !is_too_much(sse - free_sse, bound, variance, rounding, held);
        let around = Around::new(
            &whole,
            &state,
            (&outside, &found.refined.powers),
            (work.columns() as f64 + limits::AROUND_GAIN) * variance,
            &borne,
        )?;
        Ok(Saved {
            poles,
            borne: borne(around.sse),
            around,
        })
    };
    let mut saved = as_saved(state.clone())?;
    // what the search took for a mode while poles outside could not have their place
    let limit = threshold(sides[0] + sides[1], work.lines()) * variance;
    for n in (0..state.lambda.len()).rev() {
        let loss = state.lambda[n].im / state.lambda[n].re;
        if fixed_order || asked != ShapeModel::Auto || loss < tol::BACKGROUND_LOSS {
            continue;
        }
        let Ok(fewer) = state.without(target, n) else {
            continue;
        };
        let fewer = fewer.refined(target, Enough::Fine);
        let tried = as_saved(fewer.clone())?;
        if tried.around.sse - saved.around.sse < limit {
            (state, saved) = (fewer, tried);
        }
    }
    let Saved {
        poles,
        around,
        borne,
    } = saved;
    let mut moved = around.poles.into_iter();
    let mut others: Vec<(Complex64, Option<Complex64>)> = Vec::new();
    for (n, &pole) in outside.iter().enumerate() {
        let to = if fused(&outside, n) {
            None
        } else {
            moved.next()
        };
        others.push((pole, to));
    }
    let added = moved.collect();
    Ok(Search::Found(Structured {
        poles,
        replaced: inside,
        others,
        added,
        borne,
        real,
        evidence,
    }))
}

/// A structure with the poles beside it.
struct Saved {
    poles: Vec<StructuredPole>,
    around: Around,
    /// True where it leaves no more than chance.
    borne: bool,
}

/// Columns to pairs, (column, eliminated · other). Every pair is there, response by
/// response.
fn by_pair<'a>(data: &DataLayout, found: &'a PoleEstimate, swapped: bool) -> Cow<'a, Array2<f64>> {
    let (responses, references) = (data.responses.len(), data.references.len());
    let back = match &found.back {
        Some(back) => Cow::Borrowed(back),
        None => Cow::Owned(Array2::eye(found.work.columns())),
    };
    if !swapped {
        return back;
    }
    let mut turned = Array2::zeros(back.dim().f());
    for (mut column, l) in turned.columns_mut().into_iter().zip(0..) {
        column.assign(&back.column((l % responses) * references + l / responses));
    }
    Cow::Owned(turned)
}

/// Participations that come nearest to free residues: (mode, other).
fn leading_participations(
    residues: &Array2<Complex64>,
    sides: [usize; 2],
) -> Result<Array2<Complex64>, LinalgError> {
    let leading = |n: usize| -> Result<Array1<Complex64>, LinalgError> {
        let matrix = Array2::from_shape_fn(sides, |(i, j)| residues[[n, i * sides[1] + j]]);
        Ok(strongest(&matrix, 1)?.swap_remove(0).1)
    };
    let rows = (0..residues.nrows())
        .into_par_iter()
        .map(leading)
        .collect::<Result<Vec<_>, LinalgError>>()?;
    let mut out = Array2::zeros((residues.nrows(), sides[1]));
    out.rows_mut()
        .into_iter()
        .zip(&rows)
        .for_each(|(mut out, row)| out.assign(row));
    Ok(out)
}

/// Adds modes until `holds`, while one more takes more than `limit` out of the sum of
/// squares.
fn grown(
    target: &Target,
    mut state: State,
    limit: f64,
    settled: Enough,
    holds: &dyn Fn(&State) -> bool,
) -> Result<State, LinalgError> {
    for _ in 0..limits::GROWTH_MOST {
        if holds(&state) {
            break;
        }
        let Some((pole, along)) = crate::shapes::growth::candidate(target, &state, limit)? else {
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
    Ok(state.refined(target, settled))
}

/// Takes out modes that are uncertain because the others explain the data as well without
/// them: to `limit` of the sum of squares.
fn shed(target: &Target, mut state: State, variance: f64, limit: f64) -> State {
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

/// Poles with their shapes; two that lie nearer than their error bars become one of rank
/// two where the sum of squares does not mind. The search may have been on a condensed
/// target; shapes are those of the whole.
fn merged(
    [target, whole]: [&Target; 2],
    mut state: State,
    variance: f64,
    swapped: bool,
) -> Result<(Vec<StructuredPole>, State), LinalgError> {
    let mut owner: Vec<usize> = (0..state.lambda.len()).collect();
    let mut spread = state.spread();
    for n in 1..owner.len() {
        let near = (0..n).filter(|&m| owner[m] == m).find(|&m| {
            let allowed =
                variance * (spread[m].iter().sum::<f64>() + spread[n].iter().sum::<f64>());
            (state.lambda[m] - state.lambda[n]).norm_sqr() < limits::REPEATED_SIGMAS * allowed
        });
        let Some(m) = near else { continue };
        let share = [0, 1].map(|d| spread[n][d] / (spread[m][d] + spread[n][d]));
        let delta = state.lambda[m] - state.lambda[n];
        let mut lambda = state.lambda.clone();
        lambda[m] = lambda[n] + Complex64::new(delta.re * share[0], delta.im * share[1]);
        lambda[n] = lambda[m];
        let Ok(one) = State::new(target, lambda, state.participation.clone(), state.real) else {
            continue;
        };
        if one.sse - state.sse
            < limits::REPEATED_SIGMAS * variance + limits::STRUCTURE_ROUNDING * target.energy
        {
            state = one;
            spread = state.spread();
            owner[n] = m;
        }
    }
    let state = State::new(whole, state.lambda, state.participation, state.real)?;
    let shape = &state.shapes.shape;
    let shapes = if swapped {
        [&state.participation, shape]
    } else {
        [shape, &state.participation]
    };
    let first: Vec<usize> = (0..owner.len()).filter(|&n| owner[n] == n).collect();
    let poles = first
        .into_iter()
        .map(|n| {
            let rows: Vec<usize> = (0..owner.len()).filter(|&m| owner[m] == n).collect();
            let [shape, participation] = shapes.map(|all| all.select(Axis(0), &rows));
            StructuredPole {
                lambda: state.lambda[n],
                spread: spread[n],
                shape,
                participation,
            }
        })
        .collect();
    Ok((poles, state))
}
