//! One common-denominator fraction on some lines, in polynomials orthonormal for the
//! weight 1/|a|² of the denominator known so far.
//!
//! With h = g/x and u = 1/|a|, the weighted equation error of column l is u·(d·B_l − h·N_l).
//! Q spans the numerators u·h·p, T = R·√S the denominators u·√S·p, S = Σ_l|B_l|². Both are
//! orthonormal, so that eliminating the numerators leaves (theory.md, eq. 69)
//!
//! ```text
//! M = I − Σ_l C_lᴴ C_l,   C_l = Qᴴ diag(B_l) R
//! ```
//!
//! Cost: 4·lines·m·n·r flop for M, m numerator and n denominator polynomials, r columns.

use super::limits::SILENT;
use crate::damping::plane::Plane;
use crate::data::columns::Columns;
use crate::methods::lanczos::Polynomials;
use crate::methods::lanczos::Symmetry;
use chladni_linalg::blocked::blocked_matmul_h;
use chladni_linalg::{matmul, matmul_h, LinalgError};
use ndarray::{Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// The data of some lines in the plane of a law.
pub(crate) struct Lines<'a> {
    /// Variable and field.
    pub plane: Plane,
    /// Columns of the measurement.
    pub work: &'a Columns,
    /// t of the lines.
    pub nodes: Vec<f64>,
    /// g/x.
    over: Array1<f64>,
    /// S, and its root.
    pub energy: Array1<f64>,
    root_energy: Array1<f64>,
}

impl<'a> Lines<'a> {
    /// The lines of `work`.
    pub fn new(plane: Plane, work: &'a Columns) -> Self {
        let energy: Array1<f64> = work
            .b
            .rows()
            .into_iter()
            .map(|row| row.iter().map(|v| v.norm_sqr()).sum::<f64>())
            .collect();
        let least = SILENT * energy.iter().fold(f64::MIN_POSITIVE, |m, e| m.max(*e));
        let energy = energy.mapv(|e| e.max(least));
        Self {
            plane,
            work,
            nodes: work.x.iter().map(|&x| plane.node(x)).collect(),
            over: work.x.iter().zip(&work.g).map(|(x, g)| g / x).collect(),
            root_energy: energy.mapv(f64::sqrt),
            energy,
        }
    }
}

/// Modulus and phase of a denominator on the lines.
pub(crate) struct Denominator {
    /// 1/|a|, relative to its median.
    pub inverse: Array1<f64>,
    /// a/|a|.
    pub phase: Vec<Complex64>,
}

impl Denominator {
    /// a = 1.
    pub fn flat(lines: usize) -> Self {
        Self {
            inverse: Array1::ones(lines),
            phase: vec![Complex64::new(1.0, 0.0); lines],
        }
    }

    /// Π(t − root). The logarithm is carried: over a hundred modes |a| spans 43 decades.
    pub fn of(nodes: &[f64], roots: &[Complex64]) -> Self {
        let one = |&t: &f64| {
            let mut logarithm = 0.0;
            let mut phase = Complex64::new(1.0, 0.0);
            for root in roots {
                let distance = t - root;
                let modulus = distance.norm().max(f64::MIN_POSITIVE);
                logarithm += modulus.ln();
                phase *= distance / modulus;
            }
            (logarithm, phase)
        };
        let (logarithms, phase): (Vec<f64>, Vec<Complex64>) = nodes.iter().map(one).unzip();
        let mut sorted = logarithms.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        Self {
            inverse: logarithms.iter().map(|l| (median - l).exp()).collect(),
            phase,
        }
    }
}

/// Bases for one weight.
pub(crate) struct Fraction {
    /// Orthonormal basis of the weighted numerators.
    pub numerators: Polynomials,
    /// T = R·√S.
    pub denominators: Polynomials,
    /// u·p: weighted values of the polynomials of the denominator.
    pub r: Array2<f64>,
}

impl Fraction {
    /// Bases for `modes` modes and the weight 1/|a|².
    ///
    /// # Errors
    /// Too few lines.
    pub fn new(lines: &Lines, modes: usize, known: &Denominator) -> Result<Self, LinalgError> {
        let plane = lines.plane;
        let symmetry = match plane.is_even() {
            true => Symmetry::Even,
            false => Symmetry::None,
        };
        let basis = |start, degree| Polynomials::new(&lines.nodes, start, degree, symmetry);
        let numerators = basis(&known.inverse * &lines.over, plane.numerator(modes))?;
        let denominators = basis(
            &known.inverse * &lines.root_energy,
            plane.denominator(modes),
        )?;
        let mut r = denominators.columns.clone();
        for mut column in r.columns_mut() {
            column /= &lines.root_energy;
        }
        Ok(Self {
            numerators,
            denominators,
            r,
        })
    }

    /// C_l = Qᴴ diag(b_l) R of each column.
    pub fn crossed(&self, plane: Plane, b: &Array2<Complex64>) -> Vec<Array2<Complex64>> {
        let n = self.r.ncols();
        (0..b.ncols())
            .into_par_iter()
            .map(|l| {
                let mut stacked = Array2::zeros((b.nrows(), 2 * n).f());
                let (real, imaginary) = (b.column(l).mapv(|v| v.re), b.column(l).mapv(|v| v.im));
                for k in 0..n {
                    stacked.column_mut(k).assign(&(&self.r.column(k) * &real));
                    stacked
                        .column_mut(n + k)
                        .assign(&(&self.r.column(k) * &imaginary));
                }
                let sums = matmul_h(self.numerators.columns.view(), stacked.view());
                Array2::from_shape_fn((sums.nrows(), n).f(), |(i, k)| {
                    plane.product(i, k, Complex64::new(sums[[i, k]], sums[[i, n + k]]))
                })
            })
            .collect()
    }

    /// Rᴴ diag(weight) R − Σ left_lᴴ right_l.
    pub fn reduced(
        &self,
        plane: Plane,
        weight: &[Complex64],
        left: &[Array2<Complex64>],
        right: &[Array2<Complex64>],
    ) -> Array2<Complex64> {
        let n = self.r.ncols();
        let scaled = |part: &dyn Fn(&Complex64) -> f64| {
            let factor: Array1<f64> = weight.iter().map(part).collect();
            let mut scaled = self.r.clone();
            scaled
                .columns_mut()
                .into_iter()
                .for_each(|mut c| c *= &factor);
            matmul_h(self.r.view(), scaled.view())
        };
        let (real, imaginary) = (scaled(&|w| w.re), scaled(&|w| w.im));
        let whole = Array2::from_shape_fn((n, n).f(), |(i, k)| {
            plane.product(i, k, Complex64::new(real[[i, k]], imaginary[[i, k]]))
        });
        let products: Vec<Array2<Complex64>> = left
            .par_iter()
            .zip(right)
            .map(|(left, right)| matmul_h(left.view(), right.view()))
            .collect();
        products.into_iter().fold(whole, |sum, part| sum - part)
    }

    /// Rᴴ·`values`: coefficients of denominators, one column.
    pub fn along_denominators(&self, plane: Plane, values: &[Complex64]) -> Array2<Complex64> {
        Array2::from_shape_fn((self.r.ncols(), 1), |(k, _)| {
            let column = self.r.column(k);
            let sum: Complex64 = column.iter().zip(values).map(|(r, v)| v * *r).sum();
            plane.in_field(plane.turn(k).conj() * sum)
        })
    }

    /// Coefficients of the numerators that are nearest to `values` (line, column).
    pub fn nearest(&self, plane: Plane, values: &Array2<Complex64>) -> Array2<Complex64> {
        let q = self.numerators.columns.view();
        let real = blocked_matmul_h(q, values.mapv(|v| v.re).view());
        let imaginary = blocked_matmul_h(q, values.mapv(|v| v.im).view());
        Array2::from_shape_fn(real.dim().f(), |(i, l)| {
            let sum = Complex64::new(real[[i, l]], imaginary[[i, l]]);
            plane.in_field(plane.turn(i).conj() * sum)
        })
    }

    /// Values of numerators with these coefficients.
    pub fn values(&self, plane: Plane, coefficients: &Array2<Complex64>) -> Array2<Complex64> {
        let mut turned = coefficients.clone();
        for (i, mut row) in turned.rows_mut().into_iter().enumerate() {
            let turn = plane.turn(i);
            row.mapv_inplace(|v| v * turn);
        }
        let q = self.numerators.columns.view();
        let real = matmul(q, turned.mapv(|v| v.re).view());
        let imaginary = matmul(q, turned.mapv(|v| v.im).view());
        let mut values = Array2::zeros(real.dim().f());
        ndarray::Zip::from(&mut values)
            .and(&real)
            .and(&imaginary)
            .for_each(|v, &re, &im| *v = Complex64::new(re, im));
        values
    }

    /// Roots in t of the denominator with coefficients `d`.
    ///
    /// # Errors
    /// No convergence.
    pub fn roots(&self, plane: Plane, d: &[Complex64]) -> Result<Vec<Complex64>, LinalgError> {
        let turned: Vec<Complex64> = d
            .iter()
            .enumerate()
            .map(|(k, d)| d * plane.turn(k))
            .collect();
        self.denominators.roots(&turned)
    }
}

/// `None` where the lines carry fewer polynomials than were asked for.
pub(crate) fn if_carried<T>(outcome: Result<T, LinalgError>) -> Result<Option<T>, LinalgError> {
    match outcome {
        Err(LinalgError::RankDeficient { .. }) => Ok(None),
        other => other.map(Some),
    }
}

/// Roots with those of negative damping turned over.
pub(crate) fn damped(roots: &[Complex64]) -> Vec<Complex64> {
    roots
        .iter()
        .map(|root| Complex64::new(root.re, root.im.abs()))
        .collect()
}
