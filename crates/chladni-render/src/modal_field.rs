//! The field of a drive mode by mode: for models that drift, err, or are touched.

use crate::finger::Finger;
use crate::operator::Operator;
use crate::problem::Drive;
use chladni_frf::{Damping, FrfKind, ModalModel, Mode, Scaling, Trust};
use ndarray::Array1;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A model under a drive, taken apart.
pub(crate) struct ModalField<'a> {
    model: &'a ModalModel,
    operator: &'a Operator,
    drive: &'a Drive,
    /// Velocities at the responses of the operator, m/s.
    pub(crate) free: Array1<Complex64>,
    /// What each mode adds to them.
    parts: Vec<(usize, Array1<Complex64>)>,
}

impl<'a> ModalField<'a> {
    /// The field of `drive` through `operator`, made of `model`.
    pub(crate) fn new(model: &'a ModalModel, operator: &'a Operator, drive: &'a Drive) -> Self {
        let mut field = Self { model, operator, drive, free: operator.mobility.dot(drive), parts: Vec::new() };
        let counts = (0..model.modes.len()).filter(|&n| model.modes[n].trust != Trust::Rejected);
        field.parts = counts.map(|n| (n, field.part(&model.modes[n]))).collect();
        field
    }

    /// Velocities with every mode as `change` makes it; residual terms as they are.
    pub(crate) fn with_modes(&self, mut change: impl FnMut(&mut Mode)) -> Array1<Complex64> {
        let mut field = self.free.clone();
        for (n, part) in &self.parts {
            let mut mode = self.model.modes[*n].clone();
            change(&mut mode);
            field += &(self.part(&mode) - part);
        }
        field
    }

    /// Velocities with `finger` at the response `row` of the operator; `None` where the model is not mass-scaled (theory.md, eq. 52).
    pub(crate) fn touched(&self, finger: &Finger, row: usize) -> Option<Array1<Complex64>> {
        if self.model.scaling != Scaling::UnitModalMass {
            return None;
        }
        let mut from_finger = Array1::zeros(self.free.len());
        for (n, _) in &self.parts {
            let mode = &self.model.modes[*n];
            let here = self.operator.response_rows[row];
            let sign = self.operator.responses[row].direction.sign();
            from_finger += &self.mode_at(mode, mode.shape.0[here] * sign, (mode.shape.0[here] * sign).conj());
        }
        let force = self.free[row] / (finger.impedance(self.operator.frequency_hz).inv() + from_finger[row]);
        Some(&self.free - &(from_finger * force))
    }

    fn part(&self, mode: &Mode) -> Array1<Complex64> {
        let pairs =
            || self.operator.reference_columns.iter().zip(self.drive).map(|(&column, &weight)| (mode.participation.0[column], weight));
        self.mode_at(mode, pairs().map(|(phi, weight)| phi * weight).sum(), pairs().map(|(phi, weight)| phi.conj() * weight).sum())
    }

    /// Velocity of one mode at the responses under the modal force `near`, and `far` with conjugate participations.
    fn mode_at(&self, mode: &Mode, near: Complex64, far: Complex64) -> Array1<Complex64> {
        let omega = TAU * self.operator.frequency_hz;
        let mobility = FrfKind::Mobility.from_receptance(omega);
        let shape =
            self.operator.response_rows.iter().zip(&self.operator.responses).map(|(&row, dof)| mode.shape.0[row] * dof.direction.sign());
        match self.model.damping {
            Damping::Structural => {
                let factor = mobility * mode.structural_factor(omega) * near;
                shape.map(|value| value * factor).collect()
            }
            Damping::Viscous => {
                let pole = mode.viscous_pole();
                let (j_omega, scale) = (Complex64::new(0.0, omega), Complex64::new(0.0, 2.0 * pole.im).inv());
                let [near, far] = [near * scale / (j_omega - pole), far * scale.conj() / (j_omega - pole.conj())];
                shape.map(|value| mobility * (value * near + value.conj() * far)).collect()
            }
        }
    }
}
