//! The least effort that serves the scene (method `min-effort`).
//!
//! min √Σ|A_i|² with every response inside its limit by `tolerances::KAPPA_EFFORT`
//! standard deviations, or by most of the largest κ where that is less (theory.md, eq.
//! 47). For actuators that get hot, or amplifiers that are small; [`super::robust`] holds
//! better.

use crate::methods::effort::Effort;
use crate::methods::mls;
use crate::methods::solution::Solution;
use crate::problems::problem::{Problem, Rows};
use crate::solving::climb::Climb;
use crate::solving::drive_program::Asked;
use crate::tolerances;
use chladni_frf::Result;

/// The least drive found.
pub(crate) fn solve(problem: &Problem, between: Option<&Rows>, effort: Effort) -> Result<Solution> {
    let start = mls::leading_drives(problem, between)?.swap_remove(0);
    let mut climb = Climb::new(problem)?.rounds(effort.conic_rounds);
    let (kappa, drive) = climb.reach_kappa(&start, problem.kappa_of_confidence())?;
    if kappa == 0.0 {
        // no drive keeps every limit: the one that serves more responses is taken
        let mut contest = mls::Contest::new(problem, problem, problem.kappa_least);
        contest.offer(problem, &start);
        contest.offer(problem, &drive);
        return Ok(Solution::of_drive(contest.into_best()));
    }
    let asked = Asked {
        kappa: tolerances::KAPPA_EFFORT.min(tolerances::KEEP * kappa),
        factor: 1.0,
    };
    Ok(Solution::of_drive(climb.lower_effort(drive, asked)?))
}
