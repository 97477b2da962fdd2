//! Forsythe's orthogonal polynomials in jω, and the roots of a polynomial written in
//! them.
//!
//! Powers of jω are hopeless as a basis: over a band they are nearly parallel, and normal
//! equations lose all digits at about eight modes. Forsythe (1957) generates, from the
//! lines and their weights, the polynomials that are orthonormal there. Richardson and
//! Formenti (1982) use them over negative and positive frequencies, where a real
//! polynomial in s = jy is even (real) or odd (imaginary) and half of the lines are
//! enough ("half functions"):
//!
//! ```text
//! φ_k(jy) = jᵏ p_k(y),  p_k real of the parity of k
//! (φ, ψ) = ½ Σ_{±y} w φ* ψ = Re Σ_{y>0} w φ* ψ
//! s φ_k = b_{k+1} φ_{k+1} − b_k φ_{k−1}          (three terms; even weights leave no diagonal)
//! ```
//!
//! Roots of D = Σ d_k φ_k are the eigenvalues of the *comrade matrix*, which is the
//! recurrence with the last row changed: at a root, φ_m = −Σ_{k<m} (d_k/d_m) φ_k. The
//! 1982 paper went back to powers of s first; that step undoes the whole gain (eleven
//! digits at degree 40, all of them at degree 68: see the tests), so it is not offered.
//!
//! The recurrence is a Lanczos process and drifts when the weights have sharp peaks, as
//! |FRF|² has; every new polynomial is therefore orthogonalised once more against all
//! earlier ones of its parity.
//!
//! Cost: O(lines · degree²) for the basis, O(degree³) for the roots.
//!
//! Limits: nothing here is wrong at high degree, but a well-conditioned basis does not
//! make the equation error a good estimator; see [`super::equation_error`].
//!
//! G. E. Forsythe, J. SIAM 5 (1957) 74–88. M. H. Richardson, D. L. Formenti, *Parameter
//! estimation from frequency response measurements using rational fraction polynomials*,
//! Proc. IMAC 1 (1982) 167–181. S. Barnett, Linear Algebra Appl. 12 (1975) 197–208
//! (comrade matrix).

use super::limits::BREAKDOWN;
use chladni_linalg::{eigenvalues, LinalgError};
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;

/// Real polynomials in s = jy, orthonormal over ±y with given weights.
#[derive(Debug, Clone)]
pub(crate) struct Forsythe {
    /// √w·p_k on the lines, axes (line, degree): orthonormal among columns of equal
    /// parity.
    pub half: Array2<f64>,
    /// b_1 … b_m.
    recurrence: Vec<f64>,
    /// φ_0, a constant.
    first: f64,
}

impl Forsythe {
    /// Polynomials of degree 0 … `degree` on lines y > 0 with weights w ≥ 0.
    ///
    /// # Errors
    /// [`LinalgError::RankDeficient`] where fewer lines have weight than the degree needs
    /// (half as many as polynomials).
    pub fn new(y: &[f64], weights: &[f64], degree: usize) -> Result<Self, LinalgError> {
        let lines = y.len();
        let largest = y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut half = Array2::zeros((lines, degree + 1).f());
        let mut recurrence = Vec::with_capacity(degree);
        let mass = weights.iter().sum::<f64>().sqrt();
        let exhausted = |rank| LinalgError::RankDeficient {
            rank,
            columns: degree + 1,
        };
        if mass <= 0.0 || !mass.is_finite() {
            return Err(exhausted(0));
        }
        for (value, w) in half.column_mut(0).iter_mut().zip(weights) {
            *value = w.sqrt() / mass;
        }
        for k in 0..degree {
            // y·p_k − b_k·p_{k−1}, then against all of the same parity: k−1, k−3, …
            let mut next: Vec<f64> = half.column(k).iter().zip(y).map(|(p, y)| p * y).collect();
            let mut norm = 0.0;
            for _ in 0..2 {
                for earlier in (0..k).rev().step_by(2) {
                    let column = half.column(earlier);
                    let overlap: f64 = column.iter().zip(&next).map(|(a, b)| a * b).sum();
                    next.iter_mut()
                        .zip(column)
                        .for_each(|(v, a)| *v -= overlap * a);
                }
                norm = next.iter().map(|v| v * v).sum::<f64>().sqrt();
            }
            if norm <= BREAKDOWN * largest {
                return Err(exhausted(k + 1));
            }
            recurrence.push(norm);
            half.column_mut(k + 1)
                .iter_mut()
                .zip(&next)
                .for_each(|(v, n)| *v = n / norm);
        }
        Ok(Self {
            half,
            recurrence,
            first: 1.0 / mass,
        })
    }

    /// Highest degree.
    pub fn degree(&self) -> usize {
        self.recurrence.len()
    }

    /// φ_0(s) … φ_m(s) and their derivatives, by the recurrence.
    pub fn evaluate(&self, s: Complex64) -> (Vec<Complex64>, Vec<Complex64>) {
        let mut values = vec![Complex64::new(self.first, 0.0)];
        let mut slopes = vec![Complex64::new(0.0, 0.0)];
        for (k, &b) in self.recurrence.iter().enumerate() {
            let (mut value, mut slope) = (s * values[k], values[k] + s * slopes[k]);
            if k > 0 {
                value += self.recurrence[k - 1] * values[k - 1];
                slope += self.recurrence[k - 1] * slopes[k - 1];
            }
            values.push(value / b);
            slopes.push(slope / b);
        }
        (values, slopes)
    }

    /// The matrix whose eigenvalues are the roots of Σ d_k φ_k.
    fn comrade(&self, d: &[f64]) -> Array2<Complex64> {
        let m = self.degree();
        let mut c = Array2::zeros((m, m));
        for k in 0..m {
            if k + 1 < m {
                c[[k, k + 1]] += self.recurrence[k];
                c[[k + 1, k]] -= self.recurrence[k];
            }
            c[[m - 1, k]] -= self.recurrence[m - 1] * d[k] / d[m];
        }
        c
    }

    /// Roots of Σ d_k φ_k, in no particular order; d has `degree() + 1` entries, the last
    /// not zero.
    ///
    /// # Errors
    /// A leading coefficient of zero (the comrade matrix is not finite then); no
    /// convergence.
    pub fn roots(&self, d: &[f64]) -> Result<Vec<Complex64>, LinalgError> {
        Ok(eigenvalues(self.comrade(d).view())?.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lightly damped pairs over the band of `lines`, denser towards its ends, so that
    /// their polynomial has about the same size everywhere in the band. With even spacing
    /// it spans twelve decades, and no basis that is orthonormal over the whole band at
    /// once can hold the small part: a limit of the method, not of the roots.
    fn known_poles(pairs: u32) -> Vec<Complex64> {
        let angle = |n: u32| std::f64::consts::PI * (f64::from(n) + 0.5) / f64::from(pairs);
        (0..pairs)
            .map(|n| {
                Complex64::new(
                    -0.003 - 0.0002 * f64::from(n),
                    (0.505 - 0.495 * angle(n).cos()).sqrt(),
                )
            })
            .collect()
    }

    fn lines() -> Vec<f64> {
        (0..400).map(|k| 0.1 + 0.9 * f64::from(k) / 399.0).collect()
    }

    /// Π (s − s_n)(s − s_n*), scaled to values near one.
    fn product(poles: &[Complex64], s: Complex64) -> Complex64 {
        poles
            .iter()
            .map(|p| 8.0 * (s - p) * (s - p.conj()))
            .product()
    }

    /// Coefficients of `product` in the basis, by orthogonality.
    fn coefficients(poles: &[Complex64], basis: &Forsythe, y: &[f64], weights: &[f64]) -> Vec<f64> {
        (0..=basis.degree())
            .map(|k| {
                let sum: Complex64 = y
                    .iter()
                    .zip(weights)
                    .zip(basis.half.column(k))
                    .map(|((&y, w), p)| product(poles, Complex64::new(0.0, y)) * (w.sqrt() * p))
                    .sum();
                (sum * Complex64::i().powu(k as u32).conj()).re
            })
            .collect()
    }

    fn worst_root(poles: &[Complex64], found: &[Complex64]) -> f64 {
        poles
            .iter()
            .map(|p| {
                found
                    .iter()
                    .map(|s| (s - p).norm())
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    }

    fn peaked(poles: &[Complex64], y: &[f64]) -> Vec<f64> {
        y.iter()
            .map(|&y| {
                poles
                    .iter()
                    .map(|p| 1.0 / (Complex64::new(0.0, y) - p))
                    .sum::<Complex64>()
                    .norm_sqr()
            })
            .collect()
    }

    #[test]
    fn polynomials_are_orthonormal_at_degree_40() {
        let y = lines();
        for weights in [vec![1.0; y.len()], peaked(&known_poles(20), &y)] {
            let basis = Forsythe::new(&y, &weights, 40).unwrap();
            let mut worst = 0.0_f64;
            for a in 0..=40_usize {
                for b in 0..=40_usize {
                    // the sum over ±y of φ_a* φ_b, written out: odd and even are
                    // orthogonal by symmetry alone
                    let phase =
                        Complex64::i().powu(a as u32).conj() * Complex64::i().powu(b as u32);
                    let half: f64 = basis.half.column(a).dot(&basis.half.column(b));
                    let sum = 0.5 * (phase * half + (phase * half).conj()).re;
                    worst = worst.max((sum - f64::from(u8::from(a == b))).abs());
                }
            }
            assert!(worst < 1e-12, "{worst:e}");
        }
    }

    #[test]
    fn recurrence_reproduces_the_columns() {
        let y = lines();
        let basis = Forsythe::new(&y, &vec![1.0; y.len()], 40).unwrap();
        for (row, &y) in y.iter().enumerate().step_by(37) {
            let (values, _) = basis.evaluate(Complex64::new(0.0, y));
            for (k, value) in values.iter().enumerate() {
                let expected = Complex64::i().powu(k as u32) * basis.half[[row, k]];
                assert!(
                    (value - expected).norm() < 1e-11,
                    "degree {k}: {value} {expected}"
                );
            }
        }
    }

    #[test]
    fn slope_is_the_derivative() {
        let y = lines();
        let basis = Forsythe::new(&y, &peaked(&known_poles(20), &y), 12).unwrap();
        let s = Complex64::new(-0.02, 0.55);
        let step = 1e-6;
        let (_, slopes) = basis.evaluate(s);
        let (ahead, _) = basis.evaluate(s + step);
        let (behind, _) = basis.evaluate(s - step);
        for k in 0..=12 {
            let numeric = (ahead[k] - behind[k]) / (2.0 * step);
            assert!(
                (numeric - slopes[k]).norm() < 1e-6 * (1.0 + slopes[k].norm()),
                "degree {k}"
            );
        }
    }

    #[test]
    fn comrade_roots_hold() {
        let y = lines();
        for pairs in [20, 34] {
            let poles = known_poles(pairs);
            for weights in [vec![1.0; y.len()], peaked(&poles, &y)] {
                let basis = Forsythe::new(&y, &weights, 2 * poles.len()).unwrap();
                let d = coefficients(&poles, &basis, &y, &weights);
                let worst = worst_root(&poles, &basis.roots(&d).unwrap());
                assert!(worst < 1e-9, "{pairs} pairs: {worst:e}");
            }
        }
    }

    /// Roots by the route of 1982: basis coefficients to powers of s, then the companion
    /// matrix.
    fn roots_through_powers(basis: &Forsythe, d: &[f64]) -> Vec<Complex64> {
        let m = basis.degree();
        let mut powers = vec![vec![0.0; m + 1]; m + 1];
        powers[0][0] = basis.first;
        for k in 0..m {
            for i in 0..=m {
                let shifted = if i > 0 { powers[k][i - 1] } else { 0.0 };
                let before = if k > 0 {
                    basis.recurrence[k - 1] * powers[k - 1][i]
                } else {
                    0.0
                };
                powers[k + 1][i] = (shifted + before) / basis.recurrence[k];
            }
        }
        let sum: Vec<f64> = (0..=m)
            .map(|i| (0..=m).map(|k| d[k] * powers[k][i]).sum())
            .collect();
        let mut companion = Array2::<Complex64>::zeros((m, m));
        for i in 0..m {
            if i + 1 < m {
                companion[[i, i + 1]] += 1.0;
            }
            companion[[m - 1, i]] -= sum[i] / sum[m];
        }
        eigenvalues(companion.view()).unwrap().to_vec()
    }

    /// Kept as the warning it is: eleven digits are gone at degree 40, all of them at
    /// degree 68.
    #[test]
    fn roots_through_powers_are_lost() {
        let y = lines();
        let weights = vec![1.0; y.len()];
        let half_bandwidth = 0.003;
        for (pairs, least) in [(20, 1e-5), (34, 2.0 * half_bandwidth)] {
            let poles = known_poles(pairs);
            let basis = Forsythe::new(&y, &weights, 2 * poles.len()).unwrap();
            let d = coefficients(&poles, &basis, &y, &weights);
            let worst = worst_root(&poles, &roots_through_powers(&basis, &d));
            assert!(worst > least, "{pairs} pairs: {worst:e}");
        }
    }

    #[test]
    fn too_few_lines_are_an_error() {
        let outcome = Forsythe::new(&[0.5, 1.0], &[1.0, 1.0], 4);
        assert!(
            matches!(outcome, Err(LinalgError::RankDeficient { rank: 4, .. })),
            "{outcome:?}"
        );
        assert!(Forsythe::new(&[0.5, 1.0], &[0.0, 0.0], 1).is_err());
    }
}
