//! Robust drives by second-order cones (method `robust`, the default).
//!
//! The largest κ, so that every row keeps its limit under errors of κ standard deviations
//! of the model, up to the κ at which all responses keep theirs with
//! `tolerances::CONFIDENCE`, and the least peak force that keeps most of it; then the
//! largest margin in dB that a little force gives (`tolerances::LITTLE_FORCE`), and
//! again the least that keeps most of it (theory.md, eq. 44 to 47). Largest margin alone
//! is no method: it spends every force that is allowed on the last tenth of a decibel and
//! falls with the first error of the model.
//!
//! Rows interpolated between the responses take part, too. Where κ would fall below
//! `Problem::kappa_least` with all of them, only the responses keep that κ, and as much of
//! the ground between them is served as possible. The climb starts from the drive of `mls`.
//! If no drive serves every response, the better of two is taken: that of `mls`, or that of
//! the climb. Then other drives are asked: that of `mls` where a drive limit binds, and the
//! most contrasting one that the ceiling leads to ([`solve_again`]).

use crate::methods::effort::Effort;
use crate::methods::mls;
use crate::methods::solution::Solution;
use crate::panel::drive::Drive;
use crate::problems::setup::Setup;
use crate::solving::climb::Climb;
use crate::solving::drive_program::Asked;
use crate::tolerances;
use crate::touch::{drive_under_fingers, TouchDrive};
use chladni_frf::Result;

/// The most robust drive found from the best drive of `mls`; with more than one start
/// from others that it found, too.
pub(crate) fn solve(setup: &Setup, effort: Effort) -> Result<Solution> {
    let problem = &setup.problem;
    let starts = mls::leading_drives(problem, setup.between())?;
    let mut drive = climb_from(setup, &starts, effort)?;
    if problem.score(&drive).min_ratio < 1.0 {
        let within_limit = mls::solve(problem, setup.between())?.drive;
        if let Some(better) = better_of(setup, &drive, &[within_limit], effort)? {
            drive = better;
        }
    }
    under_fingers(setup, drive, effort)
}

/// The solution that one of `others` leads to, where the drive `before` serves fewer
/// responses; `None` where no other is better.
pub(crate) fn solve_again(
    setup: &Setup,
    before: &Drive,
    others: &[Drive],
    effort: Effort,
) -> Result<Option<Solution>> {
    let better = better_of(setup, before, others, effort)?;
    better
        .map(|drive| under_fingers(setup, drive, effort))
        .transpose()
}

/// The best of `others`, where it is better than `before`. If it serves every response, the
/// most robust drive near it.
fn better_of(
    setup: &Setup,
    before: &Drive,
    others: &[Drive],
    effort: Effort,
) -> Result<Option<Drive>> {
    let problem = &setup.problem;
    let mut contest = mls::Contest::new(problem, problem, problem.kappa_least);
    let known = contest.offer_as_is(before);
    let keys = others.iter().map(|drive| contest.offer(problem, drive));
    let keys: Vec<_> = keys.collect();
    if !keys.iter().any(|key| *key > known) {
        return Ok(None);
    }
    let best = contest.into_best();
    match problem.score(&best).min_ratio == 1.0 {
        true => climb_from(setup, &[best], effort).map(Some),
        false => Ok(Some(best)),
    }
}

/// The drive, continued to one that tolerates fingers where the scene expects them.
fn under_fingers(setup: &Setup, drive: Drive, effort: Effort) -> Result<Solution> {
    let Some(plan) = &setup.touch else {
        return Ok(Solution::of_drive(drive));
    };
    let TouchDrive { drive, best_db } = drive_under_fingers(setup, plan, drive, effort)?;
    Ok(Solution {
        touched_db: best_db,
        ..Solution::of_drive(drive)
    })
}

/// The most robust drive near `before`, which served a place nearby: fields that are to
/// pass into each other must be alike. Where it leads to no drive that serves every
/// response, the search begins anew.
pub(crate) fn follow(setup: &Setup, before: &Drive, effort: Effort) -> Result<Drive> {
    let problem = &setup.problem;
    let near = climb_from(setup, std::slice::from_ref(before), effort)?;
    if problem.score(&near).min_ratio == 1.0 {
        return Ok(near);
    }
    let anew = solve(setup, effort)?.drive;
    let served = |drive: &Drive| problem.score(drive).min_ratio;
    Ok(if served(&anew) > served(&near) {
        anew
    } else {
        near
    })
}

/// The best drive that any of `starts` leads to.
fn climb_from(setup: &Setup, starts: &[Drive], effort: Effort) -> Result<Drive> {
    let problem = &setup.problem;
    let enough = problem.kappa_of_confidence();
    let climb_on = |rows| Climb::new(rows).map(|climb| climb.rounds(effort.conic_rounds));
    let ground = setup
        .finely_between()
        .map(|rows| problem.with_between(rows, 1.0));
    let on = ground.as_ref().unwrap_or(problem);
    let contest =
        |most| mls::Contest::new(problem, on, problem.kappa_least).prefer_less_force_above(most);
    let (mut served, mut others) = (contest(enough), contest(f64::INFINITY));
    let serves = |kappa: f64| kappa >= problem.kappa_least * (1.0 - tolerances::SAME_KAPPA);
    let mut most = 0.0;
    for (number, start) in starts.iter().take(effort.starts.max(1)).enumerate() {
        others.offer(problem, start);
        let (kappa, on_points) =
            climb_on(problem)?.reach_kappa(start, enough / tolerances::KEEP)?;
        // a further start counts only where it leads to more κ than those before
        if number > 0 && kappa <= most + tolerances::KAPPA_GAIN {
            continue;
        }
        most = f64::max(most, kappa);
        others.offer(problem, &on_points);
        if ground.is_some() && !serves(kappa) {
            continue;
        }
        let by_need = || {
            climb_on(on)
                .map(|climb| climb.by_need(|k| ground.is_none() || on.is_measured(problem, k)))
        };
        let drive = by_need()?.climb(&on_points, enough)?;
        if serves(problem.score(&drive).kappa) && on.score(&drive).min_ratio == 1.0 {
            served.offer(on, &drive);
            continue;
        }
        others.offer(on, &drive);
        if ground.is_some() {
            let asked = Asked {
                kappa: problem.kappa_least,
                factor: 1.0,
            };
            others.offer_as_is(&by_need()?.serve_ground(on_points, asked)?);
        }
    }
    Ok(served.best().unwrap_or_else(|| others.into_best()))
}
