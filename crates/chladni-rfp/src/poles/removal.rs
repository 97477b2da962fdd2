//! Taking poles out of a linear fit one by one, exactly, without making it again
//! (theory.md, eq. 8).

use ndarray::Array2;
use num_complex::Complex64;

/// The quantities needed for that.
pub(crate) struct Removable {
    /// Inverse of the Gram matrix of the basis, (m, m).
    pub inverse: Array2<Complex64>,
    /// Residues and residual coefficients, (m, column).
    pub coefficients: Array2<Complex64>,
    /// Sums of squares of the columns of the basis.
    pub alone: Vec<f64>,
    /// Sum of squares left with all of them.
    pub sse: f64,
}

impl Removable {
    /// Rise of the sum of squares without the `n`-th pole (theory.md, eq. 8).
    pub fn rise(&self, n: usize) -> f64 {
        let energy: f64 = self.coefficients.row(n).iter().map(|v| v.norm_sqr()).sum();
        energy / self.inverse[[n, n]].re
    }

    /// Takes poles out one by one, the least significant first, residues refitted exactly
    /// after each, while a rule allows it: `may_go(kept, q, rise, inflation)` says
    /// whether pole q may be taken out of those `kept`, where that makes the sum of
    /// squares rise by `rise`; `inflation` is the variance of its residue relative to
    /// that of a pole alone. A pole whose rise is not finite always goes.
    pub fn thin_out(
        self,
        lambda: &[Complex64],
        may_go: impl Fn(&[usize], usize, f64, f64) -> bool,
    ) -> Vec<Complex64> {
        let Removable {
            mut inverse,
            mut coefficients,
            alone,
            ..
        } = self;
        let mut kept: Vec<usize> = (0..lambda.len()).collect();
        loop {
            let weakest = kept
                .iter()
                .map(|&q| {
                    (
                        q,
                        coefficients
                            .row(q)
                            .iter()
                            .map(|v| v.norm_sqr())
                            .sum::<f64>()
                            / inverse[[q, q]].re,
                    )
                })
                .filter(|&(q, rise)| {
                    !rise.is_finite() || may_go(&kept, q, rise, inverse[[q, q]].re * alone[q])
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((q, _)) = weakest else {
                return kept.into_iter().map(|q| lambda[q]).collect();
            };
            // exact removal of column q: Schur complement of the inverse Gram
            let pivot = inverse[[q, q]];
            let column = inverse.column(q).to_owned();
            let row = inverse.row(q).to_owned();
            let own = coefficients.row(q).to_owned();
            for i in 0..inverse.nrows() {
                let factor = column[i] / pivot;
                if factor.norm() == 0.0 {
                    continue;
                }
                for j in 0..inverse.ncols() {
                    inverse[[i, j]] -= factor * row[j];
                }
                coefficients
                    .row_mut(i)
                    .zip_mut_with(&own, |v, o| *v -= factor * o);
            }
            kept.retain(|&k| k != q);
        }
    }
}
