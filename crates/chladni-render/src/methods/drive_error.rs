//! The error of its amplifiers that a drive bears where its scene names none.
//!
//! A drive that bears the usual error survives on rigs where another fails, and pays with
//! margin. Between modes there is plenty of it. Beside a mode it would cost ground between
//! the responses, so that a smaller error or none is borne there (docs/accuracy.md, "The
//! default of `drive_relative`").

use crate::methods::mls;
use crate::problems::setup::Setup;
use crate::tolerances;
use chladni_frf::{Finding, Result};

/// The largest of the usual errors, relative, that costs no ground; 0 where each does. Under
/// it the drive from which `robust` starts its climb already has the κ that the climb seeks.
///
/// # Errors
/// Those of the factorisations.
pub(crate) fn borne(setup: &Setup) -> Result<f64> {
    for error in tolerances::BORNE_DRIVE_ERRORS {
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

/// Tells that a drive bears less than the usual error.
pub(crate) fn finding(borne: f64) -> Option<Finding> {
    let [usual, ..] = tolerances::BORNE_DRIVE_ERRORS;
    (borne < usual).then(|| {
        let bears = match borne > 0.0 {
            true => format!("errors of its amplifiers of {:.0} %", 100.0 * borne),
            false => "no errors of its amplifiers".to_owned(),
        };
        let words = format!(
            "the drive bears {bears}: {:.0} % would cost ground",
            100.0 * usual
        );
        Finding::note("few-drive-errors-borne", words)
            .value("drive_relative", borne)
            .help("choose a less sensitive frequency or more actuators, or name it in the scene")
    })
}
