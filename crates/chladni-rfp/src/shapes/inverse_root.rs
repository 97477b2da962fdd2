//! The root of an inverse on the directions that carry information.

use crate::shapes::limits;
use crate::tolerances as tol;
use chladni_linalg::{cholesky, eigh, matmul_h, solve_lower, LinalgError, Scalar};
use ndarray::{Array2, ArrayView2, Axis, ShapeBuilder};

/// Vᴴ·`columns`, where VVᴴ is the inverse of a matrix on the directions that carry
/// information; terms of a repeated pole may mix in any way, and no error is meant by
/// that.
pub(super) fn inverse_root<T: Scalar>(
    matrix: ArrayView2<T>,
    columns: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let size: Vec<f64> = matrix
        .diag()
        .iter()
        .map(|d| finite(d.modulus().sqrt().recip()))
        .collect();
    let even = Array2::from_shape_fn(matrix.raw_dim(), |(a, b)| {
        matrix[[a, b]] * T::of_real(size[a] * size[b])
    });
    let columns = Array2::from_shape_fn(columns.raw_dim().f(), |(a, c)| {
        columns[[a, c]] * T::of_real(size[a])
    });
    let well_known = |lower: &Array2<T>| {
        lower
            .diag()
            .iter()
            .all(|pivot| pivot.modulus().powi(2) > limits::WELL_INFORMED)
    };
    if let Some(lower) = cholesky(even.view()).ok().filter(well_known) {
        return solve_lower(lower.view(), columns.view());
    }
    let (values, vectors) = eigh(even.view())?;
    let kept: Vec<usize> = (0..values.len())
        .filter(|&c| values[c] > tol::UNINFORMED)
        .collect();
    let mut half = matmul_h(vectors.select(Axis(1), &kept).view(), columns.view());
    half.rows_mut()
        .into_iter()
        .zip(kept)
        .for_each(|(mut row, c)| row.mapv_inplace(|v| v.divided_by(values[c].sqrt())));
    Ok(half)
}

pub(super) fn finite(value: f64) -> f64 {
    if value.is_finite() {
        value
    } else {
        0.0
    }
}
