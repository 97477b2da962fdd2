//! Fields between the measured responses: polyharmonic splines, for responses anywhere.
//!
//! v(x) = Σ_k c_k φ(|x − x_k|) + polynomial of degree m − 1, φ(r) = r^{2m−2}·ln r, with Σ_k c_k p(x_k) = 0 for all those
//! polynomials; m = 2 is the thin-plate spline (Duchon 1977; Wendland, *Scattered Data Approximation*, 2005, section 8.3).
//! The order m = 4 is taken where the responses carry its ten polynomials. Measured on the panel of the fixtures at 300 Hz (20 mm
//! between responses, 153 mm of wavelength), rms error of a rendered field and largest factor on the noise of the responses: m = 2
//! 2.3 % and 1.00, m = 3 1.2 % and 1.01, m = 4 0.5 % and 1.15, m = 5 0.3 % and 1.57, m = 6 0.3 % and 2.43. Nothing is
//! extrapolated: ask only inside the convex hull.

use crate::plane::Position;
use crate::tolerances;
use chladni_linalg::lstsq;
use ndarray::{s, Array1, Array2, ArrayView2, Axis};
use num_complex::Complex64;

/// The orders m that are tried, the smoothest first.
const ORDERS: [usize; 3] = [4, 3, 2];

/// Interpolation from nodes to queries: each value is a weighted sum of the values at some nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Interpolation {
    /// Nodes that each query's value is made of; axes (query, neighbour).
    nodes: Array2<usize>,
    /// Their weights; same axes.
    weights: Array2<f64>,
}

impl Interpolation {
    /// `None` where the nodes carry no plane (fewer than three, or all on one line).
    pub(crate) fn new(nodes: &[Position], queries: &[Position]) -> Option<Self> {
        if nodes.len() <= tolerances::GLOBAL_INTERPOLATION {
            let all = Array2::from_shape_fn((queries.len(), nodes.len()), |(_, k)| k);
            return Some(Self { nodes: all, weights: patch_matrix(nodes, queries)? });
        }
        let shape = (queries.len(), tolerances::NEAREST_RESPONSES);
        let (mut neighbours, mut weights) = (Array2::zeros(shape), Array2::zeros(shape));
        for (q, &query) in queries.iter().enumerate() {
            let squared = |k: usize| (nodes[k][0] - query[0]).powi(2) + (nodes[k][1] - query[1]).powi(2);
            let mut order: Vec<usize> = (0..nodes.len()).collect();
            order.select_nth_unstable_by(tolerances::NEAREST_RESPONSES - 1, |&a, &b| squared(a).total_cmp(&squared(b)).then(a.cmp(&b)));
            order.truncate(tolerances::NEAREST_RESPONSES);
            order.sort_unstable();
            let patch: Vec<Position> = order.iter().map(|&k| nodes[k]).collect();
            weights.row_mut(q).assign(&patch_matrix(&patch, &[query])?.row(0));
            neighbours.row_mut(q).assign(&Array1::from(order));
        }
        Some(Self { nodes: neighbours, weights })
    }

    /// Fields at the queries from `values` at the nodes, axes (node, field); returns axes (query, field).
    pub(crate) fn apply(&self, values: ArrayView2<Complex64>) -> Array2<Complex64> {
        let mut fields = Array2::zeros((self.nodes.nrows(), values.ncols()));
        for (mut row, (nodes, weights)) in fields.rows_mut().into_iter().zip(self.nodes.rows().into_iter().zip(self.weights.rows())) {
            for (&node, &weight) in nodes.iter().zip(weights) {
                row.zip_mut_with(&values.row(node), |sum, &value| *sum += value * weight);
            }
        }
        fields
    }

    /// The interpolation to the queries `rows` alone.
    pub(crate) fn select(&self, rows: &[usize]) -> Self {
        Self { nodes: self.nodes.select(Axis(0), rows), weights: self.weights.select(Axis(0), rows) }
    }
}

/// The matrix S with v(queries) = S·v(nodes), from all nodes at once, by the highest order that they carry; axes (query, node).
fn patch_matrix(nodes: &[Position], queries: &[Position]) -> Option<Array2<f64>> {
    ORDERS.iter().find_map(|&order| spline_matrix(order, nodes, queries))
}

fn spline_matrix(order: usize, nodes: &[Position], queries: &[Position]) -> Option<Array2<f64>> {
    let polynomials = order * (order + 1) / 2;
    if nodes.len() < polynomials {
        return None;
    }
    let scaled = scaling(nodes);
    let nodes: Vec<Position> = nodes.iter().map(|&p| scaled(p)).collect();
    let basis =
        |point: Position| -> Vec<f64> { nodes.iter().map(|&node| phi(order, node, point)).chain(monomials(order, point)).collect() };
    let size = nodes.len() + polynomials;
    let mut system = Array2::zeros((size, size));
    for (k, &node) in nodes.iter().enumerate() {
        let row = basis(node);
        for (j, &value) in row.iter().enumerate() {
            system[[k, j]] = value;
            system[[j, k]] = value;
        }
    }
    let mut right = Array2::zeros((size, queries.len()));
    for (q, &query) in queries.iter().enumerate() {
        right.column_mut(q).assign(&Array1::from(basis(scaled(query))));
    }
    // The system is symmetric: v(query) = basis(query)ᵀ·M⁻¹·[v; 0] = (M⁻¹·basis(query))ᵀ·[v; 0].
    let solution = lstsq(system.view(), right.view()).ok()?;
    Some(solution.slice(s![..nodes.len(), ..]).t().to_owned())
}

/// To coordinates of order one: powers of metres would differ by many orders of magnitude.
fn scaling(nodes: &[Position]) -> impl Fn(Position) -> Position {
    let count = nodes.len() as f64;
    let centre = [0, 1].map(|axis| nodes.iter().map(|node| node[axis]).sum::<f64>() / count);
    let radius = nodes.iter().map(|node| (node[0] - centre[0]).hypot(node[1] - centre[1])).fold(f64::MIN_POSITIVE, f64::max);
    move |point| [0, 1].map(|axis| (point[axis] - centre[axis]) / radius)
}

/// r^{2m−2}·ln r.
fn phi(order: usize, a: Position, b: Position) -> f64 {
    let squared = (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    if squared == 0.0 {
        0.0
    } else {
        0.5 * squared.powi(order as i32 - 1) * squared.ln()
    }
}

/// All monomials of degree below `order`.
fn monomials(order: usize, [x, y]: Position) -> impl Iterator<Item = f64> {
    (0..order as i32).flat_map(move |degree| (0..=degree).map(move |power| x.powi(degree - power) * y.powi(power)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(columns: usize, rows: usize, step: f64) -> Vec<Position> {
        (0..columns * rows).map(|k| [0.034 + step * (k % columns) as f64, 0.025 + step * (k / columns) as f64]).collect()
    }

    fn largest_error(nodes: &[Position], queries: &[Position], field: impl Fn(Position) -> f64) -> f64 {
        let values = Array2::from_shape_fn((nodes.len(), 1), |(k, _)| Complex64::from(field(nodes[k])));
        let found = Interpolation::new(nodes, queries).unwrap().apply(values.view());
        found.iter().zip(queries).map(|(value, &query)| (value - field(query)).norm()).fold(0.0, f64::max)
    }

    #[test]
    fn cubic_polynomials_are_reproduced() {
        let cubic = |[x, y]: Position| 1.0 + 20.0 * x - 300.0 * x * y + 5000.0 * x * y * y - 700.0 * x.powi(3);
        assert!(largest_error(&grid(5, 4, 0.02), &grid(9, 7, 0.01), cubic) < 1e-9);
    }

    #[test]
    fn noise_of_the_responses_is_not_amplified() {
        let interpolation = Interpolation::new(&grid(11, 7, 0.02), &grid(41, 25, 0.005)).unwrap();
        let largest = interpolation.weights.rows().into_iter().map(|row| row.dot(&row).sqrt()).fold(0.0, f64::max);
        assert!(largest < 1.2, "{largest}");
    }

    #[test]
    fn many_responses_are_interpolated_patch_by_patch() {
        let wave = |[x, y]: Position| (41.0 * x).sin() * (30.0 * y).cos();
        let error = largest_error(&grid(20, 12, 0.01), &grid(38, 23, 0.005), wave);
        assert!(error < 1e-3, "{error}");
    }

    #[test]
    fn few_responses_take_a_lower_order_and_a_line_none() {
        let plane = |[x, y]: Position| 3.0 * x - y;
        assert!(largest_error(&[[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]], &[[0.03, 0.03]], plane) < 1e-12);
        assert!(Interpolation::new(&grid(7, 1, 0.02), &[[0.05, 0.025]]).is_none());
        assert!(Interpolation::new(&grid(2, 1, 0.02), &[[0.05, 0.025]]).is_none());
    }
}
