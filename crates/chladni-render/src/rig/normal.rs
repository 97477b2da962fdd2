//! Normal equations of all fields over gains and shifts.
//!
//! Around θ the fields are M·θ + b behind white noise. Evidence is asked for many priors of
//! the shifts under each prior of the gains: the gains, most of the unknowns, are eliminated
//! once for all of them. A gain is the level of all channels plus an error of its own: the level
//! comes after all other unknowns (theory.md, eq. 58).

use super::parts::Parts;
use super::seen::Seen;
use crate::kernel_error::unsolvable;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::{s, Array1, Array2, ArrayView1, ArrayViewMut1, Axis};
use num_complex::Complex64;

/// Whitened normal equations of all fields, at one scale of the unexplained part.
pub(super) struct Normal {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// ln of the likelihood that the linear model has at θ = 0, to a constant.
    ln_likelihood: f64,
}

/// The equations of the shifts and of the level alone, gains eliminated under a prior of theirs.
pub(super) struct Eliminated {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// ln of the evidence without what the shifts add.
    ln_evidence: f64,
}

/// The part of one field in the normal equations, before its noise weighs it.
struct Share {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// Σ of the squares of what the linear model leaves at θ = 0.
    square: f64,
    /// Real numbers that were measured.
    values: usize,
    /// Σ|drive|²
    force: f64,
}

impl Parts {
    /// The normal equations around θ, by the scale of the unexplained part.
    pub(super) fn normals(&self, theta: &Array1<f64>, fields: &[Seen]) -> Vec<(f64, Normal)> {
        let size = self.size();
        let shares: Vec<Share> = fields.iter().map(|seen| self.share(theta, seen)).collect();
        let normal = |&unexplained: &f64| {
            let unknowns = self.unknowns() + tolerances::LEVEL_PARTS;
            let mut normal = Normal {
                matrix: Array2::zeros((unknowns, unknowns)),
                right: Array1::zeros(unknowns),
                ln_likelihood: 0.0,
            };
            for (seen, share) in fields.iter().zip(&shares) {
                let spread = (unexplained * size).powi(2) * share.force;
                let variance = match seen.magnitudes_only {
                    true => seen.noise.powi(2) + 0.5 * spread,
                    false => 0.5 * (seen.noise.powi(2) + spread),
                };
                normal.matrix.scaled_add(1.0 / variance, &share.matrix);
                normal.right.scaled_add(1.0 / variance, &share.right);
                normal.ln_likelihood -=
                    0.5 * (share.square / variance + share.values as f64 * variance.ln());
            }
            (unexplained, normal)
        };
        tolerances::UNEXPLAINED_SCALES.iter().map(normal).collect()
    }

    fn share(&self, theta: &Array1<f64>, seen: &Seen) -> Share {
        let (field, slope) = self.field(theta, &seen.drive);
        let parts = if seen.magnitudes_only { 1 } else { 2 };
        let unknowns = self.unknowns();
        let mut rows =
            Array2::<f64>::zeros((parts * seen.rows.len(), unknowns + tolerances::LEVEL_PARTS));
        let mut left = Array1::<f64>::zeros(rows.nrows());
        for (k, (&row, &measured)) in seen.rows.iter().zip(&seen.velocity).enumerate() {
            let foretold = field[row];
            // along the foretold phase, where none was measured
            let turn = match seen.magnitudes_only {
                true => foretold.conj() / foretold.norm().max(f64::MIN_POSITIVE),
                false => Complex64::ONE,
            };
            let difference = match seen.magnitudes_only {
                true => Complex64::from(measured.norm() - foretold.norm()),
                false => measured - foretold,
            };
            for (p, &value) in slope.row(row).iter().enumerate() {
                let value = value * turn;
                rows[[parts * k, p]] = value.re;
                if parts == 2 {
                    rows[[2 * k + 1, p]] = value.im;
                }
            }
            left[parts * k] = difference.re;
            if parts == 2 {
                left[2 * k + 1] = difference.im;
            }
        }
        left += &rows.slice(s![.., ..unknowns]).dot(theta);
        for part in 0..tolerances::LEVEL_PARTS {
            let of_gains = rows.slice(s![.., part..2 * self.actuators(); 2]);
            let all = of_gains.sum_axis(Axis(1));
            rows.column_mut(unknowns + part).assign(&all);
        }
        Share {
            matrix: chladni_linalg::matmul_h(rows.view(), rows.view()),
            right: rows.t().dot(&left),
            square: left.dot(&left),
            values: left.len(),
            force: seen.drive.iter().map(Complex64::norm_sqr).sum(),
        }
    }
}

impl Normal {
    /// The equations of the shifts, gains eliminated under their prior precision.
    ///
    /// # Errors
    /// Those of the factorisations.
    pub(super) fn eliminated(&self, gains: &[f64]) -> Result<Eliminated> {
        let count = gains.len();
        let mut own = self.matrix.slice(s![..count, ..count]).to_owned();
        add(own.diag_mut(), gains);
        let root = chladni_linalg::cholesky(own.view()).map_err(unsolvable)?;
        let across = self.matrix.slice(s![..count, count..]);
        let across = chladni_linalg::solve_lower(root.view(), across).map_err(unsolvable)?;
        let right = self.right.slice(s![..count]).insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), right).map_err(unsolvable)?;
        let white = white.column(0);
        let within = chladni_linalg::matmul_h(across.view(), across.view());
        Ok(Eliminated {
            matrix: &self.matrix.slice(s![count.., count..]) - &within,
            right: &self.right.slice(s![count..]) - &across.t().dot(&white),
            ln_evidence: self.ln_likelihood + gained(&root, white, gains),
        })
    }

    /// The most probable unknowns under a prior, and their covariance.
    ///
    /// # Errors
    /// Those of the factorisation.
    pub(super) fn posterior(&self, precision: &[f64]) -> Result<(Array1<f64>, Array2<f64>)> {
        let mut matrix = self.matrix.clone();
        add(matrix.diag_mut(), precision);
        let covariance = chladni_linalg::inverse_hermitian(matrix.view()).map_err(unsolvable)?;
        Ok((covariance.dot(&self.right), covariance))
    }
}

impl Eliminated {
    /// ln of the evidence for a prior of the shifts.
    ///
    /// # Errors
    /// Those of the factorisation.
    pub(super) fn ln_evidence(&self, precision: &[f64]) -> Result<f64> {
        let mut matrix = self.matrix.clone();
        add(matrix.diag_mut(), precision);
        let root = chladni_linalg::cholesky(matrix.view()).map_err(unsolvable)?;
        let right = self.right.view().insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), right).map_err(unsolvable)?;
        Ok(self.ln_evidence + gained(&root, white.column(0), precision))
    }
}

/// The evidence that unknowns with a prior add: ½|L⁻¹b|² − ½ ln det LLᵀ + ½ ln det P.
fn gained(root: &Array2<f64>, white: ArrayView1<f64>, precision: &[f64]) -> f64 {
    let ln_det = 2.0 * root.diag().iter().map(|value| value.ln()).sum::<f64>();
    let ln_prior = precision.iter().map(|value| value.ln()).sum::<f64>();
    0.5 * (white.dot(&white) - ln_det + ln_prior)
}

fn add(mut diagonal: ArrayViewMut1<f64>, precision: &[f64]) {
    for (value, precision) in diagonal.iter_mut().zip(precision) {
        *value += precision;
    }
}
