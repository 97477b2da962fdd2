//! Robust drives by second-order cones (method `robust`, the default).
//!
//! The largest κ, so that every row keeps its limit under errors of κ standard deviations of the model; once κ is enough
//! ([`tolerances::KAPPA_CAP`]), the largest margin in dB at that κ; then the least peak force that keeps most of both (theory.md,
//! eq. 44 to 47). Largest margin alone is no method: it spends every force that is allowed on the last tenth of a
//! decibel and falls with the first error of the model.
//!
//! Rows interpolated between the responses take part, too. Where κ would fall below [`tolerances::KAPPA_LEAST`] with all of them, the
//! responses keep that much, and as much of the ground between them is served as that leaves. The climb starts from `mls`, and
//! where no drive serves every response, the one of both is taken that serves more.

use crate::climb::Climb;
use crate::drive_program::Asked;
use crate::methods::{mls, Solution};
use crate::options::Effort;
use crate::setup::Setup;
use crate::tolerances;
use chladni_frf::Result;

/// The most robust drive found from the best drive of `mls`; with more than one start from others that it found, too.
pub(crate) fn solve(setup: &Setup, effort: Effort) -> Result<Solution> {
    let problem = &setup.problem;
    let climb_on = |rows| Climb::new(rows).map(|climb| climb.rounds(effort.conic_rounds));
    let ground = setup.finely_between().map(|rows| problem.with_between(rows, 1.0));
    let mut contest = mls::Contest::new(problem, ground.as_ref().unwrap_or(problem), tolerances::KAPPA_LEAST);
    let mut most = 0.0;
    let starts = mls::leading_drives(problem, setup.between())?;
    for (number, start) in starts.iter().take(effort.starts.max(1)).enumerate() {
        contest.offer(problem, start);
        let (kappa, on_points) = climb_on(problem)?.raise_kappa(start)?;
        // another start counts where it leads to more than the first
        if number > 0 && kappa <= most + tolerances::KAPPA_GAIN {
            continue;
        }
        most = f64::max(most, kappa);
        contest.offer(problem, &on_points);
        let Some(ground) = ground.as_ref().filter(|_| kappa >= tolerances::KAPPA_LEAST) else { continue };
        let by_need = || climb_on(ground).map(|climb| climb.by_need(|k| ground.is_measured(problem, k)));
        let drive = by_need()?.climb(&on_points)?;
        contest.offer(ground, &drive);
        if problem.score(&drive).kappa < tolerances::KAPPA_LEAST {
            let asked = Asked { kappa: tolerances::KAPPA_LEAST, factor: 1.0 };
            contest.offer_as_is(&by_need()?.serve_ground(on_points, asked)?);
        }
    }
    if most > 0.0 && ground.is_none() {
        let drive = contest.into_best();
        return Ok(Solution::of_drive(climb_on(problem)?.climb(&drive)?));
    }
    Ok(Solution::of_drive(contest.into_best()))
}
