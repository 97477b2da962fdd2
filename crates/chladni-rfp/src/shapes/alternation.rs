//! The two halves of the low-rank refit: all shapes at given participations, all
//! participations at given shapes, each an exact linear problem (theory.md, eq. 18).
//! Blocks of responses on all threads, sums in fixed order.

use crate::data::information::answer;
use crate::data::inner_products::inner;
use crate::shapes::limits;
use crate::shapes::residues::{ridge, Residues};
use chladni_linalg::blocked::blocked_matmul;
use chladni_linalg::{matmul, wide, LinalgError};
use ndarray::{s, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// One row per term, with the weights and right-hand sides that do not change.
pub(crate) struct Problem<'a> {
    residues: &'a Residues<'a>,
    owner: &'a [usize],
    weight: Array2<Complex64>,
}

/// The right-hand sides of its two halves.
pub(crate) struct Halves<'a> {
    problem: &'a Problem<'a>,
    /// K·r̂, the terms of a pair one after another; the pairs of a response, too.
    weighted: Vec<Complex64>,
    /// r̂ᴴK·r̂ over all pairs.
    pub total: f64,
}

impl<'a> Problem<'a> {
    /// Terms share the weight of their pole.
    pub fn new(residues: &'a Residues, owner: &'a [usize]) -> Self {
        let weight = Array2::from_shape_fn((owner.len(), owner.len()), |(a, b)| {
            residues.weight[[owner[a], owner[b]]]
        });
        Self {
            residues,
            owner,
            weight,
        }
    }

    /// Normal matrix of one DOF whose partners are `kept`.
    fn normal(&self, fixed: &Array2<Complex64>, kept: &[usize]) -> Array2<Complex64> {
        let part = fixed.select(Axis(1), kept);
        ridge(&(&self.weight * &matmul(part.mapv(|v| v.conj()).view(), part.t())))
    }

    /// Rise of the sum of squares of low-rank residues over the free ones.
    pub fn misfit(&self, shape: &Array2<Complex64>, participation: &Array2<Complex64>) -> f64 {
        let references = self.residues.present.ncols();
        let blocks: Vec<_> = self
            .residues
            .values
            .axis_chunks_iter(Axis(1), limits::ALTERNATION_BLOCK * references)
            .enumerate()
            .collect();
        let parts: Vec<f64> = blocks
            .into_par_iter()
            .map(|(number, block)| {
                let mut difference = block.to_owned();
                for (pair, mut values) in difference.columns_mut().into_iter().enumerate() {
                    let (i, j) = (
                        number * limits::ALTERNATION_BLOCK + pair / references,
                        pair % references,
                    );
                    if !self.residues.present[[i, j]] {
                        values.fill(Complex64::default());
                        continue;
                    }
                    for (term, &n) in self.owner.iter().enumerate() {
                        values[n] -= shape[[term, i]] * participation[[term, j]];
                    }
                }
                let weighted = matmul(self.residues.weight.view(), difference.view());
                inner(difference.view(), weighted.view())
            })
            .collect();
        parts.iter().sum()
    }
}

impl<'a> Halves<'a> {
    /// K·r̂ per pair, once.
    pub fn new(problem: &'a Problem) -> Self {
        let Problem {
            residues, owner, ..
        } = problem;
        let of_poles = blocked_matmul(residues.weight.view(), residues.values.view());
        let total = inner(residues.values.view(), of_poles.view());
        let mut weighted = Vec::with_capacity(owner.len() * of_poles.ncols());
        for of_pair in of_poles.columns() {
            weighted.extend(owner.iter().map(|&n| of_pair[n]));
        }
        Self {
            problem,
            weighted,
            total,
        }
    }

    /// The weighted residues of blocks of responses, with the first response of each.
    fn blocks(&self) -> Vec<(usize, &[Complex64])> {
        let pairs = limits::ALTERNATION_BLOCK * self.problem.residues.present.ncols();
        self.weighted
            .chunks(pairs * self.problem.owner.len())
            .enumerate()
            .map(|(number, block)| (number * limits::ALTERNATION_BLOCK, block))
            .collect()
    }

    /// Adds conj(`fixed`)·residues of each measured pair of a block to `sums`, which are by DOF as
    /// `fixed` is.
    ///
    /// * `dofs`: place in `sums` and place in `fixed` of the pair (response, reference)
    fn add_pairs(
        &self,
        (first, block): (usize, &[Complex64]),
        sums: &mut [Complex64],
        fixed: &[Complex64],
        dofs: impl Fn([usize; 2]) -> [usize; 2],
    ) {
        let Problem {
            residues, owner, ..
        } = self.problem;
        let (references, terms) = (residues.present.ncols(), owner.len());
        wide(
            #[inline(always)]
            || {
                for (pair, values) in block.chunks_exact(terms).enumerate() {
                    let at = [first + pair / references, pair % references];
                    if residues.present[at] {
                        let [sum, factor] = dofs(at).map(|dof| dof * terms);
                        let factor = &fixed[factor..][..terms];
                        add_products(&mut sums[sum..][..terms], factor, values);
                    }
                }
            },
        );
    }

    /// Best shapes (row, response) for given participations.
    pub fn shapes(
        &self,
        participation: &Array2<Complex64>,
    ) -> Result<Array2<Complex64>, LinalgError> {
        let (responses, references) = self.problem.residues.present.dim();
        let terms = self.problem.owner.len();
        let fixed = by_dof(participation);
        let mut rights = vec![Complex64::ZERO; terms * responses];
        let outs = rights.par_chunks_mut(limits::ALTERNATION_BLOCK * terms);
        outs.zip(self.blocks()).for_each(|(out, block)| {
            self.add_pairs(block, out, &fixed, |[i, j]| [i - block.0, j]);
        });
        let partners = |i: usize| {
            (0..references)
                .filter(|&j| self.problem.residues.present[[i, j]])
                .collect()
        };
        self.solved(participation, &of_dofs(terms, rights), partners)
    }

    /// Best participations (row, reference) for given shapes, and what both together
    /// explain of [`Self::total`].
    pub fn participations(
        &self,
        shape: &Array2<Complex64>,
    ) -> Result<(Array2<Complex64>, f64), LinalgError> {
        let (responses, references) = self.problem.residues.present.dim();
        let terms = self.problem.owner.len();
        let fixed = by_dof(shape);
        let of_block = |block: (usize, &[Complex64])| {
            let mut right = vec![Complex64::ZERO; terms * references];
            self.add_pairs(block, &mut right, &fixed, |[i, j]| [j, i]);
            of_dofs(terms, right)
        };
        let parts: Vec<_> = self.blocks().into_par_iter().map(of_block).collect();
        let mut rights = Array2::zeros((terms, references).f());
        parts.iter().for_each(|part| rights += part);
        let partners = |j: usize| {
            (0..responses)
                .filter(|&i| self.problem.residues.present[[i, j]])
                .collect()
        };
        let best = self.solved(shape, &rights, partners)?;
        let explained = inner(rights.view(), best.view());
        Ok((best, explained))
    }

    /// One small normal system per DOF; where every pair was measured, one for all.
    fn solved(
        &self,
        fixed: &Array2<Complex64>,
        rights: &Array2<Complex64>,
        partners: impl Fn(usize) -> Vec<usize>,
    ) -> Result<Array2<Complex64>, LinalgError> {
        if self.problem.residues.present.iter().all(|p| *p) {
            return answer(
                self.problem.normal(fixed, &partners(0)).view(),
                rights.view(),
            );
        }
        let mut out = Array2::zeros(rights.dim().f());
        for a in 0..rights.ncols() {
            let solution = answer(
                self.problem.normal(fixed, &partners(a)).view(),
                rights.slice(s![.., a..a + 1]),
            )?;
            out.slice_mut(s![.., a..a + 1]).assign(&solution);
        }
        Ok(out)
    }
}

/// Values (term, DOF), the terms of a DOF one after another.
fn by_dof(values: &Array2<Complex64>) -> Vec<Complex64> {
    values.t().iter().copied().collect()
}

/// Values (term, DOF) from those of `terms` terms of each DOF.
fn of_dofs(terms: usize, values: Vec<Complex64>) -> Array2<Complex64> {
    let size = (terms, values.len() / terms);
    Array2::from_shape_vec(size.f(), values).expect("as many values of each DOF")
}

/// sum += conj(factor)·value, term by term.
#[inline(always)]
pub(super) fn add_products<'a>(
    sum: impl IntoIterator<Item = &'a mut Complex64>,
    factor: impl IntoIterator<Item = &'a Complex64>,
    value: impl IntoIterator<Item = &'a Complex64>,
) {
    for ((sum, factor), value) in sum.into_iter().zip(factor).zip(value) {
        *sum += factor.conj() * value;
    }
}
