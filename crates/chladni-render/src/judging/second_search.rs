//! A second search, where the drive of a conic method leaves responses unserved.
//!
//! The first search starts from drives that serve many responses. The ceiling finds the drive of
//! most contrast on another way, and may meet the scene where the first search ended beside it.

use crate::judging::ceiling::Ceiling;
use crate::methods::effort::Effort;
use crate::methods::method::Method;
use crate::methods::mls;
use crate::methods::solution::Solution;
use crate::panel::drive::Drive;
use crate::problems::problem::Problem;
use crate::problems::setup::Setup;
use crate::solving::climb::Climb;
use crate::tolerances;
use chladni_frf::Result;

/// The better solution, or `first` where it serves every response or none is better; and the
/// ceiling of a scene that `first` does not meet.
///
/// * `thorough`: as for [`Ceiling::of`]
///
/// # Errors
/// Those of the kernels: a broken promise.
pub(crate) fn better_solution(
    setup: &Setup,
    method: Method,
    first: Solution,
    effort: Effort,
    thorough: bool,
) -> Result<(Solution, Option<Ceiling>)> {
    let problem = &setup.problem;
    if !method.is_conic() || meets(problem, &first.drive) {
        return Ok((first, None));
    }
    let found = Ceiling::of(problem, &first.drive, thorough)?;
    let (ceiling, mut drives) = match found {
        Some((ceiling, _)) if ceiling.forbids() => return Ok((first, Some(ceiling))),
        Some((ceiling, drive)) => (Some(ceiling), vec![drive]),
        None => (None, Vec::new()),
    };
    if !drives.iter().any(|drive| meets(problem, drive)) {
        drives.extend(of_other_starts(setup)?);
    }
    let again = method.solve_again(setup, &first.drive, &drives, effort)?;
    Ok((again.unwrap_or(first), ceiling))
}

/// The drives of most contrast that the starts of method `best` lead to, without its first.
fn of_other_starts(setup: &Setup) -> Result<Vec<Drive>> {
    let mut climb = Climb::new(&setup.problem)?;
    let starts = mls::leading_drives(&setup.problem, setup.between())?;
    let others = starts.into_iter().take(tolerances::MOST_STARTS).skip(1);
    others
        .map(|start| climb.raise_hot(start).map(|(_, drive)| drive))
        .collect()
}

fn meets(problem: &Problem, drive: &Drive) -> bool {
    problem.score(drive).min_ratio == 1.0
}
