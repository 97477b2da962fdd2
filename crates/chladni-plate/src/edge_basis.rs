//! Polynomials along one side of the plate that keep the edge conditions: φ_m(ξ) =
//! (1+ξ)^s₀ (1−ξ)^s₁ p_m(ξ) on −1 ≤ ξ ≤ 1.
//!
//! The powers s are 0, 1, 2 for a free, supported and clamped edge. With p_m the
//! orthonormal Jacobi polynomials of weight (1−ξ)^(2s₁) (1+ξ)^(2s₀) the φ_m are
//! orthonormal, ∫ φ_m φ_n dξ = δ_mn, at any degree: no Gram matrix has to be inverted,
//! and free edges give Legendre polynomials. Values and derivatives follow from the
//! three-term recurrence
//!
//! ξ p_m = b_{m+1} p_{m+1} + a_m p_m + b_m p_{m−1}
//!
//! and its derivatives (Gautschi, *Orthogonal Polynomials: Computation and
//! Approximation*, 2004, table 1.1).

use crate::edges::Edge;
use chladni_linalg::matmul_h;
use ndarray::Array2;

/// The first `terms` polynomials between two edges.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EdgeBasis {
    powers: [usize; 2],
    terms: usize,
    first_value: f64,
    diagonal: Vec<f64>,
    off_diagonal: Vec<f64>,
}

/// ∫ φ_m^(r) φ_n^(s) dξ for the derivative orders that bending energy needs; named by (r,
/// s).
#[derive(Debug, Clone)]
pub(crate) struct Integrals {
    pub d22: Array2<f64>,
    pub d20: Array2<f64>,
    pub d11: Array2<f64>,
}

impl EdgeBasis {
    pub fn new(edges: [Edge; 2], terms: usize) -> Self {
        let powers = edges.map(Edge::power);
        // weight (1−ξ)^alpha (1+ξ)^beta
        let (alpha, beta) = (2.0 * powers[1] as f64, 2.0 * powers[0] as f64);
        let diagonal = (0..terms)
            .map(|m| {
                let c = 2.0 * m as f64 + alpha + beta;
                match m {
                    0 => (beta - alpha) / (c + 2.0),
                    _ => (beta * beta - alpha * alpha) / (c * (c + 2.0)),
                }
            })
            .collect();
        let off_diagonal = (0..=terms)
            .map(|m| {
                let n = m as f64;
                let c = 2.0 * n + alpha + beta;
                match m {
                    0 => 0.0,
                    1 => (4.0 * (1.0 + alpha) * (1.0 + beta) / (c * c * (c + 1.0))).sqrt(),
                    _ => (4.0 * n * (n + alpha) * (n + beta) * (n + alpha + beta)
                        / (c * c * (c + 1.0) * (c - 1.0)))
                        .sqrt(),
                }
            })
            .collect();
        Self {
            powers,
            terms,
            first_value: 1.0 / weight_integral(2 * powers[1], 2 * powers[0]).sqrt(),
            diagonal,
            off_diagonal,
        }
    }

    pub fn terms(&self) -> usize {
        self.terms
    }

    /// [φ_m, φ_m′, φ_m″] of every m at ξ.
    pub fn evaluate(&self, xi: f64) -> Vec<[f64; 3]> {
        let (left, right) = (
            power(1.0 + xi, 1.0, self.powers[0]),
            power(1.0 - xi, -1.0, self.powers[1]),
        );
        let edge = product(left, right);
        let (mut before, mut now) = ([0.0; 3], [self.first_value, 0.0, 0.0]);
        let mut all = Vec::with_capacity(self.terms);
        for m in 0..self.terms {
            all.push(product(edge, now));
            let (a, b, b_next) = (
                self.diagonal[m],
                self.off_diagonal[m],
                self.off_diagonal[m + 1],
            );
            let next = [
                ((xi - a) * now[0] - b * before[0]) / b_next,
                ((xi - a) * now[1] + now[0] - b * before[1]) / b_next,
                ((xi - a) * now[2] + 2.0 * now[1] - b * before[2]) / b_next,
            ];
            (before, now) = (now, next);
        }
        all
    }

    /// Integrals by Gauss-Legendre quadrature, exact for these degrees.
    pub fn integrals(&self) -> Integrals {
        let degree = self.terms + self.powers[0] + self.powers[1];
        let (nodes, weights) = gauss_legendre(degree + 1);
        let mut tables = [(); 3].map(|()| Array2::<f64>::zeros((nodes.len(), self.terms)));
        for (q, (&xi, weight)) in nodes.iter().zip(&weights).enumerate() {
            for (m, values) in self.evaluate(xi).into_iter().enumerate() {
                for r in 0..3 {
                    tables[r][[q, m]] = weight.sqrt() * values[r];
                }
            }
        }
        let integral = |r: usize, s: usize| matmul_h(tables[r].view(), tables[s].view());
        Integrals {
            d22: integral(2, 2),
            d20: integral(2, 0),
            d11: integral(1, 1),
        }
    }
}

/// x^s with first and second derivative along ξ, for dx/dξ = slope = ±1.
fn power(x: f64, slope: f64, s: usize) -> [f64; 3] {
    match s {
        0 => [1.0, 0.0, 0.0],
        1 => [x, slope, 0.0],
        _ => [x * x, 2.0 * slope * x, 2.0],
    }
}

/// Value, first and second derivative of a product.
fn product(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [
        u[0] * v[0],
        u[1] * v[0] + u[0] * v[1],
        u[2] * v[0] + 2.0 * u[1] * v[1] + u[0] * v[2],
    ]
}

/// ∫ (1−ξ)^α (1+ξ)^β dξ = 2^(α+β+1) α! β! / (α+β+1)!
fn weight_integral(alpha: usize, beta: usize) -> f64 {
    let factorial = |n: usize| (1..=n).map(|i| i as f64).product::<f64>();
    2f64.powi((alpha + beta + 1) as i32) * factorial(alpha) * factorial(beta)
        / factorial(alpha + beta + 1)
}

/// Nodes and weights of Gauss-Legendre quadrature with `count` points, by Newton's method
/// on P_count.
pub(crate) fn gauss_legendre(count: usize) -> (Vec<f64>, Vec<f64>) {
    let n = count as f64;
    (0..count)
        .map(|i| {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..8 {
                let (mut before, mut now) = (0.0, 1.0);
                for m in 0..count {
                    let k = m as f64;
                    (before, now) = (now, ((2.0 * k + 1.0) * x * now - k * before) / (k + 1.0));
                }
                slope = n * (before - x * now) / (1.0 - x * x);
                x -= now / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_orthonormal_for_every_pair_of_edges_up_to_high_degree() {
        let kinds = [Edge::Free, Edge::Supported, Edge::Clamped];
        for edges in kinds.iter().flat_map(|&a| kinds.map(|b| [a, b])) {
            let basis = EdgeBasis::new(edges, 60);
            let (nodes, weights) = gauss_legendre(70);
            let mut gram = Array2::<f64>::zeros((60, 60));
            for (xi, weight) in nodes.iter().zip(&weights) {
                let values = basis.evaluate(*xi);
                gram +=
                    &Array2::from_shape_fn((60, 60), |(m, n)| weight * values[m][0] * values[n][0]);
            }
            let worst = (gram - Array2::<f64>::eye(60))
                .iter()
                .fold(0.0f64, |w, v| w.max(v.abs()));
            assert!(worst < 1e-12, "{edges:?}: {worst:e}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences_and_edges_are_held() {
        let basis = EdgeBasis::new([Edge::Clamped, Edge::Supported], 8);
        let (step, xi) = (1e-5, 0.3);
        let [low, here, high] = [-step, 0.0, step].map(|d| basis.evaluate(xi + d));
        for m in 0..8 {
            let slope = (high[m][0] - low[m][0]) / (2.0 * step);
            let bend = (high[m][1] - low[m][1]) / (2.0 * step);
            assert!((slope - here[m][1]).abs() < 1e-6 * (1.0 + slope.abs()));
            assert!((bend - here[m][2]).abs() < 1e-6 * (1.0 + bend.abs()));
            let (left, right) = (basis.evaluate(-1.0)[m], basis.evaluate(1.0)[m]);
            assert!(left[0] == 0.0 && left[1] == 0.0 && right[0] == 0.0 && right[1] != 0.0);
        }
    }

    #[test]
    fn quadrature_integrates_polynomials_exactly() {
        let (nodes, weights) = gauss_legendre(40);
        for degree in [0, 2, 40, 78] {
            let integral: f64 = nodes
                .iter()
                .zip(&weights)
                .map(|(x, w)| w * x.powi(degree))
                .sum();
            assert!((integral - 2.0 / (degree as f64 + 1.0)).abs() < 1e-14);
        }
    }
}
