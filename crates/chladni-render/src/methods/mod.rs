//! The methods, one file each. All see the same [`Problem`] and return a drive; none
//! knows files or flags.

mod choice;
pub(crate) mod contrast;
mod magnitudes;
pub(crate) mod min_effort;
pub(crate) mod mls;
pub(crate) mod modal;
pub(crate) mod pressure_matching;
pub(crate) mod robust;
mod split;
pub(crate) mod tikhonov;
pub(crate) mod time_reversal;
pub(crate) mod tsvd;
pub(crate) mod vast;

pub(crate) use choice::Decision;
pub use choice::MethodChoice;
pub use modal::{ModalSteps, StepMatrix};

use crate::effort::Effort;
use crate::problem::{Drive, Problem};
use crate::setup::Setup;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Finding, ModalModel, Result};
use std::fmt;
use std::str::FromStr;

/// A method that finds the weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// One regularised least-squares solution with one phase all over the hot zone:
    /// instant, and several points worse.
    PressureMatching,
    /// Least squares of magnitudes: the phase of the hot zone is free.
    Mls,
    /// Conic programs: the largest κ, then the largest margin, then the least peak force.
    Robust,
    /// Conic programs: the least effort that serves every response.
    MinEffort,
    /// The two-step inverse of the seed paper, by pseudo-inverses. A baseline:
    /// `methods/modal.rs` says why not to use it.
    Modal,
    /// Least squares with a plain ridge, a baseline.
    Tikhonov,
    /// Least squares by a truncated singular value decomposition, a baseline.
    Tsvd,
    /// Most hot energy for its cold energy, a baseline.
    ContrastControl,
    /// Variable span trade-off, a baseline.
    Vast,
    /// Time reversal, a baseline.
    TimeReversal,
}

impl Method {
    /// All methods, in the order of their names' listing.
    pub const ALL: [Self; 10] = [
        Self::PressureMatching,
        Self::Mls,
        Self::Robust,
        Self::MinEffort,
        Self::Modal,
        Self::Tikhonov,
        Self::Tsvd,
        Self::ContrastControl,
        Self::Vast,
        Self::TimeReversal,
    ];

    /// Name as on the command line and in results.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PressureMatching => "pressure-matching",
            Self::Mls => "mls",
            Self::Robust => "robust",
            Self::MinEffort => "min-effort",
            Self::Modal => "modal",
            Self::Tikhonov => "tikhonov",
            Self::Tsvd => "tsvd",
            Self::ContrastControl => "contrast-control",
            Self::Vast => "vast",
            Self::TimeReversal => "time-reversal",
        }
    }

    /// True for methods that are there to be compared with.
    pub fn is_baseline(self) -> bool {
        !matches!(
            self,
            Self::PressureMatching | Self::Mls | Self::Robust | Self::MinEffort
        )
    }

    /// The least number of explicit modes with which it finds a drive; residual terms alone
    /// do for all but the one that goes through modal coefficients.
    pub(crate) fn least_modes(self) -> usize {
        usize::from(self == Self::Modal)
    }

    /// The drive for a scene laid over `model`.
    pub(crate) fn solve(
        self,
        setup: &Setup,
        model: &ModalModel,
        effort: Effort,
        cut: Option<f64>,
    ) -> Result<Solution> {
        let problem = &setup.problem;
        let mut solution = match self {
            Self::PressureMatching => pressure_matching::solve(problem)?,
            Self::Mls => mls::solve(problem, setup.between())?,
            Self::Robust => robust::solve(setup, effort)?,
            Self::MinEffort => min_effort::solve(problem, setup.between(), effort)?,
            Self::Modal => modal::solve(setup, model, cut)?,
            Self::Tikhonov => Solution::of_direction(problem, &tikhonov::solve(problem)?),
            Self::Tsvd => Solution::of_direction(problem, &tsvd::solve(problem)?),
            Self::ContrastControl => {
                Solution::of_direction(problem, &contrast::direction(problem)?)
            }
            Self::Vast => Solution::of_direction(problem, &vast::solve(problem)?),
            Self::TimeReversal => Solution::of_direction(problem, &time_reversal::solve(problem)),
        };
        if self.is_baseline() {
            solution.findings.push(Finding::note(
                "baseline-method",
                format!(
                    "method `{self}` is a baseline to compare with; `robust` and `mls` serve more"
                ),
            ));
        }
        Ok(solution)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FromStr for Method {
    type Err = Error;
    /// The names of [`Method::ALL`].
    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|method| method.as_str() == text)
            .ok_or_else(|| {
                let known: Vec<&str> = MethodChoice::names().collect();
                Error::new(ErrorKind::Usage, "no such rendering method")
                    .field("method")
                    .found(text)
                    .expected(known.join(", "))
            })
    }
}

/// A drive and what must be said about how it was found.
pub(crate) struct Solution {
    pub(crate) drive: Drive,
    pub(crate) findings: Vec<Finding>,
    /// Quantities between target and drive, of the method that goes through modal
    /// coefficients.
    pub(crate) modal: Option<ModalSteps>,
    /// Largest contrast that was found under the firmest fingers, dB, where no drive bears
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
    fn of_direction(problem: &Problem, direction: &Drive) -> Self {
        let drive = problem.with_best_gain(direction);
        let mut findings = Vec::new();
        if problem.drive_limits.allowed_gain(&drive) <= 1.0 + tolerances::AT_LIMIT {
            let words = format!("{} binds", problem.drive_limits.binding(&drive));
            findings.push(Finding::caution("limit-binds", words));
        }
        Self {
            findings,
            ..Self::of_drive(drive)
        }
    }
}
