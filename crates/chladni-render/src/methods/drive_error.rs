//! The error of its amplifiers that a drive tolerates where its scene names none.
//!
//! A drive that tolerates the usual error survives on rigs where another fails, and pays with
//! margin. Between modes there is plenty of it. Beside a mode it would lose ground between
//! the responses, so that only a smaller error, or none, is tolerated there (docs/accuracy.md,
//! "The default of `drive_relative`").

use crate::methods::mls;
use crate::problems::setup::Setup;
use crate::tolerances;
use chladni_frf::{Finding, Result};

/// The largest of the usual errors, relative, that loses no ground; 0 where each does. Under
/// it the drive from which `robust` starts its climb already has the κ that the climb seeks.
///
/// # Errors
/// Those of the factorisations.
pub(crate) fn tolerated_error(setup: &Setup) -> Result<f64> {
    for error in tolerances::TOLERATED_DRIVE_ERRORS {
        let under_error = setup.clone().with_drive_error(error);
        let problem = &under_error.problem;
        let starts = mls::leading_drives(problem, setup.between())?;
        let kappa = starts.first().map(|drive| problem.score(drive).kappa);
        if kappa.is_some_and(|kappa| kappa >= problem.kappa_of_confidence() / tolerances::KEEP) {
            return Ok(error);
        }
    }
    Ok(0.0)
}

/// Tells that a drive tolerates less than the usual error.
pub(crate) fn finding(tolerated: f64) -> Option<Finding> {
    let [usual, ..] = tolerances::TOLERATED_DRIVE_ERRORS;
    (tolerated < usual).then(|| {
        let errors = match tolerated > 0.0 {
            true => format!("amplifier errors of {:.0} %", 100.0 * tolerated),
            false => "no amplifier error".to_owned(),
        };
        let words = format!(
            "the drive tolerates {errors}: tolerating {:.0} % would lose ground between the \
             responses",
            100.0 * usual
        );
        Finding::note("few-drive-errors-borne", words)
            .value("drive_relative", tolerated)
            .help("choose a less sensitive frequency or more actuators, or name it in the scene")
    })
}
