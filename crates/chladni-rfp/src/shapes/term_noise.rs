//! Noise that bars of poles and shapes are made of, where FRFs are not equally noisy (theory.md, eq.
//! N1). A mode is carried by few FRFs; their noise is the one that moves it.

use crate::damping::basis::basis_derivative;
use crate::data::columns::Columns;
use crate::data::information::covariance;
use crate::poles::pole::Pole;
use crate::poles::refine::Projection;
use crate::shapes::low_rank::Shapes;
use crate::shapes::tangent::Unknown;
use chladni_linalg::{matmul, matmul_h, LinalgError};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use std::iter::zip;

/// Noise variances over the mean of all FRFs.
pub(crate) struct TermNoise {
    /// Of a value of each shape at given poles and participations, (term, response).
    pub response: Array2<f64>,
    /// Of each participation, (term, reference).
    pub reference: Array2<f64>,
    /// Of the pole of each term.
    pub pole: Array1<f64>,
}

/// The noise of single FRFs.
pub(crate) struct OfFrfs<'a> {
    pub pairs: &'a [(usize, usize)],
    /// Variance of each pair over the mean.
    pub over_mean: &'a [f64],
}

impl TermNoise {
    /// Noise of each response by itself, the same in all references and terms.
    pub fn of_responses(noise: &Array1<f64>, shapes: &Shapes) -> Self {
        let terms = shapes.owner.len();
        Self {
            response: Array2::from_shape_fn((terms, noise.len()), |(_, i)| noise[i]),
            reference: Array2::ones(shapes.participation.raw_dim()),
            pole: Array1::ones(terms),
        }
    }

    /// Noise of each FRF by itself: means over the share that FRFs have in a shape value, a
    /// participation or a pole.
    ///
    /// * `of_poles`: as from [`OfFrfs::of_poles`]
    pub fn of_frfs(noise: &OfFrfs, shapes: &Shapes, of_poles: &[f64]) -> Self {
        let Shapes {
            owner,
            shape,
            participation,
            ..
        } = shapes;
        let (mut response, mut reference) = (Means::new(shape), Means::new(participation));
        for (&(i, j), &over_mean) in zip(noise.pairs, noise.over_mean) {
            for n in 0..owner.len() {
                response.add((n, i), participation[[n, j]].norm_sqr(), over_mean);
                reference.add((n, j), shape[[n, i]].norm_sqr(), over_mean);
            }
        }
        Self {
            response: response.means(),
            reference: reference.means(),
            pole: owner.iter().map(|&owner| of_poles[owner]).collect(),
        }
    }

    /// Rows of `columns`, one per unknown, times the root of the noise that the unknown sees.
    pub fn times(&self, columns: &Array2<Complex64>, unknowns: &[Unknown]) -> Array2<Complex64> {
        let mut noisy = columns.clone();
        for (mut row, unknown) in zip(noisy.rows_mut(), unknowns) {
            let seen = match unknown.other {
                Some(j) => self.reference[[unknown.mode, j]],
                None => self.pole[unknown.mode],
            };
            row.mapv_inplace(|v| v * seen.sqrt());
        }
        noisy
    }

    /// The noise of some terms.
    pub fn select(&self, terms: &[usize]) -> Self {
        Self {
            response: self.response.select(Axis(0), terms),
            reference: self.reference.select(Axis(0), terms),
            pole: self.pole.select(Axis(0), terms),
        }
    }
}

/// Means over shares, by places.
struct Means {
    shares: Array2<f64>,
    sums: Array2<f64>,
}

impl Means {
    /// Of the places of `values`, empty.
    fn new(values: &Array2<Complex64>) -> Self {
        let none = || Array2::zeros(values.raw_dim());
        Self {
            shares: none(),
            sums: none(),
        }
    }

    fn add(&mut self, place: (usize, usize), share: f64, value: f64) {
        self.shares[place] += share;
        self.sums[place] += share * value;
    }

    /// The means; 1 for a place without shares.
    fn means(mut self) -> Array2<f64> {
        self.sums.zip_mut_with(&self.shares, |sum, &shares| {
            *sum = if shares > 0.0 { *sum / shares } else { 1.0 };
        });
        self.sums
    }
}

impl OfFrfs<'_> {
    /// Variance of each pole over that by even noise.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn of_poles(
        &self,
        (work, powers): (&Columns, &[i32]),
        poles: &[Pole],
        shapes: &Shapes,
    ) -> Result<Vec<f64>, LinalgError> {
        let lambda: Vec<Complex64> = poles.iter().map(Pole::lambda).collect();
        let q = Projection::new(work, &lambda, powers)?.q;
        let derivative = basis_derivative(work, &lambda);
        let inside = matmul_h(q.view(), derivative.view());
        let outside = derivative - matmul(q.view(), inside.view());
        let lines = matmul_h(outside.view(), outside.view());
        let mut residues = Array2::<Complex64>::zeros((lambda.len(), self.pairs.len()));
        for (term, &owner) in shapes.owner.iter().enumerate() {
            let unit = poles[owner].residue_unit(work.law);
            for (l, &(i, j)) in self.pairs.iter().enumerate() {
                residues[[owner, l]] +=
                    unit * shapes.shape[[term, i]] * shapes.participation[[term, j]];
            }
        }
        let mut loud = residues.t().to_owned();
        for (mut row, over_mean) in zip(loud.rows_mut(), self.over_mean) {
            row.mapv_inplace(|v| v * over_mean);
        }
        let conjugate = residues.mapv(|v| v.conj());
        let even = covariance((&lines * &matmul(conjugate.view(), residues.t())).view());
        let scores = &lines * &matmul(conjugate.view(), loud.view());
        let uneven = matmul(matmul(even.view(), scores.view()).view(), even.view());
        let ratio = |(uneven, even): (&Complex64, &Complex64)| match uneven.re / even.re {
            ratio if ratio.is_finite() && ratio > 0.0 => ratio,
            _ => 1.0,
        };
        Ok(zip(uneven.diag(), even.diag()).map(ratio).collect())
    }
}
