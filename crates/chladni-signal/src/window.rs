//! Windows of blocks.

use crate::limits::{OFFSET_LEAST, QUARTERS_AGREE};
use chladni_frf::BlockWindow;
use std::f64::consts::PI;

/// Values of a window on a block of `count` samples (periodic form).
pub(super) fn window_values(window: BlockWindow, count: usize, sample_rate_hz: f64) -> Vec<f64> {
    let at = |k: usize| match window {
        BlockWindow::Rectangular => 1.0,
        BlockWindow::Hann => (PI * k as f64 / count as f64).sin().powi(2),
        BlockWindow::Exponential { rate_per_s } => (-rate_per_s * k as f64 / sample_rate_hz).exp(),
    };
    (0..count).map(at).collect()
}

/// Number of independent blocks that `count` overlapping ones are worth: P. Welch (1967),
/// eq. 5, with ρ the correlation of windows that lie `hop` samples apart: n/(1 + 2 Σ (1 −
/// k/n) ρ_k²).
pub(super) fn independent_blocks(window: &[f64], hop: usize, count: usize) -> f64 {
    let power: f64 = window.iter().map(|w| w * w).sum();
    let correlation = |shift: usize| -> f64 {
        let shared: f64 = window
            .iter()
            .zip(window.get(shift..).unwrap_or_default())
            .map(|(a, b)| a * b)
            .sum();
        (shared / power).powi(2)
    };
    let sum: f64 = (1..count)
        .take_while(|k| k * hop < window.len())
        .map(|k| (1.0 - k as f64 / count as f64) * correlation(k * hop))
        .sum();
    count as f64 / (1.0 + 2.0 * sum)
}

/// Level to take off the samples of a block, as a window spreads it over the lines beside 0 Hz:
/// under a Hann window the mean, of what dies out the offset of the sensor. 0 without a window.
pub(super) fn level(window: BlockWindow, samples: &[f64]) -> f64 {
    match window {
        BlockWindow::Rectangular => 0.0,
        BlockWindow::Hann => samples.iter().sum::<f64>() / samples.len() as f64,
        BlockWindow::Exponential { .. } => settled_mean(samples),
    }
}

/// Offset of a sensor whose signal dies out: the mean of the last half. 0 where its two quarters
/// do not agree on one, and where it is small, so that the rest of an oscillation is not taken for an offset.
fn settled_mean(samples: &[f64]) -> f64 {
    let quarter = samples.len() / 4;
    let taper = window_values(BlockWindow::Hann, quarter, 1.0);
    let mean = |samples: &[f64]| {
        let sum: f64 = samples.iter().zip(&taper).map(|(x, w)| x * w).sum();
        sum / taper.iter().sum::<f64>()
    };
    let third = mean(&samples[samples.len() - 2 * quarter..][..quarter]);
    let last = mean(&samples[samples.len() - quarter..]);
    let offset = 0.5 * (third + last);
    let largest = samples
        .iter()
        .fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let is_seen = offset.abs() > OFFSET_LEAST * largest;
    match is_seen && (third - last).abs() < QUARTERS_AGREE * offset.abs() {
        true => offset,
        false => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_overlapped_hann_blocks_are_worth_their_known_part() {
        let window = window_values(BlockWindow::Hann, 1024, 1.0);
        // ρ = 1/6 at one half
        let expected = 100.0 / (1.0 + 2.0 * 0.99 / 36.0);
        assert!((independent_blocks(&window, 512, 100) - expected).abs() < 1e-6);
        assert_eq!(independent_blocks(&window, 1024, 7), 7.0);
    }
}
