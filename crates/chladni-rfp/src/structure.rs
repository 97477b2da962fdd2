//! From free residues to shapes: one shape and one participation vector per mode (theory.md, eq. 18–19).
//!
//! A mode of a linear structure moves in one shape, whichever reference drives it: R_n = ψ_n·L_nᵀ. The refit weighs
//! residues by what the data say of them (the Schur complement of the basis with the residual terms eliminated), so close
//! modes share their error correctly; it alternates between all shapes and all participations, each an exact linear
//! problem. The model file holds the result, and with it the whole fit.

use crate::tolerances as tol;
use chladni_linalg::{inverse_hermitian, matmul, matmul_h, solve_hermitian, svd_thin, LinalgError};
use ndarray::{s, Array2, Array3, Axis};
use num_complex::Complex64;

/// Shapes and participations of all poles.
#[derive(Debug, Clone)]
pub(crate) struct Shapes {
    /// Pole of each row.
    pub owner: Vec<usize>,
    /// (mode, response).
    pub shape: Array2<Complex64>,
    /// (mode, reference).
    pub participation: Array2<Complex64>,
    /// Rise of the sum of squares over free residues.
    pub rise: f64,
    /// Number of real constraints that the rank-one form sets on free residues.
    pub constraints: usize,
}

/// Free residues, their weight, and which pairs exist.
pub(crate) struct Residues<'a> {
    /// (mode, response, reference); zero where missing.
    pub values: &'a Array3<Complex64>,
    /// Weight matrix K, (mode, mode): the sum of squares rises by δᴴKδ per pair.
    pub weight: &'a Array2<Complex64>,
    /// False where a pair was not measured.
    pub present: &'a Array2<bool>,
}

/// Fits R_n = Σ ψ·Lᵀ to all poles at once, with `ranks[n]` terms for pole n (one for a mode; more for a repeated pole, or for an
/// out-of-band pole that stands for several modes). The result has one row per term, poles in order.
pub(crate) fn low_rank(residues: &Residues, ranks: &[usize]) -> Result<Shapes, LinalgError> {
    let (poles, responses, references) = residues.values.dim();
    let owner: Vec<usize> = (0..poles).flat_map(|n| std::iter::repeat_n(n, ranks[n])).collect();
    let mut shape = Array2::zeros((owner.len(), responses));
    let mut participation = Array2::zeros((owner.len(), references));
    let mut row = 0;
    for (n, &rank) in ranks.iter().enumerate() {
        let (u, sv, vh) = svd_thin(residues.values.index_axis(Axis(0), n))?;
        for c in 0..rank {
            let root = Complex64::new(sv[c].sqrt(), 0.0);
            shape.row_mut(row).assign(&(&u.column(c) * root));
            participation.row_mut(row).assign(&(&vh.row(c) * root));
            row += 1;
        }
    }
    let problem = Problem::new(residues, &owner);
    let total = problem.total;
    let mut rise = f64::MAX;
    if references > 1 || residues.present.iter().any(|p| !p) {
        for _ in 0..tol::RANK_ONE_ITERATIONS {
            shape = problem.half_step(&participation, true)?;
            participation = problem.half_step(&shape, false)?;
            balance(&mut shape, &mut participation);
            let now = problem.misfit(&shape, &participation);
            let settled = rise - now <= tol::RANK_ONE_CHANGE * now.max(1e-12 * total);
            rise = now;
            if settled {
                break;
            }
        }
    } else {
        rise = 0.0;
    }
    Ok(Shapes { constraints: constraints(residues, &owner), owner, shape, participation, rise })
}

/// Shapes and participations of some poles that are given: (row, response) and (row, reference).
pub(crate) type Given = Option<(Array2<Complex64>, Array2<Complex64>)>;

/// [`low_rank`] with the shapes of some poles given: only the others are fitted, around them.
pub(crate) fn low_rank_around(residues: &Residues, ranks: &[usize], given: &[Given]) -> Result<Shapes, LinalgError> {
    if given.iter().all(Option::is_none) {
        return low_rank(residues, ranks);
    }
    let (poles, responses, references) = residues.values.dim();
    let open: Vec<usize> = (0..poles).filter(|&n| given[n].is_none()).collect();
    let closed: Vec<usize> = (0..poles).filter(|&n| given[n].is_some()).collect();
    let mut change = Array2::zeros((closed.len(), responses * references));
    for (row, &n) in closed.iter().enumerate() {
        let product = given[n].as_ref().map(|(shape, participation)| matmul(shape.t(), participation.view()));
        for (l, value) in change.row_mut(row).iter_mut().enumerate() {
            let (i, j) = (l / references, l % references);
            if let Some(product) = product.as_ref().filter(|_| residues.present[[i, j]]) {
                *value = product[[i, j]] - residues.values[[n, i, j]];
            }
        }
    }
    let part = |rows: &[usize], columns: &[usize]| residues.weight.select(Axis(0), rows).select(Axis(1), columns);
    let own = part(&open, &open);
    let fitted = if open.is_empty() {
        None
    } else {
        let answer = solve_hermitian(ridge(&own).view(), matmul(part(&open, &closed).view(), change.view()).view())?;
        let moved =
            residues.values.select(Axis(0), &open) - answer.to_shape((open.len(), responses, references)).expect("one value per pair");
        let open_ranks: Vec<usize> = open.iter().map(|&n| ranks[n]).collect();
        Some(low_rank(&Residues { values: &moved, weight: &own, present: residues.present }, &open_ranks)?)
    };
    let (mut shape, mut participation, mut owner) = (Array2::zeros((0, responses)), Array2::zeros((0, references)), Vec::new());
    for n in 0..poles {
        let (rows, columns) = match (&given[n], &fitted) {
            (Some(given), _) => given.clone(),
            (None, Some(fitted)) => {
                let rows: Vec<usize> = (0..fitted.owner.len()).filter(|&row| open[fitted.owner[row]] == n).collect();
                (fitted.shape.select(Axis(0), &rows), fitted.participation.select(Axis(0), &rows))
            }
            (None, None) => continue,
        };
        owner.extend(std::iter::repeat_n(n, rows.nrows()));
        shape.append(Axis(0), rows.view()).expect("one value per response");
        participation.append(Axis(0), columns.view()).expect("one value per reference");
    }
    let problem = Problem::new(residues, &owner);
    let rise = problem.misfit(&shape, &participation);
    Ok(Shapes { constraints: constraints(residues, &owner), owner, shape, participation, rise })
}

/// Real constraints that rows of low rank set on free residues.
fn constraints(residues: &Residues, owner: &[usize]) -> usize {
    let (poles, responses, references) = residues.values.dim();
    let present = residues.present.iter().filter(|p| **p).count();
    let rank = |n: usize| owner.iter().filter(|&&m| m == n).count();
    let used: usize = (0..poles).map(|n| rank(n) * (responses + references - rank(n).min(responses + references))).sum();
    (2 * poles * present).saturating_sub(2 * used)
}

/// Rank that the residues of one pole need: singular values that noise of variance `variance` in the data cannot make
/// (the largest of pure noise is about σ(√responses + √references)).
pub(crate) fn significant_rank(residues: &Residues, pole: usize, variance: f64) -> Result<usize, LinalgError> {
    let (_, responses, references) = residues.values.dim();
    let (_, sv, _) = svd_thin(residues.values.index_axis(Axis(0), pole))?;
    let inverse = inverse_hermitian(ridge(residues.weight).view())?;
    let noise = (variance * inverse[[pole, pole]].re).sqrt() * ((responses as f64).sqrt() + (references as f64).sqrt());
    Ok(sv.iter().filter(|s| **s > tol::RANK_OVER_NOISE * noise).count().max(1))
}

fn energy(flat: &Array2<Complex64>, weighted: &Array2<Complex64>) -> f64 {
    flat.iter().zip(weighted).map(|(r, w)| (r.conj() * w).re).sum()
}

/// Equal norms of both factors: keeps the alternation away from overflow.
fn balance(shape: &mut Array2<Complex64>, participation: &mut Array2<Complex64>) {
    for (mut s, mut p) in shape.rows_mut().into_iter().zip(participation.rows_mut()) {
        let norm = |v: ndarray::ArrayView1<Complex64>| v.iter().map(|c| c.norm_sqr()).sum::<f64>().sqrt();
        let (a, b) = (norm(s.view()), norm(p.view()));
        if a > 0.0 && b > 0.0 {
            let factor = (b / a).sqrt();
            s.mapv_inplace(|v| v * factor);
            p.mapv_inplace(|v| v / factor);
        }
    }
}

/// One row per term, with the weights and right-hand sides that do not change.
struct Problem<'a> {
    residues: &'a Residues<'a>,
    owner: &'a [usize],
    weight: Array2<Complex64>,
    /// K·r̂, (term, pair).
    weighted: Array2<Complex64>,
    /// r̂ᴴK·r̂ over all pairs.
    total: f64,
}

impl<'a> Problem<'a> {
    /// Terms share the weight of their pole; K·r̂ per pair, once.
    fn new(residues: &'a Residues, owner: &'a [usize]) -> Self {
        let (poles, responses, references) = residues.values.dim();
        let weight = Array2::from_shape_fn((owner.len(), owner.len()), |(a, b)| residues.weight[[owner[a], owner[b]]]);
        let flat = residues.values.to_shape((poles, responses * references)).expect("one value per pair").to_owned();
        let weighted = matmul(residues.weight.view(), flat.view());
        let total = energy(&flat, &weighted);
        Self { residues, owner, weight, weighted: weighted.select(Axis(0), owner), total }
    }

    /// Normal matrix of one DOF whose partners are `kept`.
    fn normal(&self, fixed: &Array2<Complex64>, kept: &[usize]) -> Array2<Complex64> {
        let part = fixed.select(Axis(1), kept);
        ridge(&(&self.weight * &matmul(part.mapv(|v| v.conj()).view(), part.t())))
    }

    /// Best shapes for given participations (`shapes` true) or the other way round: one small normal system per DOF.
    fn half_step(&self, fixed: &Array2<Complex64>, shapes: bool) -> Result<Array2<Complex64>, LinalgError> {
        let (_, responses, references) = self.residues.values.dim();
        let (own, other) = if shapes { (responses, references) } else { (references, responses) };
        let pair = |a: usize, b: usize| if shapes { (a, b) } else { (b, a) };
        let mut rights = Array2::zeros((self.owner.len(), own));
        for a in 0..own {
            for b in 0..other {
                let (i, j) = pair(a, b);
                if self.residues.present[[i, j]] {
                    for n in 0..self.owner.len() {
                        rights[[n, a]] += fixed[[n, b]].conj() * self.weighted[[n, i * references + j]];
                    }
                }
            }
        }
        let partners =
            |a: usize| -> Vec<usize> { (0..other).filter(|&b| self.residues.present[if shapes { [a, b] } else { [b, a] }]).collect() };
        if self.residues.present.iter().all(|p| *p) {
            // one system serves all
            return solve_hermitian(self.normal(fixed, &partners(0)).view(), rights.view());
        }
        let mut out = Array2::zeros((self.owner.len(), own));
        for a in 0..own {
            let solution = solve_hermitian(self.normal(fixed, &partners(a)).view(), rights.slice(s![.., a..a + 1]))?;
            out.slice_mut(s![.., a..a + 1]).assign(&solution);
        }
        Ok(out)
    }

    /// Rise of the sum of squares of low-rank residues over the free ones.
    fn misfit(&self, shape: &Array2<Complex64>, participation: &Array2<Complex64>) -> f64 {
        let (poles, responses, references) = self.residues.values.dim();
        let mut difference = Array2::zeros((poles, responses * references));
        for (term, &n) in self.owner.iter().enumerate() {
            for i in 0..responses {
                for j in 0..references {
                    difference[[n, i * references + j]] -= shape[[term, i]] * participation[[term, j]];
                }
            }
        }
        for n in 0..poles {
            for i in 0..responses {
                for j in 0..references {
                    let value = &mut difference[[n, i * references + j]];
                    *value =
                        if self.residues.present[[i, j]] { *value + self.residues.values[[n, i, j]] } else { Complex64::new(0.0, 0.0) };
                }
            }
        }
        let weighted = matmul(self.residues.weight.view(), difference.view());
        energy(&difference, &weighted)
    }
}

/// Weight of the `kept` poles' residues where those of the `free` ones answer every change: a Schur complement.
pub(crate) fn eliminated(weight: &Array2<Complex64>, kept: &[usize], free: &[usize]) -> Result<Array2<Complex64>, LinalgError> {
    let part = |rows: &[usize], columns: &[usize]| weight.select(Axis(0), rows).select(Axis(1), columns);
    if free.is_empty() {
        return Ok(part(kept, kept));
    }
    let answer = solve_hermitian(ridge(&part(free, free)).view(), part(free, kept).view())?;
    Ok(part(kept, kept) - matmul(part(kept, free).view(), answer.view()))
}

/// A pair of modes with the same pole makes the system singular; a trace of ridge shares the residue between them.
fn ridge(matrix: &Array2<Complex64>) -> Array2<Complex64> {
    let mut out = matrix.clone();
    let largest = matrix.diag().iter().fold(0.0_f64, |m, v| m.max(v.re));
    out.diag_mut().mapv_inplace(|v| v * (1.0 + 1e-12) + 1e-18 * largest + f64::MIN_POSITIVE);
    out
}

/// Weight of the mode columns with the other columns eliminated: K = R₂₂ᴴR₂₂ of the QR with the others first.
pub(crate) fn schur_weight(modes: &Array2<Complex64>, others: &Array2<Complex64>) -> Result<Array2<Complex64>, LinalgError> {
    let outside = if others.ncols() == 0 {
        modes.clone()
    } else {
        let (q, _) = chladni_linalg::qr_thin(others.view())?;
        modes - &matmul(q.view(), matmul_h(q.view(), modes.view()).view())
    };
    Ok(matmul_h(outside.view(), outside.view()))
}
