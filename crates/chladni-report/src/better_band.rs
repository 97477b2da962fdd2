//! The band to fit instead where modes explain little of the data.

use crate::sizes::{MOST_ABOVE, MOST_BELOW, MOST_OF_BAND};
use chladni_frf::{ModalModel, Trust};

/// A band in which most modes are sure.
#[derive(Debug, PartialEq)]
pub struct BetterBand {
    /// Its ends, Hz.
    pub hz: [f64; 2],
    /// Sure modes in it.
    pub sure: usize,
}

/// The run of modes with the most sure ones over weak ones, where that leaves much of the
/// band out; `None` where there is none.
pub fn better_band(model: &ModalModel) -> Option<BetterBand> {
    let modes: Vec<(f64, bool)> = model
        .in_band_modes()
        .map(|mode| (mode.frequency_hz, mode.trust == Trust::Sure))
        .collect();
    let (first, last) = best_run(&modes)?;
    let [low_hz, high_hz] = model.band_hz;
    let before = first.checked_sub(1).map_or(low_hz, |k| modes[k].0);
    let after = modes.get(last + 1).map_or(high_hz, |mode| mode.0);
    let [low, high] = [
        between(before, modes[first].0).max(MOST_BELOW * modes[first].0),
        between(modes[last].0, after).min(MOST_ABOVE * modes[last].0),
    ];
    let low = round_down(low, before).unwrap_or_else(|| round(low, before, modes[first].0));
    let high = round(high, modes[last].0, after);
    let sure = modes[first..=last].iter().filter(|mode| mode.1).count();
    let leaves_out = (high - low) < MOST_OF_BAND * (high_hz - low_hz);
    (leaves_out && sure > 1).then_some(BetterBand {
        hz: [low, high],
        sure,
    })
}

/// First and last mode of the run with the largest count of sure modes less that of weak
/// ones.
fn best_run(modes: &[(f64, bool)]) -> Option<(usize, usize)> {
    let mut best: Option<(i64, usize, usize)> = None;
    for first in (0..modes.len()).filter(|&k| modes[k].1) {
        let mut score = 0;
        for last in first..modes.len() {
            score += if modes[last].1 { 1 } else { -1 };
            if best.is_none_or(|(known, ..)| score > known) {
                best = Some((score, first, last));
            }
        }
    }
    best.map(|(_, first, last)| (first, last))
}

fn between(low: f64, high: f64) -> f64 {
    0.5 * (low + high)
}

/// The value in one digit, rounded down, where that stays above `low`: there is no mode
/// between.
fn round_down(value: f64, low: f64) -> Option<f64> {
    let unit = 10f64.powf(value.log10().floor());
    let round = (value / unit).floor() * unit;
    (low < round).then_some(round)
}

/// The value in two digits where these stay between `low` and `high`.
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
        let modes: Vec<(f64, bool)> = [
            (52.6, true),
            (468.0, true),
            (921.0, false),
            (972.0, true),
            (1655.0, true),
            (2064.0, false),
            (2128.0, false),
            (4695.0, true),
        ]
        .to_vec();
        assert_eq!(best_run(&modes), Some((0, 4)));
        assert_eq!(best_run(&[(1.0, false)]), None);
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
