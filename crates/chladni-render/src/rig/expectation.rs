//! From a drive to one that is expected to serve more.
//!
//! The robust program wants every row inside its limit by the same κ. Where the error bars
//! leave no κ for that, its drive is sure of no row. More is to be expected of one that gives
//! up a few: it climbs the smaller of the hot and the cold mean of
//!
//! P_k = ½ erfc(−s_k/‖L·A‖), s_k the slack of row k under the drive A
//!
//! along its gradient, in the metric of the least squares of the rows (theory.md, section 12).
//! The corner between both is rounded by 0.035 at most; ends are compared without that.

use crate::panel::drive::{amplitude, Drive};
use crate::problems::problem::{chance_above, Problem};
use crate::solving::least_squares::LeastSquares;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array2;
use num_complex::Complex64;

/// Of the drives that gradient steps from `starts` lead to, within the limits of the drive,
/// the one of which most is expected; `None` where no step rises.
///
/// # Errors
/// Those of the factorisation: a broken promise.
pub(super) fn most_expected(problem: &Problem, starts: &[Drive]) -> Result<Option<Drive>> {
    let metric = LeastSquares::new(problem, 0.0)?.inverse()?;
    let ends = starts.iter().filter_map(|start| {
        let start = within_limits(problem, start.clone());
        let end = climb(problem, &metric, &start);
        let [before, after] = [&start, &end].map(|drive| problem.expected_ratio(drive));
        (after > before).then_some((after, end))
    });
    let most = ends.max_by(|a, b| a.0.total_cmp(&b.0));
    Ok(most.map(|(_, end)| end))
}

fn climb(problem: &Problem, metric: &Array2<Complex64>, start: &Drive) -> Drive {
    let mut drive = start.clone();
    let (mut value, mut gradient) = expectation(problem, &drive);
    let mut length = 1.0;
    'steps: for _ in 0..tolerances::EXPECTATION_STEPS {
        let direction = metric.dot(&gradient);
        let unit = size(&drive) / size(&direction).max(f64::MIN_POSITIVE);
        for _ in 0..tolerances::EXPECTATION_TRIES {
            let step = direction.mapv(|value| value * (unit * length));
            let next = within_limits(problem, &drive + &step);
            let (higher, slope) = expectation(problem, &next);
            if higher > value {
                (drive, value, gradient) = (next, higher, slope);
                length *= tolerances::EXPECTATION_LONGER;
                continue 'steps;
            }
            length *= tolerances::EXPECTATION_SHORTER;
        }
        break;
    }
    drive
}

fn within_limits(problem: &Problem, drive: Drive) -> Drive {
    let gain = problem.drive_limits.allowed_gain(&drive).min(1.0);
    drive.mapv(|weight| weight * gain)
}

/// The smaller of both means, its corner rounded, and its gradient.
fn expectation(problem: &Problem, drive: &Drive) -> (f64, Drive) {
    let field = problem.field(drive);
    let spread = problem.covariance.deviation(drive).max(f64::MIN_POSITIVE);
    let count = [problem.rows.hot, problem.rows.cold()].map(|rows| rows as f64);
    let kind_of = |row: usize| usize::from(!problem.rows.is_hot(row));
    // mean chances, their slopes over ‖L·A‖, and over each value of the field
    let (mut means, mut over_spread, mut pulls) = ([0.0; 2], [0.0; 2], field.clone());
    for (row, value) in field.iter().enumerate() {
        let kind = kind_of(row);
        let speed = amplitude(value).max(f64::MIN_POSITIVE);
        let bars = problem.slack(row, speed) / spread;
        means[kind] += chance_above(bars, 1.0) / count[kind];
        let density = (-bars * bars).exp() / (std::f64::consts::PI.sqrt() * spread * count[kind]);
        pulls[row] = value / speed * (density * problem.slack_per_speed(row));
        over_spread[kind] -= density * bars;
    }
    let least = f64::min(means[0], means[1]);
    let apart = means.map(|mean| (-tolerances::EXPECTATION_CORNER * (mean - least)).exp());
    let sum = apart[0] + apart[1];
    let share = apart.map(|part| part / sum);
    for (row, pull) in pulls.iter_mut().enumerate() {
        *pull *= share[kind_of(row)];
    }
    let back = problem.rows.mobility.t().mapv(|value| value.conj());
    let along = (share[0] * over_spread[0] + share[1] * over_spread[1]) / spread;
    let gradient = back.dot(&pulls)
        + problem
            .covariance
            .gram()
            .dot(drive)
            .mapv(|value| value * along);
    (
        least - (0.5 * sum).ln() / tolerances::EXPECTATION_CORNER,
        gradient,
    )
}

fn size(drive: &Drive) -> f64 {
    drive.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_model::test_problem;
    use ndarray::Array1;
    use proptest::prelude::*;

    const ACTUATORS: usize = 4;
    const ROWS: usize = 12;

    fn complex(count: usize) -> impl Strategy<Value = Vec<Complex64>> {
        let parts = proptest::collection::vec((-1.0..1.0f64, -1.0..1.0f64), count);
        parts.prop_map(|parts| {
            parts
                .iter()
                .map(|&(re, im)| Complex64::new(re, im))
                .collect()
        })
    }

    /// More rows than four actuators can serve, a third of them hot.
    fn problem(mobility: Vec<Complex64>, error: f64) -> Problem {
        let mobility = Array2::from_shape_vec((ROWS, ACTUATORS), mobility).unwrap();
        let levels = Array1::from_shape_fn(ROWS, |row| if row == 0 { 1.5 } else { 1.0 });
        test_problem((mobility, levels), ROWS / 3, error, 3.0)
    }

    proptest! {
        #[test]
        fn the_gradient_is_that_of_the_value(
            mobility in complex(ROWS * ACTUATORS),
            drive in complex(ACTUATORS),
            along in complex(ACTUATORS),
        ) {
            let problem = problem(mobility, 0.3);
            let (drive, along) = (Drive::from(drive), Drive::from(along));
            let step = 1e-5;
            let at = |sign: f64| {
                let moved = &drive + &along.mapv(|value| value * (sign * step));
                expectation(&problem, &moved).0
            };
            let gradient = expectation(&problem, &drive).1;
            let foretold: Complex64 = gradient.iter().zip(&along).map(|(g, a)| g.conj() * a).sum();
            let found = (at(1.0) - at(-1.0)) / (2.0 * step);
            prop_assert!((foretold.re - found).abs() < 1e-5 * (1.0 + found.abs()), "{foretold} {found}");
        }

        #[test]
        fn more_is_expected_than_before_and_the_limits_are_kept(
            mobility in complex(ROWS * ACTUATORS),
            drive in complex(ACTUATORS),
        ) {
            let problem = problem(mobility, 0.1);
            let drive = Drive::from(drive);
            // one within the limits, one far beyond
            for start in [drive.clone(), drive.mapv(|weight| weight * 100.0)] {
                let allowed = within_limits(&problem, start.clone());
                let Some(risen) = most_expected(&problem, &[start]).unwrap() else {
                    continue;
                };
                let [before, after] =
                    [&allowed, &risen].map(|drive| problem.expected_ratio(drive));
                prop_assert!(after > before, "{before} {after}");
                prop_assert!(risen.iter().all(|weight| weight.norm() <= 3.0 * (1.0 + 1e-12)));
            }
        }
    }

    #[test]
    fn rows_that_cannot_all_be_served_are_given_up_for_the_others() {
        // the second cold row moves as the hot ones do, the others not at all
        let mut mobility = vec![Complex64::ZERO; ROWS * ACTUATORS];
        for row in [0, 1, 2, 3, 5] {
            mobility[row * ACTUATORS] = Complex64::ONE;
        }
        let problem = problem(mobility, 0.1);
        let still = Drive::from_elem(ACTUATORS, Complex64::from(0.9));
        let risen = most_expected(&problem, std::slice::from_ref(&still))
            .unwrap()
            .unwrap();
        let [before, after] = [&still, &risen].map(|drive| problem.expected_ratio(drive));
        assert!(
            before < 0.4 && (after - 7.0 / 8.0).abs() < 0.02,
            "{before} {after}"
        );
    }
}
