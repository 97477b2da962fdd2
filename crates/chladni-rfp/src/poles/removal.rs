//! Poles taken out of a linear fit one by one: the other residues are refitted exactly each time,
//! without a new fit (theory.md, eq. 8).

use ndarray::Array2;
use num_complex::Complex64;

/// A linear fit whose columns can be taken out.
pub(crate) struct Removable {
    /// Inverse of the Gram matrix of the basis, (m, m).
    pub inverse: Array2<Complex64>,
    /// Residues and residual coefficients, (m, column).
    pub coefficients: Array2<Complex64>,
    /// Sums of squares of the columns of the basis.
    pub basis_energy: Vec<f64>,
    /// Residual sum of squares with all columns in the fit.
    pub sse: f64,
}

/// A pole that may be taken out next.
pub(crate) struct Candidate<'a> {
    /// Index of the pole.
    pub pole: usize,
    /// Indices of the poles still in the fit, this one included.
    pub kept: &'a [usize],
    /// Rise of the sum of squares without this pole.
    pub rise: f64,
    /// Variance of its residue over that of a pole alone.
    pub inflation: f64,
}

/// Rise of the sum of squares without column `n` of a basis (theory.md, eq. 8).
///
/// * `inverse`: of the Gram matrix of the basis
/// * `coefficients`: of the fit on this basis
pub(crate) fn rise_without(
    n: usize,
    inverse: &Array2<Complex64>,
    coefficients: &Array2<Complex64>,
) -> f64 {
    let energy: f64 = coefficients.row(n).iter().map(|v| v.norm_sqr()).sum();
    energy / inverse[[n, n]].re
}

impl Removable {
    /// Number of columns of the basis.
    pub fn unknowns(&self) -> usize {
        self.basis_energy.len()
    }

    /// Rise of the sum of squares without the `n`-th pole.
    pub fn rise(&self, n: usize) -> f64 {
        rise_without(n, &self.inverse, &self.coefficients)
    }

    /// Takes poles out one by one, the least significant first, while `may_go` allows it. A pole
    /// whose rise is not finite always goes. Returns the poles kept.
    pub fn thin_out(
        mut self,
        lambda: &[Complex64],
        may_go: impl Fn(&Candidate) -> bool,
    ) -> Vec<Complex64> {
        let mut kept: Vec<usize> = (0..lambda.len()).collect();
        loop {
            let candidate = |&pole: &usize| Candidate {
                pole,
                kept: &kept,
                rise: self.rise(pole),
                inflation: self.inverse[[pole, pole]].re * self.basis_energy[pole],
            };
            let weakest = kept
                .iter()
                .map(candidate)
                .filter(|candidate| !candidate.rise.is_finite() || may_go(candidate))
                .min_by(|a, b| a.rise.total_cmp(&b.rise))
                .map(|candidate| candidate.pole);
            let Some(weakest) = weakest else {
                return kept.into_iter().map(|q| lambda[q]).collect();
            };
            self.take_out(weakest);
            kept.retain(|&q| q != weakest);
        }
    }

    /// Takes column `q` out: the Schur complement of the inverse Gram matrix.
    fn take_out(&mut self, q: usize) {
        let pivot = self.inverse[[q, q]];
        let column = self.inverse.column(q).to_owned();
        let row = self.inverse.row(q).to_owned();
        let coefficients = self.coefficients.row(q).to_owned();
        for i in 0..self.inverse.nrows() {
            let factor = column[i] / pivot;
            if factor.norm() == 0.0 {
                continue;
            }
            for j in 0..self.inverse.ncols() {
                self.inverse[[i, j]] -= factor * row[j];
            }
            self.coefficients
                .row_mut(i)
                .zip_mut_with(&coefficients, |value, gone| *value -= factor * gone);
        }
    }
}
