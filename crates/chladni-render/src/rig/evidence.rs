//! The most probable gains and shifts around given ones, at the prior of the largest
//! evidence.
//!
//! Noise has the variance σ², and an unexplained mobility adds s²‖A‖², alike under like drives. The
//! scales of s, the level of all gains, gains, common shift and
//! shifts are those of the largest evidence (Laplace); a channel that needs more than its scale
//! beside the level is called odd where the evidence for that is beyond doubt.

use super::normal::Normal;
use super::parts::Parts;
use super::seen::Seen;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Result};
use ndarray::{s, Array1, Array2};
use rayon::prelude::*;

/// Prior standard deviations: unexplained part of the mobility over its rms, gains, their level,
/// common shift, shifts of single modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scales {
    /// Unexplained part.
    pub(crate) unexplained: f64,
    /// Gains.
    pub(crate) gains: f64,
    /// Level that all gains share.
    pub(crate) level: f64,
    /// Common relative shift of natural frequencies.
    pub(crate) common: f64,
    /// Relative shifts of each.
    pub(crate) modes: f64,
}

/// Scales that are tried, each with each, rising: each next one of the level and of the shifts is
/// less likely by `tolerances::WIDER_SCALE`.
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

/// The search for scales around θ.
#[derive(Clone, Copy)]
struct Around<'a> {
    tried: &'a Tried,
    /// Size of the level of all gains there: errors of each multiply it.
    level: f64,
    /// True where some field has phases; else none tells the phase of the level.
    phases: bool,
}

/// A linear model of all fields around θ.
pub(super) struct Posterior {
    /// The odds of its scales counted.
    pub(super) ln_evidence: f64,
    /// The unknowns of [`Parts`]; within a step gains beside their level, which comes last.
    pub(super) theta: Array1<f64>,
    pub(super) covariance: Array2<f64>,
    pub(super) scales: Scales,
    pub(super) odd: Vec<usize>,
}

impl Parts {
    /// One Gauss-Newton step at the scales and odd channels of the largest evidence, odds against
    /// wider scales counted; `odd` are channels that are odd in any case.
    pub(super) fn likeliest(
        &self,
        theta: &Array1<f64>,
        fields: &[Seen],
        tried: &Tried,
        mut odd: Vec<usize>,
    ) -> Result<Posterior> {
        let normals = self.normals(theta, fields)?;
        let alternatives = (self.actuators() as f64).ln();
        let around = Around {
            tried,
            level: self.level(theta),
            phases: fields.iter().any(|seen| !seen.magnitudes_only),
        };
        loop {
            // the best of each scale of gains: an odd channel goes with narrow ones
            let posteriors: Vec<Posterior> = tried
                .gains
                .par_iter()
                .map(|&gains| self.best_of_gains(&normals, gains, around, &odd))
                .collect::<Result<_>>()?;
            let wider = posteriors
                .iter()
                .filter_map(|posterior| {
                    let (channel, gain) = self.oddest(posterior, around.level, &odd)?;
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
                _ => return Ok(self.joined(plain, odd)),
            }
        }
    }

    /// The posterior of the largest evidence at one scale of gains.
    fn best_of_gains(
        &self,
        normals: &[(f64, Normal)],
        gains: f64,
        around: Around,
        odd: &[usize],
    ) -> Result<Posterior> {
        let tried = around.tried;
        let gain_precision = self.gain_precision(gains, around.level, odd);
        let mut best: Option<(f64, Scales, &Normal)> = None;
        for (unexplained, normal) in normals {
            let shifts = normal.eliminated(&gain_precision)?;
            for (widened, &common) in tried.common.iter().enumerate() {
                for (further, &modes) in tried.modes.iter().enumerate() {
                    for (off, &level) in tolerances::LEVEL_SCALES.iter().enumerate() {
                        let scales = Scales {
                            unexplained: *unexplained,
                            gains,
                            level,
                            common,
                            modes,
                        };
                        let doubt = tolerances::WIDER_SCALE * (widened + further + off) as f64;
                        let precision = self.shift_precision(&scales, around.phases);
                        let evidence = shifts.ln_evidence(&precision)? - doubt;
                        if best.is_none_or(|(most, ..)| evidence > most) {
                            best = Some((evidence, scales, normal));
                        }
                    }
                }
            }
        }
        let (ln_evidence, scales, normal) =
            best.ok_or_else(|| Error::new(ErrorKind::Internal, "no scale of shifts"))?;
        let mut precision = gain_precision;
        precision.extend(self.shift_precision(&scales, around.phases));
        let (theta, covariance) = normal.posterior(&precision)?;
        Ok(Posterior {
            theta,
            ln_evidence,
            covariance,
            scales,
            odd: Vec::new(),
        })
    }

    /// The posterior of gains that hold their level.
    fn joined(&self, apart: Posterior, odd: Vec<usize>) -> Posterior {
        let (unknowns, gains) = (self.unknowns(), 2 * self.actuators());
        let mut theta = apart.theta.slice(s![..unknowns]).to_owned();
        let mut rows = apart.covariance.slice(s![..unknowns, ..]).to_owned();
        for i in 0..gains {
            let level = unknowns + i % tolerances::LEVEL_PARTS;
            theta[i] += apart.theta[level];
            let mut row = rows.row_mut(i);
            row += &apart.covariance.row(level);
        }
        let mut covariance = rows.slice(s![.., ..unknowns]).to_owned();
        for i in 0..gains {
            let mut column = covariance.column_mut(i);
            column += &rows.column(unknowns + i % tolerances::LEVEL_PARTS);
        }
        Posterior {
            theta,
            covariance,
            odd,
            ..apart
        }
    }

    /// The channel whose gain needs a wider prior most, and what the evidence gains by it.
    fn oddest(&self, posterior: &Posterior, level: f64, odd: &[usize]) -> Option<(usize, f64)> {
        let wide = 2.0 / (level * tolerances::ODD_GAIN_ERROR).powi(2);
        let narrow = 2.0 / (level * posterior.scales.gains).powi(2);
        let gain = |i: usize| widened(i, &posterior.theta, &posterior.covariance, [wide, narrow]);
        (0..self.actuators())
            .filter(|i| !odd.contains(i))
            .map(|i| (i, gain(i)))
            .filter(|(_, gain)| gain.is_finite())
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Prior precision of the real and the imaginary part of each gain error.
    fn gain_precision(&self, gains: f64, level: f64, odd: &[usize]) -> Vec<f64> {
        let std = |i: usize| match odd.contains(&(i / 2)) {
            true => tolerances::ODD_GAIN_ERROR,
            false => gains,
        };
        (0..2 * self.actuators())
            .map(|i| 2.0 / (level * std(i)).powi(2))
            .collect()
    }

    /// The same of the shift of each mode, of the common one and of the level of all gains.
    fn shift_precision(&self, scales: &Scales, phases: bool) -> Vec<f64> {
        let mut precision = vec![2.0 / scales.modes.powi(2); 2 * self.modes()];
        precision.push(1.0 / scales.common.powi(2));
        let turn = match phases {
            true => scales.level,
            false => tolerances::LEVEL_SCALES[0],
        };
        precision.extend([scales.level, turn].map(|std| 2.0 / std.powi(2)));
        precision
    }
}

/// Growth of ln of the evidence where gain `i` alone gets the prior precision `wide` in place of
/// `narrow`.
///
/// * `sizes`, `covariance`: of all gains under the narrow one, real and imaginary parts in turn
pub(super) fn widened(
    i: usize,
    sizes: &Array1<f64>,
    covariance: &Array2<f64>,
    [wide, narrow]: [f64; 2],
) -> f64 {
    let (a, b) = (2 * i, 2 * i + 1);
    let (c, change) = (covariance, wide - narrow);
    // I + ΣΔ, two by two
    let [[m00, m01], [m10, m11]] = [
        [1.0 + c[[a, a]] * change, c[[a, b]] * change],
        [c[[b, a]] * change, 1.0 + c[[b, b]] * change],
    ];
    let det = m00 * m11 - m01 * m10;
    let (x, y) = (sizes[a], sizes[b]);
    let solved = [(m11 * x - m01 * y) / det, (m00 * y - m10 * x) / det];
    let quadratic = change * (x * solved[0] + y * solved[1]);
    (wide / narrow).ln() - 0.5 * det.ln() - 0.5 * quadratic
}
