//! Complex matrices taken apart into real parts, for products with single columns.
//!
//! A product of matrices first packs both: with a single drive, and with few of the
//! columns, that takes longer than the sums.

use crate::tolerances::LANES;
use ndarray::ArrayView2;
use num_complex::Complex64;

/// Rows of a column, their real parts apart from their imaginary ones.
#[derive(Clone, Copy)]
struct Lanes {
    re: [f64; LANES],
    im: [f64; LANES],
}

impl Lanes {
    const ZERO: Self = Self {
        re: [0.0; LANES],
        im: [0.0; LANES],
    };

    /// Adds value·factor to each sum, in one rounding: one instruction where the processor has
    /// fused sums, as most since 2013 do. Others call a function, and `mls` takes ten times as
    /// long there.
    #[inline(always)]
    fn add(&mut self, values: &Self, factor: f64) {
        for k in 0..LANES {
            self.re[k] = values.re[k].mul_add(factor, self.re[k]);
            self.im[k] = values.im[k].mul_add(factor, self.im[k]);
        }
    }
}

/// A matrix, some rows after others; of these column after column.
pub(crate) struct Split {
    columns: usize,
    lanes: Vec<Lanes>,
}

impl Split {
    /// The same matrix.
    pub(crate) fn new(matrix: ArrayView2<Complex64>) -> Self {
        let (rows, columns) = matrix.dim();
        let mut lanes = vec![Lanes::ZERO; rows.div_ceil(LANES) * columns];
        for (k, row) in matrix.rows().into_iter().enumerate() {
            let block = &mut lanes[k / LANES * columns..][..columns];
            for (lanes, value) in block.iter_mut().zip(row) {
                (lanes.re[k % LANES], lanes.im[k % LANES]) = (value.re, value.im);
            }
        }
        Self { columns, lanes }
    }

    /// Adds the columns that are named, each times its factor, to `sums`.
    #[inline(always)]
    pub(crate) fn add_terms(
        &self,
        terms: impl Iterator<Item = (usize, Complex64)> + Clone,
        sums: &mut [Complex64],
    ) {
        let blocks = self.lanes.chunks_exact(self.columns.max(1));
        for (block, sums) in blocks.zip(sums.chunks_mut(LANES)) {
            // Σ a·Re b and Σ a·Im b
            let (mut of_re, mut of_im) = (Lanes::ZERO, Lanes::ZERO);
            for (column, factor) in terms.clone() {
                let values = &block[column];
                of_re.add(values, factor.re);
                of_im.add(values, factor.im);
            }
            for (k, sum) in sums.iter_mut().enumerate() {
                sum.re += of_re.re[k] - of_im.im[k];
                sum.im += of_re.im[k] + of_im.re[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// Sizes that fill their last rows and such that do not; all columns, and one.
    #[test]
    fn products_are_those_of_the_matrix() {
        for (rows, columns) in [(16, 3), (21, 5), (3, 1)] {
            let matrix = Array2::from_shape_fn((rows, columns), |(k, j)| {
                Complex64::new((k + 2 * j) as f64, (3 * k) as f64 - j as f64)
            });
            let split = Split::new(matrix.view());
            for first in [0, columns - 1] {
                let terms = (first..columns).map(|j| (j, Complex64::new(j as f64, 1.0)));
                let mut sums = vec![Complex64::I; rows];
                split.add_terms(terms.clone(), &mut sums);
                for (sum, row) in sums.iter().zip(matrix.rows()) {
                    let values = terms.clone().map(|(j, factor)| row[j] * factor);
                    assert_eq!(*sum, Complex64::I + values.sum::<Complex64>());
                }
            }
        }
    }
}
