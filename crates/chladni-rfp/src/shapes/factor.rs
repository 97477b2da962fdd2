//! Cholesky factors of matrices that are real where shapes are: a quarter of the work.

use chladni_linalg::{cholesky, solve_lower, solve_lower_adjoint, LinalgError, Scalar};
use ndarray::Array2;
use num_complex::Complex64;

/// L of a positive definite matrix LLᴴ.
pub(crate) enum Factor {
    Real(Array2<f64>),
    Complex(Array2<Complex64>),
}

impl Factor {
    /// `real`: whatever imaginary part the matrix has is none of it.
    ///
    /// # Errors
    /// Not positive definite.
    pub fn new(matrix: &Array2<Complex64>, real: bool) -> Result<Self, LinalgError> {
        Ok(if real {
            Self::Real(cholesky(parts(matrix).view())?)
        } else {
            Self::Complex(cholesky(matrix.view())?)
        })
    }

    /// (LLᴴ)⁻¹·`right`, which is real where the matrix is.
    ///
    /// # Errors
    /// Sizes that do not fit.
    pub fn solve(&self, right: &Array2<Complex64>) -> Result<Array2<Complex64>, LinalgError> {
        fn solved<T: Scalar>(
            lower: &Array2<T>,
            right: &Array2<T>,
        ) -> Result<Array2<T>, LinalgError> {
            solve_lower_adjoint(
                lower.view(),
                solve_lower(lower.view(), right.view())?.view(),
            )
        }
        match self {
            Self::Real(lower) => Ok(solved(lower, &parts(right))?.mapv(Complex64::from)),
            Self::Complex(lower) => solved(lower, right),
        }
    }

    /// Diagonal entries `places` of (LLᴴ)⁻¹.
    ///
    /// # Errors
    /// None but those of the kernel.
    pub fn inverse_diagonal(&self, places: &[usize]) -> Result<Vec<f64>, LinalgError> {
        fn squares<T: Scalar>(
            lower: &Array2<T>,
            places: &[usize],
        ) -> Result<Vec<f64>, LinalgError> {
            let mut units = Array2::zeros((lower.nrows(), places.len()));
            places
                .iter()
                .enumerate()
                .for_each(|(c, &place)| units[[place, c]] = T::of_real(1.0));
            let half = solve_lower(lower.view(), units.view())?;
            Ok(half
                .columns()
                .into_iter()
                .map(|column| column.iter().map(|v| v.modulus().powi(2)).sum())
                .collect())
        }
        match self {
            Self::Real(lower) => squares(lower, places),
            Self::Complex(lower) => squares(lower, places),
        }
    }
}

fn parts(matrix: &Array2<Complex64>) -> Array2<f64> {
    matrix.mapv(|v| v.re)
}
