//! Polynomials orthonormal on the lines for a given weight, and the roots of a polynomial
//! written in them.
//!
//! Lanczos on diag(t) from the square root of the weight gives p_0, p_1, … with
//! t·p_k = β_{k+1}·p_{k+1} + α_k·p_k + β_k·p_{k−1} (theory.md, eq. 68). Each new one is
//! orthogonalised twice against all before it: the weights S/|a|² have sharp peaks, and
//! the short recurrence alone drifts. Roots are the eigenvalues of the comrade matrix: the
//! recurrence with its last row changed. Powers of t lose all digits at degree 34.
//!
//! Weights that are even in t make every p_k even or odd; then only half of the axis is
//! stored, and parities are orthogonal by symmetry.
//!
//! G. H. Golub, G. Meurant, *Matrices, Moments and Quadrature* (2010), chapter 4; S.
//! Barnett, Linear Algebra Appl. 12 (1975) 197–208 (comrade matrix). Cost: 8·lines·degree²
//! flop for the basis, O(degree³) for the roots.

use super::limits::{LANCZOS_BREAKDOWN, VANISHING};
use chladni_linalg::{eigenvalues, LinalgError};
use ndarray::{Array1, Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;

/// Symmetry of the weights about t = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Symmetry {
    /// The lines are the whole axis.
    None,
    /// The lines are the positive half of a symmetric axis.
    Even,
}

/// Orthonormal polynomials and their recurrence.
#[derive(Debug, Clone)]
pub(crate) struct Polynomials {
    /// √weight·p_k on the lines, axes (line, degree).
    pub columns: Array2<f64>,
    /// α_0 … α_{n−1}.
    diagonal: Vec<f64>,
    /// β_1 … β_n.
    beside: Vec<f64>,
}

impl Polynomials {
    /// Degrees 0 … `degree` on `nodes`, from the square root of the weight.
    ///
    /// # Errors
    /// [`LinalgError::RankDeficient`] where the lines with weight carry fewer polynomials.
    pub fn new(
        nodes: &[f64],
        root_weight: Array1<f64>,
        degree: usize,
        symmetry: Symmetry,
    ) -> Result<Self, LinalgError> {
        let nodes = ArrayView1::from(nodes);
        let exhausted = |rank| LinalgError::RankDeficient {
            rank,
            columns: degree + 1,
        };
        let mass = root_weight.dot(&root_weight).sqrt();
        if !(mass > 0.0 && mass.is_finite()) {
            return Err(exhausted(0));
        }
        let mut columns = Array2::zeros((nodes.len(), degree + 1).f());
        columns.column_mut(0).assign(&(root_weight / mass));
        let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
        for k in 0..degree {
            let mut next = &columns.column(k) * &nodes;
            let (first, step) = match symmetry {
                Symmetry::None => (0, 1),
                Symmetry::Even => ((k + 1) % 2, 2),
            };
            let mut own = 0.0;
            for _ in 0..2 {
                for earlier in (first..=k).step_by(step) {
                    let column = columns.column(earlier);
                    let overlap = column.dot(&next);
                    next.scaled_add(-overlap, &column);
                    if earlier == k {
                        own += overlap;
                    }
                }
            }
            let norm = next.dot(&next).sqrt();
            if norm <= LANCZOS_BREAKDOWN {
                return Err(exhausted(k + 1));
            }
            diagonal.push(own);
            beside.push(norm);
            columns.column_mut(k + 1).assign(&(next / norm));
        }
        Ok(Self {
            columns,
            diagonal,
            beside,
        })
    }

    /// Roots of Σ d_k p_k in t, in no particular order; those at infinity are left out.
    ///
    /// # Errors
    /// Coefficients that are not finite; no convergence.
    pub fn roots(&self, d: &[Complex64]) -> Result<Vec<Complex64>, LinalgError> {
        let largest = d.iter().fold(0.0, |m: f64, v| m.max(v.norm()));
        let carried = |v: &Complex64| v.norm() > VANISHING * largest;
        let n = d.iter().rposition(carried).unwrap_or(0);
        if n == 0 {
            return Ok(Vec::new());
        }
        let mut comrade = Array2::<Complex64>::zeros((n, n));
        for k in 0..n {
            comrade[[k, k]] += self.diagonal[k];
            if k + 1 < n {
                comrade[[k, k + 1]] += self.beside[k];
                comrade[[k + 1, k]] += self.beside[k];
            }
        }
        for k in 0..n {
            comrade[[n - 1, k]] -= self.beside[n - 1] * d[k] / d[n];
        }
        Ok(eigenvalues(comrade.view())?.to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::fraction::Denominator;
    use chladni_linalg::matmul_h;

    /// Modes spread evenly over (−1, 1), as many lines for each as a panel has.
    fn even(modes: usize) -> (Vec<f64>, Vec<Complex64>) {
        let lines = 50 * modes;
        let nodes = (0..lines).map(|k| 2.0 * (k as f64 + 0.5) / lines as f64 - 1.0);
        let poles = (0..modes).map(|n| {
            Complex64::new(
                2.0 * (n as f64 + 0.5) / modes as f64 - 1.0,
                0.1 / modes as f64,
            )
        });
        (nodes.collect(), poles.collect())
    }

    /// Root of the weight S/|a|², S the energy of resonances of equal size.
    fn peaked(nodes: &[f64], poles: &[Complex64], known: &Denominator) -> Array1<f64> {
        let energy: Array1<f64> = nodes
            .iter()
            .map(|t| {
                poles
                    .iter()
                    .map(|p| 1.0 / (*p - *t).norm_sqr())
                    .sum::<f64>()
                    .sqrt()
            })
            .collect();
        &energy * &known.inverse
    }

    #[test]
    fn polynomials_are_orthonormal_to_the_last_digit() {
        for modes in [12, 34, 100] {
            let (nodes, poles) = even(modes);
            let known = Denominator::of(&nodes, &poles);
            for weight in [Array1::ones(nodes.len()), peaked(&nodes, &poles, &known)] {
                let t = Polynomials::new(&nodes, weight, modes, Symmetry::None)
                    .unwrap()
                    .columns;
                let gram = matmul_h(t.view(), t.view());
                let worst = (gram - Array2::<f64>::eye(modes + 1))
                    .iter()
                    .fold(0.0, |m: f64, v| m.max(v.abs()));
                assert!(worst <= 1e-14, "{modes} modes: {worst:e}");
            }
        }
    }

    #[test]
    fn roots_of_a_hundred_modes_hold_ten_digits_of_a_half_bandwidth() {
        for modes in [34, 100] {
            let (nodes, poles) = even(modes);
            let known = Denominator::of(&nodes, &poles);
            let weight = peaked(&nodes, &poles, &known);
            let basis = Polynomials::new(&nodes, weight.clone(), modes, Symmetry::None).unwrap();
            // the denominator itself in units of its weight
            let d: Vec<Complex64> = basis
                .columns
                .columns()
                .into_iter()
                .map(|column| {
                    let sum = column
                        .iter()
                        .zip(&known.phase)
                        .zip(&weight)
                        .zip(&known.inverse);
                    sum.map(|(((t, phase), w), inverse)| phase * (t * w / inverse))
                        .sum()
                })
                .collect();
            let length = d.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
            assert!(
                d[modes].norm() > 1e-3 * length,
                "the last coefficient is lost"
            );
            let roots = basis.roots(&d).unwrap();
            let worst = poles
                .iter()
                .map(|p| {
                    let nearest = roots.iter().map(|r| (r - p).norm());
                    nearest.fold(f64::INFINITY, f64::min) / p.im
                })
                .fold(0.0, f64::max);
            assert!(worst <= 1e-10, "{modes} modes: {worst:e}");
        }
    }

    #[test]
    fn an_even_weight_makes_polynomials_of_one_parity_each() {
        let nodes: Vec<f64> = (1..=60).map(|k| f64::from(k) / 60.0).collect();
        let start = Array1::from_elem(60, 1.0);
        let half = Polynomials::new(&nodes, start, 7, Symmetry::Even).unwrap();
        let mirrored: Vec<f64> = nodes.iter().map(|t| -t).chain(nodes.clone()).collect();
        let whole = Polynomials::new(&mirrored, Array1::ones(120), 7, Symmetry::None).unwrap();
        for k in 0..=7 {
            for row in 0..60 {
                let twice = 2f64.sqrt() * whole.columns[[60 + row, k]];
                assert!((half.columns[[row, k]] - twice).abs() < 1e-12, "{k} {row}");
            }
        }
    }

    #[test]
    fn too_few_lines_are_an_error() {
        let outcome = Polynomials::new(&[-1.0, 0.0, 1.0], Array1::ones(3), 3, Symmetry::None);
        assert!(
            matches!(outcome, Err(LinalgError::RankDeficient { .. })),
            "{outcome:?}"
        );
        assert!(Polynomials::new(&[0.5], Array1::zeros(1), 0, Symmetry::None).is_err());
    }
}
