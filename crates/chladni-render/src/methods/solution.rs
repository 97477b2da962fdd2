//! The answer of a method: a drive, and what must be said about how it was found.

use crate::methods::modal_steps::ModalSteps;
use crate::panel::drive::Drive;
use crate::problems::problem::Problem;
use crate::tolerances;
use chladni_frf::Finding;

/// A drive and what must be said about how it was found.
pub(crate) struct Solution {
    pub(crate) drive: Drive,
    pub(crate) findings: Vec<Finding>,
    /// Quantities between target and drive, of the method that goes through modal
    /// coefficients.
    pub(crate) modal: Option<ModalSteps>,
    /// Largest contrast that was found under the firmest fingers, dB, where no drive tolerates
    /// them.
    pub(crate) touched_db: Option<f64>,
}

impl Solution {
    /// A drive about which nothing must be said.
    pub(crate) fn of_drive(drive: Drive) -> Self {
        Self {
            drive,
            findings: Vec::new(),
            modal: None,
            touched_db: None,
        }
    }

    /// A drive of arbitrary gain, with the best one.
    pub(super) fn of_direction(problem: &Problem, direction: &Drive) -> Self {
        let drive = problem.with_best_gain(direction);
        let mut findings = Vec::new();
        if problem.drive_limits.allowed_gain(&drive) <= 1.0 + tolerances::AT_LIMIT {
            let words = format!("{} binds", problem.drive_limits.binding(&drive));
            let finding = Finding::caution("limit-binds", words);
            findings.push(finding.help("raise the limit, or use more actuators"));
        }
        Self {
            findings,
            ..Self::of_drive(drive)
        }
    }
}
