//! Fields between the measured responses: polyharmonic splines, for responses anywhere.
//!
//! v(x) = Σ_k c_k φ(|x − x_k|) + polynomial of degree m − 1, φ(r) = r^{2m−2}·ln r, with
//! Σ_k c_k p(x_k) = 0 for all those polynomials; m = 2 is the thin-plate spline (Duchon
//! 1977; Wendland, *Scattered Data Approximation*, 2005, section 8.3). The order m = 4 is
//! taken where the responses carry its ten polynomials. Measured on the panel of the
//! fixtures at 300 Hz (20 mm between responses, 153 mm of wavelength), rms error of a
//! rendered field and largest factor on the noise of the responses: m = 2 2.3 % and 1.00,
//! m = 3 1.2 % and 1.01, m = 4 0.5 % and 1.15, m = 5 0.3 % and 1.57, m = 6 0.3 % and
//! 2.43. Nothing is extrapolated: ask only inside the convex hull.

use crate::panel::lattice::Lattice;
use crate::scene::plane::Position;
use crate::tolerances;
use crate::tolerances::ORDERS;
use chladni_linalg::{
    add_matmul, cholesky, matmul, matmul_h, qr_thin, solve_lower, solve_lower_adjoint, solve_upper,
    RANK_TOLERANCE,
};
use ndarray::{concatenate, s, stack, Array1, Array2, ArrayView1, ArrayView2, Axis};
use num_complex::Complex64;
use std::sync::Arc;

/// Places where a field is known, made ready for interpolation: once for any number of
/// queries and fields.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Nodes {
    places: Vec<Position>,
    /// One spline through all of them, where they are not too many.
    whole: Option<Arc<Spline>>,
}

/// Interpolation from nodes to queries.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Interpolation {
    /// One spline through all nodes, and its basis at the queries; axes (query,
    /// coefficient).
    Whole(Arc<Spline>, Array2<f64>),
    /// A spline of its own around each query.
    Patches(Vec<Patch>),
}

/// The nodes that the value at one query is made of, and their weights.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Patch {
    nodes: Vec<usize>,
    weights: Array1<f64>,
}

impl Nodes {
    /// `None` where the nodes carry no plane (fewer than three, or all on one line).
    pub(crate) fn new(places: &[Position]) -> Option<Self> {
        let whole = match places.len() <= tolerances::GLOBAL_INTERPOLATION {
            true => Some(Arc::new(Spline::through(places)?)),
            false => None,
        };
        let places = places.to_vec();
        Some(Self { places, whole })
    }

    /// One field at the queries from its `values` at the nodes: as [`Self::onto`] and
    /// [`Interpolation::apply`], whose basis takes longer to write down than to use once.
    /// `None` where the nodes around a query carry no plane.
    pub(crate) fn field(
        &self,
        values: ArrayView1<Complex64>,
        queries: &[Position],
    ) -> Option<Vec<Complex64>> {
        match self.whole_for(queries) {
            Some(spline) => Some(spline.field(values, queries)),
            None => {
                let field = self.onto(queries)?.apply(values.insert_axis(Axis(1)));
                Some(field.into_iter().collect())
            }
        }
    }

    /// The spline through all nodes, where it serves so many queries.
    fn whole_for(&self, queries: &[Position]) -> Option<&Arc<Spline>> {
        let size = self.places.len() * queries.len();
        let whole = self.whole.as_ref();
        whole.filter(|_| size <= tolerances::GLOBAL_BASIS)
    }

    /// `None` where the nodes around a query carry no plane.
    pub(crate) fn onto(&self, queries: &[Position]) -> Option<Interpolation> {
        let nodes = &self.places;
        if let Some(spline) = self.whole_for(queries) {
            let basis = spline.basis(queries);
            return Some(Interpolation::Whole(spline.clone(), basis));
        }
        let patches: Option<Vec<Patch>> = queries
            .iter()
            .map(|&query| {
                let near = nearest(nodes, query);
                let around: Vec<Position> = near.iter().map(|&k| nodes[k]).collect();
                let weights = Spline::through(&around)?.weights(query);
                Some(Patch {
                    nodes: near,
                    weights,
                })
            })
            .collect();
        patches.map(Interpolation::Patches)
    }
}

/// The `tolerances::NEAREST_RESPONSES` nodes around a query, and all that lie as far as
/// the last of them: on a grid many do, and which of them rounding puts first must not
/// matter.
fn nearest(nodes: &[Position], query: Position) -> Vec<usize> {
    let distances: Vec<f64> = nodes
        .iter()
        .map(|node| ((node[0] - query[0]).powi(2) + (node[1] - query[1]).powi(2)).sqrt())
        .collect();
    let mut sorted = distances.clone();
    let last = tolerances::NEAREST_RESPONSES.min(nodes.len()) - 1;
    let (_, &mut farthest, _) = sorted.select_nth_unstable_by(last, f64::total_cmp);
    (0..nodes.len())
        .filter(|&k| distances[k] <= farthest + tolerances::POSITION_M)
        .collect()
}

impl Interpolation {
    /// Fields at the queries from `values` at the nodes, axes (node, field); returns axes
    /// (query, field).
    pub(crate) fn apply(&self, values: ArrayView2<Complex64>) -> Array2<Complex64> {
        match self {
            Self::Whole(spline, basis) => {
                let fields = values.ncols();
                let parts = Array2::from_shape_fn((values.nrows(), 2 * fields), |(k, column)| {
                    match column < fields {
                        true => values[[k, column]].re,
                        false => values[[k, column - fields]].im,
                    }
                });
                let coefficients = spline.solve(parts.view());
                // for a single field a product of matrices would spend its time on
                // packing the basis
                let parts = match fields {
                    1 => stack![
                        Axis(1),
                        basis.dot(&coefficients.column(0)),
                        basis.dot(&coefficients.column(1))
                    ],
                    _ => matmul(basis.view(), coefficients.view()),
                };
                Array2::from_shape_fn((basis.nrows(), fields), |(q, column)| {
                    Complex64::new(parts[[q, column]], parts[[q, fields + column]])
                })
            }
            Self::Patches(patches) => {
                let mut fields = Array2::zeros((patches.len(), values.ncols()));
                for (mut row, patch) in fields.rows_mut().into_iter().zip(patches) {
                    for (&node, &weight) in patch.nodes.iter().zip(&patch.weights) {
                        row.zip_mut_with(&values.row(node), |sum, &value| *sum += value * weight);
                    }
                }
                fields
            }
        }
    }
}

/// A polyharmonic spline through nodes, factorised.
///
/// With the polynomials at the nodes P = Q·R and the projection Π = I − Q·Qᵀ past them,
/// (−1)^m·Π·Φ·Π is positive definite on the range of Π (Wendland, section 8.1): c = Π·c
/// solves Π·Φ·Π·c = Π·v, and R·d = Qᵀ·(v − Φ·c).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spline {
    order: usize,
    /// Scaled to coordinates of order one: powers of metres would differ by many orders
    /// of magnitude.
    nodes: Vec<Position>,
    centre: Position,
    radius: f64,
    /// Φ; axes (node, node).
    kernel: Array2<f64>,
    q: Array2<f64>,
    r: Array2<f64>,
    /// L·Lᵀ = (−1)^m·Π·Φ·Π + τ·Q·Qᵀ with some τ > 0.
    lower: Array2<f64>,
}

impl Spline {
    /// By the highest order that the nodes carry.
    fn through(nodes: &[Position]) -> Option<Self> {
        ORDERS
            .iter()
            .find_map(|&order| Self::of_order(order, nodes))
    }

    fn of_order(order: usize, nodes: &[Position]) -> Option<Self> {
        let polynomials = order * (order + 1) / 2;
        if nodes.len() < polynomials {
            return None;
        }
        let count = nodes.len() as f64;
        let centre = [0, 1].map(|axis| nodes.iter().map(|node| node[axis]).sum::<f64>() / count);
        let radius = nodes
            .iter()
            .map(|node| (node[0] - centre[0]).hypot(node[1] - centre[1]))
            .fold(f64::MIN_POSITIVE, f64::max);
        let empty = || Array2::zeros((0, 0));
        let mut spline = Self {
            order,
            nodes: Vec::new(),
            centre,
            radius,
            kernel: empty(),
            q: empty(),
            r: empty(),
            lower: empty(),
        };
        spline.nodes = nodes.iter().map(|&node| spline.scaled(node)).collect();
        let basis = spline.basis(nodes);
        let (kernel, polynomial) = basis.view().split_at(Axis(1), nodes.len());
        let (q, r) = qr_thin(polynomial).ok()?;
        // coordinates are of order one, and so is the mean square of a monomial
        if r.diag()
            .iter()
            .any(|value| value.abs() <= RANK_TOLERANCE * count.sqrt())
        {
            return None;
        }
        // Π·Φ·Π = Φ − Q·Wᵀ − W·Qᵀ, W = Φ·Q − Q·(Qᵀ·Φ·Q)/2
        let kernel = kernel.to_owned();
        let on_polynomials = matmul(kernel.view(), q.view());
        let inner = matmul_h(q.view(), on_polynomials.view());
        let w = on_polynomials - matmul(q.view(), inner.view()) * 0.5;
        let (sign, trace) = (spline.sign(), kernel.diag().sum() - inner.diag().sum());
        // as many nodes as polynomials leave nothing but rounding
        let mean = f64::max(sign * trace / count, RANK_TOLERANCE);
        let left = concatenate![Axis(1), q, w];
        let right = concatenate![Axis(1), &q * mean - &w * sign, &q * -sign];
        // Φ is symmetric: the other order of memory is its own
        let mut gram = (&kernel * sign).reversed_axes();
        add_matmul(gram.view_mut(), left.view(), right.t());
        let lower = cholesky(gram.view()).ok()?;
        Some(Self {
            kernel,
            q,
            r,
            lower,
            ..spline
        })
    }

    /// (−1)^m.
    fn sign(&self) -> f64 {
        if self.order.is_multiple_of(2) {
            1.0
        } else {
            -1.0
        }
    }

    fn scaled(&self, point: Position) -> Position {
        [0, 1].map(|axis| (point[axis] - self.centre[axis]) / self.radius)
    }

    /// Values of the basis functions; axes (query, coefficient).
    fn basis(&self, queries: &[Position]) -> Array2<f64> {
        let queries: Vec<Position> = queries.iter().map(|&query| self.scaled(query)).collect();
        let count = self.nodes.len();
        let mut basis = Array2::zeros((queries.len(), count + self.order * (self.order + 1) / 2));
        match Lattice::of(&queries, &self.nodes) {
            Some(lattice) => lattice.fill(&mut basis, |squared| phi(self.order, squared)),
            None => {
                for (mut row, query) in basis.rows_mut().into_iter().zip(&queries) {
                    for (value, node) in row.iter_mut().zip(&self.nodes) {
                        *value = phi(self.order, squared_distance(node, query));
                    }
                }
            }
        }
        for (mut row, &query) in basis.rows_mut().into_iter().zip(&queries) {
            row.slice_mut(s![count..])
                .iter_mut()
                .zip(monomials(query))
                .for_each(|(place, value)| *place = value);
        }
        basis
    }

    /// The spline through `values` at the queries.
    fn field(&self, values: ArrayView1<Complex64>, queries: &[Position]) -> Vec<Complex64> {
        let parts = stack![Axis(1), values.mapv(|v| v.re), values.mapv(|v| v.im)];
        let solved = self.solve(parts.view());
        let complex = |row: ArrayView1<f64>| Complex64::new(row[0], row[1]);
        let coefficients: Vec<Complex64> = solved.rows().into_iter().map(complex).collect();
        let (of_nodes, of_polynomial) = coefficients.split_at(self.nodes.len());
        let queries: Vec<Position> = queries.iter().map(|&query| self.scaled(query)).collect();
        let kernel = |squared| phi(self.order, squared);
        let one_by_one = |query: &Position| {
            let nodes = self.nodes.iter().zip(of_nodes);
            nodes
                .map(|(node, c)| c * kernel(squared_distance(node, query)))
                .sum::<Complex64>()
        };
        let mut field = match Lattice::of(&queries, &self.nodes) {
            Some(lattice) => lattice.sums(kernel, of_nodes),
            None => queries.iter().map(one_by_one).collect(),
        };
        for (value, &query) in field.iter_mut().zip(&queries) {
            let monomials = monomials(query);
            let terms = monomials.iter().zip(of_polynomial);
            terms.for_each(|(term, c)| *value += c * term);
        }
        field
    }

    /// Weight of each node at one query: the transpose of [`Self::solve`] on its basis.
    fn weights(&self, query: Position) -> Array1<f64> {
        let basis = self.basis(&[query]);
        let (kernel, polynomial) = basis.view().split_at(Axis(1), self.nodes.len());
        let of_polynomial = solve_lower(self.r.t(), polynomial.t()).expect("sizes of one system");
        let of_polynomial = matmul(self.q.view(), of_polynomial.view());
        let of_kernel = self
            .coefficients((&kernel.t() - &matmul(self.kernel.view(), of_polynomial.view())).view());
        (of_kernel + of_polynomial).column(0).to_owned()
    }

    /// For values at the nodes the coefficients of the splines through them; axes
    /// (coefficient, field).
    fn solve(&self, values: ArrayView2<f64>) -> Array2<f64> {
        let of_kernel = self.coefficients(values);
        let left = &values - &matmul(self.kernel.view(), of_kernel.view());
        let of_polynomial = solve_upper(self.r.view(), matmul_h(self.q.view(), left.view()).view())
            .expect("sizes of one system");
        concatenate![Axis(0), of_kernel, of_polynomial]
    }

    /// c of `values` at the nodes.
    fn coefficients(&self, values: ArrayView2<f64>) -> Array2<f64> {
        let half = solve_lower(
            self.lower.view(),
            (past(&self.q, values) * self.sign()).view(),
        );
        let solved = half
            .and_then(|half| solve_lower_adjoint(self.lower.view(), half.view()))
            .expect("sizes of one system");
        past(&self.q, solved.view())
    }
}

/// The part of `columns` that is orthogonal to the columns of `q`.
fn past(q: &Array2<f64>, columns: ArrayView2<f64>) -> Array2<f64> {
    &columns - &matmul(q.view(), matmul_h(q.view(), columns).view())
}

fn squared_distance(a: &Position, b: &Position) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

/// r^{2m−2}·ln r of r².
fn phi(order: usize, squared: f64) -> f64 {
    if squared == 0.0 {
        return 0.0;
    }
    let power = (2..order).fold(squared, |power, _| power * squared);
    0.5 * power * squared.ln()
}

/// All monomials of degree below 4, those of lower degree first: a spline of a lower order takes
/// as many as it has coefficients.
fn monomials([x, y]: Position) -> [f64; 10] {
    let (xx, xy, yy) = (x * x, x * y, y * y);
    [1.0, x, y, xx, xy, yy, x * xx, xx * y, x * yy, y * yy]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(columns: usize, rows: usize, step: f64) -> Vec<Position> {
        (0..columns * rows)
            .map(|k| {
                [
                    0.034 + step * (k % columns) as f64,
                    0.025 + step * (k / columns) as f64,
                ]
            })
            .collect()
    }

    fn largest_error(
        nodes: &[Position],
        queries: &[Position],
        field: impl Fn(Position) -> f64,
    ) -> f64 {
        let values =
            Array2::from_shape_fn((nodes.len(), 1), |(k, _)| Complex64::from(field(nodes[k])));
        let found = Nodes::new(nodes)
            .unwrap()
            .onto(queries)
            .unwrap()
            .apply(values.view());
        found
            .iter()
            .zip(queries)
            .map(|(value, &query)| (value - field(query)).norm())
            .fold(0.0, f64::max)
    }

    #[test]
    fn cubic_polynomials_are_reproduced() {
        let cubic = |[x, y]: Position| {
            1.0 + 20.0 * x - 300.0 * x * y + 5000.0 * x * y * y - 700.0 * x.powi(3)
        };
        assert!(largest_error(&grid(5, 4, 0.02), &grid(9, 7, 0.01), cubic) < 1e-9);
    }

    #[test]
    fn noise_of_the_responses_is_not_amplified() {
        let interpolation = Nodes::new(&grid(11, 7, 0.02))
            .unwrap()
            .onto(&grid(41, 25, 0.005))
            .unwrap();
        let weights = interpolation.apply(Array2::from_diag_elem(77, Complex64::ONE).view());
        let largest = weights
            .rows()
            .into_iter()
            .map(|row| row.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt())
            .fold(0.0, f64::max);
        assert!(largest < 1.2, "{largest}");
    }

    #[test]
    fn a_field_by_itself_is_that_of_the_basis() {
        let scattered: Vec<Position> = (0..40)
            .map(|k| [(7.3 * k as f64).sin(), (3.1 * k as f64).cos()])
            .collect();
        let inside = grid(9, 7, 0.01);
        for (nodes, queries) in [
            (grid(11, 7, 0.02), grid(41, 25, 0.005)),
            (scattered, inside.clone()),
            (grid(40, 26, 0.005), inside),
        ] {
            let value = |k: usize| Complex64::new((0.3 * k as f64).sin(), (0.7 * k as f64).cos());
            let values = Array1::from_shape_fn(nodes.len(), value);
            let nodes = Nodes::new(&nodes).unwrap();
            let all = values.view().insert_axis(Axis(1));
            let expected = nodes.onto(&queries).unwrap().apply(all);
            let found = nodes.field(values.view(), &queries).unwrap();
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).norm() < 1e-9 * expected.norm().max(1.0));
            }
        }
    }

    #[test]
    fn many_responses_are_interpolated_patch_by_patch() {
        let wave = |[x, y]: Position| (41.0 * x).sin() * (30.0 * y).cos();
        let error = largest_error(&grid(40, 26, 0.005), &grid(76, 49, 0.0025), wave);
        assert!(error < 1e-3, "{error}");
    }

    #[test]
    fn few_responses_take_a_lower_order_and_a_line_none() {
        let plane = |[x, y]: Position| 3.0 * x - y;
        assert!(
            largest_error(
                &[[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]],
                &[[0.03, 0.03]],
                plane
            ) < 1e-12
        );
        assert!(Nodes::new(&grid(7, 1, 0.02)).is_none() && Nodes::new(&grid(2, 1, 0.02)).is_none());
    }
}
