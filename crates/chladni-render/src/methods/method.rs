//! The methods by name, and the one that solves a scene.

use crate::methods::effort::Effort;
use crate::methods::solution::Solution;
use crate::methods::{
    contrast, min_effort, mls, modal, pressure_matching, robust, tikhonov, time_reversal, tsvd,
    vast,
};
use crate::panel::drive::Drive;
use crate::problems::setup::Setup;
use chladni_frf::{Finding, ModalModel, Result};
use std::fmt;

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

    /// The least number of explicit modes with which it finds a drive. Only `modal`, which
    /// goes through modal coefficients, needs one; the others do with residual terms alone.
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

    /// True for the methods of conic programs.
    pub(crate) fn is_conic(self) -> bool {
        matches!(self, Self::Robust | Self::MinEffort)
    }

    /// The solution that one of `others` leads to, where the drive `before` of a conic method
    /// serves fewer responses; `None` where no other is better.
    pub(crate) fn solve_again(
        self,
        setup: &Setup,
        before: &Drive,
        others: &[Drive],
        effort: Effort,
    ) -> Result<Option<Solution>> {
        match self {
            Self::Robust => robust::solve_again(setup, before, others, effort),
            Self::MinEffort => min_effort::solve_again(&setup.problem, before, others, effort),
            _ => Ok(None),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}
