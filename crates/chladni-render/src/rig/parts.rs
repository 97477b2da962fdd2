//! The mobility of a model over the gains of its channels and the shifts of its poles.
//!
//! H(θ) = [Σ_n f_n(δ_n + c)·P_n + R]·diag(1 + g), f_n(δ) = d_n(0)/d_n(δ)
//! (theory.md, eq. 58),
//!
//! with d_n(δ) = ω_n²(1 + jη_n)(1 + δ)² − ω² under structural damping and
//! ω_n²(1 + δ)² + jη_nω_nω(1 + δ) − ω² under viscous damping,
//! with a complex gain error g for each channel, a complex shift δ for each mode in the band
//! and a real shift c of all.

use super::field::rms;
use crate::panel::drive::Drive;
use crate::panel::modal_field::{answer, halves};
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Damping, ModalModel, Mode};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The parts of the mobility that can move.
pub(crate) struct Parts {
    /// Of each mode in the band, a and b of its denominator a(1 + δ)² + b(1 + δ) − ω².
    pub(super) poles: Vec<[Complex64; 2]>,
    pub(super) omega_squared: f64,
    /// Shapes of these modes, axes (response, half): see [`halves`].
    pub(super) shapes: Array2<Complex64>,
    /// Pull of each actuator on each half, per force, axes (half, actuator): the share of a half
    /// in the mobility is the outer product of both.
    pub(super) pulls: Array2<Complex64>,
    /// The mobility as the model has it.
    pub(super) whole: Array2<Complex64>,
}

impl Parts {
    /// Takes the operator of `model` apart.
    pub(crate) fn new(model: &ModalModel, operator: &Operator) -> Self {
        let omega = TAU * operator.frequency_hz;
        let counts = |mode: &&Mode| mode.counts();
        let modes: Vec<&Mode> = model.modes.iter().filter(counts).collect();
        let rows: Vec<usize> = (0..operator.responses.len()).collect();
        let [shapes, mut pulls] = halves(model.damping, &modes, operator, &rows);
        for (n, mode) in modes.iter().enumerate() {
            let answers = answer(model.damping, mode, operator.frequency_hz, 1.0);
            for (half, answer) in (n..pulls.nrows()).step_by(modes.len()).zip(answers) {
                pulls.row_mut(half).mapv_inplace(|value| value * answer);
            }
        }
        let poles = modes.iter();
        Self {
            poles: poles
                .map(|mode| denominator(mode, model.damping, omega))
                .collect(),
            omega_squared: omega * omega,
            shapes,
            pulls,
            whole: operator.mobility.clone(),
        }
    }

    pub(super) fn actuators(&self) -> usize {
        self.whole.ncols()
    }

    /// Rms of the mobility as the model has it.
    pub(super) fn size(&self) -> f64 {
        rms(&self.whole.iter().copied().collect())
    }

    /// Number of modes that may move.
    pub(super) fn modes(&self) -> usize {
        self.poles.len()
    }

    /// Real unknowns: gains, shifts, common shift.
    pub(super) fn unknowns(&self) -> usize {
        2 * self.actuators() + 2 * self.modes() + 1
    }

    /// The pulls on the halves, each times the value of its mode.
    fn scaled_pulls(&self, of_mode: impl Fn(usize) -> Complex64) -> Array2<Complex64> {
        let mut pulls = self.pulls.clone();
        for (half, mut pull) in pulls.rows_mut().into_iter().enumerate() {
            let factor = of_mode(half % self.modes());
            pull.mapv_inplace(|value| value * factor);
        }
        pulls
    }

    /// f_n and its slope at a shift.
    pub(super) fn factor(&self, n: usize, shift: Complex64) -> (Complex64, Complex64) {
        let [square, linear] = self.poles[n];
        let at = 1.0 + shift;
        let moved = (square * at + linear) * at - self.omega_squared;
        let factor = (square + linear - self.omega_squared) / moved;
        (factor, -factor * (2.0 * square * at + linear) / moved)
    }

    pub(super) fn shift(&self, theta: &Array1<f64>, n: usize) -> Complex64 {
        let at = 2 * (self.actuators() + n);
        Complex64::new(theta[at] + theta[theta.len() - 1], theta[at + 1])
    }

    pub(super) fn gain(&self, theta: &Array1<f64>, i: usize) -> Complex64 {
        Complex64::new(1.0 + theta[2 * i], theta[2 * i + 1])
    }

    /// Size of the level of all gains, by which errors of each count; at least a hundredth. The
    /// median, which odd channels do not move.
    pub(super) fn level(&self, theta: &Array1<f64>) -> f64 {
        let gains = (0..self.actuators()).map(|i| self.gain(theta, i).norm());
        let mut sizes: Vec<f64> = gains.collect();
        sizes.sort_by(f64::total_cmp);
        let median = sizes.get(sizes.len() / 2).map_or(1.0, |size| *size);
        median.max(tolerances::LEAST_LEVEL)
    }

    /// Mobility with the poles of θ, its gains left out.
    pub(super) fn moved(&self, theta: &Array1<f64>) -> Array2<Complex64> {
        let changes = self.scaled_pulls(|n| self.factor(n, self.shift(theta, n)).0 - 1.0);
        chladni_linalg::matmul(self.shapes.view(), changes.view()) + &self.whole
    }

    /// Slope of the pull on each half, per weight, over the complex shift of its mode, gains
    /// left in; axes (half, actuator).
    pub(super) fn shift_slopes(&self, theta: &Array1<f64>) -> Array2<Complex64> {
        let mut slopes = self.scaled_pulls(|n| self.factor(n, self.shift(theta, n)).1);
        for (i, mut column) in slopes.columns_mut().into_iter().enumerate() {
            let gain = self.gain(theta, i);
            column.mapv_inplace(|value| value * gain);
        }
        slopes
    }

    /// Mobility of θ.
    pub(super) fn mobility(&self, theta: &Array1<f64>) -> Array2<Complex64> {
        let mut mobility = self.moved(theta);
        for (i, mut column) in mobility.columns_mut().into_iter().enumerate() {
            let gain = self.gain(theta, i);
            column.mapv_inplace(|value| value * gain);
        }
        mobility
    }

    /// The field of θ at all rows, and its slope over each unknown; axes (row, unknown).
    pub(super) fn field(
        &self,
        theta: &Array1<f64>,
        drive: &Drive,
    ) -> (Array1<Complex64>, Array2<Complex64>) {
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
        let forces = self.shift_slopes(theta).dot(drive);
        for n in 0..self.modes() {
            let mut change = Array1::<Complex64>::zeros(moved.nrows());
            for half in (n..forces.len()).step_by(self.modes()) {
                change.scaled_add(forces[half], &self.shapes.column(half));
            }
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
}

/// a and b of the denominator a(1 + δ)² + b(1 + δ) − ω² of a mode.
pub(super) fn denominator(mode: &Mode, damping: Damping, omega: f64) -> [Complex64; 2] {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_model::test_model;

    #[test]
    fn a_shift_of_all_poles_is_that_of_the_model_in_both_laws() {
        for damping in [Damping::Structural, Damping::Viscous] {
            let model = test_model(damping, &[(80.0, 0.08), (120.0, 0.05)], [5, 2]);
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
}
