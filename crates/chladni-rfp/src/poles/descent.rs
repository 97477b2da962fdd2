//! The search for the likeliest poles: Gauss–Newton steps with Levenberg–Marquardt
//! damping (theory.md, eq. 12), for any way of computing the matrix and the gradient.

use crate::damping::gram::Beside;
use crate::damping::law::{is_rational, oscillating};
use crate::data::columns::Columns;
use crate::poles::limits;
use crate::tolerances as tol;
use chladni_linalg::solve_hermitian;
use ndarray::{Array2, ArrayView1, Axis};
use num_complex::Complex64;

/// Gauss–Newton matrix, (n, n), and gradient, (n, 1), of the poles.
pub(crate) struct NewtonSystem {
    pub information: Array2<Complex64>,
    pub gradient: Array2<Complex64>,
}

impl NewtonSystem {
    /// The step with the diagonal of the matrix raised by the part `damping` of itself; `None`
    /// where that cannot be solved.
    fn damped_step(&self, damping: f64) -> Option<Array2<Complex64>> {
        let mut damped = self.information.clone();
        for value in damped.diag_mut() {
            *value = Complex64::new(value.re * (1.0 + damping) + f64::MIN_POSITIVE, 0.0);
        }
        solve_hermitian(damped.view(), self.gradient.view()).ok()
    }

    /// Re stepᴴ·gradient: fall of the sum of squares by a step, if the model were linear.
    fn promised_fall(&self, step: &Array2<Complex64>) -> f64 {
        let parts = step.iter().zip(&self.gradient);
        parts.map(|(step, value)| (step.conj() * value).re).sum()
    }
}

/// The data of a search.
pub(crate) struct SearchData<'a> {
    /// Lines with the residual terms and the data.
    pub beside: Beside<'a, 1>,
    /// Sum of squares of the data.
    pub energy: f64,
}

impl<'a> SearchData<'a> {
    /// On the lines and columns of `work`, with the residual terms x^`powers`.
    pub fn new(work: &'a Columns, powers: &'a [i32]) -> Self {
        Self {
            beside: Beside::new(work, powers, [work.b.view()]),
            energy: work.energy(),
        }
    }
}

/// One set of poles, with all that a step from them needs.
pub(crate) trait Point: Sized {
    /// True if another kind of point can take over the search where this kind cannot be computed.
    const HAS_FALLBACK: bool;
    /// Everything linear at the poles `lambda`; `None` if it cannot be computed.
    fn at(search: &SearchData, lambda: &[Complex64]) -> Option<Self>;
    /// Residual sum of squares.
    fn sse(&self) -> f64;
    /// Rounding error of [`Self::sse`].
    fn rounding(&self, energy: f64) -> f64;
    /// Matrix and gradient of the next step.
    fn system(&self, search: &SearchData, lambda: &[Complex64]) -> NewtonSystem;
}

/// Largest step a pole may take at once: half a bandwidth, and more the farther it lies
/// outside the band.
fn step_cap(work: &Columns, lambda: Complex64) -> f64 {
    let (low, high) = work.range();
    let outside = (low - lambda.re).max(lambda.re - high).max(0.0);
    limits::STEP_INSIDE * lambda.im + limits::STEP_OUTSIDE * outside
}

/// A pole after a step to `next`, held where a model file can store it: with a loss and a natural
/// frequency above zero, and in the viscous law less than critical damping. A pole outside the
/// band, which stands for residual terms, would otherwise be left out of the file with all that it
/// explains. A structural pole in the band is not held: its lines determine it.
fn still_physical(work: &Columns, pole: Complex64, next: Complex64) -> Complex64 {
    if is_rational(work.law) && work.in_band(next) {
        return next;
    }
    let kept = |next: f64, before: f64| {
        if before > 0.0 {
            next.max(limits::KEPT * before)
        } else {
            next
        }
    };
    let floor = limits::FAR_BELOW * work.range().0;
    let re = kept(next.re, pole.re).max(floor.min(pole.re));
    let im = kept(next.im, pole.im);
    oscillating(work.law, Complex64::new(re, im), pole)
}

/// A search under way.
pub(crate) struct Descent<'a> {
    pub search: &'a SearchData<'a>,
    /// Current poles.
    pub lambda: Vec<Complex64>,
    damping: f64,
    /// Steps that may still be made.
    pub steps: usize,
}

impl<'a> Descent<'a> {
    /// A search from the poles `start`, for so many steps.
    pub fn new(search: &'a SearchData<'a>, start: &[Complex64], steps: usize) -> Self {
        let steps = if start.is_empty() { 0 } else { steps };
        Self {
            search,
            lambda: start.to_vec(),
            damping: tol::LM_START,
            steps,
        }
    }

    /// The point at the current poles; `None` if it cannot be computed.
    pub fn point<P: Point>(&self) -> Option<P> {
        P::at(self.search, &self.lambda)
    }

    /// Fall of the sum of squares by a whole Gauss–Newton step, if the model were linear.
    pub fn promised_fall<P: Point>(&self, point: &P) -> f64 {
        let newton = point.system(self.search, &self.lambda);
        let step = solve_hermitian(newton.information.view(), newton.gradient.view());
        step.map_or(f64::INFINITY, |step| newton.promised_fall(&step))
    }

    /// Makes steps until the largest is below `tolerance` half-bandwidths, or until one promises
    /// far less than the noise of one value: a pole that the data hardly determine would move for
    /// ever. Returns true at such an end, or if no step helps any more; false if the steps were
    /// too few, or if a fallback has to go on.
    pub fn run<P: Point>(&mut self, point: &mut P, tolerance: f64) -> bool {
        let mut refused = None;
        while self.steps > 0 {
            self.steps -= 1;
            let newton = refused
                .take()
                .unwrap_or_else(|| point.system(self.search, &self.lambda));
            let Some(step) = newton.damped_step(self.damping) else {
                if self.damp_more(limits::LM_LEAST_UNSOLVED) {
                    return true;
                }
                refused = Some(newton);
                continue;
            };
            let (trial, largest) = self.moved(step.index_axis(Axis(1), 0));
            let negligible =
                limits::PROMISED * point.sse() / self.search.beside.work.b.len() as f64;
            let is_last = largest < tolerance || newton.promised_fall(&step) < negligible;
            match P::at(self.search, &trial) {
                // near the end rounding decides which sum of squares is the smaller: it
                // must not refuse good steps
                Some(next) if next.sse() <= point.sse() + point.rounding(self.search.energy) => {
                    self.lambda = trial;
                    *point = next;
                    self.damping *= tol::LM_DOWN;
                }
                None if P::HAS_FALLBACK => return false,
                _ => refused = Some(newton),
            }
            if is_last || (refused.is_some() && self.damp_more(tol::LM_LEAST)) {
                return true;
            }
        }
        false
    }

    /// As [`Self::run`]; true also where all steps were made.
    pub fn ends<P: Point>(&mut self, point: &mut P, tolerance: f64) -> bool {
        self.run(point, tolerance) || self.steps == 0
    }

    /// Raises the damping, to `least` at least. True where it is so high that no step can help.
    fn damp_more(&mut self, least: f64) -> bool {
        self.damping = (self.damping * tol::LM_UP).max(least);
        self.damping > tol::LM_GIVE_UP
    }

    /// Poles after a step, and its largest part in half-bandwidths.
    fn moved(&self, step: ArrayView1<Complex64>) -> (Vec<Complex64>, f64) {
        let work = self.search.beside.work;
        let mut largest = 0.0_f64;
        let capped = |(&pole, &delta): (&Complex64, &Complex64)| {
            let cap = step_cap(work, pole);
            let delta = if delta.norm() > cap {
                delta * (cap / delta.norm())
            } else {
                delta
            };
            largest = largest.max(delta.norm() / pole.im);
            still_physical(work, pole, pole + delta)
        };
        (self.lambda.iter().zip(step).map(capped).collect(), largest)
    }
}
