//! Time reversal at one frequency (method `time-reversal`), a baseline.
//!
//! A = H_hᴴ·1: every actuator plays its own path to the hot zone backwards, so that all
//! arrive there in phase. It needs no inverse and is hard to upset by errors, and it
//! cannot be told to keep quiet anywhere: it is meant for kilohertz and pulses (Hudin,
//! Lozada and Hayward 2015), where many modes average out elsewhere.

use crate::methods::pressure_matching::one_phase_target;
use crate::panel::drive::Drive;
use crate::problems::problem::Problem;

/// The conjugate paths to the hot zone, summed.
pub(crate) fn solve(problem: &Problem) -> Drive {
    problem
        .rows
        .mobility
        .t()
        .mapv(|value| value.conj())
        .dot(&one_phase_target(problem))
}
