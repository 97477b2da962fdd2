//! The search for the likeliest poles: Gauss–Newton steps with Levenberg–Marquardt
//! damping (theory.md, eq. 12), whatever makes the matrix and the gradient.

use crate::damping::law::{is_rational, oscillating};
use crate::data::columns::Columns;
use crate::poles::limits;
use crate::tolerances as tol;
use chladni_linalg::solve_hermitian;
use ndarray::{Array2, ArrayView1, Axis};
use num_complex::Complex64;

/// One set of poles as the search sees it.
pub(crate) trait Point: Sized {
    /// False if another kind of point goes on where this one cannot be computed any more.
    const LAST: bool;
    /// Everything linear at the poles `lambda`; `energy`: of the data. `None` if it cannot be
    /// computed.
    fn at(work: &Columns, energy: f64, lambda: &[Complex64], powers: &[i32]) -> Option<Self>;
    /// Sum of squares left.
    fn sse(&self) -> f64;
    /// The part that rounding may add to it.
    fn rounding(&self, energy: f64) -> f64;
    /// Gauss–Newton matrix and gradient.
    fn system(
        &self,
        work: &Columns,
        lambda: &[Complex64],
    ) -> (Array2<Complex64>, Array2<Complex64>);
}

/// Largest step a pole may take at once: half a bandwidth, and more the farther it lies
/// outside the band.
fn step_cap(work: &Columns, lambda: Complex64) -> f64 {
    let (low, high) = work.range();
    let outside = (low - lambda.re).max(lambda.re - high).max(0.0);
    limits::STEP_INSIDE * lambda.im + limits::STEP_OUTSIDE * outside
}

/// A pole after a step, held where a model file can store it: with a loss and a natural
/// frequency above zero, and in the viscous law less than critical damping. Otherwise a pole
/// that stands for the world outside the band would be left out of the file, with all that it
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

/// Re stepᴴ·gradient.
fn along(step: &Array2<Complex64>, gradient: &Array2<Complex64>) -> f64 {
    let parts = step.iter().zip(gradient);
    parts.map(|(step, value)| (step.conj() * value).re).sum()
}

/// A search under way.
pub(crate) struct Descent<'a> {
    /// Data.
    pub work: &'a Columns,
    /// Powers of x of the residual terms.
    pub powers: &'a [i32],
    /// Sum of squares of the data.
    energy: f64,
    /// Poles as they stand.
    pub lambda: Vec<Complex64>,
    damping: f64,
    /// Steps left.
    pub steps: usize,
}

impl<'a> Descent<'a> {
    /// From the poles `start`, for so many steps.
    pub fn new(work: &'a Columns, start: &[Complex64], powers: &'a [i32], steps: usize) -> Self {
        let steps = if start.is_empty() { 0 } else { steps };
        Self {
            work,
            powers,
            energy: work.energy(),
            lambda: start.to_vec(),
            damping: tol::LM_START,
            steps,
        }
    }

    /// The point where the search stands; `None` if it cannot be computed.
    pub fn here<P: Point>(&self) -> Option<P> {
        P::at(self.work, self.energy, &self.lambda, self.powers)
    }

    /// Fall of the sum of squares by a whole Gauss–Newton step, if the model were linear.
    pub fn promised<P: Point>(&self, point: &P) -> f64 {
        let (information, gradient) = point.system(self.work, &self.lambda);
        let step = solve_hermitian(information.view(), gradient.view());
        step.map_or(f64::INFINITY, |step| along(&step, &gradient))
    }

    /// Steps until the largest is `tolerance` of a half-bandwidth, or until one promises far
    /// less than the noise of one value: a pole that the data hardly determine would move for
    /// ever. True at such an end, or if no step helps any more.
    pub fn go<P: Point>(&mut self, point: &mut P, tolerance: f64) -> bool {
        let mut system = None;
        while self.steps > 0 {
            self.steps -= 1;
            let (information, gradient) = system
                .take()
                .unwrap_or_else(|| point.system(self.work, &self.lambda));
            let mut damped = information.clone();
            for i in 0..self.lambda.len() {
                let diagonal = information[[i, i]].re;
                damped[[i, i]] =
                    Complex64::new(diagonal * (1.0 + self.damping) + f64::MIN_POSITIVE, 0.0);
            }
            let Ok(step) = solve_hermitian(damped.view(), gradient.view()) else {
                self.damping = (self.damping * tol::LM_UP).max(limits::LM_LEAST_UNSOLVED);
                system = Some((information, gradient));
                if self.damping > tol::LM_GIVE_UP {
                    return true;
                }
                continue;
            };
            let (trial, largest) = self.moved(step.index_axis(Axis(1), 0));
            let promised = along(&step, &gradient);
            let enough = largest < tolerance
                || promised < limits::PROMISED * point.sse() / self.work.b.len() as f64;
            match P::at(self.work, self.energy, &trial, self.powers) {
                // near the end rounding decides which sum of squares is the smaller: it
                // must not refuse good steps
                Some(next) if next.sse() <= point.sse() + point.rounding(self.energy) => {
                    self.lambda = trial;
                    *point = next;
                    self.damping *= tol::LM_DOWN;
                    if enough {
                        return true;
                    }
                }
                None if !P::LAST => return false,
                _ if enough => return true,
                _ => {
                    self.damping = (self.damping * tol::LM_UP).max(tol::LM_LEAST);
                    system = Some((information, gradient));
                    if self.damping > tol::LM_GIVE_UP {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Poles after a step, and its largest part in half-bandwidths.
    fn moved(&self, step: ArrayView1<Complex64>) -> (Vec<Complex64>, f64) {
        let mut largest = 0.0_f64;
        let capped = |(&pole, &delta): (&Complex64, &Complex64)| {
            let cap = step_cap(self.work, pole);
            let delta = if delta.norm() > cap {
                delta * (cap / delta.norm())
            } else {
                delta
            };
            largest = largest.max(delta.norm() / pole.im);
            still_physical(self.work, pole, pole + delta)
        };
        (self.lambda.iter().zip(step).map(capped).collect(), largest)
    }
}
