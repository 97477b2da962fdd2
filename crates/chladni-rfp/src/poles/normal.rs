//! A point of the search for poles by normal equations: everything a step needs follows
//! from one product CᴴB, where C holds the pole columns, the residual terms and the
//! derivatives (theory.md, eq. 9–11 with QQᴴ = A(AᴴA)⁻¹Aᴴ).
//!
//! A third of the flops of [`crate::poles::refine`]'s orthonormal basis, all of them in one
//! large product. It squares the condition of the basis, and so is left where rounding
//! comes near the residual: for data of some 100 dB, and for poles that nearly coincide.

use crate::damping::gram::Cauchy;
use crate::data::columns::Columns;
use crate::data::inner_products::sum_of_squares;
use crate::poles::descent::Point;
use crate::poles::limits;
use crate::poles::removal::Removable;
use chladni_linalg::blocked::blocked_matmul_h;
use chladni_linalg::{
    cholesky, inverse_hermitian, matmul, matmul_h, solve_hermitian, solve_lower,
    solve_lower_adjoint, LinalgError,
};
use ndarray::{s, Array2, ArrayViewMut2};
use num_complex::Complex64;

/// The result of the normal equations for all that is linear at one set of poles.
pub(crate) struct Plain {
    /// Gram matrix of the columns brought to unit norm, (m, m), and their norms.
    gram: Array2<Complex64>,
    norms: Vec<f64>,
    /// Residues and residual coefficients, (m, column).
    coefficients: Array2<Complex64>,
    sse: f64,
    rounding: f64,
}

/// The same with what a step of the poles needs to know.
pub(crate) struct Normal {
    /// All that is linear.
    pub plain: Plain,
    /// DᴴP⊥D, (n, n), and Dᴴ(residual), (n, column).
    outside: Array2<Complex64>,
    along: Array2<Complex64>,
}

/// The linear unknowns at given poles.
pub(crate) struct Parted {
    /// Residues and residual coefficients, (m, column).
    pub coefficients: Array2<Complex64>,
    /// Weight of the residues with the residual terms eliminated, (n, n).
    pub weight: Array2<Complex64>,
    /// Response of the residual terms to a change of the residues, (term, n).
    pub answer: Array2<Complex64>,
    /// Sum of squares left.
    pub sse: f64,
}

/// Rows over the norms of their columns.
fn unit(mut rows: ArrayViewMut2<Complex64>, norms: &[f64]) {
    rows.rows_mut()
        .into_iter()
        .zip(norms)
        .for_each(|(mut row, norm)| row.mapv_inplace(|v| v / norm));
}

impl Plain {
    /// `None` as for [`Normal`].
    pub fn at(work: &Columns, energy: f64, lambda: &[Complex64], powers: &[i32]) -> Option<Self> {
        let cauchy = Cauchy::without_derivatives(work, lambda, powers);
        let against = blocked_matmul_h(cauchy.columns.view(), work.b.view());
        Some(Self::solved(cauchy.gram(), against, energy)?.0)
    }

    /// From AᴴA and AᴴB; with L of the Gram matrix of unit columns, and L⁻¹ times their
    /// products with B.
    fn solved(
        mut gram: Array2<Complex64>,
        mut right: Array2<Complex64>,
        energy: f64,
    ) -> Option<(Self, Array2<Complex64>, Array2<Complex64>)> {
        let norms: Vec<f64> = gram.diag().iter().map(|v| v.re.sqrt()).collect();
        unit(gram.view_mut(), &norms);
        unit(gram.view_mut().reversed_axes(), &norms);
        unit(right.view_mut(), &norms);
        let lower = cholesky(gram.view()).ok()?;
        let half = solve_lower(lower.view(), right.view()).ok()?;
        let mut coefficients = solve_lower_adjoint(lower.view(), half.view()).ok()?;
        let sse = energy - sum_of_squares(&half);
        // an error of the Gram matrix in its last digit
        let rounding = f64::EPSILON
            * coefficients
                .columns()
                .into_iter()
                .map(|c| c.iter().map(|v| v.norm()).sum::<f64>().powi(2))
                .sum::<f64>();
        let sound = rounding <= limits::NORMAL_ROUNDING * sse;
        if !sound {
            return None;
        }
        unit(coefficients.view_mut(), &norms);
        Some((
            Self {
                gram,
                norms,
                coefficients,
                sse,
                rounding,
            },
            lower,
            half,
        ))
    }

    /// Residues apart from residual terms: the first `n` columns from the others.
    pub fn parted(self, n: usize) -> Result<Parted, LinalgError> {
        let Self {
            mut gram,
            norms,
            coefficients,
            sse,
            ..
        } = self;
        for ((i, j), value) in gram.indexed_iter_mut() {
            *value *= norms[i] * norms[j];
        }
        let across = gram.slice(s![n.., ..n]);
        let answer = solve_hermitian(gram.slice(s![n.., n..]), across)?;
        let weight = &gram.slice(s![..n, ..n]) - &matmul_h(across, answer.view());
        Ok(Parted {
            coefficients,
            weight,
            answer,
            sse,
        })
    }

    /// The quantities needed to take columns out.
    pub fn removable(&self) -> Result<Removable, LinalgError> {
        let mut inverse = inverse_hermitian(self.gram.view())?;
        for ((i, j), value) in inverse.indexed_iter_mut() {
            *value /= self.norms[i] * self.norms[j];
        }
        let alone = self.norms.iter().map(|norm| norm * norm).collect();
        Ok(Removable {
            inverse,
            coefficients: self.coefficients.clone(),
            alone,
            sse: self.sse,
        })
    }
}

impl Point for Normal {
    const LAST: bool = false;

    /// `None` where the columns are too alike, or the residual lies too near rounding.
    fn at(work: &Columns, energy: f64, lambda: &[Complex64], powers: &[i32]) -> Option<Self> {
        let m = lambda.len() + powers.len();
        let cauchy = Cauchy::new(work, lambda, powers);
        let products = cauchy.gram();
        let against = blocked_matmul_h(cauchy.columns.view(), work.b.view());
        let (of_columns, right) = (
            products.slice(s![..m, ..m]).to_owned(),
            against.slice(s![..m, ..]).to_owned(),
        );
        let (plain, lower, half) = Plain::solved(of_columns, right, energy)?;
        let mut of_derivatives = products.slice(s![..m, m..]).to_owned();
        unit(of_derivatives.view_mut(), &plain.norms);
        let inside = solve_lower(lower.view(), of_derivatives.view()).ok()?;
        let outside = &products.slice(s![m.., m..]) - &matmul_h(inside.view(), inside.view());
        // a derivative that is a mixture of columns but for its last digits tells nothing
        // of its pole
        if (0..lambda.len())
            .any(|n| outside[[n, n]].re < limits::DERIVATIVE_OUTSIDE * products[[m + n, m + n]].re)
        {
            return None;
        }
        let along = &against.slice(s![m.., ..]) - &matmul_h(inside.view(), half.view());
        Some(Self {
            plain,
            outside,
            along,
        })
    }

    fn sse(&self) -> f64 {
        self.plain.sse
    }

    fn rounding(&self, _: f64) -> f64 {
        self.plain.rounding
    }

    fn system(&self, _: &Columns, lambda: &[Complex64]) -> (Array2<Complex64>, Array2<Complex64>) {
        let residues = self.plain.coefficients.slice(s![..lambda.len(), ..]);
        let products = matmul(residues, residues.t().mapv(|v| v.conj()).view());
        let information = &self.outside * &products.t();
        let along = self.along.rows().into_iter().zip(residues.rows());
        let gradient = along
            .map(|(along, residues)| along.iter().zip(residues).map(|(d, r)| d * r.conj()).sum());
        (
            information,
            Array2::from_shape_vec((lambda.len(), 1), gradient.collect())
                .expect("one value per pole"),
        )
    }
}
