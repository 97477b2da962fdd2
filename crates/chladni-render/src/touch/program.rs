//! A drive that tolerates fingers.
//!
//! The touched rows of every place and fingertip join the robust program by need, the worst
//! first. κ comes before firmness: the firmest fingertip is taken under which some drive
//! keeps the κ that the scene asks for, never a firmer one at less (a drive for firm fingers
//! at κ 0.2 fails untouched under the first error of an amplifier).

use super::plan::{Judged, TouchPlan};
use crate::methods::effort::Effort;
use crate::panel::drive::{amplitude, Drive};
use crate::problems::problem::{Problem, Rows};
use crate::problems::setup::Setup;
use crate::solving::climb::{peak, Climb};
use crate::solving::drive_program::Asked;
use crate::tolerances;
use chladni_frf::Result;

/// The result of the search for a drive.
pub(crate) struct TouchDrive {
    /// The drive.
    pub(crate) drive: Drive,
    /// Largest contrast that was found under all fingertips, dB, where it is not enough.
    pub(crate) best_db: Option<f64>,
}

/// The drive that tolerates the firmest fingers, from `start`, which tolerates none.
pub(crate) fn drive_under_fingers(
    setup: &Setup,
    plan: &TouchPlan,
    start: Drive,
    effort: Effort,
) -> Result<TouchDrive> {
    let problem = &setup.problem;
    let least = plan.touch.kappa_least;
    let mut best_db = None;
    for softest in (1..=plan.touch.impedances.len()).rev() {
        let rows = plan.rows(judged(setup), softest);
        let on = problem.with_between(&rows, 1.0);
        let drive = most_robust(problem, &on, &start, least, effort.conic_rounds)?;
        if !tolerates(&on, &drive, least) {
            let reached = [&drive, &start].map(|drive| contrast_db(&on, drive));
            let most = reached.into_iter().flatten().max_by(f64::total_cmp);
            best_db = best_db.or(most);
            continue;
        }
        let drive = match setup.finely_between() {
            Some(ground) => serve_ground([problem, &on], ground, drive, least, effort)?,
            None => drive,
        };
        return Ok(TouchDrive { drive, best_db });
    }
    Ok(TouchDrive {
        drive: start,
        best_db,
    })
}

/// From a drive that tolerates fingers on `on` to one that serves the ground between the responses
/// as well. Where that costs the κ at which responses are sure, the touched ones keep 0.9 of
/// it, and as much ground is served as that and the force limit leave.
fn serve_ground(
    [problem, on]: [&Problem; 2],
    ground: &Rows,
    drive: Drive,
    least: f64,
    effort: Effort,
) -> Result<Drive> {
    let whole = on.with_between(ground, 1.0);
    let all = most_robust(problem, &whole, &drive, least, effort.conic_rounds)?;
    let kappa = problem.kappa_of_confidence().max(least) * tolerances::KEEP;
    let asked = match tolerates(on, &drive, kappa) {
        true => kappa,
        // touched rows are not sure even without the ground
        false => least,
    };
    if tolerates(&whole, &all, asked) {
        return Ok(all);
    }
    let asked = Asked {
        kappa: on.score(&drive).kappa.min(asked),
        factor: 1.0,
    };
    let mut climb = Climb::new(&whole)?
        .rounds(effort.conic_rounds)
        .by_need(|k| whole.is_measured(on, k));
    let most = climb.serve_ground(drive.clone(), asked)?;
    let served = |drive: &Drive| whole.score(drive).min_ratio;
    Ok(
        if tolerates(on, &most, asked.kappa) && served(&most) > served(&drive) {
            most
        } else if tolerates(&whole, &all, least) {
            all
        } else {
            drive
        },
    )
}

/// κ that a drive can have under all fingers, sought for a few rounds; negative where it
/// finds none.
pub(crate) fn touched_kappa(setup: &Setup, plan: &TouchPlan, start: &Drive) -> Result<f64> {
    let problem = &setup.problem;
    let rows = plan.rows(judged(setup), plan.touch.impedances.len());
    let on = problem.with_between(&rows, 1.0);
    if plan.loss_db(plan.touch.impedances.len()) > tolerances::TOUCH_LOSS_DB {
        return Ok(on.score(start).kappa);
    }
    let rounds = tolerances::TOUCH_SWEEP_ROUNDS;
    let most = problem.kappa_of_confidence();
    let (_, drive) = climb(problem, &on, rounds)?.reach_kappa(start, most)?;
    Ok(on.score(&drive).kappa)
}

/// The judged responses of a scene.
pub(crate) fn judged(setup: &Setup) -> Judged<'_> {
    Judged {
        operator: &setup.operator,
        zones: &setup.zones,
        rows: &setup.judged,
        hot: setup.problem.rows.hot,
    }
}

/// A climb over `on`, of which the rows of `problem` take part from the beginning.
fn climb<'a>(problem: &Problem, on: &'a Problem, rounds: usize) -> Result<Climb<'a>> {
    let climb = Climb::new(on)?.rounds(rounds);
    Ok(climb
        .joining(tolerances::TOUCH_ROWS_JOINING)
        .by_need(|k| on.is_measured(problem, k)))
}

/// The largest κ up to what is enough, most of it at the least peak force; where it is enough,
/// the margin that little force gives, too: fingers and the mobility under them are known to a
/// few percent, and every part of a limit that is left covers that.
fn most_robust(
    problem: &Problem,
    on: &Problem,
    start: &Drive,
    least: f64,
    rounds: usize,
) -> Result<Drive> {
    let enough = problem.kappa_of_confidence().max(least);
    let mut climb = climb(problem, on, rounds)?;
    let (_, drive) = climb.reach_kappa(start, enough / tolerances::KEEP)?;
    let kappa = on.score(&drive).kappa.min(enough / tolerances::KEEP);
    if kappa < least {
        return Ok(drive);
    }
    let asked = Asked {
        kappa: f64::max(kappa * tolerances::KEEP, least),
        factor: 1.0,
    };
    let softer = climb.lower_peak(drive.clone(), asked)?;
    // a force that is hardly less is not worth a tenth of κ
    let is_softer = peak(&softer) < peak(&drive) * (1.0 - tolerances::COST_GAIN);
    let takes = is_softer && tolerates(on, &softer, asked.kappa);
    let drive = if takes { softer } else { drive };
    if kappa < enough * (1.0 - tolerances::SAME_TOUCHED_KAPPA) {
        return Ok(drive);
    }
    let wider = climb.take_margin(drive.clone(), asked.kappa)?;
    Ok(match tolerates(on, &wider, asked.kappa) {
        true => wider,
        false => drive,
    })
}

fn tolerates(on: &Problem, drive: &Drive, least: f64) -> bool {
    on.score(drive).kappa >= least * (1.0 - tolerances::SAME_TOUCHED_KAPPA)
}

/// Least hot over largest cold, dB; `None` without one of them.
pub(crate) fn contrast_db(on: &Problem, drive: &Drive) -> Option<f64> {
    let field = on.field(drive).map(amplitude);
    let (hot, cold) = field.as_slice()?.split_at(on.rows.hot);
    let least = hot.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = cold.iter().copied().fold(0.0, f64::max);
    let ratio = least / largest;
    (ratio.is_finite() && ratio > 0.0).then(|| 20.0 * ratio.log10())
}
