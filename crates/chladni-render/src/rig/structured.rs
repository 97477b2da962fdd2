//! The structured update: gains of the channels, shifts of the poles.
//!
//! The unknowns θ of `parts` (theory.md, eq. 58) are the most probable ones given all
//! fields: Gauss-Newton, each step at the prior of the largest evidence (`evidence`).

use super::evidence::{Scales, Tried};
use super::parts::{denominator, Parts};
use super::seen::Seen;
use crate::panel::kernel_error::unsolvable;
use crate::tolerances;
use chladni_frf::{Damping, Mode, Result};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Gains and poles as the fields tell them.
#[derive(Debug, Clone)]
pub(crate) struct Structured {
    /// Scales of the largest evidence.
    pub(crate) scales: Scales,
    /// ln of that evidence, to a constant of the fields.
    pub(crate) ln_evidence: f64,
    /// Channels that are odd.
    pub(crate) odd: Vec<usize>,
    /// Gain error of each channel.
    pub(crate) gains: Array1<Complex64>,
    /// Relative shift of all.
    pub(crate) common: f64,
    /// Its standard deviation.
    pub(crate) common_std: f64,
    /// Corrected mobility.
    pub(crate) mobility: Array2<Complex64>,
    /// Mean covariance of its rows.
    pub(crate) covariance: Array2<Complex64>,
    /// Standard deviation of each gain error.
    pub(crate) gain_std: Vec<f64>,
    /// Relative shift of each mode in the band, the common one included.
    pub(crate) shifts: Vec<Complex64>,
    /// Standard deviation of their real parts.
    pub(crate) shift_std: Vec<f64>,
    /// The same of their imaginary parts.
    pub(crate) damping_std: Vec<f64>,
    /// All unknowns: where the search goes on once another field is known.
    pub(crate) theta: Array1<f64>,
}

impl Parts {
    /// The most probable gains and shifts under all fields, sought from `start` on.
    ///
    /// # Errors
    /// Those of the factorisations.
    pub(crate) fn update(
        &self,
        fields: &[Seen],
        start: Option<&Array1<f64>>,
        tried: &Tried,
    ) -> Result<Structured> {
        let mut theta = match start {
            Some(start) => start.clone(),
            None => Array1::zeros(self.unknowns()),
        };
        let mut best = self.likeliest(&theta, fields, tried, Vec::new())?;
        for _ in 1..tolerances::STRUCTURED_STEPS {
            let change = &best.theta - &theta;
            let [change, size] = [&change, &best.theta].map(|values| values.dot(values).sqrt());
            if change <= tolerances::STRUCTURED_CHANGE * size {
                break;
            }
            let [before, now] = [&theta, &best.theta].map(|theta| self.level(theta));
            let odd = match (now / before - 1.0).abs() > tolerances::LEVEL_MOVED {
                true => Vec::new(),
                false => best.odd,
            };
            theta.assign(&best.theta);
            best = self.likeliest(&theta, fields, tried, odd)?;
        }
        let theta = best.theta;
        let count = self.actuators();
        let of = |at: usize| Complex64::new(theta[at], theta[at + 1]);
        Ok(Structured {
            scales: best.scales,
            ln_evidence: best.ln_evidence,
            gains: (0..count).map(|i| of(2 * i)).collect(),
            common: theta[theta.len() - 1],
            common_std: best.covariance[[theta.len() - 1, theta.len() - 1]].sqrt(),
            mobility: self.mobility(&theta),
            covariance: self.row_covariance(&theta, &best.covariance)?,
            gain_std: (0..count)
                .map(|i| {
                    let variance = &best.covariance;
                    (variance[[2 * i, 2 * i]] + variance[[2 * i + 1, 2 * i + 1]]).sqrt()
                })
                .collect(),
            shifts: (0..self.modes()).map(|n| self.shift(&theta, n)).collect(),
            shift_std: (0..self.modes())
                .map(|n| {
                    let (own, common) = (2 * (count + n), theta.len() - 1);
                    let variance = &best.covariance;
                    let sum = variance[[own, own]] + variance[[common, common]];
                    (sum + 2.0 * variance[[own, common]]).max(0.0).sqrt()
                })
                .collect(),
            damping_std: (0..self.modes())
                .map(|n| {
                    let imaginary = 2 * (count + n) + 1;
                    best.covariance[[imaginary, imaginary]].sqrt()
                })
                .collect(),
            odd: best.odd,
            theta,
        })
    }

    /// One dead or reversed channel that foretells magnitudes far better than none does, as
    /// unknowns to start from. Such a channel turns the phases, which nobody measured, so far
    /// that the search from nothing ends beside it. `None` where every field has phases.
    pub(crate) fn lone_fault(&self, fields: &[Seen]) -> Option<Array1<f64>> {
        if !fields.iter().any(|seen| seen.magnitudes_only) {
            return None;
        }
        let paths = fields.iter().map(|seen| {
            let rows = self.whole.select(Axis(0), &seen.rows);
            let foretold = rows.dot(&seen.drive);
            (seen, rows, foretold)
        });
        let paths: Vec<_> = paths.collect();
        let miss = |channel: usize, error: f64| -> f64 {
            let of_field =
                |(seen, rows, foretold): &(&Seen, Array2<Complex64>, Array1<Complex64>)| {
                    let changed = foretold + &rows.column(channel) * (seen.drive[channel] * error);
                    let pairs = seen.velocity.iter().zip(&changed);
                    let squares = pairs.map(|(seen, told)| (seen.norm() - told.norm()).powi(2));
                    squares.sum::<f64>() / seen.noise.powi(2)
                };
            paths.iter().map(of_field).sum()
        };
        let faults = (0..self.actuators()).flat_map(|i| [(i, -1.0), (i, -2.0)]);
        let missed = faults.map(|(channel, error)| (miss(channel, error), channel, error));
        let (least, channel, error) = missed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (least < tolerances::LONE_FAULT * miss(0, 0.0)).then(|| {
            let mut theta = Array1::zeros(self.unknowns());
            theta[2 * channel] = error;
            theta
        })
    }

    /// mean_k Σ_pq Cov_pq D_pkᴴD_qk with the slopes D of the mobility: mean_k E_kᴴE_k, where
    /// E = LᵀD and Cov = LLᵀ. The real and the imaginary part of an unknown have the slopes D
    /// and jD: they add (L_re + j·L_im)·D to E. A gain moves its own channel alone, a shift
    /// the halves of its mode: for one column of L, E = U·diag(s)·V + M·diag(g), with the
    /// shapes U, the slopes V and the mobility M. The sums over those columns are taken first.
    fn row_covariance(
        &self,
        theta: &Array1<f64>,
        covariance: &Array2<f64>,
    ) -> Result<Array2<Complex64>> {
        let (responses, count) = self.whole.dim();
        let mut jittered = covariance.clone();
        let mean = jittered.diag().sum() / jittered.nrows() as f64;
        jittered
            .diag_mut()
            .mapv_inplace(|value| value + mean * tolerances::RIDGE);
        let root = chladni_linalg::cholesky(jittered.view()).map_err(unsolvable)?;
        let last = root.row(self.unknowns() - 1);
        let pair = |at: usize, e: usize| Complex64::new(root[[2 * at, e]], root[[2 * at + 1, e]]);
        let gains = Array2::from_shape_fn((self.unknowns(), count), |(e, i)| pair(i, e));
        let shifts = Array2::from_shape_fn((self.unknowns(), self.shapes.ncols()), |(e, half)| {
            pair(count + half % self.modes(), e) + last[e]
        });
        let gram = |a: &Array2<Complex64>, b: &Array2<Complex64>| {
            chladni_linalg::matmul_h(a.view(), b.view())
        };
        let (slopes, moved) = (self.shift_slopes(theta), self.moved(theta));
        let of_shifts = gram(&shifts, &shifts) * gram(&self.shapes, &self.shapes);
        let across = gram(&shifts, &gains) * gram(&self.shapes, &moved);
        let across = gram(&slopes, &across);
        let of_shifts = chladni_linalg::matmul(of_shifts.view(), slopes.view());
        let sum = gram(&slopes, &of_shifts)
            + gram(&gains, &gains) * gram(&moved, &moved)
            + &across
            + across.t().mapv(|value| value.conj());
        Ok(sum.mapv(|value| value / responses as f64))
    }
}

impl Structured {
    /// The factor that all channels share but for odd ones; `None` where they have the level of a
    /// calibrated rig.
    pub(crate) fn common_factor(&self) -> Option<Complex64> {
        if self.scales.level < tolerances::LEVEL_SCALES[1] {
            return None;
        }
        let even = (0..self.gains.len()).filter(|i| !self.odd.contains(i));
        let gains: Vec<Complex64> = even.map(|i| 1.0 + self.gains[i]).collect();
        let sum = gains.iter().sum::<Complex64>();
        (!gains.is_empty()).then(|| sum / gains.len() as f64)
    }

    /// Natural frequency, Hz, and loss factor that give mode `k` in the band the denominator
    /// of its shift at the drive frequency.
    pub(crate) fn moved_pole(
        &self,
        k: usize,
        mode: &Mode,
        damping: Damping,
        drive_hz: f64,
    ) -> (f64, f64) {
        let omega = TAU * drive_hz;
        let [square, linear] = denominator(mode, damping, omega);
        let at = 1.0 + self.shifts[k];
        let moved = (square * at + linear) * at;
        if moved.re <= 0.0 || moved.im < 0.0 {
            return (mode.frequency_hz, mode.loss_factor);
        }
        let own = moved.re.sqrt();
        let loss_factor = match damping {
            Damping::Structural => moved.im / moved.re,
            Damping::Viscous => moved.im / (own * omega),
        };
        (own / TAU, loss_factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::operator::Operator;
    use crate::test_model::test_model;

    /// The covariance of the rows is the sum over all pairs of unknowns, in both laws.
    #[test]
    fn row_covariance_is_the_sum_over_pairs_of_unknowns() {
        for damping in [Damping::Structural, Damping::Viscous] {
            let model = test_model(damping, &[(80.0, 0.08), (120.0, 0.05)], [5, 2]);
            let operator = Operator::of_model(&model, 100.0, None).unwrap();
            let parts = Parts::new(&model, &operator);
            let (unknowns, count) = (parts.unknowns(), parts.actuators());
            let some = |p: usize| 0.02 * (1.7 * p as f64 + 0.3).sin();
            let theta: Array1<f64> = (0..unknowns).map(some).collect();
            let covariance = Array2::from_shape_fn((unknowns, unknowns), |(p, q)| {
                some(p + 3) * some(q + 3) + if p == q { 1e-3 } else { 0.0 }
            });
            let slopes: Vec<Array2<Complex64>> = (0..count)
                .map(|i| {
                    let mut alone = Array1::zeros(count);
                    alone[i] = Complex64::ONE;
                    parts.field(&theta, &alone).1
                })
                .collect();
            let responses = operator.responses.len();
            let direct = Array2::from_shape_fn((count, count), |(i, j)| {
                let mut sum = Complex64::ZERO;
                for ((p, q), &value) in covariance.indexed_iter() {
                    for k in 0..responses {
                        sum += slopes[i][[k, p]].conj() * slopes[j][[k, q]] * value;
                    }
                }
                sum / responses as f64
            });
            let found = parts.row_covariance(&theta, &covariance).unwrap();
            let size = |m: &Array2<Complex64>| m.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
            let apart = size(&(&found - &direct));
            assert!(apart < 1e-9 * size(&direct), "{damping:?}: {apart:e}");
        }
    }

    #[test]
    fn a_moved_pole_has_the_denominator_of_its_shift() {
        for damping in [Damping::Structural, Damping::Viscous] {
            let mode = test_model(damping, &[(80.0, 0.08)], [2, 1]).modes[0].clone();
            let [square, linear] = denominator(&mode, damping, TAU * 100.0);
            let shift = Complex64::new(0.01, 0.005);
            let structured = Structured {
                scales: Scales {
                    unexplained: 0.0,
                    gains: 0.0,
                    level: 0.0,
                    common: 0.0,
                    modes: 0.0,
                },
                ln_evidence: 0.0,
                odd: Vec::new(),
                gains: Array1::zeros(1),
                common: 0.0,
                common_std: 0.0,
                mobility: Array2::zeros((2, 1)),
                covariance: Array2::zeros((1, 1)),
                gain_std: vec![0.0],
                shifts: vec![shift],
                shift_std: vec![0.0],
                damping_std: vec![0.0],
                theta: Array1::zeros(1),
            };
            let (frequency_hz, loss_factor) = structured.moved_pole(0, &mode, damping, 100.0);
            let moved = Mode {
                frequency_hz,
                loss_factor,
                ..mode
            };
            let [a, b] = denominator(&moved, damping, TAU * 100.0);
            let asked = (square * (1.0 + shift) + linear) * (1.0 + shift);
            assert!((a + b - asked).norm() < 1e-9 * asked.norm(), "{damping:?}");
            assert!(frequency_hz > 80.5 && loss_factor > 0.085, "{damping:?}");
        }
    }
}
