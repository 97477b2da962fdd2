//! The data of structured refinement: the compressed data once residual terms and
//! out-of-band poles are taken out, and the way back to pairs.

use crate::damping::basis::basis;
use crate::damping::gram::Cauchy;
use crate::data::columns::Columns;
use crate::data::inner_products::{inner, sum_of_squares};
use crate::shapes::alternation::add_product;
use crate::shapes::limits;
use crate::shapes::line_products::background;
use crate::shapes::line_products::LineProducts;
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_matmul_h, blocked_matmul_mixed, projected};
use chladni_linalg::{cholesky, matmul, solve_hermitian, LinalgError};
use ndarray::{s, Array2, ArrayView2, Axis, Order, ShapeBuilder};
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

    /// columnsᴴ · data of every pair, (column, own·other).
    pub fn against(&self, columns: &Array2<Complex64>) -> Array2<Complex64> {
        blocked_matmul_mixed(
            &blocked_matmul_h(columns.view(), self.data.view()),
            self.back.view(),
        )
    }
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
        let cauchy = Cauchy::new(target.work, lambda, &[]);
        Self {
            against: blocked_matmul_h(cauchy.columns.view(), target.data.view()),
            lines: LineProducts::new(&cauchy, &target.free),
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
        let blocks: Vec<ArrayView2<f64>> = target
            .back
            .axis_chunks_iter(Axis(1), limits::TARGET_BLOCK * other)
            .collect();
        let parts: Vec<Shapes> = blocks
            .into_par_iter()
            .map(|back| {
                self.block(
                    &blocked_matmul_mixed(&self.against, back),
                    participation,
                    gram_inverse,
                    real,
                )
            })
            .collect();
        let mut all = Shapes {
            shape: Array2::zeros((participation.nrows(), target.sides[0]).f()),
            explained: 0.0,
            along_shape: Array2::zeros(participation.dim()),
            along_both: Array2::zeros((participation.nrows(), 1)),
        };
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
    fn block(
        &self,
        values: &Array2<Complex64>,
        participation: &Array2<Complex64>,
        gram_inverse: &Array2<Complex64>,
        real: bool,
    ) -> Shapes {
        let (n, other) = participation.dim();
        let mut right = Array2::zeros((n, values.ncols() / other).f());
        for (pair, value) in values.columns().into_iter().enumerate() {
            add_product(
                right.column_mut(pair / other),
                participation.column(pair % other),
                value.slice(s![..n]),
            );
        }
        if real {
            right.mapv_inplace(|v: Complex64| Complex64::new(v.re, 0.0));
        }
        let shape = matmul(gram_inverse.view(), right.view());
        let explained = inner(shape.view(), right.view());
        let (mut along_shape, mut along_both) =
            (Array2::zeros((n, other).f()), Array2::zeros((n, 1).f()));
        for (pair, value) in values.columns().into_iter().enumerate() {
            let (shape, j) = (shape.column(pair / other), pair % other);
            add_product(along_shape.column_mut(j), shape, value.slice(s![..n]));
            let both = &shape * &participation.column(j);
            add_product(along_both.column_mut(0), both.view(), value.slice(s![n..]));
        }
        Shapes {
            shape,
            explained,
            along_shape,
            along_both,
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
    let residues = solve_hermitian(blocked_matmul_h(f.view(), f.view()).view(), against.view())?;
    let left = target.energy - inner(residues.view(), against.view());
    Ok((residues, left))
}
