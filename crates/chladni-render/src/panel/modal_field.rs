//! The field of a drive mode by mode: for models that drift, err, or are touched.

use crate::panel::drive::Drive;
use crate::panel::finger::Finger;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Damping, FrfKind, ModalModel, Mode, Scaling, Trust};
use ndarray::{concatenate, Array1, Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Modes as outer products at `rows` and at the actuators of an operator: shapes, axes
/// (response, half), and participations, axes (half, actuator). A mode is one half where its
/// damping is structural; viscous, its conjugate is another one, after those of all modes.
pub(crate) fn halves(
    law: Damping,
    modes: &[&Mode],
    operator: &Operator,
    rows: &[usize],
) -> [Array2<Complex64>; 2] {
    let shapes = Array2::from_shape_fn((rows.len(), modes.len()), |(k, n)| {
        modes[n].shape.0[operator.response_rows[rows[k]]]
            * operator.responses[rows[k]].direction.sign()
    });
    let columns = &operator.reference_columns;
    let participations = Array2::from_shape_fn((modes.len(), columns.len()), |(n, j)| {
        modes[n].participation.0[columns[j]]
    });
    let both = |of_modes: Array2<Complex64>, axis| match law {
        Damping::Structural => of_modes,
        Damping::Viscous => concatenate![axis, of_modes, of_modes.mapv(|value| value.conj())],
    };
    [both(shapes, Axis(1)), both(participations, Axis(0))]
}

/// Factor from the product of a mode's saved shape to ψψᵀ: 1 where the model is
/// mass-scaled. Elsewhere it is a guess, by which the rms of a mode at the responses is
/// `tolerances::RESPONSES_OVER_ACTUATORS` times that at the actuators.
pub(crate) fn guessed_scale(model: &ModalModel, operator: &Operator, mode: &Mode) -> f64 {
    if model.scaling == Scaling::UnitModalMass {
        return 1.0;
    }
    let rms = |values: &[Complex64], picked: &[usize]| {
        (picked.iter().map(|&k| values[k].norm_sqr()).sum::<f64>() / picked.len() as f64).sqrt()
    };
    let of_actuators = rms(&mode.participation.0, &operator.reference_columns);
    match rms(&mode.shape.0, &operator.response_rows) {
        size if size > 0.0 => tolerances::RESPONSES_OVER_ACTUATORS * of_actuators / size,
        _ => 0.0,
    }
}

/// Velocity of a mode at the responses, over shape times modal force, and over the
/// conjugates of both, with its natural frequency multiplied by `factor`.
pub(crate) fn answer(law: Damping, mode: &Mode, frequency_hz: f64, factor: f64) -> [Complex64; 2] {
    let omega = TAU * frequency_hz;
    // at f times its natural frequency a mode has at ω the receptance of ω/f, over f²
    let (at, mobility) = (
        omega / factor,
        FrfKind::Mobility.from_receptance(omega) / factor.powi(2),
    );
    mode.receptance_factors(law, at)
        .map(|factor| mobility * factor)
}

/// A model under a drive, taken apart.
pub(crate) struct ModalField<'a> {
    model: &'a ModalModel,
    operator: &'a Operator,
    drive: &'a Drive,
    /// Velocities at the responses of the operator, m/s.
    pub(crate) free: Array1<Complex64>,
    /// The part that each mode adds to them.
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

    /// Velocities with `finger` at the response `row` of the operator; `None` where the
    /// model is not mass-scaled (theory.md, eq. 52).
    pub(crate) fn touched(&self, finger: &Finger, row: usize) -> Option<Array1<Complex64>> {
        if self.model.scaling != Scaling::UnitModalMass {
            return None;
        }
        let from_finger = self.due_to_response(row, |_| 1.0);
        let compliance = finger.impedance(self.operator.frequency_hz).inv();
        let force = self.free[row] / (compliance + from_finger[row]);
        Some(&self.free - &(from_finger * force))
    }

    /// The shape of a mode at a response of the operator, along its sense.
    fn shape_at(&self, mode: &Mode, row: usize) -> Complex64 {
        mode.shape.0[self.operator.response_rows[row]]
            * self.operator.responses[row].direction.sign()
    }

    /// Mobility from the response `row` to all, of the modes alone, where ψψᵀ of a mode is
    /// `scale` times what its shape says.
    fn due_to_response(&self, row: usize, scale: impl Fn(&Mode) -> f64) -> Array1<Complex64> {
        let mut sum = Array1::zeros(self.free.len());
        for (n, _) in &self.parts {
            let mode = &self.model.modes[*n];
            let here = self.shape_at(mode, row) * scale(mode);
            sum += &self.mode_at(mode, here, here.conj());
        }
        sum
    }

    /// Numbers and natural frequencies, Hz, of the modes in the band.
    pub(crate) fn in_band(&self, model: &ModalModel) -> Vec<(usize, f64)> {
        let of = |(number, (n, _)): (usize, &(usize, Array1<Complex64>))| {
            let mode = &model.modes[*n];
            mode.in_band.then_some((number, mode.frequency_hz))
        };
        self.parts.iter().enumerate().filter_map(of).collect()
    }

    /// The mode of a number.
    pub(crate) fn mode(&self, number: usize) -> &Mode {
        &self.model.modes[self.parts[number].0]
    }

    /// The part that the mode of a number adds to the field.
    pub(crate) fn part_of(&self, number: usize) -> &Array1<Complex64> {
        &self.parts[number].1
    }

    /// ∂v/∂ln ω_n of the mode of a number.
    pub(crate) fn slope(&self, number: usize) -> Array1<Complex64> {
        let step = tolerances::SLOPE_STEP;
        let moved = |sign: f64| {
            self.with_frequencies(|n| if n == number { 1.0 + sign * step } else { 1.0 })
        };
        (moved(1.0) - moved(-1.0)) / Complex64::from(2.0 * step)
    }

    /// Mobility from every response to every other, of the modes alone; where the model is
    /// not mass-scaled with the guess of [`guessed_scale`].
    pub(crate) fn between_responses(&self) -> Array2<Complex64> {
        let count = self.free.len();
        let mut all = Array2::zeros((count, count));
        for (row, mut to_all) in all.rows_mut().into_iter().enumerate() {
            to_all.assign(
                &self.due_to_response(row, |mode| guessed_scale(self.model, self.operator, mode)),
            );
        }
        all
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
        let law = self.model.damping;
        let [of_near, of_far] = answer(law, mode, self.operator.frequency_hz, 1.0);
        let (near, far) = (of_near * near, of_far * far);
        let rows = self.operator.response_rows.iter();
        let shape = rows
            .zip(&self.operator.responses)
            .map(|(&row, dof)| mode.shape.0[row] * dof.direction.sign());
        match law {
            Damping::Structural => shape.map(|value| value * near).collect(),
            Damping::Viscous => shape
                .map(|value| value * near + value.conj() * far)
                .collect(),
        }
    }
}
