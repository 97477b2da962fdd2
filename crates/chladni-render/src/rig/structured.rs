//! The structured update: gains of the channels, shifts of the poles.
//!
//! H(θ) = [Σ_n f_n(δ_n + c)·P_n + R]·diag(1 + g), f_n(δ) = d_n(0)/d_n(δ)
//! (theory.md, eq. 58),
//!
//! with d_n(δ) = ω_n²(1 + jη_n)(1 + δ)² − ω² under structural damping and
//! ω_n²(1 + δ)² + jη_nω_nω(1 + δ) − ω² under viscous damping,
//! with a complex gain error g for each channel, a complex shift δ for each mode in the band
//! and a real shift c of all. θ is the most probable one given all fields (Gauss-Newton),
//! with a noise σ² + s²‖A‖². The scales of s, gains, common shift and shifts are those of the
//! largest evidence (Laplace); a channel that needs more than its scale is called odd where
//! the evidence for that is beyond doubt.

use super::field::rms;
use crate::kernel_error::unsolvable;
use crate::modal_field::mode_mobility;
use crate::operator::Operator;
use crate::problem::Drive;
use crate::tolerances;
use chladni_frf::{Damping, Error, ErrorKind, ModalModel, Mode, Result, Trust};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A measured field as an update takes it.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    /// The drive that made it.
    pub(crate) drive: Drive,
    /// Rows of the operator that were measured.
    pub(crate) rows: Vec<usize>,
    /// Velocities there, m/s; magnitudes where phases are unknown.
    pub(crate) velocity: Array1<Complex64>,
    /// Root of the mean square of their standard deviations, m/s.
    pub(crate) noise: f64,
    /// True where phases are unknown.
    pub(crate) magnitudes_only: bool,
}

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

/// Gains and poles as the fields tell them.
#[derive(Debug, Clone)]
pub(crate) struct Structured {
    /// Scales of the largest evidence.
    pub(crate) scales: Scales,
    /// Channels that are odd.
    pub(crate) odd: Vec<usize>,
    /// Gain error of each channel.
    pub(crate) gains: Array1<Complex64>,
    /// Relative shift of all.
    pub(crate) common: f64,
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
    /// All unknowns: where the search goes on once another field is known.
    theta: Array1<f64>,
}

/// The parts of the mobility that can move.
pub(crate) struct Parts {
    /// Of each mode in the band, a and b of its denominator a(1 + δ)² + b(1 + δ) − ω².
    poles: Vec<[Complex64; 2]>,
    omega_squared: f64,
    /// Share of each of these modes in the mobility.
    modes: Vec<Array2<Complex64>>,
    /// The mobility as the model has it.
    whole: Array2<Complex64>,
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

impl Parts {
    /// Takes the operator of `model` apart.
    pub(crate) fn new(model: &ModalModel, operator: &Operator) -> Self {
        let omega = TAU * operator.frequency_hz;
        let counts = |mode: &&Mode| mode.in_band && mode.trust != Trust::Rejected;
        let modes: Vec<&Mode> = model.modes.iter().filter(counts).collect();
        let poles = modes.iter();
        Self {
            poles: poles
                .map(|mode| denominator(mode, model.damping, omega))
                .collect(),
            omega_squared: omega * omega,
            modes: modes
                .iter()
                .map(|mode| mode_mobility(model, operator, mode))
                .collect(),
            whole: operator.mobility.clone(),
        }
    }

    fn actuators(&self) -> usize {
        self.whole.ncols()
    }

    /// Real unknowns: gains, shifts, common shift.
    fn unknowns(&self) -> usize {
        2 * self.actuators() + 2 * self.modes.len() + 1
    }

    /// f_n and its slope at a shift.
    fn factor(&self, n: usize, shift: Complex64) -> (Complex64, Complex64) {
        let [square, linear] = self.poles[n];
        let at = 1.0 + shift;
        let moved = (square * at + linear) * at - self.omega_squared;
        let factor = (square + linear - self.omega_squared) / moved;
        (factor, -factor * (2.0 * square * at + linear) / moved)
    }

    fn shift(&self, theta: &Array1<f64>, n: usize) -> Complex64 {
        let at = 2 * (self.actuators() + n);
        Complex64::new(theta[at] + theta[theta.len() - 1], theta[at + 1])
    }

    fn gain(&self, theta: &Array1<f64>, i: usize) -> Complex64 {
        Complex64::new(1.0 + theta[2 * i], theta[2 * i + 1])
    }

    /// Mobility with the poles of θ, its gains left out.
    fn moved(&self, theta: &Array1<f64>) -> Array2<Complex64> {
        let mut mobility = self.whole.clone();
        for (n, part) in self.modes.iter().enumerate() {
            mobility.scaled_add(self.factor(n, self.shift(theta, n)).0 - 1.0, part);
        }
        mobility
    }

    /// Mobility of θ.
    fn mobility(&self, theta: &Array1<f64>) -> Array2<Complex64> {
        let mut mobility = self.moved(theta);
        for (i, mut column) in mobility.columns_mut().into_iter().enumerate() {
            let gain = self.gain(theta, i);
            column.mapv_inplace(|value| value * gain);
        }
        mobility
    }

    /// The field of θ at all rows, and its slope over each unknown; axes (row, unknown).
    fn field(&self, theta: &Array1<f64>, drive: &Drive) -> (Array1<Complex64>, Array2<Complex64>) {
        let moved = self.moved(theta);
        let count = self.actuators();
        let played: Drive = (0..count).map(|i| drive[i] * self.gain(theta, i)).collect();
        let mut slope = Array2::zeros((moved.nrows(), self.unknowns()));
        for i in 0..count {
            let path = moved.column(i).mapv(|value| value * drive[i]);
            slope.column_mut(2 * i).assign(&path);
            slope
                .column_mut(2 * i + 1)
                .assign(&path.mapv(|value| value * Complex64::I));
        }
        let mut common = Array1::zeros(moved.nrows());
        for (n, part) in self.modes.iter().enumerate() {
            let (_, steep) = self.factor(n, self.shift(theta, n));
            let change = part.dot(&played).mapv(|value| value * steep);
            let at = 2 * (count + n);
            slope.column_mut(at).assign(&change);
            slope
                .column_mut(at + 1)
                .assign(&change.mapv(|value| value * Complex64::I));
            common += &change;
        }
        let last = self.unknowns() - 1;
        slope.column_mut(last).assign(&common);
        (moved.dot(&played), slope)
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

    /// The most probable gains and shifts under all fields, sought from `start` on.
    ///
    /// # Errors
    /// Those of the factorisations.
    pub(crate) fn update(&self, fields: &[Seen], start: Option<&Structured>) -> Result<Structured> {
        let mut theta = match start {
            Some(start) => start.theta.clone(),
            None => Array1::zeros(self.unknowns()),
        };
        let mut best = self.likeliest(&theta, fields)?;
        for _ in 1..tolerances::STRUCTURED_STEPS {
            let change = &best.theta - &theta;
            let [change, size] = [&change, &best.theta].map(|values| values.dot(values).sqrt());
            if change <= tolerances::STRUCTURED_CHANGE * size {
                break;
            }
            theta.assign(&best.theta);
            best = self.likeliest(&theta, fields)?;
        }
        let theta = best.theta;
        let count = self.actuators();
        let of = |at: usize| Complex64::new(theta[at], theta[at + 1]);
        Ok(Structured {
            scales: best.scales,
            gains: (0..count).map(|i| of(2 * i)).collect(),
            common: theta[theta.len() - 1],
            mobility: self.mobility(&theta),
            covariance: self.row_covariance(&theta, &best.covariance)?,
            gain_std: (0..count)
                .map(|i| {
                    let variance = &best.covariance;
                    (variance[[2 * i, 2 * i]] + variance[[2 * i + 1, 2 * i + 1]]).sqrt()
                })
                .collect(),
            shifts: (0..self.modes.len())
                .map(|n| self.shift(&theta, n))
                .collect(),
            shift_std: (0..self.modes.len())
                .map(|n| {
                    let (own, common) = (2 * (count + n), theta.len() - 1);
                    let variance = &best.covariance;
                    let sum = variance[[own, own]] + variance[[common, common]];
                    (sum + 2.0 * variance[[own, common]]).max(0.0).sqrt()
                })
                .collect(),
            odd: best.odd,
            theta,
        })
    }

    /// One Gauss-Newton step at the scales and odd channels of the largest evidence.
    fn likeliest(&self, theta: &Array1<f64>, fields: &[Seen]) -> Result<Posterior> {
        let normals: Vec<(f64, Normal)> = tolerances::UNEXPLAINED_SCALES
            .par_iter()
            .map(|&s| (s, self.normal(theta, fields, s)))
            .collect();
        let alternatives = (self.actuators() as f64).ln();
        let mut odd = Vec::new();
        loop {
            // the best of each scale of gains: an odd channel goes with narrow ones
            let posteriors: Vec<Posterior> = tolerances::GAIN_SCALES
                .par_iter()
                .map(|&gains| self.best_of_gains(theta, &normals, gains, &odd))
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
        gains: f64,
        odd: &[usize],
    ) -> Result<Posterior> {
        let mut best: Option<(f64, Scales, &Normal)> = None;
        for (unexplained, normal) in normals {
            for common in tolerances::COMMON_SCALES {
                for modes in tolerances::MODE_SCALES {
                    let scales = Scales {
                        unexplained: *unexplained,
                        gains,
                        common,
                        modes,
                    };
                    let evidence = self.weighed(theta, normal, &scales, odd)?.ln_evidence;
                    if best.is_none_or(|(most, ..)| evidence > most) {
                        best = Some((evidence, scales, normal));
                    }
                }
            }
        }
        let (_, scales, normal) =
            best.ok_or_else(|| Error::new(ErrorKind::Internal, "no scale of shifts"))?;
        let Weighed {
            matrix,
            right,
            ln_evidence,
        } = self.weighed(theta, normal, &scales, odd)?;
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

    /// mean_k Σ_pq Cov_pq D_pkᴴD_qk with the slopes D of the mobility.
    fn row_covariance(
        &self,
        theta: &Array1<f64>,
        covariance: &Array2<f64>,
    ) -> Result<Array2<Complex64>> {
        let (responses, count) = self.whole.dim();
        let moved = self.moved(theta);
        let mut slopes = Array2::<Complex64>::zeros((self.unknowns(), responses * count));
        let mut put = |p: usize, k: usize, i: usize, value: Complex64| {
            slopes[[p, k * count + i]] = value;
        };
        let last = self.unknowns() - 1;
        for k in 0..responses {
            for i in 0..count {
                put(2 * i, k, i, moved[[k, i]]);
                put(2 * i + 1, k, i, moved[[k, i]] * Complex64::I);
                let mut sum = Complex64::ZERO;
                for (n, part) in self.modes.iter().enumerate() {
                    let steep = self.factor(n, self.shift(theta, n)).1;
                    let value = part[[k, i]] * steep * self.gain(theta, i);
                    put(2 * (count + n), k, i, value);
                    put(2 * (count + n) + 1, k, i, value * Complex64::I);
                    sum += value;
                }
                put(last, k, i, sum);
            }
        }
        let mut jittered = covariance.clone();
        let mean = jittered.diag().sum() / jittered.nrows() as f64;
        jittered
            .diag_mut()
            .mapv_inplace(|value| value + mean * tolerances::RIDGE);
        let root = chladni_linalg::cholesky(jittered.view()).map_err(unsolvable)?;
        let root = root.t().mapv(Complex64::from);
        let errors = chladni_linalg::matmul(root.view(), slopes.view());
        let errors = Array2::from_shape_fn((self.unknowns() * responses, count), |(row, i)| {
            errors[[row / responses, (row % responses) * count + i]]
        });
        Ok(chladni_linalg::matmul_h(errors.view(), errors.view())
            .mapv(|value| value / responses as f64))
    }
}

impl Structured {
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

/// a and b of the denominator a(1 + δ)² + b(1 + δ) − ω² of a mode.
fn denominator(mode: &Mode, damping: Damping, omega: f64) -> [Complex64; 2] {
    let own = TAU * mode.frequency_hz;
    match damping {
        Damping::Structural => [
            own * own * Complex64::new(1.0, mode.loss_factor),
            Complex64::ZERO,
        ],
        Damping::Viscous => [
            (own * own).into(),
            Complex64::new(0.0, mode.loss_factor * own * omega),
        ],
    }
}

/// A linear model of all fields around θ.
struct Posterior {
    ln_evidence: f64,
    theta: Array1<f64>,
    covariance: Array2<f64>,
    scales: Scales,
    odd: Vec<usize>,
}

impl Seen {
    /// The values with the phases that `mobility` foretells, where they have none.
    pub(crate) fn phased(&self, mobility: &Array2<Complex64>) -> Array1<Complex64> {
        if !self.magnitudes_only {
            return self.velocity.clone();
        }
        let foretold = mobility.select(Axis(0), &self.rows).dot(&self.drive);
        let pairs = self.velocity.iter().zip(&foretold);
        pairs
            .map(|(seen, foretold)| {
                foretold * (seen.norm() / foretold.norm().max(f64::MIN_POSITIVE))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::{Dof, Node};
    use chladni_plate::{Synthetic, SyntheticShapes};

    #[test]
    fn a_shift_of_all_poles_is_that_of_the_model_in_both_laws() {
        for damping in [Damping::Structural, Damping::Viscous] {
            let mut model = Synthetic {
                natural_frequency_hz: vec![80.0, 120.0],
                loss_factor: vec![0.08, 0.05],
                responses: 5,
                references: 2,
                shapes: SyntheticShapes::Real,
                damping,
                frequency_hz: Array1::range(10.0, 200.0, 1.0),
                residual_powers: Vec::new(),
                ..Synthetic::default()
            }
            .build()
            .unwrap()
            .truth;
            let node = |(k, dof): (usize, &Dof)| Node {
                label: dof.node,
                xyz_m: [0.01 * k as f64, 0.01 * (k % 2) as f64, 0.0],
            };
            model.nodes = model.responses.iter().enumerate().map(node).collect();
            let operator = |model: &ModalModel| Operator::of_model(model, 100.0, None).unwrap();
            let parts = Parts::new(&model, &operator(&model));
            let shift = 1e-5;
            let mut theta = Array1::zeros(parts.unknowns());
            theta[parts.unknowns() - 1] = shift;
            let mut moved = model.clone();
            for mode in &mut moved.modes {
                mode.frequency_hz *= 1.0 + shift;
            }
            let before = operator(&model).mobility;
            let change = operator(&moved).mobility - &before;
            let error = parts.mobility(&theta) - &before - &change;
            let size = |values: &Array2<Complex64>| rms(&values.iter().copied().collect());
            assert!(
                size(&error) < 1e-3 * size(&change),
                "{damping:?}: {} of {}",
                size(&error),
                size(&change)
            );
        }
    }

    #[test]
    fn a_moved_pole_has_the_denominator_of_its_shift() {
        let mode = |damping| Synthetic {
            natural_frequency_hz: vec![80.0],
            loss_factor: vec![0.08],
            responses: 2,
            references: 1,
            shapes: SyntheticShapes::Real,
            damping,
            frequency_hz: Array1::range(10.0, 200.0, 1.0),
            residual_powers: Vec::new(),
            ..Synthetic::default()
        };
        for damping in [Damping::Structural, Damping::Viscous] {
            let mode = mode(damping).build().unwrap().truth.modes[0].clone();
            let [square, linear] = denominator(&mode, damping, TAU * 100.0);
            let shift = Complex64::new(0.01, 0.005);
            let structured = Structured {
                scales: Scales {
                    unexplained: 0.0,
                    gains: 0.0,
                    common: 0.0,
                    modes: 0.0,
                },
                odd: Vec::new(),
                gains: Array1::zeros(1),
                common: 0.0,
                mobility: Array2::zeros((2, 1)),
                covariance: Array2::zeros((1, 1)),
                gain_std: vec![0.0],
                shifts: vec![shift],
                shift_std: vec![0.0],
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
