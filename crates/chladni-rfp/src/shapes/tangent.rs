//! The tangent of the columns φ_n⊗L_n: what a step of a pole or of a participation does
//! to them, and the Gauss–Newton matrix of such steps with the shapes eliminated
//! (theory.md, eq. 28). Structured refinement steps along it, error bars of shapes are
//! read off it.

use crate::shapes::limits;
use crate::shapes::line_products::LineProducts;
use crate::tolerances as tol;
use chladni_linalg::{matmul, matmul_h};
use ndarray::{Array2, ArrayView1, Axis};
use num_complex::Complex64;

/// One unknown: its mode, whether the pole or which participation, and the unit it moves
/// along.
#[derive(Clone, Copy)]
pub(crate) struct Unknown {
    pub mode: usize,
    pub other: Option<usize>,
    pub unit: Complex64,
}

/// The point of the tangent, for DOFs of the eliminated side that were measured with the
/// same others.
pub(crate) struct Tangent<'a> {
    pub lines: &'a LineProducts,
    /// (mode, other).
    pub participation: &'a Array2<Complex64>,
    /// False where an other was not measured with these DOFs.
    pub measured: &'a [bool],
    /// L̄Lᵀ over the others measured, and ψ̄ψᵀ over the DOFs.
    pub along: &'a Array2<Complex64>,
    pub across: &'a Array2<Complex64>,
    /// Inverse of the Gram matrix of the columns.
    pub gram_inverse: &'a Array2<Complex64>,
    /// True where shapes and participations are real.
    pub real: bool,
}

impl Tangent<'_> {
    /// Inner products of all columns with the derivatives by the unknowns, (mode,
    /// unknown).
    pub fn inside(&self, unknowns: &[Unknown]) -> Array2<Complex64> {
        Array2::from_shape_fn((self.participation.nrows(), unknowns.len()), |(p, a)| {
            let Unknown {
                mode: n,
                other,
                unit,
            } = unknowns[a];
            let product = match other {
                None => self.lines.fd[[p, n]] * self.along[[p, n]],
                Some(j) if self.measured[j] => {
                    self.lines.ff[[p, n]] * self.participation[[p, j]].conj()
                }
                Some(_) => Complex64::ZERO,
            };
            taken(self.real, unit * product)
        })
    }

    /// Gauss–Newton matrix of the unknowns (Kaufman's form). `ridge`: part of each
    /// derivative's own size that is added on the diagonal.
    pub fn information(
        &self,
        unknowns: &[Unknown],
        inside: &Array2<Complex64>,
        ridge: f64,
    ) -> Array2<Complex64> {
        let LineProducts { ff, fd, dd, .. } = self.lines;
        let l = self.participation;
        let mut matrix = matmul_h(
            inside.view(),
            matmul(self.gram_inverse.view(), inside.view()).view(),
        );
        for (b, (mut column, of_column)) in
            matrix.columns_mut().into_iter().zip(unknowns).enumerate()
        {
            let (n, k) = (of_column.mode, of_column.other);
            for (a, (value, of_row)) in column.iter_mut().zip(unknowns).enumerate() {
                let (m, j) = (of_row.mode, of_row.other);
                let product = match (j, k) {
                    (Some(j), Some(k)) if j != k => None,
                    (Some(j), _) | (None, Some(j)) if !self.measured[j] => None,
                    (Some(_), Some(_)) => Some(ff[[m, n]]),
                    (Some(j), None) => Some(fd[[m, n]] * l[[n, j]]),
                    (None, Some(k)) => Some(fd[[n, m]].conj() * l[[m, k]].conj()),
                    (None, None) => Some(dd[[m, n]] * self.along[[m, n]]),
                };
                let whole = product.map_or(Complex64::ZERO, |product| {
                    let trace = if a == b { 1.0 + ridge } else { 1.0 };
                    taken(self.real, of_row.unit.conj() * of_column.unit * product) * trace
                });
                *value = (whole - *value) * self.across[[m, n]];
            }
        }
        matrix
    }
}

/// The unknowns of some modes, mode by mode: the pole, then all participations but the
/// pivot, which fixes the scale.
pub(crate) fn unknowns(
    modes: &[usize],
    pivot: &[usize],
    references: usize,
    real: bool,
) -> Vec<Unknown> {
    let units: &[Complex64] = if real {
        &[Complex64::ONE, Complex64::I]
    } else {
        &[Complex64::ONE]
    };
    let mut list = Vec::new();
    for &mode in modes {
        list.extend(units.iter().map(|&unit| Unknown {
            mode,
            other: None,
            unit,
        }));
        let others = (0..references).filter(|j| *j != pivot[mode]);
        list.extend(others.map(|j| Unknown {
            mode,
            other: Some(j),
            unit: Complex64::ONE,
        }));
    }
    list
}

/// The directions in which terms of one pole mix, (unknown, direction): participations of one move
/// along those of another, and its pivot stays. Where the shapes follow, no FRF changes by it.
///
/// * `lambda`: of each term; terms of one pole have the same
pub(crate) fn mixing(
    unknowns: &[Unknown],
    lambda: &[Complex64],
    participation: &Array2<Complex64>,
) -> Array2<Complex64> {
    let pivot = pivots(participation);
    let is_met = |n: usize| unknowns.iter().any(|unknown| unknown.mode == n);
    let pairs: Vec<[usize; 2]> = (0..lambda.len())
        .filter(|&n| is_met(n))
        .flat_map(|n| (0..lambda.len()).map(move |m| [n, m]))
        .filter(|&[n, m]| n != m && lambda[n] == lambda[m])
        .collect();
    let all = Array2::from_shape_fn((unknowns.len(), pairs.len()), |(a, c)| {
        let ([n, m], Unknown { mode, other, .. }) = (pairs[c], unknowns[a]);
        let [own, along] = [n, m].map(|term| participation.row(term));
        match other {
            Some(j) if mode == n => along[j] - own[j] * (along[pivot[n]] / own[pivot[n]]),
            _ => Complex64::ZERO,
        }
    });
    // between terms of the same participations the rest is rounding
    let size = |row: ArrayView1<Complex64>| row.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
    let told: Vec<usize> = (0..pairs.len())
        .filter(|&c| size(all.column(c)) > tol::FREE_RANK * size(participation.row(pairs[c][1])))
        .collect();
    all.select(Axis(1), &told)
}

/// The largest participation of each mode.
pub(crate) fn pivots(participation: &Array2<Complex64>) -> Vec<usize> {
    let of_mode = |row: ArrayView1<Complex64>| {
        row.indexed_iter()
            .max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))
            .map_or(0, |(j, _)| j)
    };
    participation.rows().into_iter().map(of_mode).collect()
}

/// Real part where shapes are real, all of it otherwise.
pub(crate) fn taken(real: bool, value: Complex64) -> Complex64 {
    if real {
        Complex64::new(value.re, 0.0)
    } else {
        value
    }
}

/// Modes that overlap, as lists of indices: between the lists lies more than some
/// bandwidths.
pub(crate) fn overlapping(lambda: &[Complex64]) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..lambda.len()).collect();
    order.sort_by(|&a, &b| lambda[a].re.total_cmp(&lambda[b].re));
    let mut clusters: Vec<Vec<usize>> = Vec::new();
    for n in order {
        let near = |&m: &usize| {
            lambda[n].re - lambda[m].re
                < limits::CLUSTER_HALF_WIDTHS * lambda[m].im.max(lambda[n].im)
        };
        match clusters
            .last_mut()
            .filter(|cluster| cluster.iter().any(near))
        {
            Some(cluster) => cluster.push(n),
            None => clusters.push(vec![n]),
        }
    }
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_linalg::inverse_hermitian;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Two of three terms share a pole.
    #[test]
    fn terms_of_one_pole_mix_without_a_change_of_any_frf() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut draw = |size: (usize, usize)| {
            Array2::from_shape_fn(size, |_| {
                let [re, im] = [(); 2].map(|()| random.random_range(-1.0..1.0));
                Complex64::new(re, im)
            })
        };
        let terms = [0, 1, 1];
        let [columns, derivatives] =
            [draw((20, 2)), draw((20, 2))].map(|all| all.select(Axis(1), &terms));
        let (participation, shape) = (draw((3, 4)), draw((3, 5)));
        let gram = |a: &Array2<Complex64>, b: &Array2<Complex64>| matmul_h(a.view(), b.view());
        let over = |rows: &Array2<Complex64>| gram(&rows.t().to_owned(), &rows.t().to_owned());
        let lines = LineProducts {
            whole: vec![1.0; 3],
            ff: gram(&columns, &columns),
            fd: gram(&columns, &derivatives),
            dd: gram(&derivatives, &derivatives),
        };
        let (along, across) = (over(&participation), over(&shape));
        let normal = &lines.ff * &along;
        let tangent = Tangent {
            lines: &lines,
            participation: &participation,
            measured: &[true; 4],
            along: &along,
            across: &across,
            gram_inverse: &inverse_hermitian(normal.view()).unwrap(),
            real: false,
        };
        let unknowns = unknowns(&[0, 1, 2], &pivots(&participation), 4, false);
        let information = tangent.information(&unknowns, &tangent.inside(&unknowns), 0.0);
        let lambda = terms.map(|n| Complex64::new(1.0 + n as f64, 0.01));
        let idle = mixing(&unknowns, &lambda, &participation);
        assert_eq!(idle.ncols(), 2);
        let seen = matmul(information.view(), idle.view());
        assert!(seen.iter().all(|v| v.norm() < 1e-11), "{seen}");
        // a term without participations, and one that repeats another, mix in no way
        let mut still = participation.clone();
        still.row_mut(1).fill(Complex64::ZERO);
        assert_eq!(mixing(&unknowns, &lambda, &still).ncols(), 0);
        let mut twice = participation;
        let first = twice.row(1).mapv(|v| v * Complex64::I);
        twice.row_mut(2).assign(&first);
        assert_eq!(mixing(&unknowns, &lambda, &twice).ncols(), 0);
    }
}
