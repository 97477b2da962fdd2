//! The data of structured refinement: the compressed data once residual terms and
//! out-of-band poles are taken out, and the way back to pairs.

use crate::damping::basis::basis;
use crate::damping::gram::Beside;
use crate::data::columns::Columns;
use crate::data::inner_products::{inner, sum_of_squares};
use crate::shapes::alternation::add_products;
use crate::shapes::limits;
use crate::shapes::line_products::background;
use crate::shapes::line_products::LineProducts;
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_gram, blocked_matmul_h, blocked_matmul_mixed, projected};
use chladni_linalg::{cholesky, matmul, solve_hermitian, wide, LinalgError};
use ndarray::{Array2, ArrayView2, Axis, Order, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::borrow::Cow;

/// The data once residual terms and out-of-band poles are taken out: what the modes of
/// the band must explain.
pub(crate) struct Target<'a> {
    pub work: &'a Columns,
    /// Orthonormal basis of what stays free in every pair, (line, ·).
    free: Array2<Complex64>,
    /// The rest of the compressed data, (line, column).
    data: Array2<Complex64>,
    /// (column, own·other), rows orthonormal: from columns to pairs, the DOFs whose
    /// values are eliminated first.
    pub back: Cow<'a, Array2<f64>>,
    /// Number of DOFs on the eliminated and on the other side.
    pub sides: [usize; 2],
    /// Sum of squares of `data`.
    pub energy: f64,
}

impl<'a> Target<'a> {
    /// Poles `outside` the band keep free residues and, to first order, free positions:
    /// their columns and derivatives join the residual terms.
    pub fn new(
        work: &'a Columns,
        outside: &[Complex64],
        powers: &[i32],
        back: Cow<'a, Array2<f64>>,
        sides: [usize; 2],
    ) -> Result<Self, LinalgError> {
        let free = background(work, outside, powers)?;
        let (_, data) = projected(free.view(), work.b.view());
        Ok(Self {
            energy: sum_of_squares(&data),
            work,
            free,
            data,
            back,
            sides,
        })
    }

    /// The same with the eliminated DOFs turned into as few as carry all the data: shapes
    /// enter the search through inner products alone, and those of (column, other) pairs
    /// over all DOFs keep G = MMᵀ = LLᵀ when M gives way to L. `None` where that would
    /// not make them fewer.
    pub fn condensed(&self) -> Option<Target<'a>> {
        let [own, other] = self.sides;
        let size = self.back.nrows() * other;
        if own < 2 * size {
            return None;
        }
        let all = self.back.to_shape(((size, own), Order::F)).ok()?;
        let blocks: Vec<ArrayView2<f64>> = all
            .axis_chunks_iter(Axis(1), own.div_ceil(tol::PASS_GROUPS))
            .collect();
        let parts: Vec<Array2<f64>> = blocks
            .into_par_iter()
            .map(|block| matmul(block, block.t()))
            .collect();
        let gram = parts.into_iter().reduce(|sum, part| sum + part)?;
        let factor = cholesky(gram.view()).ok()?;
        let back = factor
            .to_shape(((self.back.nrows(), size * other), Order::F))
            .ok()?
            .to_owned();
        Some(Target {
            free: self.free.clone(),
            data: self.data.clone(),
            back: Cow::Owned(back),
            sides: [size, other],
            ..*self
        })
    }

    /// Columns with what is free taken out.
    pub fn outside(&self, columns: &Array2<Complex64>) -> Array2<Complex64> {
        projected(self.free.view(), columns.view()).1
    }

    /// Residues ψ_i·L_j of every pair on the compressed columns, (mode, column).
    ///
    /// * `shape`, `participation`: (mode, own) and (mode, other)
    pub fn compressed(
        &self,
        shape: &Array2<Complex64>,
        participation: &Array2<Complex64>,
    ) -> Array2<Complex64> {
        let [own, other] = self.sides;
        let size = own.div_ceil(tol::PASS_GROUPS).max(1);
        let backs = self.back.axis_chunks_iter(Axis(1), size * other);
        let blocks: Vec<_> = shape.axis_chunks_iter(Axis(1), size).zip(backs).collect();
        let parts: Vec<Array2<Complex64>> = blocks
            .into_par_iter()
            .map(|(shape, back)| {
                let residues = residues(shape, participation.view());
                blocked_matmul_mixed(&residues, back.t())
            })
            .collect();
        let none = Array2::zeros((shape.nrows(), self.back.nrows()));
        parts.iter().fold(none, |sum, part| sum + part)
    }

    /// columnsᴴ · data of every pair, (column, own·other).
    pub fn against(&self, columns: &Array2<Complex64>) -> Array2<Complex64> {
        blocked_matmul_mixed(
            &blocked_matmul_h(columns.view(), self.data.view()),
            self.back.view(),
        )
    }
}

/// Residues ψ_i·L_j of all modes, (mode, own·other).
pub(crate) fn residues(
    shape: ArrayView2<Complex64>,
    participation: ArrayView2<Complex64>,
) -> Array2<Complex64> {
    let size = (shape.nrows(), shape.ncols() * participation.ncols());
    let mut residues = Array2::zeros(size.f());
    let pairs = shape.columns().into_iter().flat_map(|own| {
        participation
            .columns()
            .into_iter()
            .map(move |other| (own, other))
    });
    for (mut column, (own, other)) in residues.columns_mut().into_iter().zip(pairs) {
        let products = own.into_iter().zip(other).map(|(a, b)| a * b);
        column
            .iter_mut()
            .zip(products)
            .for_each(|(value, product)| *value = product);
    }
    residues
}

/// Products over lines at one set of poles: F the pole columns, D their derivatives, B
/// the compressed data.
#[derive(Clone)]
pub(crate) struct Products {
    pub lines: LineProducts,
    /// FᴴB over DᴴB, (2·mode, column).
    against: Array2<Complex64>,
}

/// The best shapes for given participations, and what the data say along and across them.
#[derive(Clone)]
pub(crate) struct Shapes {
    /// (mode, own).
    pub shape: Array2<Complex64>,
    /// Energy that they explain.
    pub explained: f64,
    /// Σ_i ψ̄_i·(FᴴB)_ij, (mode, other).
    pub along_shape: Array2<Complex64>,
    /// Σ_ij ψ̄_i·L̄_j·(DᴴB)_ij, (mode, 1).
    pub along_both: Array2<Complex64>,
}

impl Products {
    pub fn new(target: &Target, lambda: &[Complex64]) -> Self {
        // the data have nothing inside what is free
        let others = [target.data.view(), target.free.view()];
        let (gram, [against, free]) = Beside::new(target.work, &[], others).products(lambda, true);
        Self {
            against,
            lines: LineProducts::outside_of(&gram, &free),
        }
    }

    /// Shapes ψ = G⁻¹·Σ_j L̄_j(FᴴB)_j with their sums, block by block of the eliminated
    /// side: no product with all pairs is kept.
    pub fn shapes(
        &self,
        target: &Target,
        participation: &Array2<Complex64>,
        gram_inverse: &Array2<Complex64>,
        real: bool,
    ) -> Shapes {
        let other = target.sides[1];
        let mut all = Shapes {
            shape: Array2::zeros((participation.nrows(), target.sides[0]).f()),
            explained: 0.0,
            along_shape: Array2::zeros(participation.dim()),
            along_both: Array2::zeros((participation.nrows(), 1)),
        };
        if participation.is_empty() {
            return all;
        }
        let by_other: Vec<Complex64> = participation.t().iter().copied().collect();
        let blocks: Vec<ArrayView2<f64>> = target
            .back
            .axis_chunks_iter(Axis(1), limits::TARGET_BLOCK * other)
            .collect();
        let parts: Vec<Shapes> = blocks
            .into_par_iter()
            .map(|back| {
                self.block(
                    &blocked_matmul_mixed(&self.against, back),
                    &by_other,
                    gram_inverse,
                    real,
                )
            })
            .collect();
        for (part, mut shape) in parts.iter().zip(
            all.shape
                .axis_chunks_iter_mut(Axis(1), limits::TARGET_BLOCK),
        ) {
            shape.assign(&part.shape);
            all.explained += part.explained;
            all.along_shape += &part.along_shape;
            all.along_both += &part.along_both;
        }
        all
    }

    /// The same for some DOFs of the eliminated side, `values` = (FᴴB over DᴴB) of their
    /// pairs.
    ///
    /// * `participation`: of all modes for each other DOF in turn
    fn block(
        &self,
        values: &Array2<Complex64>,
        participation: &[Complex64],
        gram_inverse: &Array2<Complex64>,
        real: bool,
    ) -> Shapes {
        let n = gram_inverse.nrows();
        let other = participation.len() / n;
        let own = values.ncols() / other;
        let values = values.as_slice_memory_order().expect("a product");
        let of_own = || values.chunks_exact(2 * n * other);
        let mut right = vec![Complex64::ZERO; n * own];
        wide(
            #[inline(always)]
            || {
                for (right, values) in right.chunks_exact_mut(n).zip(of_own()) {
                    let pairs = values.chunks_exact(2 * n);
                    for (value, factor) in pairs.zip(participation.chunks_exact(n)) {
                        add_products(&mut *right, factor, &value[..n]);
                    }
                }
            },
        );
        if real {
            right.iter_mut().for_each(|value| value.im = 0.0);
        }
        let right = Array2::from_shape_vec((n, own).f(), right).expect("a value for each DOF");
        let shape = matmul(gram_inverse.view(), right.view());
        let explained = inner(shape.view(), right.view());
        let shapes: Vec<Complex64> = shape.t().iter().copied().collect();
        let mut along_shape = vec![Complex64::ZERO; n * other];
        let mut along_both = vec![Complex64::ZERO; n];
        wide(
            #[inline(always)]
            || {
                let mut both = vec![Complex64::ZERO; n];
                for (shape, values) in shapes.chunks_exact(n).zip(of_own()) {
                    let pairs = values
                        .chunks_exact(2 * n)
                        .zip(participation.chunks_exact(n));
                    for ((value, factor), along_shape) in pairs.zip(along_shape.chunks_exact_mut(n))
                    {
                        add_products(&mut *along_shape, shape, &value[..n]);
                        for ((both, shape), factor) in both.iter_mut().zip(shape).zip(factor) {
                            *both = shape * factor;
                        }
                        add_products(&mut along_both, &both, &value[n..]);
                    }
                }
            },
        );
        let columns = |count: usize, values: Vec<Complex64>| {
            Array2::from_shape_vec((n, count).f(), values).expect("a value for each DOF")
        };
        Shapes {
            shape,
            explained,
            along_shape: columns(other, along_shape),
            along_both: columns(1, along_both),
        }
    }
}

/// Residues of every column, free, at given poles, and the sum of squares they leave.
pub(crate) fn free_residues(
    target: &Target,
    lambda: &[Complex64],
) -> Result<(Array2<Complex64>, f64), LinalgError> {
    let f = target.outside(&basis(target.work, lambda, &[]));
    let against = blocked_matmul_h(f.view(), target.data.view());
    let residues = solve_hermitian(blocked_gram(f.view()).view(), against.view())?;
    let left = target.energy - inner(residues.view(), against.view());
    Ok((residues, left))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Damping;

    #[test]
    fn residues_on_columns_are_those_of_all_pairs() {
        let work = Columns {
            x: vec![0.1, 0.2],
            g: vec![1.0; 2],
            b: Array2::zeros((2, 3)),
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let value = |i: usize, j: usize| ((7 * i + 3 * j) % 11) as f64 - 5.0;
        let complex = |(i, j): (usize, usize)| Complex64::new(value(i, j), value(j + 1, i));
        // more DOFs than groups of them, and fewer
        for (own, other) in [(21, 2), (3, 4), (1, 1)] {
            let back = Array2::from_shape_fn((3, own * other).f(), |(i, j)| value(i, j));
            let target = Target {
                work: &work,
                free: Array2::zeros((2, 0)),
                data: work.b.clone(),
                back: Cow::Borrowed(&back),
                sides: [own, other],
                energy: 0.0,
            };
            let shape = Array2::from_shape_fn((2, own).f(), complex);
            let participation = Array2::from_shape_fn((2, other), complex);
            let compressed = target.compressed(&shape, &participation);
            let direct = Array2::from_shape_fn((2, 3), |(n, c)| -> Complex64 {
                let pair = |l: usize| {
                    let residue = shape[[n, l / other]] * participation[[n, l % other]];
                    residue * back[[c, l]]
                };
                (0..own * other).map(pair).sum()
            });
            let near = |(a, b): (&Complex64, &Complex64)| (a - b).norm() < 1e-9;
            assert!(compressed.iter().zip(&direct).all(near), "{own} {other}");
        }
    }
}
