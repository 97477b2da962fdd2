//! Fields on a fine grid: pixels and contours of the maps.

use chladni_render::{AreaField, AreaGrid};
use ndarray::Array2;
use num_complex::Complex64;

/// A complex field on a rectangular grid, NaN where it is not known; axes (row, column),
/// rows rising with y.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Surface {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) values: Array2<Complex64>,
}

impl Surface {
    /// The field that was interpolated over the judged area.
    pub(crate) fn of_area(area: &AreaField) -> Self {
        Self {
            x: area.x_m.clone(),
            y: area.y_m.clone(),
            values: area.velocity_m_per_s.clone(),
        }
    }

    /// The field between the responses of `grid` from its `values` at them.
    pub(crate) fn on(grid: &AreaGrid, values: &[Complex64]) -> Self {
        Self {
            x: grid.x_m.clone(),
            y: grid.y_m.clone(),
            values: grid.field(values),
        }
    }

    /// The field at the centres of square pixels in `columns` columns, rows rising with y. The
    /// interpolation is cubic (Catmull & Rom, 1974), and linear at the borders of the grid.
    pub(crate) fn refined(&self, columns: usize) -> Self {
        let (width, height) = (
            self.x[self.x.len() - 1] - self.x[0],
            self.y[self.y.len() - 1] - self.y[0],
        );
        let rows = ((columns as f64 * height / width).round() as usize).clamp(2, 4 * columns);
        let centres = |start: f64, span: f64, count: usize| -> Vec<f64> {
            (0..count)
                .map(|k| start + span * (k as f64 + 0.5) / count as f64)
                .collect()
        };
        let (x, y) = (
            centres(self.x[0], width, columns),
            centres(self.y[0], height, rows),
        );
        let values =
            Array2::from_shape_fn((rows, columns), |(row, column)| self.at(x[column], y[row]));
        Self { x, y, values }
    }

    fn at(&self, x: f64, y: f64) -> Complex64 {
        let ((row, v), (column, u)) = (interval(&self.y, y), interval(&self.x, x));
        let (rows, columns) = self.values.dim();
        if row > 0 && column > 0 && row + 2 < rows && column + 2 < columns {
            let along = |r: usize| {
                cubic(
                    u,
                    [-1, 0, 1, 2].map(|k| self.values[[r, (column as isize + k) as usize]]),
                )
            };
            let value = cubic(v, [row - 1, row, row + 1, row + 2].map(along));
            if value.is_finite() {
                return value;
            }
        }
        let corner = |dr: usize, dc: usize| {
            self.values[[(row + dr).min(rows - 1), (column + dc).min(columns - 1)]]
        };
        corner(0, 0) * ((1.0 - u) * (1.0 - v))
            + corner(0, 1) * (u * (1.0 - v))
            + corner(1, 0) * ((1.0 - u) * v)
            + corner(1, 1) * (u * v)
    }
}

/// The interval of a rising axis that contains `value`, and the place in it, 0..=1.
fn interval(axis: &[f64], value: f64) -> (usize, f64) {
    let k = axis
        .partition_point(|&a| a <= value)
        .clamp(1, axis.len() - 1)
        - 1;
    (
        k,
        ((value - axis[k]) / (axis[k + 1] - axis[k])).clamp(0.0, 1.0),
    )
}

fn cubic(t: f64, [a, b, c, d]: [Complex64; 4]) -> Complex64 {
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

/// The contours of `values` on the grid (`x`, `y`) at `level`, by marching squares; none next to
/// NaN.
pub(crate) fn contours(
    x: &[f64],
    y: &[f64],
    values: &Array2<f64>,
    level: f64,
) -> Vec<Vec<[f64; 2]>> {
    let (rows, columns) = values.dim();
    let place = |side: usize| {
        let (row, column) = (side % (rows * columns) / columns, side % columns);
        let [to_row, to_column] = if side < rows * columns {
            [row, column + 1]
        } else {
            [row + 1, column]
        };
        let (a, b) = (values[[row, column]], values[[to_row, to_column]]);
        let t = if a == b { 0.5 } else { (level - a) / (b - a) };
        [
            x[column] + t * (x[to_column] - x[column]),
            y[row] + t * (y[to_row] - y[row]),
        ]
    };
    trace(&links(values, level))
        .into_iter()
        .map(|line| line.into_iter().map(place).collect())
        .collect()
}

/// For each side of the mesh, the sides to which the contour at `level` continues. Sides along x
/// are numbered first, then those along y.
fn links(values: &Array2<f64>, level: f64) -> Vec<[Option<usize>; 2]> {
    let (rows, columns) = values.dim();
    let along_x = |row: usize, column: usize| row * columns + column;
    let along_y = |row: usize, column: usize| rows * columns + row * columns + column;
    let mut ends: Vec<[Option<usize>; 2]> = vec![[None; 2]; 2 * rows * columns];
    let mut join = |a: usize, b: usize| {
        for (from, to) in [(a, b), (b, a)] {
            let free = usize::from(ends[from][0].is_some());
            ends[from][free] = Some(to);
        }
    };
    for row in 0..rows.saturating_sub(1) {
        for column in 0..columns.saturating_sub(1) {
            let corners = [
                values[[row, column]],
                values[[row, column + 1]],
                values[[row + 1, column + 1]],
                values[[row + 1, column]],
            ];
            if corners.iter().any(|value| value.is_nan()) {
                continue;
            }
            let above = corners.map(|value| value >= level);
            let sides = [
                along_x(row, column),
                along_y(row, column + 1),
                along_x(row + 1, column),
                along_y(row, column),
            ];
            let crossed: Vec<usize> = (0..4)
                .filter(|&k| above[k] != above[(k + 1) % 4])
                .map(|k| sides[k])
                .collect();
            match crossed[..] {
                [a, b] => join(a, b),
                // a saddle: the mean of the corners decides which corners are joined
                [a, b, c, d] if (corners.iter().sum::<f64>() / 4.0 >= level) == above[0] => {
                    join(a, b);
                    join(c, d);
                }
                [a, b, c, d] => {
                    join(d, a);
                    join(b, c);
                }
                _ => {}
            }
        }
    }
    ends
}

/// The contours as lists of sides: open ones first, then closed ones, whose first side is also
/// the last.
fn trace(ends: &[[Option<usize>; 2]]) -> Vec<Vec<usize>> {
    let mut seen = vec![false; ends.len()];
    let mut lines = Vec::new();
    for open in [true, false] {
        for start in 0..ends.len() {
            if seen[start] || ends[start][0].is_none() || (open && ends[start][1].is_some()) {
                continue;
            }
            let (mut line, mut here) = (vec![start], start);
            seen[start] = true;
            while let Some(next) = ends[here]
                .iter()
                .flatten()
                .copied()
                .find(|&next| !seen[next])
            {
                seen[next] = true;
                line.push(next);
                here = next;
            }
            if !open && line.len() > 2 {
                line.push(start);
            }
            lines.push(line);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_one_closed_contour() {
        let axis: Vec<f64> = (0..41).map(|k| -1.0 + 0.05 * f64::from(k)).collect();
        let values = Array2::from_shape_fn((41, 41), |(row, column)| axis[row].hypot(axis[column]));
        let lines = contours(&axis, &axis, &values, 0.72);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        assert!(lines[0]
            .iter()
            .all(|p| (p[0].hypot(p[1]) - 0.72).abs() < 2e-3));
    }

    #[test]
    fn a_slope_is_one_open_contour_and_nan_cuts_it() {
        let axis: Vec<f64> = (0..5).map(f64::from).collect();
        let mut values = Array2::from_shape_fn((5, 5), |(_, column)| column as f64);
        assert_eq!(
            contours(&axis, &axis, &values, 1.5),
            vec![(0..5).map(|k| [1.5, f64::from(k)]).collect::<Vec<_>>()]
        );
        values[[2, 1]] = f64::NAN;
        assert_eq!(contours(&axis, &axis, &values, 1.5).len(), 2);
    }

    #[test]
    fn refinement_keeps_a_parabola() {
        let axis: Vec<f64> = (0..9).map(f64::from).collect();
        let values = Array2::from_shape_fn((9, 9), |(row, column)| {
            Complex64::new((column * column) as f64, row as f64)
        });
        let fine = Surface {
            x: axis.clone(),
            y: axis,
            values,
        }
        .refined(32);
        assert_eq!(fine.values.dim(), (32, 32));
        for (k, &x) in fine
            .x
            .iter()
            .enumerate()
            .filter(|(_, x)| (1.0..7.0).contains(*x))
        {
            assert!((fine.values[[16, k]].re - x * x).abs() < 1e-12);
        }
    }
}
