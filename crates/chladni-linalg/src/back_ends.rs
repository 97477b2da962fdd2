//! Every back end that is linked in, side by side: for benches, and for nothing else.

use crate::Result;
use ndarray::{Array1, Array2, ArrayView2};
use num_complex::Complex64;

/// A matrix that a kernel is given.
pub type Given<'a> = ArrayView2<'a, Complex64>;
/// A matrix that it gives back.
pub type Dense = Array2<Complex64>;
/// Singular vectors, singular values, singular vectors.
pub type Factors = (Dense, Array1<f64>, Dense);

/// The kernels of one back end, without the checks that stand before them elsewhere:
/// input must be finite, and sizes must fit.
#[derive(Clone, Copy)]
pub struct BackEnd {
    /// Name.
    pub name: &'static str,
    /// a·b.
    pub matmul: fn(Given, Given) -> Dense,
    /// aᴴ·b.
    pub matmul_h: fn(Given, Given) -> Dense,
    /// Thin QR.
    pub qr_thin: fn(Given) -> (Dense, Dense),
    /// R of the thin QR alone.
    pub qr_r: fn(Given) -> Dense,
    /// Thin SVD: u, s, vh.
    pub svd_thin: fn(Given) -> Result<Factors>,
    /// Eigenvalues and eigenvectors of a Hermitian matrix.
    pub eigh: fn(Given) -> Result<(Array1<f64>, Dense)>,
    /// Eigenvalues of a square matrix.
    pub eigenvalues: fn(Given) -> Result<Array1<Complex64>>,
    /// Lower Cholesky factor.
    pub cholesky: fn(Given) -> Result<Dense>,
    /// r⁻¹·b for upper triangular r.
    pub solve_upper: fn(Given, Given) -> Dense,
}

macro_rules! back_end {
    ($module:path) => {{
        use $module as own;
        BackEnd {
            name: own::NAME,
            matmul: |a, b| own::matmul(a, false, b),
            matmul_h: |a, b| own::matmul(a, true, b),
            qr_thin: own::qr_thin,
            qr_r: own::qr_r,
            svd_thin: own::svd_thin,
            eigh: own::eigh,
            eigenvalues: own::eigenvalues,
            cholesky: own::cholesky,
            solve_upper: |r, b| own::solve_triangular(r, b, own::Triangle::Upper),
        }
    }};
}

/// The back end in use, and with the feature `system` the other one as well.
pub fn back_ends() -> Vec<BackEnd> {
    let used = back_end!(crate::backend);
    #[cfg(feature = "system")]
    let all = vec![used, back_end!(crate::beside)];
    #[cfg(not(feature = "system"))]
    let all = vec![used];
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn back_ends_agree_on_what_is_unique() {
        let a = Array2::from_shape_fn((9, 4), |(i, j)| {
            Complex64::new(((3 * i + 5 * j) % 7) as f64, ((i * j) % 5) as f64 - 2.0)
        });
        let reference = crate::svd_thin(a.view()).unwrap().1;
        for matrix in [a.clone(), a.t().to_owned(), &a * 0.0] {
            let alone = crate::singular_values(matrix.view()).unwrap();
            let (_, with_vectors, _) = crate::svd_thin(matrix.view()).unwrap();
            let pairs = alone.iter().zip(&with_vectors);
            assert!(
                alone.len() == 4
                    && pairs
                        .clone()
                        .all(|(a, b)| (a - b).abs() < 1e-12 * reference[0])
            );
        }
        let product = crate::matmul_h(a.view(), a.view());
        for back_end in back_ends() {
            let (_, values, _) = (back_end.svd_thin)(a.view()).unwrap();
            assert!(
                values
                    .iter()
                    .zip(&reference)
                    .all(|(own, other)| (own / other - 1.0).abs() < 1e-12),
                "{}",
                back_end.name
            );
            let gram = (back_end.matmul_h)(a.view(), a.view());
            assert!(
                gram.iter()
                    .zip(&product)
                    .all(|(own, other)| (own - other).norm() < 1e-12 * product[[0, 0]].norm()),
                "{}",
                back_end.name
            );
        }
    }
}
