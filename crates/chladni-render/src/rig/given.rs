//! The drive to give: the new one, or the best that was measured.

use super::seen::Seen;
use crate::panel::drive::Drive;
use crate::problems::problem::{chance_above, Problem};
use crate::problems::setup::Setup;
use crate::tolerances;

/// The rule by which a measured response counts as inside its limit.
#[derive(Clone, Copy)]
pub(super) enum Count {
    /// As it was measured.
    Plain,
    /// By the chance that it is, given the noise of the field.
    Expected,
}

/// Smaller of hot and cold ratio of a field as measured; `None` where it holds too little.
pub(super) fn measured_ratio(setup: &Setup, seen: &Seen, count: Count) -> Option<f64> {
    let (rows, limits) = (&setup.problem.rows, &setup.limits);
    let mut shares = [[0.0; 2]; 2];
    for (number, row) in setup.judged.iter().enumerate() {
        let Some(place) = seen.rows.iter().position(|seen| seen == row) else {
            continue;
        };
        let level = rows.levels[number];
        let speed = seen.velocity[place].norm() / level;
        let (kind, inside, slack) = match rows.is_hot(number) {
            true => (0, limits.is_felt(speed), speed - limits.hot_m_per_s),
            false => (1, limits.is_quiet(speed), limits.cold_m_per_s - speed),
        };
        let noise = (seen.noise / level).max(f64::MIN_POSITIVE);
        shares[kind][0] += match count {
            Count::Plain => f64::from(u8::from(inside)),
            Count::Expected => chance_above(slack, noise),
        };
        shares[kind][1] += 1.0;
    }
    let ratio = |[inside, all]: [f64; 2]| (all > 0.0).then(|| inside / all);
    Some(ratio(shares[0])?.min(ratio(shares[1])?))
}

/// The drive to give.
pub(super) struct Given {
    pub(super) drive: Drive,
    /// The smaller of hot and cold ratio to be expected of it.
    pub(super) predicted: f64,
    /// The best measured field, from 0.
    pub(super) best_measured: Option<usize>,
    /// True where its drive is given again.
    pub(super) kept: bool,
}

/// The new drive, or the best measured one where that serves or no better is to be expected.
///
/// Before the third field a drive that serves is given again only where all that is known agrees:
/// given again, it teaches nothing. Later a measurement is worth more than any promise, and a drive
/// that may serve less follows only where the best one has been given again before.
///
/// * `fields`: number of all fields, those before a calibration included
/// * `was_kept`: true where the newest field is that of a drive given again
pub(super) fn best_of(
    corrected: &Setup,
    new: Drive,
    seen: &[Seen],
    (fields, was_kept): (usize, bool),
) -> Given {
    let whole = corrected.operator.responses.len();
    let allowed = |drive: &Drive| {
        corrected.problem.drive_limits.allowed_gain(drive) >= 1.0 - tolerances::AT_LIMIT
    };
    let measured_first = fields >= tolerances::MEASURED_FIRST_FIELDS;
    let as_measured = |k: usize| {
        let plain = measured_ratio(corrected, &seen[k], Count::Plain);
        measured_first && plain.is_some_and(|plain| plain >= tolerances::SERVES_AS_MEASURED)
    };
    let best = (0..seen.len())
        .filter(|&k| seen[k].rows.len() == whole && allowed(&seen[k].drive))
        .filter_map(|k| {
            let ratio = measured_ratio(corrected, &seen[k], Count::Expected)?;
            Some((as_measured(k), ratio, k))
        })
        .max_by(|a, b| {
            (a.0.cmp(&b.0))
                .then(a.1.total_cmp(&b.1))
                .then(a.2.cmp(&b.2))
        });
    let expected = corrected.problem.expected_ratio(&new);
    let serves = |ratio: f64, k: usize| {
        let told = corrected.problem.expected_ratio(&seen[k].drive);
        ratio >= tolerances::SERVES_AS_MEASURED && told >= tolerances::SERVES_AS_TOLD
    };
    let is_sure =
        |ratio: f64| chance_of_ratio(&corrected.problem, &new, ratio) >= tolerances::SURELY_NO_LESS;
    let goes_back = |ratio: f64| measured_first && !was_kept && !is_sure(ratio);
    let is_given_again = |measured: bool, ratio: f64, k: usize| {
        measured || ratio >= expected || serves(ratio, k) || goes_back(ratio)
    };
    match best {
        Some((measured, ratio, k)) if is_given_again(measured, ratio, k) => Given {
            drive: seen[k].drive.clone(),
            predicted: ratio,
            best_measured: Some(k),
            kept: true,
        },
        _ => Given {
            drive: new,
            predicted: expected,
            best_measured: best.map(|(_, _, k)| k),
            kept: false,
        },
    }
}

/// The chance that `drive` serves `ratio` of the hot and of the cold rows, or more: rows are taken
/// for independent.
fn chance_of_ratio(problem: &Problem, drive: &Drive, ratio: f64) -> f64 {
    let of_kind = |chances: Vec<f64>| {
        let least = (ratio * chances.len() as f64 - tolerances::AT_LIMIT).ceil();
        // chances of each number of rows that are served
        let mut counts = vec![1.0];
        for chance in chances {
            counts.push(0.0);
            for served in (0..counts.len()).rev() {
                let from_fewer = served.checked_sub(1).map_or(0.0, |fewer| counts[fewer]);
                counts[served] = counts[served] * (1.0 - chance) + from_fewer * chance;
            }
        }
        counts.iter().skip(least.max(0.0) as usize).sum::<f64>()
    };
    problem.chances(drive).map(of_kind).iter().product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_model::test_problem;
    use ndarray::{Array1, Array2};
    use num_complex::Complex64;

    /// Three hot rows at their limit and two cold ones far below theirs: each hot row is served
    /// with a chance of a half.
    #[test]
    fn the_chance_of_a_share_is_that_of_coins() {
        let unit = Complex64::ONE;
        let mobility =
            Array2::from_shape_fn((5, 1), |(k, _)| if k < 3 { unit } else { 0.0 * unit });
        let problem = test_problem((mobility, Array1::ones(5)), 3, 0.01, 3.0);
        let drive = Drive::from_elem(1, unit);
        for (ratio, chance) in [
            (0.0, 1.0),
            (0.3, 0.875),
            (1.0 / 3.0, 0.875),
            (0.5, 0.5),
            (1.0, 0.125),
        ] {
            let told = chance_of_ratio(&problem, &drive, ratio);
            assert!((told - chance).abs() < 1e-9, "{ratio}: {told}");
        }
    }
}
