//! Fingers that come and go: the force of an impedance that changes over time.
//!
//! The finger at the place f moves with the ground and pushes back by F = −Z(t)·v_f, with
//! its impedance at the carrier. That force drives every mode like an actuator at f, and
//! what it adds is laid over the free field, sample by sample: F at the end of a step
//! depends on itself by what the step makes of it, one division.
//!
//! As for steady fingers (`finger.rs`), what the model knows only from the actuators takes
//! no part, and the modes must be mass-scaled.

use crate::panel::finger::Finger;
use crate::time::causal::{share, CausalModel};
use crate::time::simulate::Step;
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A finger at one place.
#[derive(Debug, Clone)]
pub(crate) struct Touch {
    /// Row of the listener.
    pub(crate) row: usize,
    pub(crate) finger: Finger,
    /// From when on it has which share of the finger's impedance; in the order of time.
    pub(crate) steps: Vec<(f64, f64)>,
}

impl Touch {
    fn share(&self, time_s: f64) -> f64 {
        let begun = self.steps.partition_point(|(from_s, _)| *from_s <= time_s);
        match begun {
            0 => 0.0,
            _ => self.steps[begun - 1].1,
        }
    }
}

/// The part that a finger adds to the motion of a model.
pub(crate) struct Contact<'a> {
    model: &'a CausalModel,
    touch: &'a Touch,
    /// The part that a unit of force adds to each pole.
    inputs: Vec<Complex64>,
    states: Vec<Complex64>,
    force: Complex64,
}

impl<'a> Contact<'a> {
    /// At rest.
    pub(crate) fn new(model: &'a CausalModel, touch: &'a Touch) -> Self {
        let input = |n: usize| match model.is_at_rest(n) {
            true => Complex64::ZERO,
            false => share(model.poles[n]) * model.shapes[[touch.row, n]],
        };
        let inputs = (0..model.poles.len()).map(input).collect();
        Self {
            model,
            touch,
            inputs,
            states: vec![Complex64::ZERO; model.poles.len()],
            force: Complex64::ZERO,
        }
    }

    /// Lays its field over `moved`, axes (time, row), which begins at the sample `first`.
    pub(crate) fn lay_over(&mut self, moved: &mut Array2<Complex64>, first: usize, step_s: f64) {
        let steps: Vec<Step> = (0..self.states.len())
            .map(|n| Step::new(-self.model.distance(n), step_s))
            .collect();
        let here = self.model.shapes.row(self.touch.row);
        let at_once: Complex64 = (0..self.states.len())
            .map(|n| here[n] * steps[n].next * self.inputs[n])
            .sum();
        let carrier_hz = self.model.carrier_rad_per_s / TAU;
        let impedance = self.touch.finger.impedance(carrier_hz);
        let mut states = Array2::zeros((self.states.len(), moved.nrows()));
        for (k, mut column) in states.columns_mut().into_iter().enumerate() {
            for (n, state) in self.states.iter_mut().enumerate() {
                *state = steps[n].decay * *state + steps[n].last * self.inputs[n] * self.force;
            }
            let free = moved[[k, self.touch.row]] + here.dot(&Array1::from(self.states.clone()));
            let impedance = impedance * self.touch.share(step_s * (first + k) as f64);
            self.force = -impedance * free / (1.0 + impedance * at_once);
            for (n, state) in self.states.iter_mut().enumerate() {
                *state += steps[n].next * self.inputs[n] * self.force;
                column[n] = *state;
            }
        }
        *moved += &self.model.moved(states.view());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::modal_field::ModalField;
    use crate::panel::operator::Operator;
    use crate::time::envelope::{Edge, Envelope, Ramp};
    use crate::time::simulate::Motion;
    use crate::time::tracks::{Track, Tracks};

    /// A finger that stays comes to what a steady one does; one that has left, to nothing.
    #[test]
    fn a_finger_that_stays_is_the_steady_one_and_one_that_leaves_is_forgotten() {
        let mut panel = chladni_plate::Panel::default();
        (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 300.0);
        let model = chladni_plate::simulate(&panel, None, None).unwrap().truth;
        let operator = Operator::of_model(&model, 300.0, None).unwrap();
        let causal = CausalModel::new(&model, &operator).unwrap();
        let drive: Array1<Complex64> = (0..causal.inputs.ncols())
            .map(|j| Complex64::from_polar(1e-3, 0.7 * (j * j) as f64))
            .collect();
        let tracks = Tracks {
            frequency_hz: 300.0,
            tracks: vec![Track {
                pattern: drive.clone(),
                correction: None,
                envelope: Envelope::Gate {
                    rise: Edge::Cosine(Ramp {
                        start_s: 0.0,
                        duration_s: 0.05,
                    }),
                    fall: Edge::NEVER,
                },
            }],
        };
        let row = 24;
        let finger = Finger::default();
        let modal = ModalField::new(&model, &operator, &drive);
        let touched = modal.touched(&finger, row).unwrap();
        let touch = Touch {
            row,
            finger,
            steps: vec![(0.1, 1.0), (0.9, 0.0)],
        };
        let step_s = 2.5e-4;
        let mut motion = Motion::new(&causal);
        let mut contact = Contact::new(&causal, &touch);
        let mut all = Vec::new();
        for block in 0..8 {
            let mut moved = motion.under(&tracks.sampled(step_s, 1000 * block, 1000));
            contact.lay_over(&mut moved, 1000 * block, step_s);
            all.push(moved);
        }
        let size = |v: &Array1<Complex64>| v.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let apart = |sample: usize, expected: &Array1<Complex64>| {
            let found = all[sample / 1000].row(sample % 1000).to_owned();
            size(&(found - expected)) / size(expected)
        };
        // half of the loss factor, by which the causal pair differs from structural damping
        assert!(apart(3500, &touched) < 0.01, "{}", apart(3500, &touched));
        assert!(apart(7900, &modal.free) < 1e-3);
        assert!(apart(3500, &modal.free) > 0.1, "the finger is felt");
    }
}
