//! The poles beside those that have their shapes, as the model is saved: one place each for
//! all FRFs (theory.md, section 4).

use crate::damping::basis::basis;
use crate::damping::law::{is_rational, loss_bound};
use crate::damping::saved;
use crate::data::columns::Columns;
use crate::data::inner_products::inner;
use crate::poles::descent::SearchData;
use crate::poles::refine::{refined_sum, sum_in_sight, Projection};
use crate::poles::scan::places_beyond;
use crate::shapes::limits;
use crate::shapes::step::State;
use crate::shapes::target::Target;
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_gram, blocked_matmul, blocked_matmul_h, projected};
use chladni_linalg::LinalgError;
use num_complex::Complex64;
use rayon::prelude::*;

/// True where pole `n` is so close to one before it that their residues are large and
/// cancel.
pub(crate) fn fused(poles: &[Complex64], n: usize) -> bool {
    let close = |b: &Complex64| (poles[n] - b).norm() < limits::FUSED * (poles[n].im + b.im);
    poles[..n].iter().any(close)
}

/// The poles beside those that have their shapes, with free residues.
pub(crate) struct Around {
    /// Poles in the x plane.
    pub poles: Vec<Complex64>,
    /// Sum of squares that all together leave.
    pub sse: f64,
}

/// The data less what the poles with shapes explain.
pub(crate) struct Rest<'a> {
    work: Columns,
    powers: &'a [i32],
    /// Number of poles with shapes.
    modes: usize,
    /// Energy of these that the compressed data cannot hold.
    beside: f64,
}

impl<'a> Rest<'a> {
    /// The data less the poles of `state`, a state on `whole`.
    pub fn new(whole: &Target, state: &State, powers: &'a [i32]) -> Self {
        let work = whole.work;
        let columns = basis(work, &state.lambda, &[]);
        let (compressed, beside) = {
            let gram = blocked_gram(columns.view());
            let compressed = whole.compressed(&state.shapes.shape, &state.participation);
            let along = blocked_matmul(gram.view(), compressed.view());
            // Σ rᴴGr over all FRFs is the trace of G·RRᴴ
            let all = (&gram * &state.residue_products()).sum().re;
            let beside = all - inner(compressed.view(), along.view());
            (compressed, beside.max(0.0))
        };
        let mut left = blocked_matmul(columns.view(), compressed.view());
        left.zip_mut_with(&work.b, |value, all| *value = all - *value);
        Self {
            work: work.with_columns(left),
            powers,
            modes: state.lambda.len(),
            beside,
        }
    }

    /// After at most so many steps of refinement.
    fn refined(&self, poles: &[Complex64], steps: usize) -> Result<Around, LinalgError> {
        let work = &self.work;
        let found = refined_sum(work, poles, self.powers, tol::FINE.within(steps))?;
        let (poles, sse) = saved::refined(work, found, self.powers, steps)?;
        Ok(Around {
            sse: sse + self.beside,
            poles,
        })
    }

    /// The same to the end; `None` where poles come into the band, fuse, or become such as
    /// no model file has.
    fn settled(&self, poles: &[Complex64]) -> Option<Around> {
        let around = self.refined(poles, tol::FINE.steps).ok()?;
        let poles = &around.poles;
        let most = loss_bound(self.work.law);
        let stays = |pole: &Complex64| {
            let damped = 0.0 < pole.im && pole.im < most * pole.re;
            damped && pole.re > 0.0 && !self.work.in_band(*pole)
        };
        let sound = poles.iter().all(stays) && (0..poles.len()).all(|n| !fused(poles, n));
        sound.then_some(around)
    }

    /// The poles `outside`, each at its place. The search lets them follow each FRF by
    /// itself, to first order; here they have one place for all.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn placed(&self, outside: &[Complex64]) -> Result<Around, LinalgError> {
        let apart = (0..outside.len()).filter(|&n| !fused(outside, n));
        let apart: Vec<Complex64> = apart.map(|n| outside[n]).collect();
        let before = self.refined(&apart, 0)?;
        let after = self.settled(&apart);
        Ok(after.filter(|one| one.sse < before.sse).unwrap_or(before))
    }

    /// With other places, and with poles added, until no more than `most` is left, while a
    /// change takes out more than `worth`.
    pub fn completed(&self, mut best: Around, worth: f64, most: f64) -> Around {
        for _ in 0..limits::AROUND_MOST {
            if best.sse <= most || best.poles.len() + self.modes >= self.work.lines() / 2 {
                break;
            }
            let to_pay = best.sse - worth;
            let pays = |one: &Around| one.sse < to_pay;
            match self.one_moved(&best, to_pay).filter(pays) {
                Some(better) => best = better,
                None => match self.one_more(&best, to_pay).filter(pays) {
                    Some(better) => best = better,
                    None => break,
                },
            }
        }
        best
    }

    /// One pole in another place: a rise of the sum of squares may keep it from its own.
    fn one_moved(&self, best: &Around, to_pay: f64) -> Option<Around> {
        let places: Vec<Complex64> = places_beyond(&self.work).collect();
        let moves = (0..best.poles.len()).flat_map(|n| places.iter().map(move |to| (n, *to)));
        let moves: Vec<(usize, Complex64)> = moves.collect();
        let with_moved = |(n, to): (usize, Complex64)| {
            let mut poles = best.poles.clone();
            poles[n] = to;
            poles
        };
        let starts = moves.into_iter().map(with_moved).collect();
        self.least(starts, to_pay, |_| true)
    }

    /// One pole more.
    fn one_more(&self, best: &Around, to_pay: f64) -> Option<Around> {
        let with_one_more = |start| [&best.poles[..], &[start]].concat();
        let starts = self.starts(best).into_iter().map(with_one_more);
        self.least(starts.collect(), to_pay, |more| {
            let added = more.poles[more.poles.len() - 1];
            limits::LOSS_ADDED.contains(&(added.im / added.re))
        })
    }

    /// The one of these `starts` that leaves least in the end; of equal ones the first. Those that
    /// leave least after a few steps are followed to it, and more only while none is allowed.
    /// Left out are those that will not come below `to_pay`, as far as that is in sight.
    fn least(
        &self,
        starts: Vec<Vec<Complex64>>,
        to_pay: f64,
        allowed: impl Fn(&Around) -> bool + Sync,
    ) -> Option<Around> {
        let search = SearchData::new(&self.work, self.powers);
        let after_few_steps = |start: &Vec<Complex64>| {
            let few = tol::FINE.within(limits::AROUND_FIRST_STEPS);
            let found = sum_in_sight(&search, start, few);
            found.unwrap_or([f64::INFINITY, f64::NEG_INFINITY])
        };
        let left: Vec<[f64; 2]> = starts.par_iter().map(after_few_steps).collect();
        // a model file of the viscous law has other columns, which may leave less: there nothing is
        // left out
        let in_sight = is_rational(self.work.law);
        let may_pay = |n: &usize| !in_sight || left[*n][1] + self.beside < to_pay;
        let mut order: Vec<usize> = (0..starts.len()).filter(may_pay).collect();
        order.sort_by(|&a, &b| left[a][0].total_cmp(&left[b][0]));
        let settled = |&n: &usize| self.settled(&starts[n]).filter(&allowed);
        order.chunks(limits::AROUND_FOLLOWED).find_map(|followed| {
            let ends: Vec<Around> = followed.par_iter().filter_map(settled).collect();
            ends.into_iter().min_by(|a, b| a.sse.total_cmp(&b.sse))
        })
    }

    /// Places from which a pole is added. Beside a pole that is there, the two stand for it
    /// and its derivative.
    fn starts(&self, best: &Around) -> Vec<Complex64> {
        let beside = best.poles.iter().map(|pole| pole + 2.0 * pole.im);
        places_beyond(&self.work).chain(beside).collect()
    }

    /// The most that one pole more takes out of the sum of squares where it is tried from.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn gain_in_sight(&self, around: &Around) -> Result<f64, LinalgError> {
        let now = Projection::new(&self.work, &around.poles, self.powers)?;
        let tried = basis(&self.work, &self.starts(around), &[]);
        let (_, own) = projected(now.q.view(), tried.view());
        let met = blocked_matmul_h(own.view(), now.residual.view());
        let energy =
            |v: ndarray::ArrayView1<Complex64>| v.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let gains = met
            .rows()
            .into_iter()
            .zip(own.columns())
            .map(|(met, own)| energy(met) / energy(own).max(f64::MIN_POSITIVE));
        Ok(gains.fold(0.0, f64::max))
    }
}
