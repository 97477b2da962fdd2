//! Errors of the drives that a scene is made to bear where it does not say.
//!
//! Gains and phases of amplifiers err by some 2 % of the force, and a drive that is not made
//! for that fails beside a resonance. Between modes bearing it costs nothing. Where κ shows
//! that it costs something, the drive that bears less and the one that bears none are made
//! as well: the one is given that bears most and still serves what the plain one serves.

use crate::drift::Drift;
use crate::methods::{Decision, Method, Solution};
use crate::problem::{amplitude, Drive};
use crate::setup::Setup;
use crate::tolerances;
use crate::touch::firmness;
use chladni_frf::{Finding, ModalModel, ReferenceUnit, Result};
use rayon::prelude::*;

/// A drive, and the errors of the drives that it was made for.
pub(crate) struct Bearing {
    pub(crate) method: Method,
    pub(crate) solution: Solution,
    /// Rms of each complex gain.
    pub(crate) drive_relative: f64,
    /// The price of it, where it has one.
    pub(crate) finding: Option<Finding>,
}

/// A drive made for some errors of the drives, and the ground that it serves.
struct Attempt {
    bearing: Bearing,
    min_ratio: f64,
    /// κ with these errors.
    kappa: f64,
    /// Smaller share of hot and cold rows, those between the responses with them.
    ground: f64,
    /// Number of fingertips that it bears.
    fingers: usize,
}

/// The drive of a scene under `drift`. Only `robust` makes drives for errors that nobody
/// stated: quick methods have no κ to keep, and pay with responses.
///
/// # Errors
/// Those of the method.
pub(crate) fn solve(
    setup: &Setup,
    model: &ModalModel,
    drift: &Drift,
    decision: &Decision,
    cut: Option<f64>,
) -> Result<Bearing> {
    if drift.drive_relative.is_some() || decision.method != Method::Robust {
        let (method, solution) = decision.run(setup, model, cut)?;
        return Ok(Bearing {
            method,
            solution,
            drive_relative: drift.drive_relative.unwrap_or(0.0),
            finding: None,
        });
    }
    let attempt = |relative: f64| Attempt::new(setup, model, decision, cut, relative);
    let [most, less] = tolerances::DRIVE_ERRORS;
    let first = attempt(most)?;
    let all_fingers = setup
        .touch
        .as_ref()
        .map_or(0, |plan| plan.touch.impedances.len());
    if first.kappa >= tolerances::KAPPA_ENOUGH && first.fingers == all_fingers {
        return Ok(first.bearing);
    }
    let others: Vec<Attempt> = [less, 0.0]
        .into_par_iter()
        .map(attempt)
        .collect::<Result<_>>()?;
    Ok(most_that_serves(setup, first, others))
}

impl Attempt {
    fn new(
        setup: &Setup,
        model: &ModalModel,
        decision: &Decision,
        cut: Option<f64>,
        relative: f64,
    ) -> Result<Self> {
        let loud = setup.with_drive_errors(relative);
        let (method, solution) = decision.run(&loud, model, cut)?;
        let drive = &solution.drive;
        let score = loud.problem.score(drive);
        let ground = match loud.finely_between() {
            Some(rows) => loud.problem.with_between(rows, 1.0).score(drive).min_ratio,
            None => score.min_ratio,
        };
        Ok(Self {
            min_ratio: score.min_ratio,
            kappa: score.kappa,
            ground,
            fingers: firmness(&loud, drive),
            bearing: Bearing {
                method,
                solution,
                drive_relative: relative,
                finding: None,
            },
        })
    }

    /// True where it serves what `plain` serves.
    fn serves_like(&self, plain: &Self) -> bool {
        self.min_ratio >= plain.min_ratio
            && self.ground >= plain.ground - tolerances::GROUND_FOR_DRIVE_ERRORS
            && self.fingers >= plain.fingers
    }

    fn drive(&self) -> &Drive {
        &self.bearing.solution.drive
    }
}

/// The first of `first` and `others`, which bear less and less and at last nothing, that
/// serves what the last one serves.
fn most_that_serves(setup: &Setup, first: Attempt, others: Vec<Attempt>) -> Bearing {
    let mut all: Vec<Attempt> = std::iter::once(first).chain(others).collect();
    let plain = all.len() - 1;
    let taken = (0..plain)
        .find(|&k| all[k].serves_like(&all[plain]))
        .unwrap_or(plain);
    let finding = price(setup, &all[taken], &all[plain], taken == 0);
    let mut bearing = all.swap_remove(taken).bearing;
    bearing.finding = Some(finding);
    bearing
}

/// The note on what bearing errors of the drives costs, or why it bears less.
fn price(setup: &Setup, taken: &Attempt, plain: &Attempt, is_most: bool) -> Finding {
    let percent = |relative: f64| format!("{} %", 100.0 * relative);
    let unit = match setup.operator.unit {
        ReferenceUnit::Newton => "mN",
        ReferenceUnit::Volt => "mV",
    };
    let peak = |attempt: &Attempt| 1e3 * attempt.drive().iter().map(amplitude).fold(0.0, f64::max);
    let drift = |attempt: &Attempt| setup.problem.score(attempt.drive()).kappa;
    let relative = taken.bearing.drive_relative;
    let least = match is_most {
        true => String::new(),
        false => format!(
            "errors of the drives of {} would cost responses or ground: ",
            percent(tolerances::DRIVE_ERRORS[0])
        ),
    };
    let words = match relative > 0.0 {
        true => format!(
            "{least}made for errors of the drives of {}: largest drive {:.2} {unit} ({:.2} {unit} \
             without), κ {:.2} against drift of the panel alone ({:.2} without)",
            percent(relative),
            peak(taken),
            peak(plain),
            drift(taken),
            drift(plain)
        ),
        false => format!("{least}the drive is made for none"),
    };
    Finding::note("drive-errors", words)
        .value("drive_relative", relative)
        .help("state [drift] drive_relative in the scene")
}
