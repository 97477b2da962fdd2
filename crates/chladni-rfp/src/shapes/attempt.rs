//! An attempt at structure: some poles have one shape each, all others stay free in every
//! FRF.

use crate::data::layout::DataLayout;
use crate::data::options::ShapeModel;
use crate::poles::estimate::PoleEstimate;
use crate::poles::significance::threshold;
use crate::shapes::around::{fused, Around, Rest};
use crate::shapes::from_moments::{close_groups, from_moments};
use crate::shapes::limits;
use crate::shapes::order::{grown, merged, shed};
use crate::shapes::residues::{beyond_chance, most_by_chance, strongest};
use crate::shapes::step::{Enough, State};
use crate::shapes::structure::{Search, Structured, StructuredPole};
use crate::shapes::target::{free_residues, Target};
use crate::tolerances as tol;
use chladni_linalg::blocked::blocked_matmul_mixed;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::borrow::Cow;

/// True where chance explains so many standard deviations of χ².
pub(super) fn is_chance(sigmas: f64) -> bool {
    sigmas <= limits::STRUCTURE_SIGMAS
}

/// Poles that have one shape each, all others free in every FRF.
pub(super) struct Attempt<'a> {
    found: &'a PoleEstimate,
    asked: ShapeModel,
    fixed_order: bool,
    inside: Vec<Complex64>,
    outside: Vec<Complex64>,
    whole: Target<'a>,
    condensed: Option<Target<'a>>,
    /// True where references are eliminated, and responses kept in the search: the few are.
    swapped: bool,
    /// Free residues of the poles inside, (pole, column), and the sum of squares that they
    /// leave.
    residues: Array2<Complex64>,
    free_sse: f64,
}

/// A structure with the poles beside it.
struct Saved {
    poles: Vec<StructuredPole>,
    around: Around,
    /// True where it leaves no more than chance.
    borne: bool,
}

impl<'a> Attempt<'a> {
    /// `belongs`: true for the poles that have one shape each.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(
        data: &DataLayout,
        found: &'a PoleEstimate,
        (asked, fixed_order): (ShapeModel, bool),
        belongs: impl Fn(&Complex64) -> bool,
    ) -> Result<Self, LinalgError> {
        let (inside, outside): (Vec<Complex64>, Vec<Complex64>) =
            found.refined.lambda.iter().partition(|l| belongs(l));
        // eliminated are the many DOFs, kept in the search the few
        let (responses, references) = (data.responses.len(), data.references.len());
        let swapped = references > responses;
        let sides = match swapped {
            true => [references, responses],
            false => [responses, references],
        };
        let powers = &found.refined.powers;
        let back = by_pair(data, found, swapped);
        let whole = Target::new(&found.work, &outside, powers, back, sides)?;
        let condensed = whole.condensed();
        let (residues, free_sse) = free_residues(condensed.as_ref().unwrap_or(&whole), &inside)?;
        Ok(Self {
            found,
            asked,
            fixed_order,
            inside,
            outside,
            whole,
            condensed,
            swapped,
            residues,
            free_sse,
        })
    }

    fn target(&self) -> &Target<'a> {
        self.condensed.as_ref().unwrap_or(&self.whole)
    }

    /// Sum of squares that a mode must take out, or a structure may leave, to count.
    fn limit(&self) -> f64 {
        let sides = self.whole.sides;
        threshold(sides[0] + sides[1], self.whole.work.lines()) * self.found.variance
    }

    /// Rounding of a difference of sums of squares.
    fn rounding(&self) -> f64 {
        limits::STRUCTURE_ROUNDING * self.target().energy
    }

    /// Constraints of one shape for each mode.
    fn constraints(&self, state: &State) -> usize {
        let [own, other] = self.whole.sides;
        2 * state.lambda.len() * (own - 1) * (other - 1)
    }

    /// Constraints of real shapes besides. Each mode keeps one complex factor by rank one,
    /// two real ones by being real: phases of shape and participation.
    fn phases(&self, state: &State) -> usize {
        let [own, other] = self.whole.sides;
        state.lambda.len() * (own + other - 1)
    }

    /// Standard deviations of chance by which one shape for each mode leaves more than
    /// free residues.
    pub fn beyond_free(&self, state: &State) -> f64 {
        let rise = state.sse - self.free_sse;
        let constraints = self.constraints(state);
        beyond_chance(rise, constraints, self.found.variance, self.rounding())
    }

    /// The modes with one shape each, as many as the data show; `known`: such a state of
    /// the poles of the band, from which the search is short.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn one_shape_each(&self, known: Option<&State>) -> Result<State, LinalgError> {
        let (target, variance) = (self.target(), self.found.variance);
        let several = self.whole.sides[1] > 1;
        let mut state = match known.and_then(|state| self.taken_from(state)) {
            Some(state) => state?,
            None => self.start()?,
        };
        if several || self.asked == ShapeModel::Rank1 {
            state = state.refined(target, Enough::SumOfSquares(variance));
        }
        if self.asked == ShapeModel::Auto && !self.fixed_order && several {
            // residues of each FRF by itself are the model's start
            let powers = self.found.refined.powers.len();
            let free = self.whole.work.lines().saturating_sub(powers);
            let most = free.saturating_sub(self.outside.len() + 1);
            let holds = |state: &State| {
                let sigmas = self.beyond_free(state);
                state.lambda.len() >= most || sigmas <= limits::GROWTH_SIGMAS
            };
            let enough = Enough::SumOfSquares(variance);
            state = grown(target, state, self.limit(), enough, &holds)?;
            state = shed(target, state, variance, self.limit());
        }
        Ok(state)
    }

    /// The start of the search: participations that come nearest to free residues, or close poles
    /// from the moments of these if that leaves less.
    fn start(&self) -> Result<State, LinalgError> {
        let target = self.target();
        let residues = blocked_matmul_mixed(&self.residues, target.back.view());
        let along = leading_participations(&residues, target.sides)?;
        let start = State::new(target, self.inside.clone(), along.clone(), false)?;
        let groups = close_groups(&self.inside);
        if groups.is_empty() {
            return Ok(start);
        }
        let (mut lambda, mut along) = (self.inside.clone(), along);
        let mut is_other = false;
        for group in groups {
            let poles: Vec<Complex64> = group.iter().map(|&n| self.inside[n]).collect();
            let matrices = group.iter().map(|&n| of_pole(&residues, target.sides, n));
            let Some((poles, rows)) = from_moments(&poles, &matrices.collect::<Vec<_>>())? else {
                continue;
            };
            for ((&n, pole), row) in group.iter().zip(poles).zip(rows.rows()) {
                lambda[n] = pole;
                along.row_mut(n).assign(&row);
            }
            is_other = true;
        }
        if !is_other {
            return Ok(start);
        }
        // modes that coincide in pole and participations have no shapes: the first start is left
        let other = State::new(target, lambda, along, false).ok();
        Ok(other.filter(|other| other.sse < start.sse).unwrap_or(start))
    }

    /// The modes of another attempt that are in the band, if they are those of this one.
    fn taken_from(&self, state: &State) -> Option<Result<State, LinalgError>> {
        let in_band = |n: &usize| self.whole.work.in_band(state.lambda[*n]);
        let kept: Vec<usize> = (0..state.lambda.len()).filter(in_band).collect();
        let same = kept.len() == self.inside.len();
        same.then(|| state.of_modes(self.target(), &kept))
    }

    /// True where the poles outside, with one place each for all FRFs, leave so much more
    /// than chance that no pole that could be added makes it good.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn is_hopeless(&self, state: &State) -> Result<bool, LinalgError> {
        let state = self.on_whole(state)?;
        let rest = Rest::new(&self.whole, &state, &self.found.refined.powers);
        let placed = rest.placed(&self.outside)?;
        let excess = placed.sse - self.most(&state, true);
        Ok(excess > 0.0 && rest.gain_in_sight(&placed)? * limits::GAIN_BEYOND_SIGHT < excess)
    }

    /// Largest sum of squares that chance leaves of the model as saved.
    fn most(&self, state: &State, real: bool) -> f64 {
        let free: f64 = self.found.refined.projection.sse;
        let [own, other] = self.whole.sides;
        let constraints = self.constraints(state) + if real { self.phases(state) } else { 0 };
        let held = (self.whole.work, own * other);
        free + most_by_chance(constraints, self.found.variance, self.rounding(), held)
    }

    /// The search may have been on a condensed target; shapes are those of the whole.
    fn on_whole<'s>(&self, state: &'s State) -> Result<Cow<'s, State>, LinalgError> {
        if self.condensed.is_none() {
            return Ok(Cow::Borrowed(state));
        }
        let all: Vec<usize> = (0..state.lambda.len()).collect();
        state.of_modes(&self.whole, &all).map(Cow::Owned)
    }

    /// The end of the search from modes with one shape each: real where the data admit it,
    /// and the poles beside them as the model is saved.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn searched(&self, state: State) -> Result<Search, LinalgError> {
        let added = state.lambda.len().saturating_sub(self.inside.len());
        let mut evidence = format!(
            "one shape per mode ({:+.1} sigma of chance",
            self.beyond_free(&state)
        );
        if added > 0 {
            evidence += &format!(", {added} of {} modes seen only so", state.lambda.len());
        }
        evidence.push(')');
        let Some(state) = self.with_real_shapes(state, &mut evidence)? else {
            return Ok(Search::Inapplicable);
        };
        let real = state.real;
        let saved = self.without_background(state)?;
        let mut moved = saved.around.poles.into_iter();
        let mut others: Vec<(Complex64, Option<Complex64>)> = Vec::new();
        for (n, &pole) in self.outside.iter().enumerate() {
            let stays = !fused(&self.outside, n);
            others.push((pole, if stays { moved.next() } else { None }));
        }
        Ok(Search::Found(Structured {
            poles: saved.poles,
            replaced: self.inside.clone(),
            others,
            added: moved.collect(),
            borne: saved.borne,
            real,
            evidence,
        }))
    }

    /// Real shapes where they are asked for or leave no more than chance, to the last
    /// digits; `None` where one reference has no real shape, so that nothing is gained.
    fn with_real_shapes(
        &self,
        state: State,
        evidence: &mut String,
    ) -> Result<Option<State>, LinalgError> {
        let target = self.target();
        if self.asked != ShapeModel::Rank1 {
            let real = state.with_real_shapes(target)?;
            let real = real.refined(target, Enough::Fine);
            let rise = real.sse - state.sse;
            let phases = self.phases(&state);
            let sigmas = beyond_chance(rise, phases, self.found.variance, self.rounding());
            if self.asked == ShapeModel::Real || is_chance(sigmas) {
                *evidence += &format!(", real ({sigmas:+.1} sigma)");
                return Ok(Some(real));
            }
            if self.whole.sides[1] == 1 {
                return Ok(None);
            }
        }
        Ok(Some(state.refined(target, Enough::Fine)))
    }

    /// The model as saved without what the search took for a mode while poles outside
    /// could not have their place.
    fn without_background(&self, mut state: State) -> Result<Saved, LinalgError> {
        let mut saved = self.saved(state.clone())?;
        if self.fixed_order || self.asked != ShapeModel::Auto {
            return Ok(saved);
        }
        for n in (0..state.lambda.len()).rev() {
            if state.lambda[n].im < tol::BACKGROUND_LOSS * state.lambda[n].re {
                continue;
            }
            let Ok(fewer) = state.without(self.target(), n) else {
                continue;
            };
            let fewer = fewer.refined(self.target(), Enough::Fine);
            let tried = self.saved(fewer.clone())?;
            if tried.around.sse - saved.around.sse < self.limit() {
                (state, saved) = (fewer, tried);
            }
        }
        Ok(saved)
    }

    /// The model as saved: one shape or more for each pole, and one place for each of the
    /// poles beside them.
    fn saved(&self, state: State) -> Result<Saved, LinalgError> {
        let variance = self.found.variance;
        let (state, merged) = merged(self.target(), state, variance);
        let state = self.on_whole(&state)?;
        let most = self.most(&state, state.real);
        let rest = Rest::new(&self.whole, &state, &self.found.refined.powers);
        let worth = (self.whole.work.columns() as f64 + limits::AROUND_GAIN) * variance;
        let mut around = rest.completed(rest.placed(&self.outside)?, worth, most);
        if self.asked != ShapeModel::Auto && around.sse > most {
            // poles beside cannot make good what shapes that were asked for leave: they would only
            // become many, and lean on each other
            around = rest.placed(&self.outside)?;
        }
        let shape = &state.shapes.shape;
        let shapes = match self.swapped {
            true => [&state.participation, shape],
            false => [shape, &state.participation],
        };
        let all = 0..merged.owner.len();
        let own = all.clone().filter(|&n| merged.owner[n] == n);
        let pole = |n: usize| {
            let rows: Vec<usize> = all.clone().filter(|&m| merged.owner[m] == n).collect();
            let [shape, participation] = shapes.map(|all| all.select(Axis(0), &rows));
            StructuredPole {
                lambda: state.lambda[n],
                spread: merged.spread[n],
                shape,
                participation,
            }
        };
        Ok(Saved {
            poles: own.map(pole).collect(),
            borne: around.sse <= most,
            around,
        })
    }
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

/// The residues of one pole, (own, other).
fn of_pole(residues: &Array2<Complex64>, sides: [usize; 2], n: usize) -> Array2<Complex64> {
    Array2::from_shape_fn(sides.f(), |(i, j)| residues[[n, i * sides[1] + j]])
}

/// Participations that come nearest to free residues: (mode, other).
fn leading_participations(
    residues: &Array2<Complex64>,
    sides: [usize; 2],
) -> Result<Array2<Complex64>, LinalgError> {
    let leading = |n: usize| -> Result<Array1<Complex64>, LinalgError> {
        Ok(strongest(&of_pole(residues, sides, n), 1)?.swap_remove(0).1)
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
