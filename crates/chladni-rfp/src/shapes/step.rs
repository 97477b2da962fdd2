//! Poles and participations together, shapes eliminated: variable projection on rank-one
//! residues (theory.md, eq. 26–29).
//!
//! The stacked problem (lines × references rows, one right-hand side per response) is
//! never formed: every product of its columns φ_n⊗L_n factors into a product over lines
//! and one over references. One step costs the line products, 16Nn(2n + r), and one small
//! Hermitian solve per cluster of overlapping modes.

use crate::shapes::factor::Factor;
use crate::shapes::limits;
use crate::shapes::line_products::LineProducts;
use crate::shapes::tangent::{overlapping, pivots, taken, unknowns, Tangent, Unknown};
use crate::shapes::target::{residues, Products, Shapes, Target};
use crate::tolerances as tol;
use chladni_linalg::{inverse_hermitian, matmul, LinalgError};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

fn conjugate(a: &Array2<Complex64>) -> Array2<Complex64> {
    a.mapv(|v| v.conj())
}

/// The end of a search.
#[derive(Clone, Copy)]
pub(crate) enum Enough {
    /// At the last digits.
    Fine,
    /// Enough to tell whether the structure holds: the sum of squares, to this much.
    SumOfSquares(f64),
    /// Enough to tell whether a mode shows.
    Rough,
}

impl Enough {
    /// * `largest`: the last step in half-bandwidths, `drop` of the sum of squares by it
    /// * `left`: the step that would follow
    fn is_reached(self, largest: f64, drop: f64, left: f64) -> bool {
        match self {
            Self::SumOfSquares(least) if drop < least => largest < limits::STRUCTURED_ROUGH_STEP,
            Self::Fine | Self::SumOfSquares(_) => left < limits::STRUCTURED_FINE,
            Self::Rough => largest < tol::ROUGH.tolerance,
        }
    }
}

/// A point of the search.
#[derive(Clone)]
pub(crate) struct State {
    /// Poles, rising in Re λ is not required.
    pub lambda: Vec<Complex64>,
    /// (mode, other): participations, 1 at the pivot.
    pub participation: Array2<Complex64>,
    /// The best shapes for them.
    pub shapes: Shapes,
    /// Sum of squares left.
    pub sse: f64,
    /// True where shapes and participations are real.
    pub real: bool,
    pivot: Vec<usize>,
    products: Products,
    /// Inverse of the Gram matrix of the columns φ_n⊗L_n.
    gram_inverse: Array2<Complex64>,
    /// Inner products of participations and of shapes, (mode, mode).
    along: Array2<Complex64>,
    across: Array2<Complex64>,
}

/// The damped Gauss–Newton matrix of one cluster of modes.
struct Factored {
    modes: Vec<usize>,
    unknowns: Vec<Unknown>,
    matrix: Factor,
}

impl State {
    /// The same without mode `n`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn without(&self, target: &Target, n: usize) -> Result<Self, LinalgError> {
        let kept: Vec<usize> = (0..self.lambda.len()).filter(|&m| m != n).collect();
        self.of_modes(target, &kept)
    }

    /// Some modes of it on a target of as many other DOFs.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_modes(&self, target: &Target, kept: &[usize]) -> Result<Self, LinalgError> {
        let lambda = kept.iter().map(|&m| self.lambda[m]).collect();
        let participation = self.participation.select(Axis(0), kept);
        Self::new(target, lambda, participation, self.real)
    }

    /// Shapes by linear least squares at poles and participations.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(
        target: &Target,
        lambda: Vec<Complex64>,
        participation: Array2<Complex64>,
        real: bool,
    ) -> Result<Self, LinalgError> {
        let products = Products::new(target, &lambda);
        let pivot = pivots(&participation);
        Self::at(target, (lambda, products), (participation, pivot), real)
    }

    /// The same poles with real shapes and participations.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn with_real_shapes(&self, target: &Target) -> Result<Self, LinalgError> {
        let poles = (self.lambda.clone(), self.products.clone());
        let along = (self.participation.clone(), pivots(&self.participation));
        Self::at(target, poles, along, true)
    }

    /// True where no participation is much larger than the pivot of its mode.
    fn pivots_hold(&self, participation: &Array2<Complex64>) -> bool {
        let of_modes = participation.rows().into_iter().zip(&self.pivot);
        let mut of_modes = of_modes.map(|(row, &pivot)| (row, row[pivot].norm()));
        of_modes.all(|(row, pivot)| row.iter().all(|v| v.norm() <= limits::PIVOT_KEPT * pivot))
    }

    /// Shapes at poles with their products, and at participations with their pivots.
    fn at(
        target: &Target,
        (lambda, products): (Vec<Complex64>, Products),
        (mut participation, pivot): (Array2<Complex64>, Vec<usize>),
        real: bool,
    ) -> Result<Self, LinalgError> {
        for (mut row, &at) in participation.rows_mut().into_iter().zip(&pivot) {
            let value = row[at];
            row.mapv_inplace(|v| taken(real, v / value));
        }
        let along = matmul(conjugate(&participation).view(), participation.t());
        let gram_inverse = inverse_hermitian(
            (&products.lines.ff * &along)
                .mapv(|v| taken(real, v))
                .view(),
        )?;
        let shapes = products.shapes(target, &participation, &gram_inverse, real);
        let across = matmul(conjugate(&shapes.shape).view(), shapes.shape.t());
        Ok(Self {
            sse: target.energy - shapes.explained,
            lambda,
            participation,
            shapes,
            real,
            pivot,
            products,
            gram_inverse,
            along,
            across,
        })
    }

    /// Residues ψ_i·L_j of all modes, (mode, own·other).
    pub fn residues(&self) -> Array2<Complex64> {
        residues(self.shapes.shape.view(), self.participation.view())
    }

    /// R̄Rᵀ of [`Self::residues`], (mode, mode).
    pub fn residue_products(&self) -> Array2<Complex64> {
        &self.across * &self.along
    }

    /// The unknowns of some modes.
    fn unknowns(&self, modes: &[usize]) -> Vec<Unknown> {
        let references = self.participation.ncols();
        unknowns(modes, &self.pivot, references, self.real)
    }

    /// Gauss–Newton matrix of the given unknowns, shapes eliminated. Two terms of one
    /// pole may share their participations in any way: a trace of each derivative's own
    /// size keeps the matrix regular.
    fn information(&self, unknowns: &[Unknown]) -> Array2<Complex64> {
        let tangent = Tangent {
            lines: &self.products.lines,
            participation: &self.participation,
            measured: &vec![true; self.participation.ncols()],
            along: &self.along,
            across: &self.across,
            gram_inverse: &self.gram_inverse,
            real: self.real,
        };
        tangent.information(
            unknowns,
            &tangent.inside(unknowns),
            limits::STRUCTURED_RIDGE,
        )
    }

    /// Gradient along the same unknowns.
    fn gradient(&self, unknowns: &[Unknown]) -> Array2<Complex64> {
        let LineProducts { ff, fd, .. } = &self.products.lines;
        let (l, along, across) = (&self.participation, &self.along, &self.across);
        let modes = 0..self.lambda.len();
        Array2::from_shape_fn((unknowns.len(), 1), |(a, _)| {
            let Unknown {
                mode: m,
                other: j,
                unit,
            } = unknowns[a];
            let value = match j {
                None => {
                    let model = modes
                        .clone()
                        .map(|p| fd[[p, m]].conj() * across[[m, p]] * along[[m, p]])
                        .sum::<Complex64>();
                    self.shapes.along_both[[m, 0]] - model
                }
                Some(j) => {
                    let model = modes
                        .clone()
                        .map(|p| ff[[m, p]] * across[[m, p]] * l[[p, j]])
                        .sum::<Complex64>();
                    self.shapes.along_shape[[m, j]] - model
                }
            };
            taken(self.real, unit.conj() * value)
        })
    }

    /// The damped Gauss–Newton matrices of all clusters.
    fn factored(&self, damping: f64) -> Result<Vec<Factored>, LinalgError> {
        overlapping(&self.lambda)
            .into_par_iter()
            .map(|modes| {
                let unknowns = self.unknowns(&modes);
                let mut matrix = self.information(&unknowns);
                matrix.diag_mut().mapv_inplace(|d| {
                    Complex64::new(d.re * (1.0 + damping) + f64::MIN_POSITIVE, 0.0)
                });
                Ok(Factored {
                    matrix: Factor::new(&matrix, self.real)?,
                    modes,
                    unknowns,
                })
            })
            .collect()
    }

    /// A damped step of every cluster; the largest pole step in half-bandwidths.
    fn stepped(&self, target: &Target, clusters: &[Factored]) -> Result<(Self, f64), LinalgError> {
        let (mut lambda, mut participation) = (self.lambda.clone(), self.participation.clone());
        let mut largest = 0.0_f64;
        for Factored {
            modes,
            unknowns,
            matrix,
        } in clusters
        {
            let step = matrix.solve(&self.gradient(unknowns))?;
            let mut moves = vec![Complex64::default(); self.lambda.len()];
            for (unknown, &value) in unknowns.iter().zip(&step) {
                match unknown.other {
                    None => moves[unknown.mode] += unknown.unit * value,
                    Some(j) => participation[[unknown.mode, j]] += value,
                }
            }
            for &n in modes {
                let size = moves[n].norm() / self.lambda[n].im;
                largest = largest.max(size);
                lambda[n] +=
                    moves[n] * (limits::STRUCTURED_STEP / size.max(limits::STRUCTURED_STEP));
                lambda[n].im = lambda[n]
                    .im
                    .max(limits::STRUCTURED_LOSS_KEPT * self.lambda[n].im);
            }
        }
        // matrices that are kept are those of these pivots
        let next = match largest < limits::MATRIX_KEPT && self.pivots_hold(&participation) {
            true => {
                let products = Products::new(target, &lambda);
                let along = (participation, self.pivot.clone());
                Self::at(target, (lambda, products), along, self.real)?
            }
            false => Self::new(target, lambda, participation, self.real)?,
        };
        Ok((next, largest))
    }

    /// Gauss–Newton with Levenberg–Marquardt damping until it is [`Enough`]. Short steps
    /// keep the matrices of the step before: they hardly change, and cost more than all
    /// else.
    pub fn refined(mut self, target: &Target, enough: Enough) -> Self {
        let mut damping = tol::LM_START;
        let (mut clusters, mut before, mut slower) = (None, 0.0, 1.0);
        // the sum of squares is a difference of large numbers: near the end its rounding
        // must not refuse good steps
        let rounding = tol::STEP_ROUNDING * target.energy;
        for _ in 0..tol::FINE.steps {
            let factored = clusters.take().map_or_else(|| self.factored(damping), Ok);
            match factored.and_then(|clusters| Ok((self.stepped(target, &clusters)?, clusters))) {
                Ok(((next, largest), kept)) if next.sse <= self.sse + rounding => {
                    let drop = self.sse - next.sse;
                    clusters =
                        (largest < limits::MATRIX_KEPT && next.pivot == self.pivot).then_some(kept);
                    self = next;
                    damping *= tol::LM_DOWN;
                    // steps shrink about geometrically: the error left is about the next step,
                    // by the slower of the last two rates
                    let made = largest.min(limits::STRUCTURED_STEP);
                    let rate = (made / before).clamp(limits::LEAST_RATE, 1.0);
                    if enough.is_reached(largest, drop, largest * rate.max(slower)) {
                        break;
                    }
                    (before, slower) = (made, rate);
                }
                Ok(((_, largest), _)) if largest < limits::STRUCTURED_FINE => break,
                _ => {
                    (before, slower) = (0.0, 1.0);
                    damping = (damping * tol::LM_UP).max(tol::LM_LEAST);
                    if damping > tol::LM_GIVE_UP {
                        break;
                    }
                }
            }
        }
        self
    }

    /// Variances of Re λ and Im λ per mode for unit noise variance.
    pub fn spread(&self) -> Vec<[f64; 2]> {
        let of_cluster = |cluster: Vec<usize>| {
            let unknowns = self.unknowns(&cluster);
            let poles: Vec<usize> = (0..unknowns.len())
                .filter(|&a| unknowns[a].other.is_none())
                .collect();
            let variances = Factor::new(&self.information(&unknowns), self.real)
                .ok()?
                .inverse_diagonal(&poles)
                .ok()?;
            Some(
                poles
                    .into_iter()
                    .map(|a| unknowns[a])
                    .zip(variances)
                    .collect::<Vec<_>>(),
            )
        };
        let mut spread = vec![[f64::INFINITY; 2]; self.lambda.len()];
        let clusters: Vec<_> = overlapping(&self.lambda)
            .into_par_iter()
            .filter_map(of_cluster)
            .collect();
        for (unknown, variance) in clusters.into_iter().flatten() {
            let half = 0.5 * variance;
            match (self.real, unknown.unit.im != 0.0) {
                (false, _) => spread[unknown.mode] = [half; 2],
                (true, imaginary) => spread[unknown.mode][usize::from(imaginary)] = half,
            }
        }
        spread
    }
}
