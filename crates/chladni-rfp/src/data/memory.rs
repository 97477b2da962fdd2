//! Passes over the data, FRF by FRF: groups that run side by side, each read block by
//! block.

use crate::data::reading::{in_place, squares, visit};
use crate::data::screening::Screened;
use crate::tolerances as tol;
use chladni_frf::FrfValues;
use chladni_linalg::add_matmul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::ops::Range;

impl Screened<'_> {
    /// The FRFs in groups whose number depends on nothing but theirs, so that sums over
    /// them have the same bits on any number of threads.
    pub fn groups(&self) -> Vec<Range<usize>> {
        let (total, size) = (self.pairs.len(), self.group_size());
        (0..total)
            .step_by(size)
            .map(|first| first..(first + size).min(total))
            .collect()
    }

    /// FRFs of a group; the last may have fewer.
    pub fn group_size(&self) -> usize {
        self.pairs
            .len()
            .div_ceil(tol::PASS_GROUPS)
            .max(tol::GROUP_FRFS)
    }

    /// Reads a group: `see` is given a range of FRFs and their values, (real and
    /// imaginary part of each line in turn, FRF), not yet in work units.
    pub fn each_block(
        &self,
        group: Range<usize>,
        mut see: impl FnMut(Range<usize>, ArrayView2<f64>),
    ) {
        for first in group.clone().step_by(tol::BLOCK_FRFS) {
            let frfs = first..(first + tol::BLOCK_FRFS).min(group.end);
            match in_place(&self.frf.values, &self.pairs[frfs.clone()], &self.lines) {
                Some(block) => see(frfs, block),
                None => self.each_copy(&self.frf.values, frfs, |frfs, block| {
                    see(frfs, block.view())
                }),
            }
        }
    }

    /// The same with blocks that can be changed.
    fn each_copy(
        &self,
        values: &FrfValues,
        group: Range<usize>,
        mut see: impl FnMut(Range<usize>, ArrayViewMut2<f64>),
    ) {
        let rows = 2 * self.lines.len();
        let mut scratch = vec![0.0; rows * tol::BLOCK_FRFS.min(group.len())];
        for first in group.clone().step_by(tol::BLOCK_FRFS) {
            let frfs = first..(first + tol::BLOCK_FRFS).min(group.end);
            let block = &mut scratch[..rows * frfs.len()];
            for (frf, &pair) in block.chunks_exact_mut(rows).zip(&self.pairs[frfs.clone()]) {
                visit(
                    values,
                    pair,
                    &self.lines,
                    frf.chunks_exact_mut(2),
                    |out, value| (out[0], out[1]) = (value.re, value.im),
                );
            }
            see(
                frfs.clone(),
                ArrayViewMut2::from_shape((rows, frfs.len()).f(), block).expect("one per value"),
            );
        }
    }

    /// Sum of squares of each measured FRF less basis·coefficients, in one pass.
    ///
    /// * `basis`: (real and imaginary part of each line, column)
    /// * `coefficients`: adds those of one FRF (position among the pairs), one per column
    pub fn misfit(
        &self,
        basis: &Array2<f64>,
        coefficients: impl Fn(usize, &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let columns = basis.ncols();
        let inverse = -self.factor().inv();
        let mut model = basis.clone();
        for mut column in model.columns_mut() {
            for mut line in column.exact_chunks_mut(2) {
                let value = inverse * Complex64::new(line[0], line[1]);
                (line[0], line[1]) = (value.re, value.im);
            }
        }
        let unit = self.factor().norm_sqr();
        let of_group =
            |group: Range<usize>| {
                let mut factors = vec![0.0; columns * tol::BLOCK_FRFS];
                let mut sums = Vec::with_capacity(group.len());
                self.each_copy(&self.measured().values, group, |frfs, mut left| {
                    let factors = &mut factors[..columns * frfs.len()];
                    factors.fill(0.0);
                    factors
                        .chunks_exact_mut(columns.max(1))
                        .zip(frfs.clone())
                        .for_each(|(own, l)| coefficients(l, own));
                    let factors = ArrayView2::from_shape((columns, frfs.len()).f(), factors)
                        .expect("one per column and FRF");
                    add_matmul(left.view_mut(), model.view(), factors);
                    sums.extend(left.columns().into_iter().map(|frf| {
                        unit * squares(frf.to_slice().expect("one FRF after the other"))
                    }));
                });
                sums
            };
        self.groups()
            .into_par_iter()
            .flat_map_iter(of_group)
            .collect()
    }
}
