//! Quantities between the two steps of method `modal`, and how well its matrices invert.

use crate::tolerances;
use chladni_frf::{ComplexVector, Finding};
use serde::{Deserialize, Serialize};

/// Quantities between the target field and the drive of the two steps.
///
/// `asked` and `driven` are modal forces with the gain of the drive: N times the unit of
/// the participations (N/√kg where the model is mass-scaled). They are the same where Ψ
/// has full row rank; where they are not, the actuators cannot set these modes
/// independently.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModalSteps {
    /// Natural frequencies of the modes that take part, Hz, in the order of the model.
    pub frequency_hz: Vec<f64>,
    /// W_n,d of the first step, one per mode (seed paper, eq. 10).
    pub asked: ComplexVector,
    /// Σ_i A_i ψ_n^i of the drive, one per mode (eq. 11).
    pub driven: ComplexVector,
    /// Γ, the γ_n at the judged responses; axes (response, mode).
    pub gamma: StepMatrix,
    /// Ψ, the modes at the actuators; axes (mode, actuator).
    pub psi: StepMatrix,
}

/// Properties of a matrix that a step inverts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepMatrix {
    /// Singular values, falling.
    pub singular_values: Vec<f64>,
    /// Number of them above rounding; the others are taken for zero.
    pub rank: usize,
}

impl StepMatrix {
    /// Largest over least singular value; infinite where the rank is short.
    pub fn condition(&self) -> f64 {
        match self.singular_values.as_slice() {
            [first, .., last] if self.rank == self.singular_values.len() => first / last,
            [_] if self.rank == 1 => 1.0,
            _ => f64::INFINITY,
        }
    }

    /// The finding about an inverse that cannot be trusted.
    pub(super) fn finding(&self, name: &str, [rows, columns]: [usize; 2]) -> Option<Finding> {
        let Self {
            singular_values,
            rank,
        } = self;
        if *rank < singular_values.len() {
            let values: Vec<String> = singular_values
                .iter()
                .map(|value| format!("{value:.1e}"))
                .collect();
            let words = format!(
                "{name} is rank deficient: {rows} x {columns}, rank {rank} of {}; singular values {}",
                values.len(),
                values.join(", ")
            );
            return Some(Finding::caution("rank-deficient", words));
        }
        (self.condition() > tolerances::ILL_CONDITIONED).then(|| {
            let [first, last] = [
                singular_values[0],
                singular_values[singular_values.len() - 1],
            ];
            let words = format!(
                "{name} is ill conditioned: singular values from {first:.1e} down to {last:.1e}"
            );
            Finding::caution("nearly-rank-deficient", words)
        })
    }
}
