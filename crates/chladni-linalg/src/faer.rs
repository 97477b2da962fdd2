//! Default back end: faer, always sequential. Contiguous ndarray memory is viewed in
//! place, other layouts are copied.

use crate::{LinalgError, Result, Scalar};
use faer::linalg::solvers::Eigen;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::mat::{Mat, MatRef};
use faer::{Accum, Par, Side};
use ndarray::{Array1, Array2, ArrayView2, ArrayViewMut2, ShapeBuilder};
use num_complex::Complex64;
use std::borrow::Cow;

pub const NAME: &str = "faer";

/// Requirements of faer on an element.
pub trait Element:
    faer::traits::ComplexField<Real = f64> + faer::traits::Conjugate<Canonical = Self>
{
}
impl Element for f64 {}
impl Element for Complex64 {}

/// The triangle, and whether its adjoint.
#[derive(Clone, Copy)]
pub enum Triangle {
    Lower,
    LowerAdjoint,
    Upper,
}

/// Memory of an ndarray view as faer sees it.
struct Viewed<'a, T: Clone> {
    data: Cow<'a, [T]>,
    dim: (usize, usize),
    row_major: bool,
}

impl<T: Scalar> Viewed<'_, T> {
    fn as_ref(&self) -> MatRef<'_, T> {
        let (rows, columns) = self.dim;
        if self.row_major {
            MatRef::from_row_major_slice(&self.data, rows, columns)
        } else {
            MatRef::from_column_major_slice(&self.data, rows, columns)
        }
    }
}

fn viewed<'a, T: Scalar>(a: &'a ArrayView2<'_, T>) -> Viewed<'a, T> {
    let dim = a.dim();
    if let Some(data) = a
        .to_slice_memory_order()
        .filter(|_| a.t().is_standard_layout())
    {
        return Viewed {
            data: Cow::Borrowed(data),
            dim,
            row_major: false,
        };
    }
    if let Some(data) = a.as_slice() {
        return Viewed {
            data: Cow::Borrowed(data),
            dim,
            row_major: true,
        };
    }
    Viewed {
        data: Cow::Owned(a.t().iter().copied().collect()),
        dim,
        row_major: false,
    }
}

fn array<T: Scalar>(m: MatRef<'_, T>) -> Array2<T> {
    let mut data = Vec::with_capacity(m.nrows() * m.ncols());
    for column in m.col_iter() {
        match column.try_as_col_major() {
            Some(column) => data.extend_from_slice(column.as_slice()),
            None => data.extend(column.iter().copied()),
        }
    }
    Array2::from_shape_vec((m.nrows(), m.ncols()).f(), data)
        .expect("as many values as the shape has")
}

pub fn matmul<T: Scalar>(a: ArrayView2<T>, adjoint: bool, b: ArrayView2<T>) -> Array2<T> {
    let rows = if adjoint { a.ncols() } else { a.nrows() };
    let mut c = Array2::<T>::zeros((rows, b.ncols()).f());
    product(c.view_mut(), false, a, adjoint, b);
    c
}

pub fn product<T: Scalar>(
    c: ArrayViewMut2<T>,
    add: bool,
    a: ArrayView2<T>,
    adjoint: bool,
    b: ArrayView2<T>,
) {
    let accum = if add { Accum::Add } else { Accum::Replace };
    let (va, vb) = (viewed(&a), viewed(&b));
    let (rows, columns) = c.dim();
    let data = c.reversed_axes().into_slice().expect("column-major");
    let dst = faer::mat::MatMut::from_column_major_slice_mut(data, rows, columns);
    let one = <T as Scalar>::of_real(1.0);
    if adjoint {
        faer::linalg::matmul::matmul(
            dst,
            accum,
            va.as_ref().adjoint(),
            vb.as_ref(),
            one,
            Par::Seq,
        );
    } else {
        faer::linalg::matmul::matmul(dst, accum, va.as_ref(), vb.as_ref(), one, Par::Seq);
    }
}

pub fn qr_thin<T: Scalar>(a: ArrayView2<T>) -> (Array2<T>, Array2<T>) {
    let qr = viewed(&a).as_ref().qr();
    (array(qr.compute_thin_Q().as_ref()), array(qr.thin_R()))
}

pub fn qr_r<T: Scalar>(a: ArrayView2<T>) -> Array2<T> {
    array(viewed(&a).as_ref().qr().thin_R())
}

pub fn svd_thin<T: Scalar>(a: ArrayView2<T>) -> Result<(Array2<T>, Array1<f64>, Array2<T>)> {
    let svd = viewed(&a)
        .as_ref()
        .thin_svd()
        .map_err(|_| LinalgError::NoConvergence { operation: "SVD" })?;
    let s = svd
        .S()
        .column_vector()
        .iter()
        .map(|v| v.modulus())
        .collect();
    let vh: Mat<T> = svd.V().adjoint().to_owned();
    Ok((array(svd.U()), s, array(vh.as_ref())))
}

pub fn singular_values<T: Scalar>(a: ArrayView2<T>) -> Result<Array1<f64>> {
    let operation = "singular values";
    let values = viewed(&a).as_ref().singular_values();
    let values = values.map_err(|_| LinalgError::NoConvergence { operation })?;
    Ok(values.iter().map(|v| v.modulus()).collect())
}

pub fn eigh<T: Scalar>(a: ArrayView2<T>) -> Result<(Array1<f64>, Array2<T>)> {
    let operation = "Hermitian eigenvalues";
    let eigen = viewed(&a)
        .as_ref()
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| LinalgError::NoConvergence { operation })?;
    let values = eigen
        .S()
        .column_vector()
        .iter()
        .map(|v| faer::traits::ComplexField::real_part_impl(v))
        .collect();
    Ok((values, array(eigen.U())))
}

pub fn eigenvalues(a: ArrayView2<Complex64>) -> Result<Array1<Complex64>> {
    let operation = "eigenvalues";
    let eigen =
        Eigen::new(viewed(&a).as_ref()).map_err(|_| LinalgError::NoConvergence { operation })?;
    Ok(eigen.S().column_vector().iter().copied().collect())
}

pub fn cholesky<T: Scalar>(a: ArrayView2<T>) -> Result<Array2<T>> {
    let llt = viewed(&a)
        .as_ref()
        .llt(Side::Lower)
        .map_err(|_| LinalgError::NotPositiveDefinite { size: a.nrows() })?;
    Ok(array(llt.L()))
}

pub fn solve_triangular<T: Scalar>(
    t: ArrayView2<T>,
    b: ArrayView2<T>,
    which: Triangle,
) -> Array2<T> {
    let vt = viewed(&t);
    let mut x = viewed(&b).as_ref().to_owned();
    match which {
        Triangle::Lower => solve_lower_triangular_in_place(vt.as_ref(), x.as_mut(), Par::Seq),
        Triangle::LowerAdjoint => {
            solve_upper_triangular_in_place(vt.as_ref().adjoint(), x.as_mut(), Par::Seq)
        }
        Triangle::Upper => solve_upper_triangular_in_place(vt.as_ref(), x.as_mut(), Par::Seq),
    }
    array(x.as_ref())
}
