//! The root of an inverse on the directions that carry information.

use crate::shapes::limits;
use crate::tolerances as tol;
use chladni_linalg::blocked::range;
use chladni_linalg::{cholesky, eigh, matmul, matmul_h, solve_lower, LinalgError, Scalar};
use ndarray::{Array2, ArrayView2, Axis, ShapeBuilder};

/// Vᴴ·`columns`, where VVᴴ is the inverse of a matrix on the directions that carry
/// information.
pub(super) fn inverse_root<T: Scalar>(
    matrix: ArrayView2<T>,
    columns: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let none = Array2::zeros((columns.nrows(), 0));
    inverse_root_beside(none.view(), matrix, columns)
}

/// The same where directions are known to carry none, whatever rounding and ridges say.
///
/// * `idle`: these, (unknown, direction)
pub(super) fn inverse_root_beside<T: Scalar>(
    idle: ArrayView2<T>,
    matrix: ArrayView2<T>,
    columns: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let size: Vec<f64> = matrix
        .diag()
        .iter()
        .map(|d| finite(d.modulus().sqrt().recip()))
        .collect();
    let mut even = Array2::from_shape_fn(matrix.raw_dim(), |(a, b)| {
        matrix[[a, b]] * T::of_real(size[a] * size[b])
    });
    let mut columns = Array2::from_shape_fn(columns.raw_dim().f(), |(a, c)| {
        columns[[a, c]] * T::of_real(size[a])
    });
    if !idle.is_empty() {
        // as if they were known, and nothing hung on them: the matrix has its full rank then
        let basis = evened_basis(idle, &size)?;
        let adjoint = matmul_h(basis.view(), Array2::eye(size.len()).view());
        let onto_idle =
            |a: &Array2<T>| matmul(basis.view(), matmul(adjoint.view(), a.view()).view());
        columns -= &onto_idle(&columns);
        even -= &onto_idle(&even);
        even -= &matmul(matmul(even.view(), basis.view()).view(), adjoint.view());
        even += &matmul(basis.view(), adjoint.view());
    }
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

/// Orthonormal basis of `idle` directions in units of the unknowns' own deviations, `size`.
fn evened_basis<T: Scalar>(idle: ArrayView2<T>, size: &[f64]) -> Result<Array2<T>, LinalgError> {
    let mut evened = Array2::from_shape_fn(idle.raw_dim().f(), |(a, c)| match size[a] > 0.0 {
        true => idle[[a, c]].divided_by(size[a]),
        false => T::of_real(0.0),
    });
    for mut column in evened.columns_mut() {
        let square: f64 = column.iter().map(|v| v.modulus().powi(2)).sum();
        column.mapv_inplace(|v| v.divided_by(square.sqrt().max(f64::MIN_POSITIVE)));
    }
    range(evened.view(), tol::FREE_RANK)
}

pub(super) fn finite(value: f64) -> f64 {
    if value.is_finite() {
        value
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    /// Two of three unknowns mix: a ridge that makes the matrix regular adds nothing to the error.
    #[test]
    fn an_idle_direction_has_no_error_whatever_a_ridge_says() {
        let idle = array![[2.0], [-1.0], [0.0]];
        // information of the other directions alone: each row across the idle one
        let seen = array![[1.0, 2.0, 0.0], [0.3, 0.6, 4.0], [-1.0, -2.0, 1.0]];
        let exact = matmul_h(seen.view(), seen.view());
        let unit = Array2::eye(3);
        let covariance = |ridge: f64| {
            let matrix = &exact + &(Array2::<f64>::eye(3) * ridge);
            let root = inverse_root_beside(idle.view(), matrix.view(), unit.view()).unwrap();
            matmul_h(root.view(), root.view())
        };
        let (expected, ridged) = (covariance(0.0), covariance(1e-8));
        // the inverse on the other directions: M·C·M = M
        let back = matmul(matmul(exact.view(), expected.view()).view(), exact.view());
        assert!((&back - &exact).iter().all(|v| v.abs() < 1e-12), "{back}");
        assert!(
            (&ridged - &expected).iter().all(|v| v.abs() < 1e-6),
            "{ridged}"
        );
    }
}
