//! Back end of the feature `system`: LAPACK through ndarray-linalg over OpenBLAS, kept to
//! one thread per call.
//!
//! OpenBLAS built without threads is also built without locks: two of our threads inside
//! it at once give wrong numbers without a word (seen in Debian 12's serial build: the
//! first mode of a plate at 0.2 Hz). Which build runs is the machine's choice at load
//! time, so it is asked: a build with threads is held to one per call and entered freely,
//! a build without them by one thread at a time.

use crate::{LinalgError, Result, Scalar};
use ndarray::linalg::general_mat_mul;
use ndarray::{Array1, Array2, ArrayView2, ArrayViewMut2, ShapeBuilder};
use ndarray_linalg::{
    Cholesky, Diag, EigVals, Eigh, JobSvd, Lapack, SolveTriangular, QR, SVDDC, UPLO,
};
use num_complex::Complex64;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

pub const NAME: &str = "lapack";

/// Requirements of ndarray-linalg on an element, and those of the other back end, so that
/// both can be compared.
pub trait Element: Lapack<Real = f64> + crate::beside::Element {}
impl Element for f64 {}
impl Element for Complex64 {}

mod openblas {
    use std::ffi::c_int;

    #[allow(unsafe_code)]
    mod c {
        use super::c_int;
        unsafe extern "C" {
            pub safe fn openblas_set_num_threads(threads: c_int);
            pub safe fn openblas_get_parallel() -> c_int;
        }
    }

    /// Keeps OpenBLAS to one thread per call; true where several callers may be inside at
    /// once.
    pub fn single_threaded_calls() -> bool {
        c::openblas_set_num_threads(1);
        c::openblas_get_parallel() != 0
    }
}

/// To be held during every call into LAPACK.
fn lapack() -> Option<MutexGuard<'static, ()>> {
    static SHARED: OnceLock<bool> = OnceLock::new();
    static ALONE: Mutex<()> = Mutex::new(());
    let shared = *SHARED.get_or_init(openblas::single_threaded_calls);
    (!shared).then(|| ALONE.lock().unwrap_or_else(PoisonError::into_inner))
}

/// The triangle, and whether its adjoint.
#[derive(Clone, Copy)]
pub enum Triangle {
    Lower,
    LowerAdjoint,
    Upper,
}

/// A column-major copy: LAPACK's own layout, 1.6 times faster in QR than the row-major
/// one.
fn column_major<T: Scalar>(a: ArrayView2<T>) -> Array2<T> {
    let mut copy = Array2::zeros(a.dim().f());
    copy.assign(&a);
    copy
}

fn adjoint<T: Scalar>(a: ArrayView2<T>) -> Array2<T> {
    a.t().mapv(|v| ndarray_linalg::Scalar::conj(&v))
}

pub fn matmul<T: Scalar>(a: ArrayView2<T>, conjugate: bool, b: ArrayView2<T>) -> Array2<T> {
    if conjugate {
        adjoint(a).dot(&b)
    } else {
        a.dot(&b)
    }
}

pub fn product<T: Scalar>(
    mut c: ArrayViewMut2<T>,
    add: bool,
    a: ArrayView2<T>,
    conjugate: bool,
    b: ArrayView2<T>,
) {
    let (one, kept) = (
        <T as Scalar>::of_real(1.0),
        <T as Scalar>::of_real(if add { 1.0 } else { 0.0 }),
    );
    if conjugate {
        general_mat_mul(one, &adjoint(a), &b, kept, &mut c);
    } else {
        general_mat_mul(one, &a, &b, kept, &mut c);
    }
}

pub fn qr_thin<T: Scalar>(a: ArrayView2<T>) -> (Array2<T>, Array2<T>) {
    let _entered = lapack();
    column_major(a)
        .qr()
        .expect("LAPACK QR fails only on wrong arguments")
}

pub fn qr_r<T: Scalar>(a: ArrayView2<T>) -> Array2<T> {
    qr_thin(a).1
}

pub fn svd_thin<T: Scalar>(a: ArrayView2<T>) -> Result<(Array2<T>, Array1<f64>, Array2<T>)> {
    let _entered = lapack();
    let operation = "SVD";
    let (u, s, vh) = column_major(a)
        .svddc(JobSvd::Some)
        .map_err(|_| LinalgError::NoConvergence { operation })?;
    Ok((u.expect("asked for"), s, vh.expect("asked for")))
}

pub fn singular_values<T: Scalar>(a: ArrayView2<T>) -> Result<Array1<f64>> {
    let _entered = lapack();
    let operation = "singular values";
    let factors = column_major(a).svddc(JobSvd::None);
    let (_, values, _) = factors.map_err(|_| LinalgError::NoConvergence { operation })?;
    Ok(values)
}

pub fn eigh<T: Scalar>(a: ArrayView2<T>) -> Result<(Array1<f64>, Array2<T>)> {
    let _entered = lapack();
    let operation = "Hermitian eigenvalues";
    column_major(a)
        .eigh(UPLO::Lower)
        .map_err(|_| LinalgError::NoConvergence { operation })
}

pub fn eigenvalues(a: ArrayView2<Complex64>) -> Result<Array1<Complex64>> {
    let _entered = lapack();
    let operation = "eigenvalues";
    column_major(a)
        .eigvals()
        .map_err(|_| LinalgError::NoConvergence { operation })
}

pub fn cholesky<T: Scalar>(a: ArrayView2<T>) -> Result<Array2<T>> {
    let _entered = lapack();
    column_major(a)
        .cholesky(UPLO::Lower)
        .map_err(|_| LinalgError::NotPositiveDefinite { size: a.nrows() })
}

pub fn solve_triangular<T: Scalar>(
    t: ArrayView2<T>,
    b: ArrayView2<T>,
    which: Triangle,
) -> Array2<T> {
    let _entered = lapack();
    let (uplo, matrix) = match which {
        Triangle::Lower => (UPLO::Lower, column_major(t)),
        Triangle::LowerAdjoint => (UPLO::Upper, column_major(adjoint(t).view())),
        Triangle::Upper => (UPLO::Upper, column_major(t)),
    };
    matrix
        .solve_triangular(uplo, Diag::NonUnit, &column_major(b))
        // a zero on the diagonal: no finite answer, as with the other back end; sizes are
        // checked by the caller
        .unwrap_or_else(|_| Array2::from_elem(b.dim(), T::of_real(f64::NAN)))
}
