//! The magnitude iteration of [`super::mls`].
//!
//! Majorisation: with p_k the nearest value of S_k to h_k·A (same phase, limited
//! magnitude), A becomes the least-squares fit to p; p overshoots by the factor
//! `tolerances::MLS_RELAXATION`. Rows that keep their limits have p_k = h_k·A, so that
//! a step is the fit to the own field of A and the pull of the others alone. After some
//! steps only those drives go on that serve most.

use crate::methods::split::Split;
use crate::panel::drive::Drive;
use crate::problems::problem::Problem;
use crate::solving::least_squares::LeastSquares;
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::wide;
use ndarray::{concatenate, Array2, ArrayView1, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use std::cmp::Ordering;

/// So many steps, and so many drives that go on after them.
pub(crate) type Round = (usize, usize);

/// The quantities that every step over the rows of a problem takes, found once.
pub(crate) struct MagnitudeSteps<'a> {
    problem: &'a Problem,
    /// From a drive to the velocities of all rows, then to its fit to these.
    field_and_fit: Split,
    /// From pulls of rows to a change of the drive.
    pull: Split,
}

impl<'a> MagnitudeSteps<'a> {
    /// Of a factorised problem.
    ///
    /// # Errors
    /// None: sizes fit.
    pub(crate) fn new(least_squares: &LeastSquares<'a>) -> Result<Self> {
        let problem = least_squares.problem;
        let [pull, own_fit] = least_squares.pull_and_own_fit()?;
        Ok(Self {
            problem,
            field_and_fit: Split::new(concatenate![Axis(0), problem.rows.mobility, own_fit].view()),
            pull: Split::new(pull.view()),
        })
    }

    /// The drive after so many steps with all rows a `margin` inside their limits, a
    /// factor.
    fn after(&self, steps: usize, drive: ArrayView1<Complex64>, margin: f64) -> Drive {
        let mut weights = drive.to_vec();
        wide(
            #[inline(always)]
            || self.take(steps, &mut weights, margin),
        );
        weights.into()
    }

    #[inline(always)]
    fn take(&self, steps: usize, drive: &mut [Complex64], margin: f64) {
        let Problem { limits, rows, .. } = self.problem;
        let (felt, quiet) = (limits.hot_m_per_s * margin, limits.cold_m_per_s / margin);
        let count = rows.mobility.nrows();
        let mut field_and_fit = vec![Complex64::ZERO; count + drive.len()];
        let mut pulls = Vec::with_capacity(count);
        for _ in 0..steps {
            field_and_fit.fill(Complex64::ZERO);
            let terms = drive.iter().copied().enumerate();
            self.field_and_fit.add_terms(terms, &mut field_and_fit);
            let (field, fit) = field_and_fit.split_at(count);
            pulls.clear();
            for (k, value) in field.iter().enumerate() {
                let square = value.norm_sqr();
                if k < rows.hot && square < felt * felt {
                    pulls.push((k, pull(*value, felt)));
                } else if k >= rows.hot && square > quiet * quiet {
                    pulls.push((k, pull(*value, quiet)));
                }
            }
            drive.copy_from_slice(fit);
            self.pull.add_terms(pulls.iter().copied(), drive);
        }
    }
}

/// Drives on their way.
pub(crate) struct Race<'a> {
    steps: &'a MagnitudeSteps<'a>,
    /// Axes (actuator, drive).
    drives: Array2<Complex64>,
    /// Margin of the rows that each aims at, as a factor.
    margins: Vec<f64>,
}

impl<'a> Race<'a> {
    /// From all starts, each with its margin in dB.
    pub(crate) fn new(steps: &'a MagnitudeSteps<'a>, starts: &[(&Drive, f64)]) -> Self {
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
        let columns = self.drives.columns_mut().into_iter();
        let ways: Vec<_> = columns.zip(&self.margins).collect();
        ways.into_par_iter().for_each(|(mut column, &margin)| {
            let ended = self.steps.after(steps, column.view(), margin);
            column.assign(&ended);
        });
        let keys = self.take_best_gains();
        let mut order: Vec<usize> = (0..keys.len()).collect();
        order.sort_by(|&a, &b| better_first(&keys[a], &keys[b]).then(a.cmp(&b)));
        order.truncate(kept);
        self.drives = self.drives.select(Axis(1), &order);
        self.margins = order.iter().map(|&k| self.margins[k]).collect();
    }

    /// Those that are left; axes (actuator, drive).
    pub(crate) fn into_drives(self) -> Array2<Complex64> {
        self.drives
    }

    /// Scales every drive by [`Problem::best_gain`]. Returns the criteria of each after that: least
    /// zone, total, κ.
    fn take_best_gains(&mut self) -> Vec<[f64; 3]> {
        let problem = self.steps.problem;
        let fields = problem.fields(self.drives.view());
        let columns = self.drives.columns_mut().into_iter();
        let columns = columns.zip(fields);
        columns
            .map(|(mut column, (amplitudes, deviation))| {
                let gain = problem.best_gain(&amplitudes, &column.to_owned());
                column.mapv_inplace(|weight| weight * gain);
                let score = problem.score_of(&(amplitudes * gain), deviation * gain);
                [score.min_ratio, score.success_ratio, score.kappa]
            })
            .collect()
    }
}

/// The change that moves `value` along its own phase to the magnitude `limit`, and beyond by the
/// relaxation.
#[inline(always)]
fn pull(value: Complex64, limit: f64) -> Complex64 {
    let before = value.norm_sqr().sqrt();
    let change = tolerances::MLS_RELAXATION * (limit - before);
    if before > 0.0 {
        value * (change / before)
    } else {
        change.into()
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
        let relaxation = tolerances::MLS_RELAXATION;
        assert_eq!(pull(Complex64::ZERO, 1.0), Complex64::from(relaxation));
        let expected = Complex64::new(0.0, -relaxation);
        assert!((pull(Complex64::new(0.0, 2.0), 1.0) - expected).norm() < 1e-15);
    }
}
