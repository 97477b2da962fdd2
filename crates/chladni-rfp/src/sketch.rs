//! First pass over the data: the count sketch (theory.md, eq. 6).

use crate::reading::visit;
use crate::screen::Screened;
use crate::tolerances as tol;
use crate::work::{line_energy, Work};
use ndarray::{s, Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::ops::Range;

impl Screened<'_> {
    /// First pass: count sketch (each FRF added with a random sign to one of a few columns, scaled so that the noise
    /// keeps its variance) and the energy of each line over all FRFs.
    pub fn sketch(&self, seed: u64) -> (Work, Array1<f64>) {
        let (total, width) = (self.pairs.len(), self.effort.sketch_columns.max(1));
        if total <= width {
            let work = self.work();
            let energy = line_energy(&work.b) * total as f64;
            return (work, energy);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut order: Vec<usize> = (0..total).collect();
        order.shuffle(&mut rng);
        let mut bucket = vec![0; total];
        for (position, &l) in order.iter().enumerate() {
            bucket[l] = position % width;
        }
        let sign: Vec<f64> = (0..total).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
        let chunks: Vec<Range<usize>> =
            (0..self.lines.len()).step_by(tol::BLOCK_LINES).map(|a| a..(a + tol::BLOCK_LINES).min(self.lines.len())).collect();
        let parts: Vec<(Vec<Complex64>, Vec<f64>)> = chunks
            .par_iter()
            .map(|rows| {
                let (mut sums, mut energy) = (vec![Complex64::default(); rows.len() * width], vec![0.0; rows.len()]);
                let lines = &self.lines[rows.clone()];
                for ((&pair, &bucket), &sign) in self.pairs.iter().zip(&bucket).zip(&sign) {
                    let sums = &mut sums[bucket * rows.len()..(bucket + 1) * rows.len()];
                    visit(&self.frf.values, pair, lines, sums.iter_mut().zip(&mut energy), |(sum, energy), value| {
                        *sum += sign * value;
                        *energy += value.norm_sqr();
                    });
                }
                (sums, energy)
            })
            .collect();
        let factor = self.factor();
        let scale = (width as f64 / total as f64).sqrt() * factor;
        let mut b = Array2::zeros((self.lines.len(), width).f());
        let mut energy = Array1::zeros(self.lines.len());
        for (rows, (sums, squares)) in chunks.into_iter().zip(parts) {
            let sums = Array2::from_shape_vec((rows.len(), width).f(), sums).expect("one per line and column");
            b.slice_mut(s![rows.clone(), ..]).zip_mut_with(&sums, |value, sum| *value = sum * scale);
            energy.slice_mut(s![rows]).assign(&(Array1::from(squares) * factor.norm_sqr()));
        }
        (Work { x: self.x.clone(), g: self.g.clone(), b }, energy)
    }
}
