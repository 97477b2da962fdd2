//! The band to fit instead where modes explain little of the data.

use crate::sizes::{MOST_ABOVE, MOST_BELOW, MOST_OF_BAND};
use chladni_frf::{ModalModel, Mode, Trust};
use std::ops::RangeInclusive;

/// A band in which most modes are sure.
#[derive(Debug, PartialEq)]
pub struct BetterBand {
    /// Its ends, Hz.
    pub hz: [f64; 2],
    /// Sure modes in it.
    pub sure: usize,
}

/// The band of the run of modes with the most sure ones over weak ones; `None` where it would
/// leave out little of the band of `model`, or holds fewer than two sure modes.
pub fn better_band(model: &ModalModel) -> Option<BetterBand> {
    let modes: Vec<&Mode> = model.in_band_modes().collect();
    let is_sure: Vec<bool> = modes.iter().map(|mode| mode.trust == Trust::Sure).collect();
    let run = best_run(&is_sure)?;
    let hz = |k: usize| modes.get(k).map(|mode| mode.frequency_hz);
    let [low_hz, high_hz] = model.band_hz;
    let (first_hz, last_hz) = (hz(*run.start())?, hz(*run.end())?);
    let before_hz = run.start().checked_sub(1).and_then(hz).unwrap_or(low_hz);
    let after_hz = hz(run.end() + 1).unwrap_or(high_hz);
    let [low, high] = [
        between(before_hz, first_hz).max(MOST_BELOW * first_hz),
        between(last_hz, after_hz).min(MOST_ABOVE * last_hz),
    ];
    let low = round_down(low, before_hz).unwrap_or_else(|| round(low, before_hz, first_hz));
    let high = round(high, last_hz, after_hz);
    let sure = is_sure[run].iter().filter(|is_sure| **is_sure).count();
    let leaves_out = (high - low) < MOST_OF_BAND * (high_hz - low_hz);
    (leaves_out && sure > 1).then_some(BetterBand {
        hz: [low, high],
        sure,
    })
}

/// The run of modes with the largest number of sure modes minus that of weak ones.
fn best_run(is_sure: &[bool]) -> Option<RangeInclusive<usize>> {
    let mut best: Option<(i64, RangeInclusive<usize>)> = None;
    for first in (0..is_sure.len()).filter(|&k| is_sure[k]) {
        let mut score = 0;
        for last in first..is_sure.len() {
            score += if is_sure[last] { 1 } else { -1 };
            if best.as_ref().is_none_or(|(known, _)| score > *known) {
                best = Some((score, first..=last));
            }
        }
    }
    best.map(|(_, run)| run)
}

fn between(low: f64, high: f64) -> f64 {
    0.5 * (low + high)
}

/// The value rounded down to one digit; `None` where that is not above `low`.
fn round_down(value: f64, low: f64) -> Option<f64> {
    let unit = 10f64.powf(value.log10().floor());
    let round = (value / unit).floor() * unit;
    (low < round).then_some(round)
}

/// The value rounded to two digits, or unchanged where that is not between `low` and `high`.
fn round(value: f64, low: f64, high: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    let round = (value / unit).round() * unit;
    match low < round && round < high {
        true => round,
        false => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_run_with_most_sure_modes_is_taken() {
        let is_sure = [true, true, false, true, true, false, false, true];
        assert_eq!(best_run(&is_sure), Some(0..=4));
        assert_eq!(best_run(&[false]), None);
    }

    #[test]
    fn ends_are_round_numbers_between_modes() {
        assert_eq!(round_down(26.3, 0.1), Some(20.0));
        assert_eq!(round_down(921.0, 905.0), None);
        assert_eq!(round(1859.5, 1655.0, 2064.0), 1900.0);
        assert_eq!(round(21.04, 0.1, 52.6), 21.0);
        assert_eq!(round(100.15, 100.1, 100.2), 100.15);
    }
}
