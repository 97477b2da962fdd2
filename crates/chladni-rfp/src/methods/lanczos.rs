//! Polynomials orthonormal on the lines for a given weight, and the roots of a polynomial
//! written in them.
//!
//! Lanczos on diag(t) from the square root of the weight gives p_0, p_1, … with
//! t·p_k = β_{k+1}·p_{k+1} + α_k·p_k + β_k·p_{k−1} (theory.md, eq. 57). Each new one is
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

use chladni_linalg::{eigenvalues, LinalgError};
use ndarray::{Array1, Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;

/// A recurrence coefficient below this says that the lines carry no further polynomial:
/// fewer of them have weight than the degree asks for.
const BREAKDOWN: f64 = 1e-13;

/// Size of a leading coefficient over the largest one below which it is rounding.
const VANISHING: f64 = 1e-16;

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
            if norm <= BREAKDOWN {
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
