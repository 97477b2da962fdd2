//! Inner products of matrices that lie column after column in memory. Row by row they would take
//! many times as long.

use crate::data::reading::squares;
use ndarray::{Array2, ArrayView2};
use num_complex::Complex64;

/// Σ|a|².
pub(crate) fn sum_of_squares(a: &Array2<Complex64>) -> f64 {
    match a.as_slice_memory_order() {
        Some(values) => squares(bytemuck::cast_slice(values)),
        None => a.iter().map(Complex64::norm_sqr).sum(),
    }
}

/// Σ Re āb.
pub(crate) fn inner(a: ArrayView2<Complex64>, b: ArrayView2<Complex64>) -> f64 {
    let products = |(a, b): (&Complex64, &Complex64)| a.re * b.re + a.im * b.im;
    let columns = a.columns().into_iter().zip(b.columns());
    columns
        .map(|(a, b)| a.iter().zip(b).map(products).sum::<f64>())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::ShapeBuilder;

    #[test]
    fn sums_do_not_depend_on_the_layout() {
        let value = |(i, j): (usize, usize)| Complex64::new(1.0 + i as f64, j as f64 - 2.0);
        let (rows, columns) = (
            Array2::from_shape_fn((3, 5), value),
            Array2::from_shape_fn((3, 5).f(), value),
        );
        // 5·(1 + 4 + 9) + 3·(4 + 1 + 0 + 1 + 4)
        for a in [&rows, &columns] {
            assert_eq!(sum_of_squares(a), 100.0);
            assert_eq!(inner(a.view(), rows.view()), 100.0);
        }
        let apart = columns.slice_move(ndarray::s![..;2, ..]);
        assert_eq!(sum_of_squares(&apart), 5.0 * 10.0 + 2.0 * 10.0);
        assert_eq!(
            inner(apart.view(), apart.mapv(|v| v * Complex64::I).view()),
            0.0
        );
    }
}
