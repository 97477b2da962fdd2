//! Regularised least squares on the judged rows.
//!
//! minimise Σ_k w_k( |h_k·A − t_k|² + ‖L·A‖² ) + ridge: N·A = Σ_k w_k h_kᴴt_k, N = Σ_k
//! w_k h_kᴴh_k + R, R = Σ_k w_k·LᴴL + ridge·I. LᴴL is the expected error of one row, so
//! that what is minimised is the expected squared misfit.

use crate::panel::kernel_error::unsolvable;
use crate::problems::problem::Problem;
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::{cholesky, matmul, matmul_h, solve_lower, solve_lower_adjoint};
use ndarray::{s, Array2, ArrayView2};
use num_complex::Complex64;
use std::ops::Range;

/// The least-squares problem of all judged rows, factorised once for any number of
/// targets.
pub(crate) struct LeastSquares<'a> {
    pub(crate) problem: &'a Problem,
    /// R.
    regulariser: Array2<Complex64>,
    /// Lower factor of N.
    lower: Array2<Complex64>,
}

impl<'a> LeastSquares<'a> {
    /// * `extra_ridge`: relative to the mean diagonal of N
    ///
    /// # Errors
    /// Those of the factorisation: a broken promise.
    pub(crate) fn new(problem: &'a Problem, extra_ridge: f64) -> Result<Self> {
        let [energy, regulariser] = parts(problem, 0..problem.rows.mobility.nrows(), extra_ridge);
        let lower = cholesky((energy + &regulariser).view()).map_err(unsolvable)?;
        Ok(Self {
            problem,
            regulariser,
            lower,
        })
    }

    /// The drives for targets on the hot rows, 0 on the cold ones; axes of `targets` (hot
    /// row, target), of the drives (actuator, target).
    ///
    /// # Errors
    /// None: sizes fit.
    pub(crate) fn drives(&self, targets: ArrayView2<Complex64>) -> Result<Array2<Complex64>> {
        let mut weighted = targets.to_owned();
        for (mut row, &weight) in weighted
            .rows_mut()
            .into_iter()
            .zip(&self.problem.row_weights)
        {
            row.mapv_inplace(|value| value * weight);
        }
        self.solve(matmul_h(self.problem.rows.hot_rows(), weighted.view()).view())
    }

    /// N⁻¹.
    ///
    /// # Errors
    /// None: sizes fit.
    pub(crate) fn inverse(&self) -> Result<Array2<Complex64>> {
        self.solve(Array2::from_diag_elem(self.lower.nrows(), Complex64::ONE).view())
    }

    /// N⁻¹·Hᴴ·diag(w), from a change of the targets of all rows to that of the drive, and
    /// I − N⁻¹·R: the least-squares fit to the field h_k·A of a drive A itself is the
    /// drive (I − N⁻¹·R)·A.
    ///
    /// # Errors
    /// None: sizes fit.
    pub(crate) fn pull_and_own_fit(&self) -> Result<[Array2<Complex64>; 2]> {
        let inverse = self.inverse()?;
        let mut weighted = self.problem.rows.mobility.t().mapv(|value| value.conj());
        weighted *= &self.problem.row_weights.mapv(Complex64::from);
        let pull = matmul(inverse.view(), weighted.view());
        let unit = Array2::from_diag_elem(inverse.nrows(), Complex64::ONE);
        Ok([pull, unit - matmul(inverse.view(), self.regulariser.view())])
    }

    fn solve(&self, right: ArrayView2<Complex64>) -> Result<Array2<Complex64>> {
        let half = solve_lower(self.lower.view(), right);
        half.and_then(|half| solve_lower_adjoint(self.lower.view(), half.view()))
            .map_err(unsolvable)
    }
}

/// N of the rows `range` of `problem`.
pub(crate) fn normal_matrix(problem: &Problem, range: Range<usize>) -> Array2<Complex64> {
    let [energy, regulariser] = parts(problem, range, 0.0);
    energy + regulariser
}

/// Σ_k w_k h_kᴴh_k of the rows `range`, and R.
fn parts(problem: &Problem, range: Range<usize>, extra_ridge: f64) -> [Array2<Complex64>; 2] {
    let weights = problem.row_weights.slice(s![range.clone()]);
    let mut scaled = problem.rows.mobility.slice(s![range, ..]).to_owned();
    for (mut row, &weight) in scaled.rows_mut().into_iter().zip(weights) {
        row.mapv_inplace(|value| value * weight.sqrt());
    }
    let energy = matmul_h(scaled.view(), scaled.view());
    let mut regulariser = problem.covariance.gram() * Complex64::from(weights.sum());
    let trace = energy
        .diag()
        .iter()
        .chain(regulariser.diag())
        .map(|value| value.re)
        .sum::<f64>();
    let ridge = trace / energy.nrows() as f64 * (tolerances::RIDGE + extra_ridge);
    regulariser.diag_mut().mapv_inplace(|value| value + ridge);
    [energy, regulariser]
}
