//! Distances between places on grids, each of them once.
//!
//! The 1025 places of a grid on 77 responses have 79 000 distances, of which a thousand
//! differ: a function of the distance is then a table.

use crate::scene::plane::Position;
use crate::tolerances::{self, GLOBAL_BASIS, SHARED_MOST};
use chladni_linalg::matmul;
use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

/// Places and nodes whose coordinates repeat.
pub(crate) struct Lattice {
    axes: [Axis; 2],
}

/// One coordinate.
struct Axis {
    /// Index of the coordinate of each place, among the distinct ones.
    of_place: Vec<usize>,
    /// The same of each node.
    of_node: Vec<usize>,
    /// Index of the distance, among the distinct ones, between two coordinates; axes
    /// (place, node).
    kind: Array2<usize>,
    /// Squares of the distinct distances.
    squared: Vec<f64>,
}

impl Lattice {
    /// `None` where coordinates, or distances, hardly repeat.
    pub(crate) fn of(places: &[Position], nodes: &[Position]) -> Option<Self> {
        let worth_it = places.len() * nodes.len() / tolerances::PAIRS_PER_DISTANCE;
        let axis = |which: usize| {
            Axis::of(
                places.iter().map(|p| p[which]),
                nodes.iter().map(|p| p[which]),
                worth_it,
            )
        };
        let axes = [axis(0)?, axis(1)?];
        (axes[0].squared.len() * axes[1].squared.len() <= worth_it).then_some(Self { axes })
    }

    /// Fills the columns of the nodes with `function` of the squared distances; axes of
    /// `matrix` (place, node and more).
    pub(crate) fn fill(&self, matrix: &mut Array2<f64>, function: impl Fn(f64) -> f64) {
        let [x, y] = &self.axes;
        let table = self.table(function);
        let (of_x, of_y) = (x.offsets(1), y.offsets(x.squared.len()));
        let places = x.of_place.iter().zip(&y.of_place);
        for (mut row, (&x, &y)) in matrix.rows_mut().into_iter().zip(places) {
            for (value, (x, y)) in row.iter_mut().zip(of_x[x].iter().zip(&of_y[y])) {
                *value = table[x + y];
            }
        }
    }

    /// Σ coefficient·`function` of the squared distance over the nodes, at each place. Nodes
    /// of one x and places of one y share the sum over the nodes' y, for every distance in
    /// x at once: one product of matrices.
    pub(crate) fn sums(
        &self,
        function: impl Fn(f64) -> f64,
        coefficients: &[Complex64],
    ) -> Vec<Complex64> {
        let [x, y] = &self.axes;
        let table = self.table(function);
        let kinds = x.squared.len();
        let ([rows, lines], columns) = ([y.kind.nrows(), y.kind.ncols()], x.kind.ncols());
        let places = || x.of_place.iter().zip(&y.of_place);
        let pairs = x.of_place.len() * x.of_node.len();
        let is_large = rows * kinds * lines > GLOBAL_BASIS;
        if is_large || rows * kinds * lines * columns > SHARED_MOST * pairs {
            let (of_x, of_y) = (x.offsets(1), y.offsets(kinds));
            let at = |(&x, &y): (&usize, &usize)| {
                let nodes = of_x[x].iter().zip(&of_y[y]).zip(coefficients);
                nodes.map(|((x, y), c)| c * table[x + y]).sum()
            };
            return places().map(at).collect();
        }
        // axes (y of the nodes, row of places and distance in x)
        let mut values = Vec::with_capacity(lines * rows * kinds);
        for line in y.kind.columns() {
            let of_rows = line.into_iter();
            of_rows.for_each(|&kind| values.extend_from_slice(&table[kind * kinds..][..kinds]));
        }
        let values = ArrayView2::from_shape((lines, rows * kinds), &values)
            .expect("a value of each distance");
        // axes (y, x of the nodes and part)
        let mut nodes = Array2::zeros((lines, 2 * columns));
        for ((&column, &line), c) in x.of_node.iter().zip(&y.of_node).zip(coefficients) {
            nodes[[line, 2 * column]] += c.re;
            nodes[[line, 2 * column + 1]] += c.im;
        }
        // axes (row of places and distance in x, x of the nodes and part)
        let shared = matmul(nodes.t(), values).reversed_axes();
        let shared = shared.as_standard_layout();
        let shared = shared.as_slice().expect("standard layout");
        let starts = x.kind.map(|kind| 2 * columns * kind);
        let at = |(&of_x, &of_y): (&usize, &usize)| {
            let of_row = &shared[2 * columns * kinds * of_y..];
            let parts = starts
                .row(of_x)
                .into_iter()
                .enumerate()
                .map(|(column, start)| {
                    let part = &of_row[start + 2 * column..][..2];
                    Complex64::new(part[0], part[1])
                });
            parts.sum()
        };
        places().map(at).collect()
    }

    /// `function` of the distinct squared distances, those in x one after another.
    fn table(&self, function: impl Fn(f64) -> f64) -> Vec<f64> {
        let [x, y] = &self.axes;
        let dy = y.squared.iter();
        let squares = dy.flat_map(|dy| x.squared.iter().map(move |dx| dx + dy));
        squares.map(function).collect()
    }
}

impl Axis {
    fn of(
        places: impl Iterator<Item = f64>,
        nodes: impl Iterator<Item = f64>,
        most: usize,
    ) -> Option<Self> {
        let (of_place, places) = distinct(places);
        let (of_node, nodes) = distinct(nodes);
        if places.len() * nodes.len() > most {
            return None;
        }
        let all = places
            .iter()
            .flat_map(|place| nodes.iter().map(move |node| (place - node).abs()));
        let (kind, distances) = distinct(all);
        let kind = Array2::from_shape_vec((places.len(), nodes.len()), kind)
            .expect("one distance of each pair");
        Some(Self {
            of_place,
            of_node,
            kind,
            squared: distances
                .iter()
                .map(|distance| distance * distance)
                .collect(),
        })
    }

    /// For each coordinate, `stride` times the kind of its distance to each node.
    fn offsets(&self, stride: usize) -> Vec<Vec<usize>> {
        let kinds = self.kind.rows().into_iter();
        kinds
            .map(|kinds| {
                let nodes = self.of_node.iter();
                nodes.map(|&node| stride * kinds[node]).collect()
            })
            .collect()
    }
}

/// Index of each value among the distinct ones, and these, rising.
fn distinct(values: impl Iterator<Item = f64>) -> (Vec<usize>, Vec<f64>) {
    // the value after one is on a grid mostly that of before, or the same
    let mut met = Vec::<f64>::new();
    let mut last = 0;
    let mut index = |value: f64| {
        if met.get(last) != Some(&value) {
            last = if last + 1 < met.len() { last + 1 } else { 0 };
        }
        if met.get(last) != Some(&value) {
            last = met.len();
            met.push(value);
        }
        last
    };
    let mut which: Vec<usize> = values.map(&mut index).collect();
    let mut order: Vec<usize> = (0..met.len()).collect();
    order.sort_unstable_by(|&a, &b| met[a].total_cmp(&met[b]));
    let (mut of_met, mut kept) = (vec![0; met.len()], Vec::<f64>::new());
    for k in order {
        if kept
            .last()
            .is_none_or(|&last| met[k] - last > tolerances::SAME_COORDINATE)
        {
            kept.push(met[k]);
        }
        of_met[k] = kept.len() - 1;
    }
    which.iter_mut().for_each(|k| *k = of_met[*k]);
    (which, kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_has_a_table_and_scattered_places_have_none() {
        let grid = |n: usize, step: f64| -> Vec<Position> {
            (0..n * n)
                .map(|k| [0.1 + step * (k % n) as f64, step * (k / n) as f64])
                .collect()
        };
        let (places, nodes) = (grid(9, 0.1), grid(5, 0.2));
        let mut matrix = Array2::zeros((81, 25));
        Lattice::of(&places, &nodes)
            .expect("few distances")
            .fill(&mut matrix, |squared| squared);
        let coefficients: Vec<Complex64> = (0..25)
            .map(|j| Complex64::new(j as f64 - 7.0, 0.5 * j as f64))
            .collect();
        let sums = Lattice::of(&places, &nodes)
            .expect("few distances")
            .sums(|squared| squared, &coefficients);
        for (sum, row) in sums.iter().zip(matrix.rows()) {
            let expected: Complex64 = row.iter().zip(&coefficients).map(|(v, c)| v * c).sum();
            assert!((sum - expected).norm() < 1e-10);
        }
        for (k, p) in places.iter().enumerate() {
            for (j, n) in nodes.iter().enumerate() {
                let expected = (p[0] - n[0]).powi(2) + (p[1] - n[1]).powi(2);
                assert!((matrix[[k, j]] - expected).abs() < 1e-12);
            }
        }
        // few places on many lines: each sum by itself
        let sparse: Vec<Position> = (0..100)
            .map(|k| [(k % 40) as f64, (7 * k % 40) as f64])
            .collect();
        let all: Vec<Position> = (0..144)
            .map(|k| [(k % 12) as f64, (k / 12) as f64])
            .collect();
        let ones = vec![Complex64::new(1.0, -2.0); 144];
        let sums = Lattice::of(&sparse, &all)
            .expect("few distances")
            .sums(|squared| squared, &ones);
        for (p, sum) in sparse.iter().zip(sums) {
            let squares = all
                .iter()
                .map(|n| (p[0] - n[0]).powi(2) + (p[1] - n[1]).powi(2));
            assert!((sum - squares.sum::<f64>() * ones[0]).norm() < 1e-6);
        }
        let scattered: Vec<Position> = (0..81)
            .map(|k| [(7.3 * k as f64).sin(), (3.1 * k as f64).cos()])
            .collect();
        assert!(Lattice::of(&scattered, &nodes).is_none());
    }
}
