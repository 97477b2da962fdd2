//! The tangent of the columns φ_n⊗L_n: what a step of a pole or of a participation does
//! to them, and the Gauss–Newton matrix of such steps with the shapes eliminated
//! (theory.md, eq. 28). Structured refinement steps along it, error bars of shapes are
//! read off it.

use crate::shapes::limits;
use crate::shapes::line_products::LineProducts;
use chladni_linalg::{matmul, matmul_h};
use ndarray::{Array2, ArrayView1};
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
