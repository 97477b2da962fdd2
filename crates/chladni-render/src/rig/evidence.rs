//! The most probable gains and shifts around given ones, at the prior of the largest
//! evidence.
//!
//! The noise is σ² + s²‖A‖². The scales of s, gains, common shift and shifts are those of
//! the largest evidence (Laplace); a channel that needs more than its scale is called odd
//! where the evidence for that is beyond doubt.

use super::field::rms;
use super::parts::Parts;
use super::seen::Seen;
use crate::kernel_error::unsolvable;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Result};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// Prior standard deviations: unexplained part of the mobility over its rms, gains, common
/// shift, shifts of single modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scales {
    /// Unexplained part.
    pub(crate) unexplained: f64,
    /// Gains.
    pub(crate) gains: f64,
    /// Common relative shift of natural frequencies.
    pub(crate) common: f64,
    /// Relative shifts of each.
    pub(crate) modes: f64,
}

/// Scales that are tried, each with each, rising: each next one of the shifts is less likely
/// by `tolerances::WIDER_SCALE`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tried {
    gains: &'static [f64],
    common: &'static [f64],
    modes: &'static [f64],
}

impl Tried {
    /// Whatever may be wrong with a rig.
    pub(crate) const OF_RIG: Self = Self {
        gains: &tolerances::GAIN_SCALES,
        common: &tolerances::COMMON_SCALES,
        modes: &tolerances::MODE_SCALES,
    };

    /// A common shift of any size behind usual amplifiers: its error bar must not be that of
    /// a scale that happened to do.
    pub(crate) const OF_SHIFT: Self = Self {
        gains: &[tolerances::RIG_DRIVE_ERROR],
        common: &[tolerances::ANY_SHIFT],
        modes: &[tolerances::MODE_SCALES[0]],
    };
}

/// Whitened normal equations of all fields at one θ, by the scale of the unexplained part.
struct Normal {
    matrix: Array2<f64>,
    right: Array1<f64>,
    /// −½ rᵀr − Σ ln σ, to a constant.
    ln_likelihood: f64,
}

/// Normal equations under a prior.
struct Weighed {
    matrix: Array2<f64>,
    right: Array1<f64>,
    ln_evidence: f64,
}

/// A linear model of all fields around θ.
pub(super) struct Posterior {
    /// The odds of its scales counted.
    pub(super) ln_evidence: f64,
    pub(super) theta: Array1<f64>,
    pub(super) covariance: Array2<f64>,
    pub(super) scales: Scales,
    pub(super) odd: Vec<usize>,
}

impl Parts {
    /// One Gauss-Newton step at the scales and odd channels of the largest evidence, odds against
    /// wider scales counted.
    pub(super) fn likeliest(
        &self,
        theta: &Array1<f64>,
        fields: &[Seen],
        tried: &Tried,
    ) -> Result<Posterior> {
        let normals: Vec<(f64, Normal)> = tolerances::UNEXPLAINED_SCALES
            .par_iter()
            .map(|&s| (s, self.normal(theta, fields, s)))
            .collect();
        let alternatives = (self.actuators() as f64).ln();
        let mut odd = Vec::new();
        loop {
            // the best of each scale of gains: an odd channel goes with narrow ones
            let posteriors: Vec<Posterior> = tried
                .gains
                .par_iter()
                .map(|&gains| self.best_of_gains(theta, &normals, (gains, tried), &odd))
                .collect::<Result<_>>()?;
            let wider = posteriors
                .iter()
                .filter_map(|posterior| {
                    let (channel, gain) = self.oddest(posterior, &odd)?;
                    Some((posterior.ln_evidence + gain, channel))
                })
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let plain = posteriors
                .into_iter()
                .max_by(|a, b| a.ln_evidence.total_cmp(&b.ln_evidence))
                .ok_or_else(|| Error::new(ErrorKind::Internal, "no scale of gains"))?;
            match wider {
                Some((with, channel))
                    if with - plain.ln_evidence - alternatives > tolerances::ODD_EVIDENCE
                        && odd.len() < tolerances::MOST_ODD =>
                {
                    odd.push(channel);
                }
                _ => return Ok(Posterior { odd, ..plain }),
            }
        }
    }

    /// The posterior of the largest evidence at one scale of gains.
    fn best_of_gains(
        &self,
        theta: &Array1<f64>,
        normals: &[(f64, Normal)],
        (gains, tried): (f64, &Tried),
        odd: &[usize],
    ) -> Result<Posterior> {
        let mut best: Option<(f64, Scales, &Normal)> = None;
        for (unexplained, normal) in normals {
            for (widened, &common) in tried.common.iter().enumerate() {
                for (further, &modes) in tried.modes.iter().enumerate() {
                    let scales = Scales {
                        unexplained: *unexplained,
                        gains,
                        common,
                        modes,
                    };
                    let doubt = tolerances::WIDER_SCALE * (widened + further) as f64;
                    let evidence = self.weighed(theta, normal, &scales, odd)?.ln_evidence - doubt;
                    if best.is_none_or(|(most, ..)| evidence > most) {
                        best = Some((evidence, scales, normal));
                    }
                }
            }
        }
        let (ln_evidence, scales, normal) =
            best.ok_or_else(|| Error::new(ErrorKind::Internal, "no scale of shifts"))?;
        let Weighed { matrix, right, .. } = self.weighed(theta, normal, &scales, odd)?;
        let covariance = chladni_linalg::inverse_hermitian(matrix.view()).map_err(unsolvable)?;
        Ok(Posterior {
            theta: covariance.dot(&right),
            ln_evidence,
            covariance,
            scales,
            odd: Vec::new(),
        })
    }

    /// The normal equations under a prior, and the evidence for it.
    fn weighed(
        &self,
        theta: &Array1<f64>,
        normal: &Normal,
        scales: &Scales,
        odd: &[usize],
    ) -> Result<Weighed> {
        let precision = self.prior(scales, odd);
        let mut matrix = normal.matrix.clone();
        for (value, precision) in matrix.diag_mut().iter_mut().zip(&precision) {
            *value += precision;
        }
        // around θ the data see M·θ + b
        let shifted = normal.matrix.dot(theta);
        let right = &normal.right + &shifted;
        let root = chladni_linalg::cholesky(matrix.view()).map_err(unsolvable)?;
        let column = right.view().insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), column).map_err(unsolvable)?;
        let ln_det = 2.0 * root.diag().iter().map(|value| value.ln()).sum::<f64>();
        let ln_prior = precision.iter().map(|value| value.ln()).sum::<f64>();
        // −½ rᵀr at θ, moved to the next one
        let quadratic = white.iter().map(|value| value * value).sum::<f64>()
            - theta.dot(&shifted)
            - 2.0 * normal.right.dot(theta);
        Ok(Weighed {
            matrix,
            right,
            ln_evidence: normal.ln_likelihood + 0.5 * (quadratic - ln_det + ln_prior),
        })
    }

    /// The channel whose gain needs a wider prior most, and what the evidence gains by it.
    fn oddest(&self, posterior: &Posterior, odd: &[usize]) -> Option<(usize, f64)> {
        let wide = 2.0 / tolerances::ODD_GAIN_ERROR.powi(2);
        let narrow = 2.0 / posterior.scales.gains.powi(2);
        let change = wide - narrow;
        let gain = |i: usize| {
            let (a, b) = (2 * i, 2 * i + 1);
            let c = &posterior.covariance;
            // I + ΣΔ, two by two
            let [[m00, m01], [m10, m11]] = [
                [1.0 + c[[a, a]] * change, c[[a, b]] * change],
                [c[[b, a]] * change, 1.0 + c[[b, b]] * change],
            ];
            let det = m00 * m11 - m01 * m10;
            let (x, y) = (posterior.theta[a], posterior.theta[b]);
            let solved = [(m11 * x - m01 * y) / det, (m00 * y - m10 * x) / det];
            let quadratic = change * (x * solved[0] + y * solved[1]);
            (wide / narrow).ln() - 0.5 * det.ln() - 0.5 * quadratic
        };
        (0..self.actuators())
            .filter(|i| !odd.contains(i))
            .map(|i| (i, gain(i)))
            .filter(|(_, gain)| gain.is_finite())
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn normal(&self, theta: &Array1<f64>, fields: &[Seen], unexplained: f64) -> Normal {
        let unknowns = self.unknowns();
        let mut normal = Normal {
            matrix: Array2::zeros((unknowns, unknowns)),
            right: Array1::zeros(unknowns),
            ln_likelihood: 0.0,
        };
        let size = rms(&self.whole.iter().copied().collect());
        for seen in fields {
            let (field, slope) = self.field(theta, &seen.drive);
            let force = seen.drive.iter().map(Complex64::norm_sqr).sum::<f64>();
            let spread = (unexplained * size).powi(2) * force;
            let variance = match seen.magnitudes_only {
                true => seen.noise.powi(2) + 0.5 * spread,
                false => 0.5 * (seen.noise.powi(2) + spread),
            };
            let scale = 1.0 / variance.sqrt();
            let parts = if seen.magnitudes_only { 1 } else { 2 };
            let mut rows = Array2::<f64>::zeros((parts * seen.rows.len(), unknowns));
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
                    let value = value * turn * scale;
                    rows[[parts * k, p]] = value.re;
                    if parts == 2 {
                        rows[[2 * k + 1, p]] = value.im;
                    }
                }
                left[parts * k] = difference.re * scale;
                if parts == 2 {
                    left[2 * k + 1] = difference.im * scale;
                }
            }
            normal.matrix += &chladni_linalg::matmul_h(rows.view(), rows.view());
            normal.right += &rows.t().dot(&left);
            normal.ln_likelihood -=
                0.5 * left.dot(&left) + 0.5 * rows.nrows() as f64 * variance.ln();
        }
        normal
    }

    fn prior(&self, scales: &Scales, odd: &[usize]) -> Array1<f64> {
        let count = self.actuators();
        let mut precision = Array1::zeros(self.unknowns());
        for i in 0..count {
            let std = if odd.contains(&i) {
                tolerances::ODD_GAIN_ERROR
            } else {
                scales.gains
            };
            precision[2 * i] = 2.0 / (std * std);
            precision[2 * i + 1] = 2.0 / (std * std);
        }
        let last = self.unknowns() - 1;
        for value in precision.iter_mut().take(last).skip(2 * count) {
            *value = 2.0 / scales.modes.powi(2);
        }
        precision[last] = 1.0 / scales.common.powi(2);
        precision
    }
}
