//! The field of a drive mode by mode: for models that drift, err, or are touched.

use crate::finger::Finger;
use crate::operator::Operator;
use crate::problem::Drive;
use crate::tolerances;
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
        let mut field = Self {
            model,
            operator,
            drive,
            free: operator.mobility.dot(drive),
            parts: Vec::new(),
        };
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

    /// Velocities with the natural frequency of each mode multiplied by `factor` of its
    /// number.
    pub(crate) fn with_frequencies(&self, factor: impl Fn(usize) -> f64) -> Array1<Complex64> {
        if self.model.damping == Damping::Viscous {
            let mut number = 0..;
            return self.with_modes(|mode| mode.frequency_hz *= number.next().map_or(1.0, &factor));
        }
        let omega = TAU * self.operator.frequency_hz;
        let mut field = self.free.clone();
        for (number, (n, part)) in self.parts.iter().enumerate() {
            let mode = &self.model.modes[*n];
            let squared = (TAU * mode.frequency_hz).powi(2) * Complex64::new(1.0, mode.loss_factor);
            let x = omega * omega;
            let ratio = (squared - x) / (squared * factor(number).powi(2) - x);
            field.scaled_add(ratio - 1.0, part);
        }
        field
    }

    /// How many modes take part.
    pub(crate) fn modes(&self) -> usize {
        self.parts.len()
    }

    /// Velocities with `finger` at the response `row` of the operator; `None` where the
    /// model is not mass-scaled (theory.md, eq. 52).
    pub(crate) fn touched(&self, finger: &Finger, row: usize) -> Option<Array1<Complex64>> {
        (self.model.scaling == Scaling::UnitModalMass).then(|| self.pressed(finger, row, |_| 1.0))
    }

    /// The same with a guess where the model is not mass-scaled: how much every mode
    /// moves the responses for what it moves the actuators
    /// ([`tolerances::RESPONSES_OVER_ACTUATORS`]).
    pub(crate) fn perhaps_touched(&self, finger: &Finger, row: usize) -> Array1<Complex64> {
        let rms = |values: &[Complex64], picked: &[usize]| {
            (picked.iter().map(|&k| values[k].norm_sqr()).sum::<f64>() / picked.len() as f64).sqrt()
        };
        let (rows, columns) = (
            &self.operator.response_rows,
            &self.operator.reference_columns,
        );
        self.touched(finger, row).unwrap_or_else(|| {
            self.pressed(finger, row, |mode| match rms(&mode.shape.0, rows) {
                size if size > 0.0 => {
                    tolerances::RESPONSES_OVER_ACTUATORS * rms(&mode.participation.0, columns)
                        / size
                }
                _ => 0.0,
            })
        })
    }

    /// Velocities with `finger` at `row`, where ψψᵀ of a mode is `scale` times what its
    /// shape says.
    fn pressed(
        &self,
        finger: &Finger,
        row: usize,
        scale: impl Fn(&Mode) -> f64,
    ) -> Array1<Complex64> {
        let mut from_finger = Array1::zeros(self.free.len());
        for (n, _) in &self.parts {
            let mode = &self.model.modes[*n];
            let here = mode.shape.0[self.operator.response_rows[row]]
                * self.operator.responses[row].direction.sign()
                * scale(mode);
            from_finger += &self.mode_at(mode, here, here.conj());
        }
        let force = self.free[row]
            / (finger.impedance(self.operator.frequency_hz).inv() + from_finger[row]);
        &self.free - &(from_finger * force)
    }

    fn part(&self, mode: &Mode) -> Array1<Complex64> {
        let pairs = || {
            self.operator
                .reference_columns
                .iter()
                .zip(self.drive)
                .map(|(&column, &weight)| (mode.participation.0[column], weight))
        };
        self.mode_at(
            mode,
            pairs().map(|(phi, weight)| phi * weight).sum(),
            pairs().map(|(phi, weight)| phi.conj() * weight).sum(),
        )
    }

    /// Velocity of one mode at the responses under the modal force `near`, and `far` with
    /// conjugate participations.
    fn mode_at(&self, mode: &Mode, near: Complex64, far: Complex64) -> Array1<Complex64> {
        let omega = TAU * self.operator.frequency_hz;
        let mobility = FrfKind::Mobility.from_receptance(omega);
        let shape = self
            .operator
            .response_rows
            .iter()
            .zip(&self.operator.responses)
            .map(|(&row, dof)| mode.shape.0[row] * dof.direction.sign());
        match self.model.damping {
            Damping::Structural => {
                let factor = mobility * mode.structural_factor(omega) * near;
                shape.map(|value| value * factor).collect()
            }
            Damping::Viscous => {
                let pole = mode.viscous_pole();
                let (j_omega, scale) = (
                    Complex64::new(0.0, omega),
                    Complex64::new(0.0, 2.0 * pole.im).inv(),
                );
                let [near, far] = [
                    near * scale / (j_omega - pole),
                    far * scale.conj() / (j_omega - pole.conj()),
                ];
                shape
                    .map(|value| mobility * (value * near + value.conj() * far))
                    .collect()
            }
        }
    }
}
