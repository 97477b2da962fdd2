//! The least effort that serves the scene (method `min-effort`).
//!
//! min √Σ|A_i|² with every response inside its limit by `tolerances::KAPPA_EFFORT`
//! standard deviations, or by most of the largest κ where that is less (theory.md, eq.
//! 47). For actuators that get hot, or amplifiers that are small; [`super::robust`] holds
//! better.

use crate::methods::effort::Effort;
use crate::methods::mls;
use crate::methods::solution::Solution;
use crate::panel::drive::Drive;
use crate::problems::problem::{Problem, Rows};
use crate::solving::climb::Climb;
use crate::solving::drive_program::Asked;
use crate::tolerances;
use chladni_frf::Result;

/// The least drive found.
pub(crate) fn solve(problem: &Problem, between: Option<&Rows>, effort: Effort) -> Result<Solution> {
    let start = mls::leading_drives(problem, between)?.swap_remove(0);
    let drive = least_from(problem, &start, effort)?;
    if problem.score(&drive).min_ratio == 1.0 {
        return Ok(Solution::of_drive(drive));
    }
    // where a drive limit binds, `mls` has another drive
    let within_limit = mls::solve(problem, between)?.drive;
    let better = solve_again(problem, &drive, &[within_limit], effort)?;
    Ok(better.unwrap_or_else(|| Solution::of_drive(drive)))
}

/// The least drive that the first of `others` leads to which serves more of the worse zone
/// than `before`; `None` where none does.
pub(crate) fn solve_again(
    problem: &Problem,
    before: &Drive,
    others: &[Drive],
    effort: Effort,
) -> Result<Option<Solution>> {
    let served = |drive: &Drive| problem.score(drive).min_ratio;
    for other in others {
        let drive = least_from(problem, other, effort)?;
        if served(&drive) > served(before) {
            return Ok(Some(Solution::of_drive(drive)));
        }
    }
    Ok(None)
}

/// The least drive that `start` leads to.
fn least_from(problem: &Problem, start: &Drive, effort: Effort) -> Result<Drive> {
    let mut climb = Climb::new(problem)?.rounds(effort.conic_rounds);
    let (kappa, drive) = climb.reach_kappa(start, problem.kappa_of_confidence())?;
    if kappa == 0.0 {
        // no drive keeps every limit: the one that serves more responses is taken
        let mut contest = mls::Contest::new(problem, problem, problem.kappa_least);
        contest.offer(problem, start);
        contest.offer(problem, &drive);
        return Ok(contest.into_best());
    }
    let asked = Asked {
        kappa: tolerances::KAPPA_EFFORT.min(tolerances::KEEP * kappa),
        factor: 1.0,
    };
    climb.lower_effort(drive, asked)
}
