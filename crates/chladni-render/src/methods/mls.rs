//! Least squares of magnitudes with the model's own covariance (method `mls`).
//!
//! The phase of the hot zone is free, and a row that keeps its limit with a margin is not pulled anywhere:
//!
//! minimise Σ_k w_k( dist(h_k·A, S_k)² + ‖L·A‖² ), S_k = {|v| ≥ V_h·10^{g/20}} on hot rows, {|v| ≤ V_c·10^{−g/20}} on cold ones.
//!
//! Majorisation: with p_k the nearest value of S_k to h_k·A (same phase, limited magnitude), A ← G·p, one factorisation for all
//! steps; p overshoots by the factor [`tolerances::MLS_RELAXATION`]. The classic form (Kassakian 2006: hot rows pulled to
//! one magnitude from both sides, cold ones to zero) spends its freedom on rows that are right already: on the study's 2×2
//! corner it served 0.95 of the hot responses where this form serves all, at twice the force.
//!
//! The problem is not convex, so several starts compete: pressure matching, contrast control, and hot zones with a phase that
//! runs across. They compete on the responses alone and with rows interpolated between the responses, of two weights; winner is
//! who serves most responses, then has some κ, then serves most ground between the responses.

use crate::gain::within_drive_limit;
use crate::methods::pressure_matching::one_phase_target;
use crate::methods::{contrast, Solution};
use crate::plane::Rectangle;
use crate::problem::{Drive, Problem, Rows};
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array2;
use num_complex::Complex64;
use std::cmp::Ordering;
use std::f64::consts::PI;

/// Phase differences across the hot zone, in x and in y, of the tilted starts: half waves.
const TILTS: [[f64; 2]; 6] = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0], [2.0, 0.0], [0.0, 2.0]];

/// The best drive found; `between` are rows between the responses, where there are any.
pub(crate) fn solve(problem: &Problem, between: Option<&Rows>) -> Result<Solution> {
    within_drive_limit(problem, |ridge| Ok(search(problem, between, ridge)?.0))
}

/// Up to `count` drives of different starts, the best first.
pub(crate) fn leading_drives(problem: &Problem, between: Option<&Rows>, count: usize) -> Result<Vec<Drive>> {
    let (best, others) = search(problem, between, 0.0)?;
    let mut drives = vec![best];
    drives.extend(others);
    drives.truncate(count);
    Ok(drives)
}

/// The best drive, and those that its rivals on the responses ended at.
fn search(problem: &Problem, between: Option<&Rows>, ridge: f64) -> Result<(Drive, Vec<Drive>)> {
    let mut problems = vec![problem.clone()];
    problems.extend(between.iter().flat_map(|rows| tolerances::BETWEEN_WEIGHTS.map(|weight| problem.with_between(rows, weight))));
    let mut contest = Contest::new(problem, problems.last().expect("at least the responses"), tolerances::KAPPA_ENOUGH);
    let mut leaders = None;
    for problem in &problems {
        let inverse = problem.regularised_inverse(ridge)?;
        let starts = match leaders {
            None => starts(problem, &inverse)?,
            Some(leaders) => leaders,
        };
        leaders = Some(contest.enter(problem, &inverse, &starts));
    }
    Ok((contest.into_best(), leaders.unwrap_or_default()))
}

/// What a drive is judged by, the more important first: responses served (least zone, total), κ up to what is enough, ground
/// served (least zone, total), κ over all ground.
type Key = [f64; 6];

/// Keeps the best drive of all that are offered.
pub(crate) struct Contest<'a> {
    points: &'a Problem,
    ground: &'a Problem,
    /// κ on the responses of which more counts less than ground between them.
    enough: f64,
    best: Option<(Key, Drive)>,
}

impl<'a> Contest<'a> {
    /// On the responses of `points`, then on the rows of `ground`.
    pub(crate) fn new(points: &'a Problem, ground: &'a Problem, enough: f64) -> Self {
        Self { points, ground, enough, best: None }
    }

    /// The best drive that was offered; silence where none was.
    pub(crate) fn into_best(self) -> Drive {
        self.best.map_or_else(|| Drive::zeros(self.points.rows.mobility.ncols()), |(_, drive)| drive)
    }

    /// Iterates from all starts with the first margin, and from the best of them with the others; returns the leading drives.
    fn enter(&mut self, problem: &Problem, inverse: &Array2<Complex64>, starts: &[Drive]) -> Vec<Drive> {
        let [first, others @ ..] = tolerances::MLS_MARGINS_DB;
        let mut drives: Vec<(Key, Drive)> = Vec::new();
        for start in starts {
            let drive = iterate(problem, inverse, start, first);
            drives.push((self.offer(problem, &drive), drive));
        }
        drives.sort_by(|(a, _), (b, _)| better_first(a, b));
        for margin_db in others {
            let drive = iterate(problem, inverse, &drives[0].1, margin_db);
            self.offer(problem, &drive);
        }
        drives.truncate(tolerances::MLS_LEADERS);
        drives.into_iter().map(|(_, drive)| drive).collect()
    }

    /// Enters a drive with its best gain on `problem`.
    pub(crate) fn offer(&mut self, problem: &Problem, drive: &Drive) -> Key {
        self.judge(problem.with_best_gain(drive))
    }

    /// Enters a drive with the gain that it has, or the largest that its limits allow.
    pub(crate) fn offer_as_is(&mut self, drive: &Drive) -> Key {
        let gain = self.points.drive_limits.allowed_gain(drive).min(1.0);
        self.judge(drive.mapv(|weight| weight * gain))
    }

    fn judge(&mut self, drive: Drive) -> Key {
        let (points, ground) = (self.points.score(&drive), self.ground.score(&drive));
        let robust = points.kappa.min(self.enough);
        let key = [points.min_ratio, points.success_ratio, robust, ground.min_ratio, ground.success_ratio, ground.kappa];
        if self.best.as_ref().is_none_or(|(best, _)| key > *best) {
            self.best = Some((key, drive));
        }
        key
    }
}

/// The more important entries decide; equal ones hand over to the next.
fn better_first(a: &Key, b: &Key) -> Ordering {
    a.iter().zip(b).map(|(a, b)| b.total_cmp(a)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
}

/// Where the iteration starts: pressure matching, contrast control, tilted phases.
fn starts(problem: &Problem, inverse: &Array2<Complex64>) -> Result<Vec<Drive>> {
    let one_phase = one_phase_target(problem);
    let hot_m = &problem.rows.positions_m[..problem.rows.hot];
    let zone = Rectangle::around(hot_m).expect("a problem has a hot row");
    let across = |value: f64, low: f64, high: f64| (value - low) / (high - low).max(tolerances::POSITION_M);
    let tilted = |[half_waves_x, half_waves_y]: [f64; 2]| {
        let mut target = one_phase.clone();
        for (value, [x, y]) in target.iter_mut().zip(hot_m) {
            let phase = half_waves_x * across(*x, zone.x_min, zone.x_max) + half_waves_y * across(*y, zone.y_min, zone.y_max);
            *value = Complex64::from_polar(1.0, PI * phase);
        }
        inverse.dot(&target)
    };
    let mut starts = vec![inverse.dot(&one_phase), contrast::direction(problem)?];
    starts.extend(TILTS.map(tilted));
    Ok(starts)
}

/// [`tolerances::MLS_STEPS`] steps of the majorisation from `start`.
fn iterate(problem: &Problem, inverse: &Array2<Complex64>, start: &Drive, margin_db: f64) -> Drive {
    let ratio = 10f64.powf(margin_db / 20.0);
    let (hot_limit, cold_limit) = (problem.limits.hot_m_per_s * ratio, problem.limits.cold_m_per_s / ratio);
    let mut drive = problem.with_best_gain(start);
    for _ in 0..tolerances::MLS_STEPS {
        let mut target = problem.field(&drive);
        for (k, value) in target.iter_mut().enumerate() {
            let amplitude = value.norm();
            let is_hot = k < problem.rows.hot;
            let limit = if is_hot { hot_limit } else { cold_limit };
            if (is_hot && amplitude < limit) || (!is_hot && amplitude > limit) {
                *value = relaxed(*value, amplitude, limit);
            }
        }
        drive = inverse.dot(&target);
    }
    drive
}

/// `value` moved along its own phase to the magnitude `limit`, and beyond by the relaxation.
fn relaxed(value: Complex64, amplitude: f64, limit: f64) -> Complex64 {
    let phase = if amplitude > 0.0 { value / amplitude } else { Complex64::ONE };
    phase * (amplitude + tolerances::MLS_RELAXATION * (limit - amplitude))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_still_row_gets_some_phase_and_a_loud_one_is_reduced() {
        assert_eq!(relaxed(Complex64::ZERO, 0.0, 1.0), Complex64::from(tolerances::MLS_RELAXATION));
        let value = Complex64::new(0.0, 2.0);
        let expected = 2.0 - tolerances::MLS_RELAXATION;
        assert!((relaxed(value, 2.0, 1.0) - Complex64::new(0.0, expected)).norm() < 1e-15);
    }
}
