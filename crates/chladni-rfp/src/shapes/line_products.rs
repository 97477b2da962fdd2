//! Products over lines of pole columns and their derivatives.

use crate::damping::gram::Cauchy;
use crate::damping::structural::{basis, basis_derivative};
use crate::data::columns::Columns;

use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_matmul_h, range};
use chladni_linalg::{cholesky, matmul_h, solve_hermitian, solve_lower, LinalgError};
use ndarray::{s, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Range;

/// Products over lines of the pole columns F and their derivatives D, what stays free in
/// every pair taken out: (mode, mode).
pub(crate) struct LineProducts {
    pub ff: Array2<Complex64>,
    pub fd: Array2<Complex64>,
    pub dd: Array2<Complex64>,
}

impl LineProducts {
    /// `free`: orthonormal basis of what stays free in every pair, (line, ·).
    pub fn new(cauchy: &Cauchy, free: &Array2<Complex64>) -> Self {
        let inside = blocked_matmul_h(free.view(), cauchy.columns.view());
        Self::parts(&(cauchy.gram() - blocked_matmul_h(inside.view(), inside.view())))
    }

    /// Those of the poles `lambda`, where what stays free are residual terms and the
    /// `others`, their residues and, to first order, their positions.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn beside(
        work: &Columns,
        lambda: &[Complex64],
        others: &[Complex64],
        powers: &[i32],
    ) -> Result<Self, LinalgError> {
        let all = [lambda, others].concat();
        let gram = Cauchy::new(work, &all, powers).gram();
        let (n, m) = (lambda.len(), all.len() + powers.len());
        let (own, free): (Vec<usize>, Vec<usize>) =
            (0..gram.nrows()).partition(|&i| i < n || (m..m + n).contains(&i));
        let norm = |i: usize| gram[[i, i]].re.sqrt();
        let unit = |i: usize, j: usize| gram[[free[i], free[j]]] / (norm(free[i]) * norm(free[j]));
        let size = free.len();
        let outstanding = |lower: &Array2<Complex64>| {
            lower.diag().iter().all(|pivot| pivot.re > tol::OUTSTANDING)
        };
        let Some(lower) =
            cholesky(Array2::from_shape_fn((size, size).f(), |(i, j)| unit(i, j)).view())
                .ok()
                .filter(outstanding)
        else {
            return Ok(Self::new(
                &Cauchy::new(work, lambda, &[]),
                &background(work, others, powers)?,
            ));
        };
        let across = Array2::from_shape_fn((size, own.len()).f(), |(i, j)| {
            gram[[free[i], own[j]]] / norm(free[i])
        });
        let inside = solve_lower(lower.view(), across.view())?;
        let left = gram.select(Axis(0), &own).select(Axis(1), &own)
            - matmul_h(inside.view(), inside.view());
        Ok(Self::parts(&left))
    }

    fn parts(all: &Array2<Complex64>) -> Self {
        let n = all.nrows() / 2;
        let part =
            |rows: Range<usize>, columns: Range<usize>| all.slice(s![rows, columns]).to_owned();
        Self {
            ff: part(0..n, 0..n),
            fd: part(0..n, n..2 * n),
            dd: part(n..2 * n, n..2 * n),
        }
    }

    /// Inner products of the derivatives outside the columns.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn outside(&self) -> Result<Array2<Complex64>, LinalgError> {
        let Self { ff, fd, dd } = self;
        let mut free = ff.clone();
        free.diag_mut()
            .mapv_inplace(|v| v * (1.0 + tol::STRUCTURED_RIDGE) + f64::MIN_POSITIVE);
        Ok(dd - &matmul_h(fd.view(), solve_hermitian(free.view(), fd.view())?.view()))
    }
}

/// Orthonormal basis of what stays free in every pair, (line, ·): residual terms, and
/// poles `outside` the band with their residues and, to first order, their positions.
pub(crate) fn background(
    work: &Columns,
    outside: &[Complex64],
    powers: &[i32],
) -> Result<Array2<Complex64>, LinalgError> {
    let (columns, derivatives) = (
        basis(work, outside, powers),
        basis_derivative(work, outside),
    );
    let mut all = ndarray::concatenate(Axis(1), &[columns.view(), derivatives.view()])
        .expect("the same lines");
    for mut column in all.columns_mut() {
        let norm = column
            .iter()
            .map(|v| v.norm_sqr())
            .sum::<f64>()
            .sqrt()
            .max(f64::MIN_POSITIVE);
        column.mapv_inplace(|v| v / norm);
    }
    range(all.view(), tol::FREE_RANK)
}
