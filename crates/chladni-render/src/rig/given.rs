//! The drive to give: the new one, or the best that was measured.

use super::seen::Seen;
use crate::problem::{chance_above, Drive};
use crate::setup::Setup;
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
        let (kind, inside, slack) = match number < rows.hot {
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
/// given again, it teaches nothing. Later a measurement is worth more than any promise.
///
/// * `fields`: number of all fields, those before a calibration included
pub(super) fn best_of(corrected: &Setup, new: Drive, seen: &[Seen], fields: usize) -> Given {
    let whole = corrected.operator.responses.len();
    let allowed = |drive: &Drive| {
        corrected.problem.drive_limits.allowed_gain(drive) >= 1.0 - tolerances::AT_LIMIT
    };
    let as_measured = |k: usize| {
        let plain = measured_ratio(corrected, &seen[k], Count::Plain);
        let counts = fields >= tolerances::MEASURED_FIRST_FIELDS;
        counts && plain.is_some_and(|plain| plain >= tolerances::SERVES_AS_MEASURED)
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
    match best {
        Some((measured, ratio, k)) if measured || ratio >= expected || serves(ratio, k) => Given {
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
