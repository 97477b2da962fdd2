//! The step of a time axis: even but for digits that were not printed, or refused.

use crate::limits::{
    LATE_SAMPLES, LATE_STEPS, STEP_TOLERANCE, TIME_DECIMALS, TIME_PIECES, WHOLE_DIGITS,
};
use chladni_frf::{Error, Result};

/// The step of times that are even but for printed digits; `to_s`: one unit of them.
///
/// # Errors
/// Times that are not evenly spaced.
pub(super) fn even_step(times: &[f64], to_s: f64) -> Result<f64> {
    let steps = times.len().saturating_sub(1);
    let (Some(first), Some(last), 1..) = (times.first(), times.last(), steps) else {
        return Ok(0.0);
    };
    let mean = (last - first) / steps as f64;
    // printed times round at the last of their digits
    let largest = first.abs().max(last.abs());
    let rounding = STEP_TOLERANCE.max(1e-5 * largest / mean.abs().max(f64::MIN_POSITIVE));
    let single = times.windows(2).map(|pair| (1, pair[1] - pair[0]));
    // steps that differ little from one to the next may add up
    let pieces = TIME_PIECES.min(steps);
    let of_pieces = (0..pieces).map(|n| {
        let (from, to) = (n * steps / pieces, (n + 1) * steps / pieces);
        (to - from, times[to] - times[from])
    });
    let evenly = check_steps(single, mean, |_| rounding.min(0.1), to_s);
    // rounding adds nothing up
    let (step, late_steps) = match evenly {
        Ok(()) => (mean, LATE_STEPS),
        Err(error) => (rounded_step(times).ok_or(error)?, 0.0),
    };
    check_steps(
        of_pieces,
        mean,
        |count| late_steps.max(LATE_SAMPLES / count as f64),
        to_s,
    )?;
    Ok(step)
}

/// The step of the even axis that all times are, but for decimals that were not printed; `None`
/// where there is none.
fn rounded_step(times: &[f64]) -> Option<f64> {
    let digit = last_digit(times)?;
    let count = times.len() as f64;
    let mean_time = times.iter().sum::<f64>() / count;
    let centre = (count - 1.0) / 2.0;
    let (mut product, mut square) = (0.0, 0.0);
    for (k, time) in times.iter().enumerate() {
        let place = k as f64 - centre;
        product += place * (time - mean_time);
        square += place * place;
    }
    let step = product / square;
    let is_near =
        |(k, time): (usize, &f64)| (time - mean_time - step * (k as f64 - centre)).abs() <= digit;
    times.iter().enumerate().all(is_near).then_some(step)
}

/// One unit of the last decimal that any of the times has; `None` where they have more decimals
/// than were printed.
fn last_digit(times: &[f64]) -> Option<f64> {
    let has_no_more = |scale: f64| {
        let is_whole = |time: &f64| {
            let digits = time * scale;
            (digits - digits.round()).abs() <= WHOLE_DIGITS * digits.abs().max(1.0)
        };
        times.iter().all(is_whole)
    };
    let scales = (0..=TIME_DECIMALS).map(|decimals| 10f64.powi(decimals));
    scales
        .into_iter()
        .find(|scale| has_no_more(*scale))
        .map(|scale| 1.0 / scale)
}

/// Refuses times that differ from even ones.
///
/// * `spans`: numbers of steps, and the time that they take
/// * `most`: relative difference up to which so many steps are even
fn check_steps(
    spans: impl Iterator<Item = (usize, f64)>,
    mean: f64,
    most: impl Fn(usize) -> f64,
    to_s: f64,
) -> Result<()> {
    let (mut least, mut largest, mut is_even) = (f64::INFINITY, f64::NEG_INFINITY, true);
    for (count, span) in spans {
        let step = span / count as f64;
        (least, largest) = (least.min(step), largest.max(step));
        is_even &= (step / mean - 1.0).abs() <= most(count);
    }
    if is_even {
        return Ok(());
    }
    Err(Error::bad_data("the samples are not evenly spaced in time")
        .field("time axis")
        .found(format!(
            "steps from {:.4e} to {:.4e} s",
            least * to_s,
            largest * to_s
        ))
        .expected("one step: one sampling rate")
        .help("resample the record first"))
}

#[cfg(test)]
mod tests {
    use super::super::{runs_of, ChannelOverride};
    use super::*;
    use chladni_frf::Run;

    fn read(time: &dyn Fn(usize) -> String) -> Result<Vec<Run>> {
        let rows = (0..20_000).map(|k| format!("{},{},0\n", time(k), k % 7));
        let text = format!("t,1:+Z_N,2:+Z_m/s\n{}", rows.collect::<String>());
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("take.csv");
        std::fs::write(&file, text).unwrap();
        let document = crate::read_documents(&[file], &crate::ReadOptions::default()).unwrap();
        runs_of(&document[0], &ChannelOverride::default())
    }

    #[test]
    fn times_whose_steps_change_on_the_way_are_refused_and_printed_digits_are_not() {
        let rounded = read(&|k| format!("{:.6}", k as f64 / 51_200.0)).unwrap();
        assert!((rounded[0].sample_rate_hz / 51_200.0 - 1.0).abs() < 1e-5);
        let error = read(&|k| format!("{:.6}", k as f64 * 1e-3 + 5e-5 * k.max(10_000) as f64));
        let told = error.unwrap_err().to_string();
        assert!(
            told.contains("not evenly spaced")
                && told.contains("steps from 1.0000e-3 to 1.0500e-3 s"),
            "{told}"
        );
        // times summed up in single precision, and those that end at the trigger
        let mut sum = 0.0_f32;
        let summed = std::iter::repeat_with(|| {
            sum += 1e-4;
            f64::from(sum)
        });
        let summed: Vec<f64> = summed.take(20_000).collect();
        assert!(read(&|k| format!("{:.7}", summed[k])).is_ok());
        assert!(read(&|k| format!("{:.6}", (k as f64 - 19_999.0) / 51_200.0)).is_ok());
        for slips in [0.028, 0.004] {
            let slipping = |k: usize| 1e-3 * (k as f64 + slips * k.max(10_000) as f64);
            assert!(read(&|k| slipping(k).to_string()).is_err(), "{slips}");
        }
        let falling = even_step(&[2.0, 1.0, 0.0], 1.0).unwrap();
        assert_eq!(falling, -1.0);
        assert!(even_step(&[0.0, f64::NAN, 2.0, 3.0], 1.0).is_err());
    }

    #[test]
    fn times_with_few_decimals_are_even_where_no_sample_is_missing() {
        // a fifth of a step is cut off, or rounded
        let time = |k: usize| k as f64 / 2048.0;
        let cut = |k: usize| (time(k) * 1e4).floor() / 1e4;
        for runs in [
            read(&|k| format!("{:.4}", time(k))),
            read(&|k| format!("{:.4}", cut(k))),
            read(&|k| format!("{:.1}", time(k) * 1e3)),
        ] {
            let rate = runs.unwrap()[0].sample_rate_hz;
            let rate = if rate < 10.0 { rate * 1e3 } else { rate };
            assert!((rate / 2048.0 - 1.0).abs() < 1e-7, "{rate}");
        }
        // a sample is lost on the way, or the clock changes
        let lost = |k: usize| time(k + usize::from(k > 9_000));
        assert!(read(&|k| format!("{:.4}", lost(k))).is_err());
        assert!(read(&|k| format!("{:.4}", time(k) + 5e-6 * k.max(10_000) as f64)).is_err());
        // half a step is no digit that was cut off
        let uneven = |k: usize| time(k) + 0.25 / 2048.0 * (k % 2) as f64;
        assert!(read(&|k| format!("{:.6}", uneven(k))).is_err());
        // whole milliseconds, of which one is left out
        assert!(read(&|k| format!("{:.3}", 1e-3 * (k + usize::from(k > 77)) as f64)).is_err());
    }
}
