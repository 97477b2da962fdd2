//! Viscous poles refined in the columns that the file has for them: residues r and r* of s
//! and s*, two real columns a pole (theory.md, eq. 16).
//!
//! A search has one complex column a pole, which is exact for real residues. A pole far below
//! the band with complex ones needs another place here than there.
//!
//! Variable projection over the reals (Kaufman, BIT 15 (1975) 49), Levenberg–Marquardt, the
//! derivatives by differences. Cost per step ≈ 16·lines·m·(m + r) flop, m poles and
//! residual terms, r columns.

use crate::damping::law::is_rational;
use crate::damping::limits;
use crate::damping::places::viscous_pole_of;
use crate::damping::viscous::{halves, viscous_basis};
use crate::data::columns::Columns;
use crate::data::information::{answer, coefficients};
use crate::tolerances::{LM_START, LM_UP};
use chladni_linalg::blocked::{projected, tall_qr};
use chladni_linalg::{matmul, matmul_h, LinalgError};
use ndarray::{s, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;

/// Poles of the x plane after at most `most` steps, and the sum of squares that they
/// leave of `work`, with free residues and residual terms x^`powers`.
///
/// * `found`: where they stand and what they leave in the columns of the search; where
///   these are those of the model file, that is the answer
///
/// # Errors
/// A kernel that fails.
pub(crate) fn refined(
    work: &Columns,
    found: (Vec<Complex64>, f64),
    powers: &[i32],
    most: usize,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    if is_rational(work.law) {
        return Ok(found);
    }
    let poles = found.0;
    let data = halves(&work.b);
    let mut here = Point::at(work, &data, poles, powers)?;
    let mut damping = LM_START;
    for _ in 0..most {
        // poles that cannot be told apart any more stay where they are
        let Ok(step) = here.step(work, damping) else {
            break;
        };
        let next = Point::at(work, &data, here.moved(&step), powers);
        let Some(next) = next.ok().filter(|next| next.sse < here.sse) else {
            damping *= LM_UP;
            continue;
        };
        let settled = here.sse - next.sse < limits::SAVED_SETTLED * here.sse;
        (here, damping) = (next, damping / LM_UP);
        if settled {
            break;
        }
    }
    Ok((here.poles, here.sse))
}

/// The linear part at some poles.
struct Point {
    poles: Vec<Complex64>,
    /// Orthonormal basis of the columns.
    q: Array2<f64>,
    /// Coefficients of the columns of poles, (2·pole, column).
    residues: Array2<f64>,
    residual: Array2<f64>,
    sse: f64,
}

impl Point {
    fn at(
        work: &Columns,
        data: &Array2<f64>,
        poles: Vec<Complex64>,
        powers: &[i32],
    ) -> Result<Self, LinalgError> {
        let values: Vec<Complex64> = poles.iter().copied().map(viscous_pole_of).collect();
        let (q, r) = tall_qr(viscous_basis(work, &values, powers).view())?;
        let (along, residual) = projected(q.view(), data.view());
        let coefficients = coefficients(r.view(), along.view())?;
        Ok(Self {
            residues: coefficients.slice(s![..2 * poles.len(), ..]).to_owned(),
            sse: residual.iter().map(|v| v * v).sum(),
            poles,
            q,
            residual,
        })
    }

    /// Derivatives of the columns of the poles by Re λ and Im λ, in half-widths: those of
    /// pole n are columns 4n to 4n + 3.
    fn derivatives(&self, work: &Columns) -> Array2<f64> {
        let h = limits::SAVED_DIFFERENCE;
        let directions = [Complex64::ONE, Complex64::I];
        let mut out = Array2::zeros((2 * work.lines(), 4 * self.poles.len()).f());
        for (n, &pole) in self.poles.iter().enumerate() {
            for (d, direction) in directions.into_iter().enumerate() {
                let column = |side: f64| {
                    let pole = pole + side * h * pole.im * direction;
                    viscous_basis(work, &[viscous_pole_of(pole)], &[])
                };
                let first = 4 * n + 2 * d;
                out.slice_mut(s![.., first..first + 2])
                    .assign(&((column(1.0) - column(-1.0)) / (2.0 * h)));
            }
        }
        out
    }

    /// Step of each pole, half-widths, (2·pole + direction, 1).
    fn step(&self, work: &Columns, damping: f64) -> Result<Array2<f64>, LinalgError> {
        let (_, outside) = projected(self.q.view(), self.derivatives(work).view());
        let gram = matmul_h(outside.view(), outside.view());
        let against = matmul_h(outside.view(), self.residual.view());
        let strength = matmul(self.residues.view(), self.residues.t());
        let unknowns = 2 * self.poles.len();
        // the two columns of a pole move together
        let of = |unknown: usize, part: usize| (2 * unknown + part, 2 * (unknown / 2) + part);
        let mut matrix = Array2::from_shape_fn((unknowns, unknowns), |(a, b)| {
            let parts = [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter();
            let product = |(p, q)| {
                let ((column, row), (other, with)) = (of(a, p), of(b, q));
                gram[[column, other]] * strength[[row, with]]
            };
            parts.map(product).sum::<f64>()
        });
        let right = Array2::from_shape_fn((unknowns, 1), |(a, _)| {
            let product = |part| {
                let (column, row) = of(a, part);
                against.row(column).dot(&self.residues.row(row))
            };
            product(0) + product(1)
        });
        matrix.diag_mut().mapv_inplace(|v| v * (1.0 + damping));
        answer(matrix.view(), right.view())
    }

    /// The poles after a step, none beyond half its distance to either axis.
    fn moved(&self, step: &Array2<f64>) -> Vec<Complex64> {
        let steps = step.axis_chunks_iter(Axis(0), 2);
        let moved = |(pole, step): (&Complex64, ndarray::ArrayView2<f64>)| {
            let (re, im) = (step[[0, 0]] * pole.im, step[[1, 0]] * pole.im);
            let limited = |by: f64, size: f64| by.clamp(-limits::SAVED_LOSS_BY_STEP * size, size);
            pole + Complex64::new(limited(re, pole.re), limited(im, pole.im))
        };
        self.poles.iter().zip(steps).map(moved).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Damping;

    /// Residues of a pole below the band that no real shape has, found from beside it.
    #[test]
    fn a_pole_with_complex_residues_is_found_where_it_stands() {
        let x: Vec<f64> = (0..400)
            .map(|k| (0.02 + 0.98 * f64::from(k) / 399.0).powi(2))
            .collect();
        let truth = Complex64::new(1.2e-4, 6e-6);
        let empty = Columns {
            g: vec![1.0; x.len()],
            b: Array2::zeros((x.len(), 3)),
            law: Damping::Viscous,
            leakage: None,
            neighbours: 0.0,
            x,
        };
        let columns = viscous_basis(&empty, &[viscous_pole_of(truth)], &[]);
        let residues = [[1.0, 0.3], [-0.4, 0.8], [0.2, -0.5]];
        let b = Array2::from_shape_fn((400, 3).f(), |(k, c)| {
            let value = |row: usize| {
                (0..2)
                    .map(|part| columns[[row, part]] * residues[c][part])
                    .sum::<f64>()
            };
            Complex64::new(value(k), value(k + 400))
        });
        let work = empty.with_columns(b);
        let energy = work.energy();
        let (poles, sse) = refined(
            &work,
            (vec![1.3 * truth], f64::INFINITY),
            &[-1, 0, 1, 2],
            60,
        )
        .unwrap();
        assert!(sse < 1e-20 * energy, "{sse:e} of {energy:e}");
        assert!((poles[0] - truth).norm() < 1e-6 * truth.im, "{poles:?}");
    }
}
