//! The magnitude iteration of [`super::mls`], many drives at a time.
//!
//! Majorisation: with p_k the nearest value of S_k to h_k·A (same phase, limited
//! magnitude), A becomes the least-squares fit to p; p overshoots by the factor
//! `tolerances::MLS_RELAXATION`. Rows that keep their limits have p_k = h_k·A, so that
//! a step is the fit to the own field of A and the pull of the others alone. All drives
//! take a step together; after some steps only those go on that serve most.

use crate::least_squares::LeastSquares;
use crate::problem::{amplitude, Drive, Problem};
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::{matmul, matmul_h};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use std::cmp::Ordering;

/// So many steps, and so many drives that go on after them.
pub(crate) type Round = (usize, usize);

/// The quantities that every step over the rows of a problem takes, found once.
pub(crate) struct Steps<'a> {
    problem: &'a Problem,
    /// From pulls of rows to a change of the drive; see
    /// [`LeastSquares::inverse_and_own_fit`].
    inverse: Array2<Complex64>,
    own_fit: Array2<Complex64>,
}

impl<'a> Steps<'a> {
    /// Of a factorised problem.
    ///
    /// # Errors
    /// None: sizes fit.
    pub(crate) fn new(least_squares: &LeastSquares<'a>) -> Result<Self> {
        let [inverse, own_fit] = least_squares.inverse_and_own_fit()?;
        Ok(Self {
            problem: least_squares.problem,
            inverse,
            own_fit,
        })
    }
}

/// Drives on their way.
pub(crate) struct Race<'a> {
    steps: &'a Steps<'a>,
    /// Axes (actuator, drive).
    drives: Array2<Complex64>,
    /// By what factor each wants its rows inside their limits.
    margins: Vec<f64>,
}

impl<'a> Race<'a> {
    /// From all starts, each with its margin in dB.
    pub(crate) fn new(steps: &'a Steps<'a>, starts: &[(&Drive, f64)]) -> Self {
        let mut drives = Array2::zeros((steps.problem.rows.mobility.ncols(), starts.len()));
        for (mut column, (start, _)) in drives.columns_mut().into_iter().zip(starts) {
            column.assign(start);
        }
        let mut race = Self {
            steps,
            drives,
            margins: starts
                .iter()
                .map(|(_, margin_db)| 10f64.powf(margin_db / 20.0))
                .collect(),
        };
        race.take_best_gains();
        race
    }

    /// A round; those that serve most go on, with their best gain, the best first.
    pub(crate) fn run(&mut self, (steps, kept): Round) {
        for _ in 0..steps {
            self.step();
        }
        let keys = self.take_best_gains();
        let mut order: Vec<usize> = (0..keys.len()).collect();
        order.sort_by(|&a, &b| better_first(&keys[a], &keys[b]).then(a.cmp(&b)));
        order.truncate(kept);
        self.drives = self.drives.select(Axis(1), &order);
        self.margins = order.iter().map(|&k| self.margins[k]).collect();
    }

    /// Those that are left.
    pub(crate) fn into_drives(self) -> Vec<Drive> {
        self.drives
            .columns()
            .into_iter()
            .map(|column| column.to_owned())
            .collect()
    }

    fn step(&mut self) {
        let Steps {
            problem:
                Problem {
                    limits,
                    rows,
                    row_weights,
                    ..
                },
            inverse,
            own_fit,
        } = self.steps;
        let mut pulls = matmul(rows.mobility.view(), self.drives.view());
        for (mut column, margin) in pulls.columns_mut().into_iter().zip(&self.margins) {
            let (felt, quiet) = (limits.hot_m_per_s * margin, limits.cold_m_per_s / margin);
            for (k, value) in column.iter_mut().enumerate() {
                let (keeps, limit) = match k < rows.hot {
                    true => (value.norm_sqr() >= felt * felt, felt),
                    false => (value.norm_sqr() <= quiet * quiet, quiet),
                };
                *value = if keeps {
                    Complex64::ZERO
                } else {
                    (relaxed(*value, limit) - *value) * row_weights[k]
                };
            }
        }
        let pulled = matmul_h(rows.mobility.view(), pulls.view());
        self.drives =
            matmul(own_fit.view(), self.drives.view()) + matmul(inverse.view(), pulled.view());
    }

    /// Scales every drive by the gain that serves most rows; what each is judged by then:
    /// least zone, total, κ.
    fn take_best_gains(&mut self) -> Vec<[f64; 3]> {
        let problem = self.steps.problem;
        let amplitudes = matmul(problem.rows.mobility.view(), self.drives.view()).map(amplitude);
        let deviations = problem.covariance.deviations(self.drives.view());
        let columns = self.drives.columns_mut().into_iter();
        let columns = columns.zip(amplitudes.columns()).zip(deviations);
        columns
            .map(|((mut column, amplitudes), deviation)| {
                let gain = problem.best_gain(&amplitudes.to_owned(), &column.to_owned());
                column.mapv_inplace(|weight| weight * gain);
                let score = problem.score_of(&(&amplitudes * gain), deviation * gain);
                [score.min_ratio, score.success_ratio, score.kappa]
            })
            .collect()
    }
}

/// `value` moved along its own phase to the magnitude `limit`, and beyond by the
/// relaxation.
fn relaxed(value: Complex64, limit: f64) -> Complex64 {
    let before = amplitude(&value);
    let moved = before + tolerances::MLS_RELAXATION * (limit - before);
    if before > 0.0 {
        value * (moved / before)
    } else {
        moved.into()
    }
}

/// The more important entries decide; equal ones hand over to the next.
pub(crate) fn better_first<const N: usize>(a: &[f64; N], b: &[f64; N]) -> Ordering {
    a.iter()
        .zip(b)
        .map(|(a, b)| b.total_cmp(a))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_still_row_gets_some_phase_and_a_loud_one_is_reduced() {
        assert_eq!(
            relaxed(Complex64::ZERO, 1.0),
            Complex64::from(tolerances::MLS_RELAXATION)
        );
        let value = Complex64::new(0.0, 2.0);
        let expected = 2.0 - tolerances::MLS_RELAXATION;
        assert!((relaxed(value, 1.0) - Complex64::new(0.0, expected)).norm() < 1e-15);
    }
}
