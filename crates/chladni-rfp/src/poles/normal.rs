//! Points of the search for poles by normal equations: everything a step needs follows
//! from one product CᴴB, where C holds the pole columns, the residual terms and the
//! derivatives (theory.md, eq. 9–11 with QQᴴ = A(AᴴA)⁻¹Aᴴ).
//!
//! They take a third of the flops of the orthonormal basis of [`crate::poles::refine`], all of
//! them in one large product. They square the condition of the basis, so the orthonormal basis
//! takes over where rounding comes near the residual: for data of some 100 dB, and for poles that
//! nearly coincide.

use crate::data::columns::Columns;
use crate::data::inner_products::sum_of_squares;
use crate::poles::descent::{NewtonSystem, Point, SearchData};
use crate::poles::limits;
use crate::poles::removal::Removable;
use chladni_linalg::{
    cholesky, inverse_hermitian, matmul, matmul_h, solve_hermitian, solve_lower,
    solve_lower_adjoint, LinalgError,
};
use ndarray::{s, Array1, Array2, ArrayView1, ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex64;

/// The linear fit at given poles, by normal equations.
pub(crate) struct NormalFit {
    /// Gram matrix of the columns brought to unit norm, (m, m).
    gram: Array2<Complex64>,
    /// Norms of these columns.
    norms: Vec<f64>,
    /// Residues and residual coefficients, (m, column).
    coefficients: Array2<Complex64>,
    /// Residual sum of squares, and its rounding error.
    sse: f64,
    rounding: f64,
}

/// A linear fit with its triangular factor.
struct Factored {
    fit: NormalFit,
    /// L of the Gram matrix of unit columns, (m, m).
    lower: Array2<Complex64>,
    /// L⁻¹ times the products of the unit columns with the data, (m, column).
    half_solved: Array2<Complex64>,
}

/// The linear fit with the derivatives that a step of the poles needs.
pub(crate) struct NormalPoint {
    pub fit: NormalFit,
    /// DᴴP⊥D, (n, n).
    derivative_gram: Array2<Complex64>,
    /// Dᴴ(residual), (n, column).
    derivative_residual: Array2<Complex64>,
}

/// The linear unknowns at given poles, residues apart from residual terms.
pub(crate) struct Partitioned {
    /// Residues and residual coefficients, (m, column).
    pub coefficients: Array2<Complex64>,
    /// Weight of the residues with the residual terms eliminated, (n, n).
    pub weight: Array2<Complex64>,
    /// Residual terms per unit of residue that they give way to, (term, n).
    pub terms_per_residue: Array2<Complex64>,
    /// Residual sum of squares.
    pub sse: f64,
}

/// Divides each row by its norm.
fn divide_rows(mut rows: ArrayViewMut2<Complex64>, norms: &[f64]) {
    rows.rows_mut()
        .into_iter()
        .zip(norms)
        .for_each(|(mut row, norm)| row.mapv_inplace(|v| v / norm));
}

/// Gradient of the poles, (n, 1): Σ over columns of Dᴴ(residual) times conjugate residues.
pub(crate) fn gradient(
    derivative_residual: ArrayView2<Complex64>,
    residues: ArrayView2<Complex64>,
) -> Array2<Complex64> {
    let row = |(d, r): (ArrayView1<Complex64>, ArrayView1<Complex64>)| -> Complex64 {
        d.iter().zip(r).map(|(d, r)| d * r.conj()).sum()
    };
    let rows = derivative_residual.rows().into_iter().zip(residues.rows());
    Array1::from_iter(rows.map(row)).insert_axis(Axis(1))
}

impl Factored {
    /// Solves the normal equations with AᴴA and AᴴB.
    fn new(mut gram: Array2<Complex64>, mut right: Array2<Complex64>, energy: f64) -> Option<Self> {
        let norms: Vec<f64> = gram.diag().iter().map(|v| v.re.sqrt()).collect();
        divide_rows(gram.view_mut(), &norms);
        divide_rows(gram.view_mut().reversed_axes(), &norms);
        divide_rows(right.view_mut(), &norms);
        let lower = cholesky(gram.view()).ok()?;
        let half_solved = solve_lower(lower.view(), right.view()).ok()?;
        let mut coefficients = solve_lower_adjoint(lower.view(), half_solved.view()).ok()?;
        let sse = energy - sum_of_squares(&half_solved);
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
        divide_rows(coefficients.view_mut(), &norms);
        Some(Self {
            fit: NormalFit {
                gram,
                norms,
                coefficients,
                sse,
                rounding,
            },
            lower,
            half_solved,
        })
    }
}

impl NormalFit {
    /// The fit with the poles `lambda`; `None` as for [`NormalPoint`].
    pub fn at(work: &Columns, lambda: &[Complex64], powers: &[i32]) -> Option<Self> {
        let SearchData { beside, energy } = SearchData::new(work, powers);
        let (gram, [against]) = beside.products(lambda, false);
        Some(Factored::new(gram, against, energy)?.fit)
    }

    /// Residual sum of squares.
    pub fn sse(&self) -> f64 {
        self.sse
    }

    /// Partitions the unknowns: the first `n` columns are poles, the others residual terms.
    pub fn partitioned(self, n: usize) -> Result<Partitioned, LinalgError> {
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
        let terms_per_residue = solve_hermitian(gram.slice(s![n.., n..]), across)?;
        let weight = &gram.slice(s![..n, ..n]) - &matmul_h(across, terms_per_residue.view());
        Ok(Partitioned {
            coefficients,
            weight,
            terms_per_residue,
            sse,
        })
    }

    /// The fit as one whose columns can be taken out.
    pub fn removable(&self) -> Result<Removable, LinalgError> {
        let mut inverse = inverse_hermitian(self.gram.view())?;
        for ((i, j), value) in inverse.indexed_iter_mut() {
            *value /= self.norms[i] * self.norms[j];
        }
        Ok(Removable {
            inverse,
            coefficients: self.coefficients.clone(),
            basis_energy: self.norms.iter().map(|norm| norm * norm).collect(),
            sse: self.sse,
        })
    }
}

impl Point for NormalPoint {
    const HAS_FALLBACK: bool = true;

    /// `None` where the columns are too alike, or the residual lies too near rounding.
    fn at(search: &SearchData, lambda: &[Complex64]) -> Option<Self> {
        let m = lambda.len() + search.beside.powers.len();
        let (all, [against]) = search.beside.products(lambda, true);
        let gram = all.slice(s![..m, ..m]).to_owned();
        let right = against.slice(s![..m, ..]).to_owned();
        let Factored {
            fit,
            lower,
            half_solved,
        } = Factored::new(gram, right, search.energy)?;
        let mut across = all.slice(s![..m, m..]).to_owned();
        divide_rows(across.view_mut(), &fit.norms);
        // the part of the derivatives along the columns
        let inside = solve_lower(lower.view(), across.view()).ok()?;
        let derivative_gram = &all.slice(s![m.., m..]) - &matmul_h(inside.view(), inside.view());
        // a derivative that is a mixture of columns but for its last digits tells nothing
        // of its pole
        let is_rounding = |n: usize| {
            let whole = all[[m + n, m + n]].re;
            derivative_gram[[n, n]].re < limits::DERIVATIVE_OUTSIDE * whole
        };
        if (0..lambda.len()).any(is_rounding) {
            return None;
        }
        let along_fit = matmul_h(inside.view(), half_solved.view());
        Some(Self {
            fit,
            derivative_gram,
            derivative_residual: &against.slice(s![m.., ..]) - &along_fit,
        })
    }

    fn sse(&self) -> f64 {
        self.fit.sse()
    }

    fn rounding(&self, _: f64) -> f64 {
        self.fit.rounding
    }

    fn system(&self, _: &SearchData, lambda: &[Complex64]) -> NewtonSystem {
        let residues = self.fit.coefficients.slice(s![..lambda.len(), ..]);
        let products = matmul(residues, residues.t().mapv(|v| v.conj()).view());
        NewtonSystem {
            information: &self.derivative_gram * &products.t(),
            gradient: gradient(self.derivative_residual.view(), residues),
        }
    }
}
