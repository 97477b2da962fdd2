//! A set in memory as the source of a fit. Its passes read groups of FRFs in parallel, each group
//! block by block.

use crate::data::columns::{line_energy, Columns};
use crate::data::error::FitError;
use crate::data::given_noise::given_noise;
use crate::data::layout::Weighting;
use crate::data::limits;
use crate::data::pair_weights::{NextWeights, NoiseSource, PairWeights};
use crate::data::products::{measured_basis, project, Projected};
use crate::data::reading::{energy, in_place, squares, visit};
use crate::data::screening::{FirstPass, Screened};
use crate::data::sketch::{Mixing, Sums};
use crate::data::source::{Source, Way};
use crate::tolerances as tol;
use chladni_frf::{Damping, Finding};
use chladni_linalg::add_matmul;
use ndarray::{Array1, Array2, ArrayView2, ArrayViewMut2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::ops::Range;

impl Screened<'_> {
    /// The FRFs in groups of [`Self::group_size`].
    pub fn groups(&self, least: usize) -> Vec<Range<usize>> {
        let (total, size) = (self.pairs.len(), self.group_size(least));
        (0..total)
            .step_by(size)
            .map(|first| first..(first + size).min(total))
            .collect()
    }

    /// Number of FRFs of a group: `least` at least, unless fewer than [`limits::GROUPS_LEAST`] groups
    /// would result; the last group may have fewer. It depends on nothing but the set, so that sums
    /// over groups have the same bits on any number of threads.
    pub fn group_size(&self, least: usize) -> usize {
        let total = self.pairs.len();
        let fewest = (total / limits::GROUP_FRFS).clamp(1, limits::GROUPS_LEAST);
        total.div_ceil((total / least).clamp(fewest, tol::PASS_GROUPS))
    }

    /// Reads a group. `see` gets a range of FRFs and their values, (real and imaginary part of each
    /// line in turn, FRF), not in work units but weighted.
    pub fn each_block(
        &self,
        group: Range<usize>,
        mut see: impl FnMut(Range<usize>, ArrayView2<f64>),
    ) {
        for first in group.clone().step_by(limits::BLOCK_FRFS) {
            let frfs = first..(first + limits::BLOCK_FRFS).min(group.end);
            let in_place = in_place(&self.frf.values, &self.pairs[frfs.clone()], &self.lines);
            match in_place.filter(|_| self.weighting.is_none()) {
                Some(block) => see(frfs, block),
                None => self.each_copy(
                    frfs,
                    |pair| self.weight_of(pair),
                    |frfs, block| see(frfs, block.view()),
                ),
            }
        }
    }

    /// Reads a group into blocks that `see` may change, each FRF times its `weight`.
    fn each_copy(
        &self,
        group: Range<usize>,
        weight: impl Fn((usize, usize)) -> f64,
        mut see: impl FnMut(Range<usize>, ArrayViewMut2<f64>),
    ) {
        let rows = 2 * self.lines.len();
        let mut scratch = vec![0.0; rows * limits::BLOCK_FRFS.min(group.len())];
        for first in group.clone().step_by(limits::BLOCK_FRFS) {
            let frfs = first..(first + limits::BLOCK_FRFS).min(group.end);
            let block = &mut scratch[..rows * frfs.len()];
            for (frf, &pair) in block.chunks_exact_mut(rows).zip(&self.pairs[frfs.clone()]) {
                let weight = weight(pair);
                visit(
                    &self.frf.values,
                    pair,
                    &self.lines,
                    frf.chunks_exact_mut(2),
                    |out, value| (out[0], out[1]) = (value.re * weight, value.im * weight),
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
    /// * `coefficients`: adds those of one FRF (position among the pairs) to zeros, one per column
    pub fn misfit(
        &self,
        basis: &Array2<f64>,
        coefficients: impl Fn(usize, &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let columns = basis.ncols();
        let inverse = -self.factor().inv();
        // in measured units, with the opposite sign
        let mut model = basis.clone();
        for mut column in model.columns_mut() {
            for mut line in column.exact_chunks_mut(2) {
                let value = inverse * Complex64::new(line[0], line[1]);
                (line[0], line[1]) = (value.re, value.im);
            }
        }
        let unit = self.factor().norm_sqr();
        let of_group = |group: Range<usize>| {
            let mut factors = vec![0.0; columns * limits::BLOCK_FRFS];
            let mut sums = Vec::with_capacity(group.len());
            self.each_copy(
                group,
                |_| 1.0,
                |frfs, mut values| {
                    let factors = &mut factors[..columns * frfs.len()];
                    factors.fill(0.0);
                    factors
                        .chunks_exact_mut(columns.max(1))
                        .zip(frfs.clone())
                        .for_each(|(of_frf, l)| coefficients(l, of_frf));
                    let factors = ArrayView2::from_shape((columns, frfs.len()).f(), factors)
                        .expect("one per column and FRF");
                    add_matmul(values.view_mut(), model.view(), factors);
                    sums.extend(values.columns().into_iter().map(|frf| {
                        unit * squares(frf.to_slice().expect("one FRF after the other"))
                    }));
                },
            );
            sums
        };
        self.groups(limits::GROUP_FRFS)
            .into_par_iter()
            .flat_map_iter(of_group)
            .collect()
    }
}

impl Source for Screened<'_> {
    type Stop = FitError;

    /// Count sketch: each FRF is added with a random sign to one of a few columns, scaled
    /// so that the noise keeps its variance. Sets of few FRFs are their own sketch.
    fn sketch(&self, seed: u64) -> (Columns, Array1<f64>) {
        let (total, width) = (self.pairs.len(), self.effort.sketch_columns.max(1));
        if total <= width {
            let work = self.work();
            let energy = line_energy(&work.b) * total as f64;
            return (work, energy);
        }
        let scale = (width as f64 / total as f64).sqrt() * self.factor();
        let scaled = |sums: &Sums| {
            let columns = sums.columns.mapv(|sum| sum * scale);
            (columns, &sums.line_energy * self.factor().norm_sqr())
        };
        let compute = || {
            scaled(&Sums::new(
                &self.frf.values,
                &self.pairs,
                &self.lines,
                &Mixing::even(total, width, seed),
                self.weighting.as_ref().map(|weighting| &weighting.weights),
            ))
        };
        let (columns, energy) = self.first_pass.of(seed, scaled).unwrap_or_else(compute);
        (self.axis().with_columns(columns), energy)
    }

    fn end_first_pass(&self) {
        // for many FRFs the sums are a small part of the data, and take long to compute
        if self.pairs.len() < limits::SUMS_KEPT_FRFS {
            self.first_pass.end();
        }
    }

    fn projected(
        &self,
        way: &Way,
        q: Array2<Complex64>,
        energy: &Array1<f64>,
    ) -> Result<Projected, FitError> {
        let weights = way.weights();
        let basis = measured_basis(self, &q, weights);
        drop(q);
        Ok(project(self, basis, energy, weights)?)
    }

    fn way(&self) -> Option<&Way> {
        None
    }

    fn without(&self, places: &[usize]) -> Self {
        let (layout, kept) = self.layout.without(places);
        Self {
            layout,
            first_pass: self.first_pass.select(&kept),
            ..*self
        }
    }

    fn in_law(&self, law: Damping) -> Self {
        let mut other = self.clone();
        other.layout.law = law;
        other
    }

    fn given_noise(&self) -> Option<(Vec<f64>, NoiseSource)> {
        given_noise(self)
    }

    fn weighted(
        &self,
        weights: Option<(PairWeights, Option<NoiseSource>)>,
        still_to_try: NextWeights,
    ) -> Result<Self, FitError> {
        let mut other = self.clone();
        let layout = &mut other.layout;
        layout.next_weights = still_to_try;
        let measured_rms = layout.measured_rms();
        if weights.is_none() && layout.weighting.is_none() {
            return Ok(other);
        }
        layout.weighting = weights.map(|(weights, noise_source)| Weighting {
            weights,
            rms: measured_rms,
            noise_source,
        });
        let weighted_energy = |&pair: &(usize, usize)| {
            let weight = layout.weight_of(pair);
            energy(&self.frf.values, pair, &layout.lines, weight).sum
        };
        layout.energy = layout.pairs.par_iter().map(weighted_energy).collect();
        layout.rms = match layout.weighting {
            Some(_) => layout.mean_square().sqrt(),
            None => measured_rms,
        };
        other.first_pass = FirstPass::default();
        Ok(other)
    }

    fn noted(&self, finding: Option<Finding>) -> Self {
        let mut other = self.clone();
        other.layout.warnings.extend(finding);
        other
    }

    fn values(&self) -> Option<&Screened<'_>> {
        Some(self)
    }
}
