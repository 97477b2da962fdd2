//! Covariances from information matrices, and normal equations, even if the data do not determine
//! some directions. These get an infinite variance, or no part in the solution; no fit stops for
//! them.

use crate::data::limits;
use crate::tolerances as tol;
use chladni_linalg::{
    eigh, inverse_hermitian, matmul, matmul_h, solve_hermitian, solve_upper, LinalgError, Scalar,
};
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};
use num_complex::Complex64;

/// Inverse of a Hermitian information matrix. Unknowns that the data do not determine have an
/// infinite variance and no covariance.
pub(crate) fn covariance<T: Scalar>(information: ArrayView2<T>) -> Array2<T> {
    inverse_hermitian(information)
        .ok()
        .filter(|inverse| inverse.iter().all(Scalar::is_finite_value))
        .or_else(|| Some(Determined::new(information).ok()?.covariance()))
        .unwrap_or_else(|| Array2::from_diag_elem(information.nrows(), T::of_real(f64::INFINITY)))
}

/// Solution of normal equations. Directions that the matrix does not determine have no part in it.
///
/// # Errors
/// A matrix with a value that is not finite.
pub(crate) fn answer<T: Scalar>(
    matrix: ArrayView2<T>,
    right: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let solved = solve_hermitian(matrix, right).ok();
    match solved.filter(|solution| solution.iter().all(Scalar::is_finite_value)) {
        Some(solution) => Ok(solution),
        None => {
            let root = Determined::new(matrix)?.root;
            Ok(matmul_h(root.view(), matmul(root.view(), right).view()))
        }
    }
}

/// Coefficients of columns from R and Qᴴb of their QR. Equal columns share theirs evenly.
///
/// # Errors
/// As [`answer`].
pub(crate) fn coefficients<T: Scalar>(
    r: ArrayView2<T>,
    qb: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let solved = solve_upper(r, qb).ok();
    match solved.filter(|all| all.iter().all(Scalar::is_finite_value)) {
        Some(solved) => Ok(solved),
        None => answer(matmul_h(r, r).view(), matmul_h(r, qb).view()),
    }
}

/// The directions that an information matrix determines.
struct Determined<T> {
    /// (direction, unknown): the inverse on these directions is rootᴴ·root.
    root: Array2<T>,
    /// False for unknowns with a part in undetermined directions.
    known: Vec<bool>,
}

impl<T: Scalar> Determined<T> {
    /// Uses the eigenvectors of the matrix, scaled to a unit diagonal.
    fn new(matrix: ArrayView2<T>) -> Result<Self, LinalgError> {
        let n = matrix.nrows();
        let scale: Vec<f64> = matrix
            .diag()
            .iter()
            .map(|value| value.modulus().sqrt().recip())
            // the square of a root is finite, too
            .map(|scale| {
                if (scale * scale).is_finite() {
                    scale
                } else {
                    0.0
                }
            })
            .collect();
        let unit_diagonal = Array2::from_shape_fn((n, n), |(a, b)| {
            matrix[[a, b]] * T::of_real(scale[a] * scale[b])
        });
        let (values, vectors) = eigh(unit_diagonal.view())?;
        let (determined, others): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&c| values[c] > tol::UNINFORMED);
        let known = |a: usize| {
            let part = |&c: &usize| vectors[[a, c]].modulus().powi(2);
            scale[a] > 0.0 && others.iter().map(part).sum::<f64>() < limits::IN_THE_DARK
        };
        let scales = Array2::from_shape_fn((n, n), |(a, b)| {
            T::of_real(if a == b { scale[a] } else { 0.0 })
        });
        let mut root = matmul_h(vectors.select(Axis(1), &determined).view(), scales.view());
        root.rows_mut()
            .into_iter()
            .zip(&determined)
            .for_each(|(mut row, &c)| row.mapv_inplace(|v| v.divided_by(values[c].sqrt())));
        Ok(Self {
            root,
            known: (0..n).map(known).collect(),
        })
    }

    fn covariance(&self) -> Array2<T> {
        let mut covariance = matmul_h(self.root.view(), self.root.view());
        for a in (0..self.known.len()).filter(|&a| !self.known[a]) {
            covariance.row_mut(a).fill(T::of_real(0.0));
            covariance.column_mut(a).fill(T::of_real(0.0));
            covariance[[a, a]] = T::of_real(f64::INFINITY);
        }
        covariance
    }
}

/// Share of an error of each line that stays in the residual; the fit absorbs the rest (leverage;
/// MacKinnon & White 1985, HC3). An error common to all FRFs moves the poles too, so the derivatives
/// by the poles count.
///
/// * `q`: orthonormal basis of the model, (line, m)
/// * `derivative`: by the poles, (line, pole)
pub(crate) fn kept_share(q: &Array2<Complex64>, derivative: &Array2<Complex64>) -> Vec<f64> {
    let energy = |v: ArrayView1<Complex64>| v.iter().map(|c| c.norm_sqr()).sum::<f64>();
    let derivative_energy: Vec<f64> = derivative.columns().into_iter().map(energy).collect();
    let of_poles = |k: usize| {
        derivative
            .row(k)
            .iter()
            .zip(&derivative_energy)
            .map(|(d, all)| d.norm_sqr() / all)
            .sum::<f64>()
    };
    (0..q.nrows())
        .map(|k| (1.0 - energy(q.row(k)) - of_poles(k)).max(limits::LEAST_KEPT))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn what_is_told_keeps_its_variance_beside_what_is_not() {
        // the second and third unknown enter as their sum alone
        let information = array![[4.0, 0.0, 0.0], [0.0, 1e6, 1e6], [0.0, 1e6, 1e6]];
        let covariance = covariance(information.view());
        assert!((covariance[[0, 0]] - 0.25).abs() < 1e-12, "{covariance}");
        assert!(covariance[[1, 1]].is_infinite() && covariance[[2, 2]].is_infinite());
        assert_eq!(covariance[[1, 2]], 0.0);
        let shared = answer(information.view(), array![[8.0], [2e6], [2e6]].view()).unwrap();
        for (found, expected) in shared.iter().zip([2.0, 1.0, 1.0]) {
            assert!((found - expected).abs() < 1e-9, "{shared}");
        }
    }

    #[test]
    fn an_unknown_without_information_or_without_number_is_not_known() {
        let zero = covariance(array![[0.0, 0.0], [0.0, 2.0]].view());
        assert!(zero[[0, 0]].is_infinite() && (zero[[1, 1]] - 0.5).abs() < 1e-12);
        let nothing = covariance(Array2::from_elem((2, 2), Complex64::new(f64::NAN, 0.0)).view());
        assert!(nothing.diag().iter().all(|v| v.re.is_infinite()));
    }
}
