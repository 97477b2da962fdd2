//! The gain of a drive, and its force limit.
//!
//! The gain is found on predicted counts, the smaller of hot and cold first. Found from the
//! target, it would be set by the error of the fit; found from the sum of both counts,
//! silence would often win.

use crate::methods::solution::Solution;
use crate::panel::drive::{amplitude, Drive};
use crate::problems::problem::Problem;
use crate::tolerances;
use chladni_frf::{Finding, Result};
use ndarray::{Array1, Axis};

impl Problem {
    /// Scales a drive by the gain that serves the largest share of the worse zone, and among such
    /// gains most rows; its limits bound the gain.
    ///
    /// Counts change only at the gains where one row meets its limit, so one gain between
    /// each two of them is tried; among the rows that are then inside, the least hot and
    /// the loudest cold one get the same slack.
    pub(crate) fn with_best_gain(&self, drive: &Drive) -> Drive {
        let gain = self.best_gain(&self.field(drive).map(amplitude), drive);
        drive.mapv(|weight| weight * gain)
    }

    /// That gain, of a drive whose field has these amplitudes.
    pub(crate) fn best_gain(&self, amplitudes: &Array1<f64>, drive: &Drive) -> f64 {
        if drive.iter().all(|weight| weight.norm_sqr() == 0.0) {
            return 1.0;
        }
        let allowed = self.drive_limits.allowed_gain(drive);
        let rank = |(hot, cold): (usize, usize)| (self.min_ratio(hot, cold), hot + cold);
        // an unlimited drive may take any of the other gains
        let start = if allowed.is_finite() { allowed } else { 1.0 };
        let mut best = (start, rank(self.counts(amplitudes, start)));
        for (gain, counts) in self
            .tried_gains(amplitudes)
            .into_iter()
            .filter(|tried| tried.0 < allowed)
        {
            if rank(counts) > best.1 {
                best = (gain, rank(counts));
            }
        }
        let balanced = self.balanced_gain(amplitudes, best.0).min(allowed);
        match rank(self.counts(amplitudes, balanced)) >= best.1 {
            true => balanced,
            false => best.0,
        }
    }

    /// Every pair of counts that some gain leads to, hot and cold, with such a gain;
    /// rising. While no hot row is felt, the loudest gain is the best: hot ground gets as
    /// much as cold ground allows.
    fn tried_gains(&self, amplitudes: &Array1<f64>) -> Vec<(f64, (usize, usize))> {
        let mut meets: Vec<(f64, bool)> = (0..amplitudes.len())
            .map(|k| (self.limit_m_per_s(k) / amplitudes[k], self.rows.is_hot(k)))
            .collect();
        meets.retain(|meet| meet.0.is_finite());
        meets.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let (mut felt, mut quiet) = (0, self.rows.cold());
        let mut tried = Vec::from_iter(meets.first().map(|first| (first.0, (felt, quiet))));
        for (k, &(gain, hot)) in meets.iter().enumerate() {
            if hot {
                felt += 1;
            } else {
                quiet -= 1;
            }
            let next = meets.get(k + 1);
            let next = next.map_or(tolerances::BEYOND_LAST_GAIN * gain, |next| next.0);
            if next > gain {
                tried.push(((gain * next).sqrt(), (felt, quiet)));
            }
        }
        tried
    }

    /// The gain at which the least hot and the loudest cold row, of those inside at
    /// `gain`, have the same κ.
    fn balanced_gain(&self, amplitudes: &Array1<f64>, gain: f64) -> f64 {
        let (hot, cold) = amplitudes.view().split_at(Axis(0), self.rows.hot);
        let least = hot
            .iter()
            .copied()
            .filter(|v| self.limits.is_felt(gain * v))
            .fold(f64::INFINITY, f64::min);
        let loudest = cold
            .iter()
            .copied()
            .filter(|v| self.limits.is_quiet(gain * v))
            .fold(0.0, f64::max);
        let balanced = (self.limits.hot_m_per_s + self.limits.cold_m_per_s) / (least + loudest);
        if least.is_finite() && balanced.is_finite() {
            balanced
        } else {
            gain
        }
    }
}

/// Solves with a rising ridge until the force limit no longer costs any response its
/// limit, and takes the best of all.
///
/// * `solve`: the drive for a ridge relative to the mean diagonal of the normal matrix
pub(crate) fn within_drive_limit(
    problem: &Problem,
    solve: impl Fn(f64) -> Result<Drive>,
) -> Result<Solution> {
    let mut drive = solve(0.0)?;
    let mut solution = Solution::of_drive(drive.clone());
    let mut score = problem.score(&drive);
    let at_limit =
        |drive: &Drive| problem.drive_limits.allowed_gain(drive) <= 1.0 + tolerances::AT_LIMIT;
    if score.min_ratio == 1.0 || !at_limit(&drive) {
        return Ok(solution);
    }
    let mut ridge_used = 0.0;
    for ridge in tolerances::FORCE_RIDGES {
        drive = solve(ridge)?;
        let other = problem.score(&drive);
        let key = |score: &crate::problems::problem::Score| {
            [score.min_ratio, score.success_ratio, score.kappa]
        };
        if key(&other) > key(&score) {
            (score, ridge_used, solution.drive) = (other, ridge, drive.clone());
        }
        if other.min_ratio == 1.0 || !at_limit(&drive) {
            break;
        }
    }
    let words = format!(
        "{} binds: the drive was regularised more strongly (ridge {ridge_used:.0e}), and {:.1} % \
         of the responses keep their limit",
        problem.drive_limits.binding(&solution.drive),
        100.0 * score.success_ratio
    );
    solution.findings.push(
        Finding::caution("limit-binds", words).help("raise the limit, or use more actuators"),
    );
    Ok(solution)
}

#[cfg(test)]
mod tests {
    use crate::test_model::test_problem;
    use ndarray::{array, Array1, Array2};
    use num_complex::Complex64;

    #[test]
    fn a_drive_that_reaches_no_hot_row_is_as_loud_as_the_cold_rows_allow() {
        // a hot row, felt from gain 10 on, and a cold one, quiet up to 0.8
        let mobility: Array2<Complex64> = array![[0.1.into()], [1.0.into()]];
        let drive = Array1::from_elem(1, Complex64::ONE);
        // of the limits one lies on either side of what the cold row allows
        for (each, expected) in [(0.5, 0.5), (0.8, 0.8), (0.9, 0.8), (5.0, 0.8)] {
            let problem = test_problem((mobility.clone(), Array1::ones(2)), 1, 0.0, each);
            let found = problem.with_best_gain(&drive)[0].norm();
            assert!((found - expected).abs() < 1e-12, "{each}: {found}");
        }
    }
}
