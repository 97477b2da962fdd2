//! Products whose right side has many columns, on all threads: blocks of columns whose
//! size depends on nothing but their number, so that the bits are the same on any number
//! of threads.

use crate::limits::{LEAST, MOST, ROW_BLOCKS, SMALL};
use crate::{
    add_matmul, matmul, matmul_h, qr_r, qr_thin, set_matmul, set_matmul_h, svd_thin, LinalgError,
    Scalar,
};
use ndarray::{s, Array1, Array2, ArrayView2, ArrayViewMut2, Axis, CowArray, Ix2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Columns per block of a product with `columns` columns and so many multiplications in
/// all: blocks of nearly one size.
fn block(columns: usize, multiplications: usize) -> usize {
    if multiplications < SMALL {
        columns.max(1)
    } else {
        columns
            .div_ceil(columns.div_ceil(LEAST).clamp(1, MOST))
            .max(1)
    }
}

/// Runs `work` on a thread of the pool: each of its many short products would otherwise
/// wait for two of them to wake.
pub fn in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::scope(|_| work())
}

/// a·b.
pub fn blocked_matmul<T: Scalar>(a: ArrayView2<T>, b: ArrayView2<T>) -> Array2<T> {
    let mut out = Array2::zeros((a.nrows(), b.ncols()).f());
    blocked(out.view_mut(), a.len(), b, |c, b| set_matmul(c, a, b));
    out
}

/// aᴴ·b.
pub fn blocked_matmul_h<T: Scalar>(a: ArrayView2<T>, b: ArrayView2<T>) -> Array2<T> {
    let mut out = Array2::zeros((a.ncols(), b.ncols()).f());
    blocked(out.view_mut(), a.len(), b, |c, b| set_matmul_h(c, a, b));
    out
}

/// aᴴ·a: of the two triangles, which mirror each other, one is computed.
pub fn blocked_gram(a: ArrayView2<Complex64>) -> Array2<Complex64> {
    let n = a.ncols();
    let mut gram = Array2::zeros((n, n).f());
    let size = block(n, a.len() * n);
    let blocks: Vec<_> = gram.axis_chunks_iter_mut(Axis(1), size).collect();
    blocks
        .into_par_iter()
        .enumerate()
        .for_each(|(number, mut out)| {
            let first = number * size;
            let end = first + out.ncols();
            let product = matmul_h(a.slice(s![.., ..end]), a.slice(s![.., first..end]));
            out.slice_mut(s![..end, ..]).assign(&product);
        });
    for j in 0..n {
        gram[[j, j]].im = 0.0;
        for i in 0..j {
            gram[[j, i]] = gram[[i, j]].conj();
        }
    }
    gram
}

fn blocked<T: Scalar>(
    mut out: ArrayViewMut2<T>,
    per_column: usize,
    b: ArrayView2<T>,
    product: impl Fn(ArrayViewMut2<T>, ArrayView2<T>) + Sync,
) {
    // some columns of a matrix whose rows lie side by side would be copied
    let size = match b.t().is_standard_layout() {
        true => block(b.ncols(), per_column * b.ncols()),
        false => b.ncols().max(1),
    };
    let blocks: Vec<_> = out
        .axis_chunks_iter_mut(Axis(1), size)
        .zip(b.axis_chunks_iter(Axis(1), size))
        .collect();
    blocks.into_par_iter().for_each(|(out, b)| product(out, b));
}

/// Zeros to add products to, (row, column) by columns. They are written, so that fresh pages are
/// touched once: pages that the system has only promised are mapped twice, at the first read and
/// at the first write.
pub fn cleared(rows: usize, columns: usize) -> Array2<f64> {
    // the compiler must not make it a promise again
    let mut values = std::hint::black_box(Vec::with_capacity(rows * columns));
    values.resize(rows * columns, 0.0);
    Array2::from_shape_vec((rows, columns).f(), values).expect("as many values")
}

/// Sum of what `part` makes of each of `items` (at least one), by a tree that their
/// number fixes: few parts are alive at once.
pub fn tree_sum<I: Send, S: Send>(
    mut items: Vec<I>,
    part: &(impl Fn(I) -> S + Sync),
    add: &(impl Fn(S, S) -> S + Sync),
) -> S {
    let right = items.split_off(items.len() / 2);
    if items.is_empty() {
        return part(right.into_iter().next().expect("at least one"));
    }
    let (left, right) = rayon::join(|| tree_sum(items, part, add), || tree_sum(right, part, add));
    add(left, right)
}

/// Qᴴb and b − Q·Qᴴb.
pub fn projected<T: Scalar>(q: ArrayView2<T>, b: ArrayView2<T>) -> (Array2<T>, Array2<T>) {
    let (mut inside, mut outside) = (
        Array2::zeros((q.ncols(), b.ncols()).f()),
        Array2::zeros(b.raw_dim().f()),
    );
    let size = block(b.ncols(), 2 * q.len() * b.ncols());
    let blocks = inside
        .axis_chunks_iter_mut(Axis(1), size)
        .zip(outside.axis_chunks_iter_mut(Axis(1), size));
    let blocks: Vec<_> = blocks.zip(b.axis_chunks_iter(Axis(1), size)).collect();
    blocks
        .into_par_iter()
        .for_each(|((mut inside, mut outside), b)| {
            set_matmul_h(inside.view_mut(), q, b);
            outside.assign(&b);
            add_matmul(outside, q, inside.mapv(|v| T::zero() - v).view());
        });
    (inside, outside)
}

/// Thin QR of a tall matrix from those of blocks of its rows.
///
/// # Errors
/// As [`qr_thin`].
pub fn tall_qr<T: Scalar>(a: ArrayView2<T>) -> Result<(Array2<T>, Array2<T>), LinalgError> {
    let (rows, m) = a.dim();
    if rows < 2 * ROW_BLOCKS * m || a.len() * m < SMALL {
        return qr_thin(a);
    }
    let size = rows.div_ceil(ROW_BLOCKS);
    let blocks: Vec<_> = a.axis_chunks_iter(Axis(0), size).collect();
    let parts = blocks
        .into_par_iter()
        .map(qr_thin)
        .collect::<Result<Vec<_>, LinalgError>>()?;
    let factors: Vec<_> = parts.iter().map(|(_, r)| r.view()).collect();
    let (top, r) = qr_thin(
        ndarray::concatenate(Axis(0), &factors)
            .expect("as many columns")
            .view(),
    )?;
    let mut q = Array2::zeros((rows, m).f());
    let products: Vec<_> = parts
        .par_iter()
        .enumerate()
        .map(|(i, (q, _))| matmul(q.view(), top.slice(s![i * m..(i + 1) * m, ..])))
        .collect();
    q.axis_chunks_iter_mut(Axis(0), size)
        .zip(&products)
        .for_each(|(mut q, product)| q.assign(product));
    Ok((q, r))
}

/// Orthonormal basis of the range of a matrix with columns of unit norm: of singular
/// values beyond `least` of the largest.
///
/// # Errors
/// As [`svd_thin`].
pub fn range<T: Scalar>(a: ArrayView2<T>, least: f64) -> Result<Array2<T>, LinalgError> {
    let kept =
        |s: &Array1<f64>| -> Vec<usize> { (0..s.len()).filter(|&i| s[i] > least * s[0]).collect() };
    if a.nrows() < a.ncols() {
        let (u, s, _) = svd_thin(a)?;
        return Ok(u.select(Axis(1), &kept(&s)));
    }
    let (q, r) = tall_qr(a)?;
    // columns that stand well outside those before them: no direction is missing
    if r.diag().iter().all(|pivot| pivot.modulus() > least.sqrt()) {
        return Ok(q);
    }
    let (u, s, _) = svd_thin(r.view())?;
    Ok(blocked_matmul(
        q.view(),
        u.select(Axis(1), &kept(&s)).view(),
    ))
}

/// R of the QR alone.
///
/// # Errors
/// As [`qr_thin`].
pub fn tall_r<T: Scalar>(a: ArrayView2<T>) -> Result<Array2<T>, LinalgError> {
    let (rows, m) = a.dim();
    if rows < 2 * ROW_BLOCKS * m || a.len() * m < SMALL {
        return qr_r(a);
    }
    let blocks: Vec<_> = a
        .axis_chunks_iter(Axis(0), rows.div_ceil(ROW_BLOCKS))
        .collect();
    let parts = blocks
        .into_par_iter()
        .map(qr_r)
        .collect::<Result<Vec<_>, LinalgError>>()?;
    let factors: Vec<_> = parts.iter().map(|r| r.view()).collect();
    qr_r(
        ndarray::concatenate(Axis(0), &factors)
            .expect("as many columns")
            .view(),
    )
}

/// Real and imaginary part of each line in turn; no copy of a matrix by columns.
pub fn interleaved(b: &Array2<Complex64>) -> CowArray<'_, f64, Ix2> {
    let size = (2 * b.nrows(), b.ncols());
    let by_columns = b.t().to_slice().map(bytemuck::cast_slice);
    if let Some(parts) = by_columns.and_then(|parts| ArrayView2::from_shape(size.f(), parts).ok()) {
        return parts.into();
    }
    let part = |value: Complex64, row: usize| {
        if row.is_multiple_of(2) {
            value.re
        } else {
            value.im
        }
    };
    Array2::from_shape_fn(size.f(), |(row, c)| part(b[[row / 2, c]], row)).into()
}

/// a·b for complex a and real b, as a real product of twice the rows.
pub fn blocked_matmul_mixed(a: &Array2<Complex64>, b: ArrayView2<f64>) -> Array2<Complex64> {
    let parts = interleaved(a);
    let mut out: Array2<Complex64> = Array2::zeros((a.nrows(), b.ncols()).f());
    let values = out.as_slice_memory_order_mut().unwrap_or_default();
    let size = (2 * a.nrows(), b.ncols());
    let product = ArrayViewMut2::from_shape(size.f(), bytemuck::cast_slice_mut(values));
    blocked(
        product.expect("two parts of each value"),
        parts.len(),
        b,
        |c, b| set_matmul(c, parts.view(), b),
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(rows: usize, columns: usize, seed: usize) -> Array2<Complex64> {
        let value = |k: usize| ((k * 7919 + seed) % 101) as f64 / 50.0 - 1.0;
        Array2::from_shape_fn((rows, columns).f(), |(i, j)| {
            Complex64::new(value(i + 3 * j), value(5 * i + j))
        })
    }

    #[test]
    fn blocks_make_the_same_product() {
        let (a, b) = (values(600, 40, 1), values(40, 333, 2));
        let near = |x: &Array2<Complex64>, y: &Array2<Complex64>| {
            x.iter().zip(y).all(|(x, y)| (x - y).norm() < 1e-12)
        };
        assert!(near(
            &blocked_matmul(a.view(), b.view()),
            &matmul(a.view(), b.view())
        ));
        let c = values(600, 333, 3);
        for columns in [1, 40, 333] {
            let part = c.slice(s![.., ..columns]);
            let gram = blocked_gram(part);
            assert!(near(&gram, &matmul_h(part, part)));
            assert_eq!(gram, gram.t().mapv(|v| v.conj()));
        }
        assert!(near(
            &blocked_matmul_h(a.view(), c.view()),
            &matmul_h(a.view(), c.view())
        ));
        let (q, r) = tall_qr(c.slice(s![.., ..5]).to_owned().view()).unwrap();
        assert!(near(
            &matmul(q.view(), r.view()),
            &c.slice(s![.., ..5]).to_owned()
        ));
        let r = tall_r(c.slice(s![.., ..5]).to_owned().view()).unwrap();
        assert!(near(
            &matmul_h(r.view(), r.view()),
            &matmul_h(c.slice(s![.., ..5]), c.slice(s![.., ..5])).mapv(|v| v)
        ));
        let (inside, outside) = projected(q.view(), c.view());
        assert!(
            near(&inside, &matmul_h(q.view(), c.view()))
                && near(&outside, &(&c - &matmul(q.view(), inside.view())))
        );
        assert!(near(
            &matmul_h(q.view(), outside.view()),
            &Array2::zeros(inside.raw_dim())
        ));
        let real = b.mapv(|v| v.re);
        assert!(near(
            &blocked_matmul_mixed(&a, real.view()),
            &matmul(a.view(), real.mapv(|v| Complex64::new(v, 0.0)).view())
        ));
    }
}
