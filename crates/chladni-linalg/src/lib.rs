//! Dense kernels behind plain functions on ndarray views.
//!
//! Two back ends with the same private signatures: [faer](https://docs.rs/faer) by
//! default, LAPACK through `ndarray-linalg` with the feature `system`. Nothing outside
//! this crate names a back end. What no back end promises is checked here, before the
//! call: finite input (an eigenvalue routine may answer NaN with NaN silently), matching
//! sizes, scaling of the SVD (squares of the entries must not leave the range of f64),
//! and rank in [`lstsq`].
//!
//! ```
//! use chladni_linalg::{lstsq, svd_thin};
//! use ndarray::array;
//!
//! let a = array![[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]];
//! let line = lstsq(a.view(), array![[1.0], [3.0], [5.0]].view())?;
//! assert!((line[[0, 0]] - 1.0).abs() < 1e-12 && (line[[1, 0]] - 2.0).abs() < 1e-12);
//! let (u, singular, vh) = svd_thin(a.view())?;
//! assert_eq!((u.dim(), singular.len(), vh.dim()), ((3, 2), 2, (2, 2)));
//! # Ok::<(), chladni_linalg::LinalgError>(())
//! ```
//!
//! | matrix | functions |
//! |---|---|
//! | any | [`matmul`], [`matmul_h`], [`svd_thin`], [`singular_values`], [`qr_thin`], [`qr_r`], [`lstsq`] |
//! | square | [`eigenvalues`] |
//! | Hermitian | [`eigh`], [`cholesky`], [`solve_hermitian`], [`inverse_hermitian`] |
//! | triangular | [`solve_lower`], [`solve_lower_adjoint`], [`solve_upper`] |
//!
//! Real or complex ([`Scalar`]). Errors are [`LinalgError`].
//!
//! Functions of this page run on one thread. Those of `blocked`, for the other crates, run
//! on all threads of rayon, in blocks whose size does not depend on the number of threads.

mod back_ends;
#[cfg(not(feature = "system"))]
#[path = "faer.rs"]
mod backend;
#[cfg(feature = "system")]
#[path = "lapack.rs"]
mod backend;
#[cfg(feature = "system")]
#[allow(dead_code)] // the bench needs only its kernels
#[path = "faer.rs"]
mod beside;
#[doc(hidden)] // for the crates of Chladni: no promise
pub mod blocked;
mod doors;
#[doc(hidden)] // for the crates of Chladni: no promise
pub mod fft;
mod limits;
mod scalar;
mod upper_halves;
mod wide;

pub use back_ends::{back_ends, BackEnd, Dense, Factors, Given};
use doors::Doors;
use ndarray::{Array1, Array2, ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex64;
pub use scalar::Scalar;
use thiserror::Error;
#[doc(hidden)] // for the crates of Chladni: no promise
pub use wide::wide;

/// Name of the back end in use, for result files and benches.
pub const BACKEND: &str = backend::NAME;

/// Relative size below which a diagonal entry of R counts as zero in [`lstsq`]: a few
/// hundred roundings of a well-scaled column. Ten times more refuses usable fits near
/// repeated poles, ten times less lets noise through as solutions.
pub const RANK_TOLERANCE: f64 = 1e-13;

/// The reason that a kernel gave no result.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum LinalgError {
    /// NaN or infinity in the input.
    #[error("{operation}: the matrix holds NaN or infinity")]
    NotFinite {
        /// Kernel.
        operation: &'static str,
    },
    /// Sizes that do not fit.
    #[error("{operation}: sizes {left:?} and {right:?} do not fit")]
    Shape {
        /// Kernel.
        operation: &'static str,
        /// Rows and columns of the first matrix.
        left: (usize, usize),
        /// Rows and columns of the second.
        right: (usize, usize),
    },
    /// A matrix of the wrong shape.
    #[error("{operation}: a matrix of {rows} × {columns} {wrong}")]
    WrongShape {
        /// Kernel.
        operation: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
        /// The part of a sentence that says what is wrong.
        wrong: &'static str,
    },
    /// Cholesky met a pivot that is not positive.
    #[error("the matrix of size {size} is not positive definite")]
    NotPositiveDefinite {
        /// Rows.
        size: usize,
    },
    /// Least squares without a unique solution.
    #[error("least squares: rank {rank} of {columns} columns")]
    RankDeficient {
        /// Numerical rank.
        rank: usize,
        /// Columns.
        columns: usize,
    },
    /// An iteration inside the back end did not converge.
    #[error("{operation} did not converge")]
    NoConvergence {
        /// Kernel.
        operation: &'static str,
    },
}

/// Result of a kernel.
pub type Result<T> = std::result::Result<T, LinalgError>;

fn finite<T: Scalar>(operation: &'static str, a: &ArrayView2<T>) -> Result<()> {
    // as the values lie in memory: an iterator over columns by rows takes several times as long
    let all = match a.to_slice_memory_order() {
        Some(values) => values.iter().all(|v| v.is_finite_value()),
        None => a.iter().all(|v| v.is_finite_value()),
    };
    if all {
        Ok(())
    } else {
        Err(LinalgError::NotFinite { operation })
    }
}

fn square<T>(operation: &'static str, a: &ArrayView2<T>) -> Result<()> {
    shaped(operation, a, a.nrows() == a.ncols(), "is not square")
}

fn tall<T>(operation: &'static str, a: &ArrayView2<T>) -> Result<()> {
    let holds = a.nrows() >= a.ncols();
    shaped(operation, a, holds, "has fewer rows than columns")
}

fn shaped<T>(
    operation: &'static str,
    a: &ArrayView2<T>,
    holds: bool,
    wrong: &'static str,
) -> Result<()> {
    match holds {
        true => Ok(()),
        false => Err(LinalgError::WrongShape {
            operation,
            rows: a.nrows(),
            columns: a.ncols(),
            wrong,
        }),
    }
}

/// a·b. Non-finite entries propagate as in ordinary arithmetic.
///
/// # Panics
/// Inner sizes that differ.
pub fn matmul<T: Scalar>(a: ArrayView2<T>, b: ArrayView2<T>) -> Array2<T> {
    assert_eq!(a.ncols(), b.nrows(), "matmul: inner sizes");
    if a.is_empty() || b.is_empty() {
        return Array2::zeros((a.nrows(), b.ncols()));
    }
    Doors::matmul(a, false, b)
}

/// aᴴ·b.
///
/// # Panics
/// Numbers of rows that differ.
pub fn matmul_h<T: Scalar>(a: ArrayView2<T>, b: ArrayView2<T>) -> Array2<T> {
    assert_eq!(a.nrows(), b.nrows(), "matmul_h: inner sizes");
    if a.is_empty() || b.is_empty() {
        return Array2::zeros((a.ncols(), b.ncols()));
    }
    Doors::matmul(a, true, b)
}

/// c ← c + a·b for column-major c: sums over blocks without memory of their own.
///
/// # Panics
/// Sizes that differ, or a c that is not column-major.
pub fn add_matmul<T: Scalar>(c: ArrayViewMut2<T>, a: ArrayView2<T>, b: ArrayView2<T>) {
    assert_eq!(
        (a.ncols(), a.nrows(), b.ncols()),
        (b.nrows(), c.nrows(), c.ncols()),
        "add_matmul: sizes"
    );
    if !(a.is_empty() || b.is_empty()) {
        Doors::product(c, true, a, false, b);
    }
}

/// c ← a·b for column-major c, whatever it held. Of zeros that the system has promised
/// but not yet written this touches each page once; [`add_matmul`] reads before it
/// writes, and a page is mapped twice.
///
/// # Panics
/// Sizes that differ, or a c that is not column-major.
pub fn set_matmul<T: Scalar>(mut c: ArrayViewMut2<T>, a: ArrayView2<T>, b: ArrayView2<T>) {
    assert_eq!(
        (a.ncols(), a.nrows(), b.ncols()),
        (b.nrows(), c.nrows(), c.ncols()),
        "set_matmul: sizes"
    );
    match a.is_empty() || b.is_empty() {
        true => c.fill(T::zero()),
        false => Doors::product(c, false, a, false, b),
    }
}

/// c ← aᴴ·b, as [`set_matmul`].
///
/// # Panics
/// Sizes that differ, or a c that is not column-major.
pub fn set_matmul_h<T: Scalar>(mut c: ArrayViewMut2<T>, a: ArrayView2<T>, b: ArrayView2<T>) {
    assert_eq!(
        (a.nrows(), a.ncols(), b.ncols()),
        (b.nrows(), c.nrows(), c.ncols()),
        "set_matmul_h: sizes"
    );
    match a.is_empty() || b.is_empty() {
        true => c.fill(T::zero()),
        false => Doors::product(c, false, a, true, b),
    }
}

/// Thin QR of a tall matrix (rows ≥ columns): (Q with orthonormal columns, R upper
/// triangular).
///
/// # Errors
/// Non-finite input; fewer rows than columns.
pub fn qr_thin<T: Scalar>(a: ArrayView2<T>) -> Result<(Array2<T>, Array2<T>)> {
    finite("QR", &a)?;
    tall("QR", &a)?;
    if a.ncols() == 0 {
        return Ok((Array2::zeros((a.nrows(), 0)), Array2::zeros((0, 0))));
    }
    Ok(Doors::qr_thin(a))
}

/// R of the thin QR alone, at about half the cost.
///
/// # Errors
/// As [`qr_thin`].
pub fn qr_r<T: Scalar>(a: ArrayView2<T>) -> Result<Array2<T>> {
    finite("QR", &a)?;
    tall("QR", &a)?;
    if a.ncols() == 0 {
        return Ok(Array2::zeros((0, 0)));
    }
    Ok(Doors::qr_r(a))
}

/// Thin SVD: a = u·diag(s)·vh, s falling.
///
/// # Errors
/// Non-finite input; no convergence.
pub fn svd_thin<T: Scalar>(a: ArrayView2<T>) -> Result<(Array2<T>, Array1<f64>, Array2<T>)> {
    finite("SVD", &a)?;
    let scale = a.iter().fold(0.0_f64, |m, v| m.max(v.modulus()));
    let size = a.nrows().min(a.ncols());
    if size == 0 || scale == 0.0 {
        let eye = |rows, columns| {
            Array2::from_shape_fn((rows, columns), |(i, j)| {
                if i == j {
                    T::of_real(1.0)
                } else {
                    T::of_real(0.0)
                }
            })
        };
        return Ok((
            eye(a.nrows(), size),
            Array1::zeros(size),
            eye(size, a.ncols()),
        ));
    }
    let (u, s, vh) = Doors::svd_thin(a.mapv(|v| v.divided_by(scale)).view())?;
    Ok((u, s * scale, vh))
}

/// Singular values alone, falling: a fraction of the work of [`svd_thin`].
///
/// # Errors
/// Non-finite input; no convergence.
pub fn singular_values<T: Scalar>(a: ArrayView2<T>) -> Result<Array1<f64>> {
    finite("singular values", &a)?;
    let scale = a.iter().fold(0.0_f64, |m, v| m.max(v.modulus()));
    if scale == 0.0 {
        return Ok(Array1::zeros(a.nrows().min(a.ncols())));
    }
    Ok(Doors::singular_values(a.mapv(|v| v.divided_by(scale)).view())? * scale)
}

/// Eigenvalues (rising) and orthonormal eigenvectors (columns) of a Hermitian matrix; the
/// lower triangle is read.
///
/// # Errors
/// Non-finite or non-square input; no convergence.
pub fn eigh<T: Scalar>(a: ArrayView2<T>) -> Result<(Array1<f64>, Array2<T>)> {
    finite("Hermitian eigenvalues", &a)?;
    square("Hermitian eigenvalues", &a)?;
    if a.is_empty() {
        return Ok((Array1::zeros(0), Array2::zeros((0, 0))));
    }
    Doors::eigh(a)
}

/// Eigenvalues of a general complex matrix, in no particular order.
///
/// # Errors
/// Non-finite or non-square input; no convergence.
pub fn eigenvalues(a: ArrayView2<Complex64>) -> Result<Array1<Complex64>> {
    finite("eigenvalues", &a)?;
    square("eigenvalues", &a)?;
    if a.is_empty() {
        return Ok(Array1::zeros(0));
    }
    let values = backend::eigenvalues(a);
    upper_halves::clear();
    values
}

/// Lower factor L of a = L·Lᴴ; the lower triangle is read.
///
/// # Errors
/// Non-finite or non-square input; not positive definite.
pub fn cholesky<T: Scalar>(a: ArrayView2<T>) -> Result<Array2<T>> {
    finite("Cholesky", &a)?;
    square("Cholesky", &a)?;
    if a.is_empty() {
        return Ok(Array2::zeros((0, 0)));
    }
    Doors::cholesky(a)
}

/// Solves l·x = b for lower triangular l.
///
/// # Errors
/// Sizes that do not fit.
pub fn solve_lower<T: Scalar>(l: ArrayView2<T>, b: ArrayView2<T>) -> Result<Array2<T>> {
    triangular("lower triangular solve", l, b, backend::Triangle::Lower)
}

/// Solves lᴴ·x = b for lower triangular l.
///
/// # Errors
/// Sizes that do not fit.
pub fn solve_lower_adjoint<T: Scalar>(l: ArrayView2<T>, b: ArrayView2<T>) -> Result<Array2<T>> {
    triangular(
        "adjoint lower triangular solve",
        l,
        b,
        backend::Triangle::LowerAdjoint,
    )
}

/// Solves r·x = b for upper triangular r.
///
/// # Errors
/// Sizes that do not fit.
pub fn solve_upper<T: Scalar>(r: ArrayView2<T>, b: ArrayView2<T>) -> Result<Array2<T>> {
    triangular("upper triangular solve", r, b, backend::Triangle::Upper)
}

fn triangular<T: Scalar>(
    operation: &'static str,
    t: ArrayView2<T>,
    b: ArrayView2<T>,
    which: backend::Triangle,
) -> Result<Array2<T>> {
    if t.nrows() != t.ncols() || t.nrows() != b.nrows() {
        return Err(LinalgError::Shape {
            operation,
            left: t.dim(),
            right: b.dim(),
        });
    }
    if b.is_empty() {
        return Ok(Array2::zeros(b.dim()));
    }
    Ok(Doors::solve_triangular(t, b, which))
}

/// Solves a·x = b for Hermitian positive definite a (Cholesky).
///
/// # Errors
/// As [`cholesky`]; sizes that do not fit.
pub fn solve_hermitian<T: Scalar>(a: ArrayView2<T>, b: ArrayView2<T>) -> Result<Array2<T>> {
    let l = cholesky(a)?;
    let y = solve_lower(l.view(), b)?;
    solve_lower_adjoint(l.view(), y.view())
}

/// Inverse of a Hermitian positive definite matrix.
///
/// # Errors
/// As [`cholesky`].
pub fn inverse_hermitian<T: Scalar>(a: ArrayView2<T>) -> Result<Array2<T>> {
    solve_hermitian(a, Array2::from_diag_elem(a.nrows(), T::of_real(1.0)).view())
}

/// Least-squares solution of a·x ≈ b for a tall matrix of full column rank (QR, columns
/// scaled to unit norm).
///
/// # Errors
/// Non-finite input, sizes that do not fit, [`LinalgError::RankDeficient`] by
/// [`RANK_TOLERANCE`].
pub fn lstsq<T: Scalar>(a: ArrayView2<T>, b: ArrayView2<T>) -> Result<Array2<T>> {
    finite("least squares", &b)?;
    if a.nrows() != b.nrows() {
        return Err(LinalgError::Shape {
            operation: "least squares",
            left: a.dim(),
            right: b.dim(),
        });
    }
    let mut scaled = a.to_owned();
    let scales: Vec<f64> = a
        .axis_iter(Axis(1))
        .map(|column| {
            column
                .iter()
                .map(|v| v.modulus().powi(2))
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    for (mut column, &scale) in scaled.axis_iter_mut(Axis(1)).zip(&scales) {
        if scale > 0.0 {
            column.mapv_inplace(|v| v.divided_by(scale));
        }
    }
    let (q, r) = qr_thin(scaled.view())?;
    let diagonal: Vec<f64> = r.diag().iter().map(|v| v.modulus()).collect();
    let rank = diagonal.iter().filter(|d| **d > RANK_TOLERANCE).count();
    if rank < r.ncols() {
        return Err(LinalgError::RankDeficient {
            rank,
            columns: r.ncols(),
        });
    }
    let mut x = solve_upper(r.view(), matmul_h(q.view(), b).view())?;
    for (mut row, &scale) in x.axis_iter_mut(Axis(0)).zip(&scales) {
        row.mapv_inplace(|v| v.divided_by(scale));
    }
    Ok(x)
}
