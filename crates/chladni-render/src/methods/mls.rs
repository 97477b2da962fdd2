//! Least squares of magnitudes with the model's own covariance (method `mls`).
//!
//! The phase of the hot zone is free, and a row that keeps its limit with a margin is not
//! pulled anywhere:
//!
//! minimise Σ_k w_k( dist(h_k·A, S_k)² + ‖L·A‖² ), S_k = {|v| ≥ V_h·10^{g/20}} on hot
//! rows, {|v| ≤ V_c·10^{−g/20}} on cold ones.
//!
//! The steps are those of [`super::magnitudes`]. The classic form (Kassakian 2006: hot
//! rows pulled to one magnitude from both sides, cold ones to zero) spends its freedom on
//! rows that are right already: on the study's 2×2 corner it served 0.95 of the hot
//! responses where this form serves all, at twice the force.
//!
//! The problem is not convex, so several starts compete: pressure matching, contrast
//! control, and hot zones with a phase that runs across; first on the responses alone,
//! their leaders with several margins, and the leaders of these also with rows
//! interpolated between the responses. The winner serves most responses. Among equals κ
//! decides, up to what is enough, then the ground that is served between the responses.

use crate::methods::contrast;
use crate::methods::gain::within_drive_limit;
use crate::methods::magnitudes::{better_first, MagnitudeSteps, Race, Round};
use crate::methods::solution::Solution;
use crate::panel::drive::Drive;
use crate::problems::problem::{Problem, Rows, Score};
use crate::scene::plane::Rectangle;
use crate::solving::climb::peak;
use crate::solving::least_squares::LeastSquares;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Phase differences across the hot zone, in x and in y, of the tilted starts: half
/// waves. With each tilt the list holds its mirror images and the exchange of its axes,
/// so that the starts of a mirrored or turned panel are those of the panel itself.
const TILTS: [[f64; 2]; 12] = [
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [1.0, -1.0],
    [-1.0, -1.0],
    [2.0, 0.0],
    [-2.0, 0.0],
    [0.0, 2.0],
    [0.0, -2.0],
];

/// The best drive found; `between` are rows between the responses, where there are any.
pub(crate) fn solve(problem: &Problem, between: Option<&Rows>) -> Result<Solution> {
    within_drive_limit(problem, |ridge| Ok(search(problem, between, ridge)?.0))
}

/// The best drive, and those of other starts that differ from it and from each other, the
/// better ones first.
pub(crate) fn leading_drives(problem: &Problem, between: Option<&Rows>) -> Result<Vec<Drive>> {
    let (best, others) = search(problem, between, 0.0)?;
    let mut drives = vec![best];
    for drive in others {
        if drives
            .iter()
            .all(|known| likeness(known, &drive) < tolerances::SAME_WAY)
        {
            drives.push(drive);
        }
    }
    Ok(drives)
}

/// |aᴴb|/(‖a‖‖b‖).
fn likeness(a: &Drive, b: &Drive) -> f64 {
    let inner: Complex64 = a.iter().zip(b).map(|(a, b)| a.conj() * b).sum();
    let square = |drive: &Drive| drive.iter().map(Complex64::norm_sqr).sum::<f64>();
    (inner.norm_sqr() / (square(a) * square(b))).sqrt()
}

/// The best drive, and all that ended a part of the search.
fn search(problem: &Problem, between: Option<&Rows>, ridge: f64) -> Result<(Drive, Vec<Drive>)> {
    let with_ground = between.map(|rows| problem.with_between(rows, tolerances::BETWEEN_WEIGHT));
    let ground = with_ground.as_ref().unwrap_or(problem);
    let mut contest = Contest::new(problem, ground, tolerances::KAPPA_ENOUGH);
    let [from_starts, with_each_margin, on_ground] = tolerances::MLS_ROUNDS;
    let on_points = LeastSquares::new(problem, ridge)?;
    let starts = starts(&on_points)?;
    let steps = MagnitudeSteps::new(&on_points)?;
    let [first_margin, ..] = tolerances::MLS_MARGINS_DB;
    let first = contest.enter(&steps, &starts, &[first_margin], from_starts);
    let margins = &tolerances::MLS_MARGINS_DB;
    let mut ended = contest.enter(&steps, &first, margins, with_each_margin);
    if let Some(ground) = &with_ground {
        let last = contest.enter(
            &MagnitudeSteps::new(&LeastSquares::new(ground, ridge)?)?,
            &ended,
            margins,
            on_ground,
        );
        ended.splice(..0, last);
    }
    ended.extend(first);
    Ok((contest.into_best(), ended))
}

/// Criteria of a drive, the more important first: responses served (least zone, total), κ
/// up to what is enough, ground served (least zone, total), κ over all ground up to what
/// is asked of it, little force.
type Key = [f64; 7];

/// Keeps the best drive of all that are offered.
pub(crate) struct Contest<'a> {
    points: &'a Problem,
    ground: &'a Problem,
    /// κ on the responses of which more counts less than ground between them.
    enough: f64,
    /// κ over all ground of which more counts less than a smaller force.
    asked: f64,
    best: Option<(Key, Drive)>,
}

impl<'a> Contest<'a> {
    /// On the responses of `points`, then on the rows of `ground`.
    pub(crate) fn new(points: &'a Problem, ground: &'a Problem, enough: f64) -> Self {
        Self {
            points,
            ground,
            enough,
            asked: f64::INFINITY,
            best: None,
        }
    }

    /// The same where more κ than `kappa` over all ground counts less than a smaller
    /// force.
    pub(crate) fn prefer_less_force_above(self, kappa: f64) -> Self {
        Self {
            asked: kappa,
            ..self
        }
    }

    /// The best drive that was offered.
    pub(crate) fn best(self) -> Option<Drive> {
        self.best.map(|(_, drive)| drive)
    }

    /// The same; silence where none was.
    pub(crate) fn into_best(self) -> Drive {
        let actuators = self.points.rows.mobility.ncols();
        self.best().unwrap_or_else(|| Drive::zeros(actuators))
    }

    /// Iterates from all starts, each with each of the margins in dB, the best going on
    /// from round to round; returns the leading drives.
    fn enter(
        &mut self,
        steps: &MagnitudeSteps,
        starts: &[Drive],
        margins_db: &[f64],
        rounds: [Round; 2],
    ) -> Vec<Drive> {
        let with_margins = starts
            .iter()
            .flat_map(|start| margins_db.iter().map(move |&margin_db| (start, margin_db)));
        let mut race = Race::new(steps, &with_margins.collect::<Vec<_>>());
        for round in rounds {
            race.run(round);
        }
        let ended = race.into_drives();
        let scores = [self.points, self.ground].map(|problem| problem.scores(ended.view()));
        let mut drives: Vec<(Key, Drive)> = ended
            .columns()
            .into_iter()
            .zip(scores[0].iter().zip(&scores[1]))
            .map(|(drive, (&points, &ground))| {
                let drive = drive.to_owned();
                (self.compare(&drive, [points, ground]), drive)
            })
            .collect();
        drives.sort_by(|(a, _), (b, _)| better_first(a, b));
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
        let scores = [self.points, self.ground].map(|problem| problem.score(&drive));
        self.compare(&drive, scores)
    }

    /// The key of a drive with these scores, which is kept where it is the best.
    fn compare(&mut self, drive: &Drive, [points, ground]: [Score; 2]) -> Key {
        // conic programs that aim at such a κ end a rounding above or below it
        let up_to = |kappa: f64, enough: f64| kappa.min(enough * (1.0 - tolerances::SAME_KAPPA));
        let robust = [
            up_to(points.kappa, self.enough),
            up_to(ground.kappa, self.asked),
        ];
        let key = [
            points.min_ratio,
            points.success_ratio,
            robust[0],
            ground.min_ratio,
            ground.success_ratio,
            robust[1],
            -peak(drive),
        ];
        if self.best.as_ref().is_none_or(|(best, _)| key > *best) {
            self.best = Some((key, drive.clone()));
        }
        key
    }
}

/// Starts of the iteration: pressure matching, contrast control, tilted phases.
fn starts(least_squares: &LeastSquares) -> Result<Vec<Drive>> {
    let problem = least_squares.problem;
    let hot_m = &problem.rows.positions_m[..problem.rows.hot];
    let zone = Rectangle::around(hot_m).expect("a problem has a hot row");
    // from −½ to ½: no corner of the zone is the first
    let across = |value: f64, low: f64, high: f64| {
        (value - 0.5 * (low + high)) / (high - low).max(tolerances::POSITION_M)
    };
    let targets = Array2::from_shape_fn((hot_m.len(), 1 + TILTS.len()), |(k, column)| {
        let ([x, y], [half_waves_x, half_waves_y]) = (
            hot_m[k],
            column.checked_sub(1).map_or([0.0; 2], |tilt| TILTS[tilt]),
        );
        let phase = half_waves_x * across(x, zone.x_min, zone.x_max)
            + half_waves_y * across(y, zone.y_min, zone.y_max);
        Complex64::from_polar(1.0, PI * phase)
    });
    let mut starts: Vec<Drive> = least_squares
        .drives(targets.view())?
        .columns()
        .into_iter()
        .map(|column| problem.in_phase(column.to_owned()))
        .collect();
    starts.insert(1, contrast::direction(problem)?);
    Ok(starts)
}
