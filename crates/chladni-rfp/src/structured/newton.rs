//! Poles and participations together, shapes eliminated: variable projection on rank-one residues (theory.md, eq. 26–29).
//!
//! The stacked problem (lines × references rows, one right-hand side per response) is never formed: every product of its
//! columns φ_n⊗L_n factors into a product over lines and one over references. One step costs the line products, 16Nn(2n + r),
//! and one small Hermitian solve per cluster of overlapping modes.

use crate::model::overlapping;
use crate::tolerances as tol;
use crate::work::{basis, basis_derivative, Work};
use chladni_linalg::{inverse_hermitian, matmul, matmul_h, solve_hermitian, svd_thin, LinalgError};
use ndarray::{Array2, Axis};
use num_complex::Complex64;

fn conjugate(a: &Array2<Complex64>) -> Array2<Complex64> {
    a.mapv(|v| v.conj())
}

/// Real part where shapes are real, all of it otherwise.
fn taken(real: bool, a: &Array2<Complex64>) -> Array2<Complex64> {
    if real {
        a.mapv(|v| Complex64::new(v.re, 0.0))
    } else {
        a.clone()
    }
}

/// The data once residual terms and out-of-band poles are taken out: what the modes of the band must explain.
pub(super) struct Target<'a> {
    pub work: &'a Work,
    /// Orthonormal basis of what stays free in every pair, (line, ·).
    free: Array2<Complex64>,
    /// The rest of the compressed data, (line, column).
    data: Array2<Complex64>,
    /// (column, own·other), rows orthonormal: from columns to pairs, the DOFs whose values are eliminated first.
    pub back: Array2<Complex64>,
    /// Number of DOFs on the eliminated and on the other side.
    pub sides: [usize; 2],
    /// Sum of squares of `data`.
    pub energy: f64,
}

impl<'a> Target<'a> {
    /// Poles `outside` the band keep free residues and, to first order, free positions: their columns and derivatives join the
    /// residual terms.
    pub fn new(
        work: &'a Work,
        outside: &[Complex64],
        powers: &[i32],
        back: Array2<Complex64>,
        sides: [usize; 2],
    ) -> Result<Self, LinalgError> {
        let (columns, derivatives) = (basis(work, outside, powers), basis_derivative(work, outside));
        let mut all = ndarray::concatenate(Axis(1), &[columns.view(), derivatives.view()]).expect("the same lines");
        for mut column in all.columns_mut() {
            let norm = column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            column.mapv_inplace(|v| v / norm);
        }
        let (u, s, _) = svd_thin(all.view())?;
        let kept: Vec<usize> = (0..s.len()).filter(|&i| s[i] > tol::FREE_RANK * s[0]).collect();
        let free = u.select(Axis(1), &kept);
        let data = &work.b - &matmul(free.view(), matmul_h(free.view(), work.b.view()).view());
        let energy = data.iter().map(|v| v.norm_sqr()).sum();
        Ok(Self { work, free, data, back, sides, energy })
    }

    /// Columns with what is free taken out.
    pub fn outside(&self, columns: &Array2<Complex64>) -> Array2<Complex64> {
        columns - &matmul(self.free.view(), matmul_h(self.free.view(), columns.view()).view())
    }

    /// columnsᴴ · data of every pair, (column, own·other).
    pub fn against(&self, columns: &Array2<Complex64>) -> Array2<Complex64> {
        matmul(matmul_h(columns.view(), self.data.view()).view(), self.back.view())
    }
}

/// Products over lines at one set of poles: F the pole columns, D their derivatives, B the data.
struct Products {
    ff: Array2<Complex64>,
    fd: Array2<Complex64>,
    dd: Array2<Complex64>,
    fb: Array2<Complex64>,
    db: Array2<Complex64>,
}

impl Products {
    fn new(target: &Target, lambda: &[Complex64]) -> Self {
        let f = target.outside(&basis(target.work, lambda, &[]));
        let d = target.outside(&basis_derivative(target.work, lambda));
        Self {
            ff: matmul_h(f.view(), f.view()),
            fd: matmul_h(f.view(), d.view()),
            dd: matmul_h(d.view(), d.view()),
            fb: target.against(&f),
            db: target.against(&d),
        }
    }
}

/// Residues of every pair, free, at given poles, and the sum of squares they leave.
pub(super) fn free_residues(target: &Target, lambda: &[Complex64]) -> Result<(Array2<Complex64>, f64), LinalgError> {
    let products = Products::new(target, lambda);
    let residues = solve_hermitian(products.ff.view(), products.fb.view())?;
    let explained: f64 = residues.iter().zip(&products.fb).map(|(r, b)| (r.conj() * b).re).sum();
    Ok((residues, target.energy - explained))
}

/// A point of the search.
pub(super) struct State {
    /// Poles, rising in Re λ is not required.
    pub lambda: Vec<Complex64>,
    /// (mode, other): participations, 1 at the pivot.
    pub participation: Array2<Complex64>,
    /// (mode, own): the best shapes for them.
    pub shape: Array2<Complex64>,
    /// Sum of squares left.
    pub sse: f64,
    /// True where shapes and participations are real.
    pub real: bool,
    pivot: Vec<usize>,
    products: Products,
    /// Inverse of the Gram matrix of the columns φ_n⊗L_n.
    gram_inverse: Array2<Complex64>,
}

/// One unknown: its mode, whether the pole or which participation, and the unit it moves along.
#[derive(Clone, Copy)]
struct Unknown {
    mode: usize,
    other: Option<usize>,
    unit: Complex64,
}

impl State {
    /// Shapes by linear least squares at poles and participations.
    pub fn new(target: &Target, lambda: Vec<Complex64>, participation: Array2<Complex64>, real: bool) -> Result<Self, LinalgError> {
        let [own, other] = target.sides;
        let mut participation = participation;
        let mut pivot = Vec::with_capacity(lambda.len());
        for mut row in participation.rows_mut() {
            let (at, value) =
                row.indexed_iter().max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr())).map(|(j, v)| (j, *v)).expect("a DOF");
            pivot.push(at);
            row.mapv_inplace(|v| if real { Complex64::new((v / value).re, 0.0) } else { v / value });
        }
        let products = Products::new(target, &lambda);
        let along = matmul(conjugate(&participation).view(), participation.t());
        let gram = taken(real, &(&products.ff * &along));
        let mut right = Array2::zeros((lambda.len(), own));
        for ((n, i), value) in right.indexed_iter_mut() {
            *value = (0..other).map(|j| participation[[n, j]].conj() * products.fb[[n, i * other + j]]).sum();
        }
        let right = taken(real, &right);
        let gram_inverse = inverse_hermitian(gram.view())?;
        let shape = matmul(gram_inverse.view(), right.view());
        let explained: f64 = shape.iter().zip(&right).map(|(s, r)| (s.conj() * r).re).sum();
        Ok(Self { sse: target.energy - explained, lambda, participation, shape, real, pivot, products, gram_inverse })
    }

    /// Residues ψ_i L_j of all modes, (mode, own·other).
    pub fn residues(&self) -> Array2<Complex64> {
        let [own, other] = [self.shape.ncols(), self.participation.ncols()];
        Array2::from_shape_fn((self.lambda.len(), own * other), |(n, l)| self.shape[[n, l / other]] * self.participation[[n, l % other]])
    }

    fn unknowns(&self, modes: &[usize]) -> Vec<Unknown> {
        let mut list = Vec::new();
        for &mode in modes {
            list.push(Unknown { mode, other: None, unit: Complex64::new(1.0, 0.0) });
            if self.real {
                list.push(Unknown { mode, other: None, unit: Complex64::i() });
            }
            let others = (0..self.participation.ncols()).filter(|j| *j != self.pivot[mode]);
            list.extend(others.map(|j| Unknown { mode, other: Some(j), unit: Complex64::new(1.0, 0.0) }));
        }
        list
    }

    /// Gauss–Newton matrix and gradient of the given unknowns, shapes eliminated (Kaufman's form). Two terms of one pole may share
    /// their participations in any way: a trace of each derivative's own size keeps the matrix regular.
    fn system(&self, unknowns: &[Unknown]) -> (Array2<Complex64>, Array2<Complex64>) {
        let Products { ff, fd, dd, fb, db } = &self.products;
        let (l, own, other) = (&self.participation, self.shape.ncols(), self.participation.ncols());
        let along = matmul(conjugate(l).view(), l.t());
        let across = matmul(conjugate(&self.shape).view(), self.shape.t());
        let take = |v: Complex64| if self.real { Complex64::new(v.re, 0.0) } else { v };
        // inner products of the stacked columns with the stacked derivatives
        let inside = Array2::from_shape_fn((self.lambda.len(), unknowns.len()), |(p, a)| {
            let Unknown { mode: n, other: j, unit } = unknowns[a];
            take(unit * j.map_or_else(|| fd[[p, n]] * along[[p, n]], |j| ff[[p, n]] * l[[p, j]].conj()))
        });
        let known = matmul_h(inside.view(), matmul(self.gram_inverse.view(), inside.view()).view());
        let matrix = Array2::from_shape_fn((unknowns.len(), unknowns.len()), |(a, b)| {
            let (Unknown { mode: m, other: j, unit: u }, Unknown { mode: n, other: k, unit: v }) = (unknowns[a], unknowns[b]);
            let product = match (j, k) {
                (None, None) => dd[[m, n]] * along[[m, n]],
                (None, Some(k)) => fd[[n, m]].conj() * l[[m, k]].conj(),
                (Some(j), None) => fd[[m, n]] * l[[n, j]],
                (Some(j), Some(k)) if j == k => ff[[m, n]],
                _ => Complex64::default(),
            };
            let trace = if a == b { 1.0 + tol::STRUCTURED_RIDGE } else { 1.0 };
            (take(u.conj() * v * product) * trace - known[[a, b]]) * across[[m, n]]
        });
        let gradient = Array2::from_shape_fn((unknowns.len(), 1), |(a, _)| {
            let Unknown { mode: m, other: j, unit } = unknowns[a];
            let shape = |i: usize| self.shape[[m, i]].conj();
            let value: Complex64 = match j {
                None => {
                    let data: Complex64 =
                        (0..own).map(|i| shape(i) * (0..other).map(|j| l[[m, j]].conj() * db[[m, i * other + j]]).sum::<Complex64>()).sum();
                    data - (0..self.lambda.len()).map(|p| fd[[p, m]].conj() * across[[m, p]] * along[[m, p]]).sum::<Complex64>()
                }
                Some(j) => {
                    let data: Complex64 = (0..own).map(|i| shape(i) * fb[[m, i * other + j]]).sum();
                    data - (0..self.lambda.len()).map(|p| ff[[m, p]] * across[[m, p]] * l[[p, j]]).sum::<Complex64>()
                }
            };
            take(unit.conj() * value)
        });
        (matrix, gradient)
    }

    /// A damped step of every cluster; the largest pole step in half-bandwidths.
    fn stepped(&self, target: &Target, damping: f64) -> Result<(Self, f64), LinalgError> {
        let (mut lambda, mut participation) = (self.lambda.clone(), self.participation.clone());
        let mut largest = 0.0_f64;
        for cluster in overlapping(&self.lambda) {
            let unknowns = self.unknowns(&cluster);
            let (mut matrix, gradient) = self.system(&unknowns);
            matrix.diag_mut().mapv_inplace(|d| Complex64::new(d.re * (1.0 + damping) + f64::MIN_POSITIVE, 0.0));
            let step = solve_hermitian(matrix.view(), gradient.view())?;
            let mut moves = vec![Complex64::default(); self.lambda.len()];
            for (unknown, &value) in unknowns.iter().zip(&step) {
                match unknown.other {
                    None => moves[unknown.mode] += unknown.unit * value,
                    Some(j) => participation[[unknown.mode, j]] += value,
                }
            }
            for &n in &cluster {
                let size = moves[n].norm() / self.lambda[n].im;
                largest = largest.max(size);
                lambda[n] += moves[n] * (tol::STRUCTURED_STEP / size.max(tol::STRUCTURED_STEP));
                lambda[n].im = lambda[n].im.max(0.1 * self.lambda[n].im);
            }
        }
        Ok((Self::new(target, lambda, participation, self.real)?, largest))
    }

    /// Gauss–Newton with Levenberg–Marquardt damping until the largest step is `tolerance` of a half-bandwidth.
    pub fn refined(mut self, target: &Target, iterations: usize, tolerance: f64) -> Self {
        let mut damping = tol::LM_START;
        // the sum of squares is a difference of large numbers: near the end its rounding must not refuse good steps
        let rounding = tol::STEP_ROUNDING * target.energy;
        for _ in 0..iterations {
            match self.stepped(target, damping) {
                Ok((next, largest)) if next.sse <= self.sse + rounding => {
                    self = next;
                    damping *= 0.1;
                    if largest < tolerance {
                        break;
                    }
                }
                Ok((_, largest)) if largest < tolerance => break,
                _ => {
                    damping = (damping * 10.0).max(1e-6);
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
        let mut spread = vec![[f64::INFINITY; 2]; self.lambda.len()];
        for cluster in overlapping(&self.lambda) {
            let unknowns = self.unknowns(&cluster);
            let Ok(inverse) = inverse_hermitian(self.system(&unknowns).0.view()) else { continue };
            for (a, unknown) in unknowns.iter().enumerate().filter(|(_, u)| u.other.is_none()) {
                let half = 0.5 * inverse[[a, a]].re.max(0.0);
                match (self.real, unknown.unit.im != 0.0) {
                    (false, _) => spread[unknown.mode] = [half; 2],
                    (true, imaginary) => spread[unknown.mode][usize::from(imaginary)] = half,
                }
            }
        }
        spread
    }
}
