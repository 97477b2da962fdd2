//! Products over lines of pole columns and their derivatives.

use crate::damping::basis::{basis, basis_derivative};
use crate::damping::gram::Beside;
use crate::data::columns::Columns;
use crate::data::information::answer;
use crate::shapes::limits;

use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_gram, range};
use chladni_linalg::{cholesky, matmul_h, solve_lower, LinalgError};
use ndarray::{s, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Range;

/// Products over lines of the pole columns F and their derivatives D, what stays free in
/// every pair taken out: (mode, mode).
#[derive(Clone)]
pub(crate) struct LineProducts {
    /// ‖F_n‖² before what stays free was taken out.
    pub whole: Vec<f64>,
    pub ff: Array2<Complex64>,
    pub fd: Array2<Complex64>,
    pub dd: Array2<Complex64>,
}

impl LineProducts {
    /// * `gram`: inner products of the columns of poles and of their derivatives
    /// * `with_free`: those of the columns with an orthonormal basis of what stays free in every pair
    pub fn outside_of(gram: &Array2<Complex64>, with_free: &Array2<Complex64>) -> Self {
        let (columns, free) = with_free.dim();
        let inside = Array2::from_shape_fn((free, columns).f(), |(i, j)| with_free[[j, i]].conj());
        Self::parts(gram, &(gram - &blocked_gram(inside.view())))
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
        let (gram, []) = Beside::new(work, powers, []).products(&all, true);
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
            let free = background(work, others, powers)?;
            let (gram, [free]) = Beside::new(work, &[], [free.view()]).products(lambda, true);
            return Ok(Self::outside_of(&gram, &free));
        };
        let across = Array2::from_shape_fn((size, own.len()).f(), |(i, j)| {
            gram[[free[i], own[j]]] / norm(free[i])
        });
        let inside = solve_lower(lower.view(), across.view())?;
        let whole = gram.select(Axis(0), &own).select(Axis(1), &own);
        let left = &whole - &matmul_h(inside.view(), inside.view());
        Ok(Self::parts(&whole, &left))
    }

    /// Of (F, D), whole and with what stays free taken out.
    fn parts(whole: &Array2<Complex64>, all: &Array2<Complex64>) -> Self {
        let n = all.nrows() / 2;
        let part =
            |rows: Range<usize>, columns: Range<usize>| all.slice(s![rows, columns]).to_owned();
        Self {
            whole: (0..n).map(|i| whole[[i, i]].re).collect(),
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
        let Self { ff, fd, dd, .. } = self;
        let free = self.regular(ff.clone(), |_| 1.0);
        Ok(dd - &matmul_h(fd.view(), answer(free.view(), fd.view())?.view()))
    }

    /// A Gram matrix of columns φ_n⊗L_n, `along(n)` = ‖L_n‖², kept regular: what is left
    /// of a column is known to the rounding of the whole of it.
    pub fn regular(
        &self,
        mut gram: Array2<Complex64>,
        along: impl Fn(usize) -> f64,
    ) -> Array2<Complex64> {
        for (n, value) in gram.diag_mut().iter_mut().enumerate() {
            *value += limits::STRUCTURED_RIDGE * self.whole[n] * along(n) + f64::MIN_POSITIVE;
        }
        gram
    }

    /// True where enough of a column is left to be told from rounding.
    pub fn is_left(&self, n: usize) -> bool {
        self.ff[[n, n]].re > tol::UNINFORMED * self.whole[n]
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Poles at 0.1, 0.2, … 0.9 on 500 lines, and some beside them.
    fn lines(rows: &[Complex64]) -> LineProducts {
        let x: Vec<f64> = (0..500).map(|k| 0.05 + 0.0019 * f64::from(k)).collect();
        let work = Columns {
            g: vec![1.0; x.len()],
            b: Array2::zeros((x.len(), 0)),
            x,
            law: chladni_frf::Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let band: Vec<Complex64> = (1..10)
            .map(|n| Complex64::new(0.1 * f64::from(n), 0.02))
            .collect();
        LineProducts::beside(&work, rows, &band, &[-1, 0, 1, 2]).unwrap()
    }

    #[test]
    fn a_pole_in_the_span_of_the_others_is_not_known_and_stops_nothing() {
        for rank in 1..=3 {
            let far = lines(&vec![Complex64::new(8.0, 0.1); rank]);
            assert!(
                (0..rank).all(|n| !far.is_left(n)),
                "rank {rank}: {}",
                far.ff
            );
            let near = lines(&vec![Complex64::new(1.02, 0.02); rank]);
            assert!((0..rank).all(|n| near.is_left(n)));
            for lines in [far, near] {
                assert!(
                    lines.outside().unwrap().iter().all(|v| v.is_finite()),
                    "rank {rank}"
                );
            }
        }
    }
}
