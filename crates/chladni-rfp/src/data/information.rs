//! Covariances from information matrices, and normal equations, where the data do not determine
//! some directions: these have an infinite variance, or no part in the answer, and no fit stops
//! for them.

use crate::data::limits;
use crate::tolerances as tol;
use chladni_linalg::{
    eigh, inverse_hermitian, matmul, matmul_h, solve_hermitian, solve_upper, LinalgError, Scalar,
};
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};
use num_complex::Complex64;

/// Inverse of a Hermitian information matrix. Unknowns that the data do not tell have an
/// infinite variance and no covariance.
pub(crate) fn covariance<T: Scalar>(information: ArrayView2<T>) -> Array2<T> {
    inverse_hermitian(information)
        .ok()
        .filter(|inverse| inverse.iter().all(Scalar::is_finite_value))
        .or_else(|| Some(Informed::by(information).ok()?.covariance()))
        .unwrap_or_else(|| Array2::from_diag_elem(information.nrows(), T::of_real(f64::INFINITY)))
}

/// Solution of normal equations; directions that the matrix does not tell have no part in
/// it.
///
/// # Errors
/// A matrix that is no number.
pub(crate) fn answer<T: Scalar>(
    matrix: ArrayView2<T>,
    right: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let solved = solve_hermitian(matrix, right).ok();
    match solved.filter(|answer| answer.iter().all(Scalar::is_finite_value)) {
        Some(answer) => Ok(answer),
        None => {
            let root = Informed::by(matrix)?.root;
            Ok(matmul_h(root.view(), matmul(root.view(), right).view()))
        }
    }
}

/// Coefficients of columns from R and Qᴴb of their QR; columns that are alike share theirs.
///
/// # Errors
/// As [`answer`].
pub(crate) fn coefficients<T: Scalar>(
    r: ArrayView2<T>,
    along: ArrayView2<T>,
) -> Result<Array2<T>, LinalgError> {
    let solved = solve_upper(r, along).ok();
    match solved.filter(|all| all.iter().all(Scalar::is_finite_value)) {
        Some(solved) => Ok(solved),
        None => answer(matmul_h(r, r).view(), matmul_h(r, along).view()),
    }
}

/// The directions that an information matrix tells.
struct Informed<T> {
    /// (direction, unknown): the inverse on these directions is rootᴴ·root.
    root: Array2<T>,
    /// False for unknowns with a part in other directions.
    known: Vec<bool>,
}

impl<T: Scalar> Informed<T> {
    /// By the eigenvectors of the matrix brought to a unit diagonal.
    fn by(matrix: ArrayView2<T>) -> Result<Self, LinalgError> {
        let n = matrix.nrows();
        let size: Vec<f64> = matrix
            .diag()
            .iter()
            .map(|own| own.modulus().sqrt().recip())
            .map(|size| if size.is_finite() { size } else { 0.0 })
            .collect();
        let even = Array2::from_shape_fn((n, n), |(a, b)| {
            matrix[[a, b]] * T::of_real(size[a] * size[b])
        });
        let (values, vectors) = eigh(even.view())?;
        let (told, dark): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&c| values[c] > tol::UNINFORMED);
        let known = |a: usize| {
            let part = |&c: &usize| vectors[[a, c]].modulus().powi(2);
            size[a] > 0.0 && dark.iter().map(part).sum::<f64>() < limits::IN_THE_DARK
        };
        let sizes = Array2::from_shape_fn((n, n), |(a, b)| {
            T::of_real(if a == b { size[a] } else { 0.0 })
        });
        let mut root = matmul_h(vectors.select(Axis(1), &told).view(), sizes.view());
        root.rows_mut()
            .into_iter()
            .zip(&told)
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

/// Share of an error of each line that stays in the residual: the fit takes the rest
/// along (leverage; MacKinnon & White 1985, HC3). An error common to all FRFs moves the
/// poles too, so their derivatives count.
pub(crate) fn kept_share(q: &Array2<Complex64>, derivative: &Array2<Complex64>) -> Vec<f64> {
    let energy = |v: ArrayView1<Complex64>| v.iter().map(|c| c.norm_sqr()).sum::<f64>();
    let columns: Vec<f64> = derivative.columns().into_iter().map(energy).collect();
    let of_poles = |k: usize| {
        derivative
            .row(k)
            .iter()
            .zip(&columns)
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
