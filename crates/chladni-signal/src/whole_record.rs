//! Transform of a whole record, and the lines that belong to each line of the FRFs.

use crate::limits::{LARGEST_FACTOR, LINE_ROUNDING};
use chladni_frf::{Error, Result};
use chladni_linalg::fft;
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

/// The largest even length up to `samples` with small prime factors; a record loses less
/// than a hundredth by it.
pub(super) fn smooth_length(samples: usize) -> usize {
    let is_smooth = |mut length: usize| {
        for factor in 2..=LARGEST_FACTOR {
            while length.is_multiple_of(factor) {
                length /= factor;
            }
        }
        length == 1
    };
    (1..=samples / 2)
        .rev()
        .find(|&half| is_smooth(half))
        .map_or(0, |half| 2 * half)
}

/// Lines 0 to N/2 of the transform of the first N `samples`, N even: two samples make one
/// complex value, so that the transform is half as long.
pub(super) fn spectrum(samples: &[f64]) -> Vec<Complex64> {
    let half = samples.len() / 2;
    let mut folded: Vec<Complex64> = samples
        .chunks_exact(2)
        .map(|pair| Complex64::new(pair[0], pair[1]))
        .collect();
    fft::forward(half).process(&mut folded);
    folded.push(folded[0]);
    for k in 0..=half / 2 {
        let (a, b) = (folded[k], folded[half - k].conj());
        let (even, odd) = (0.5 * (a + b), 0.5 * (a - b));
        // e^{−2πjk/N}/j
        let turn = Complex64::from_polar(1.0, -TAU * k as f64 / samples.len() as f64)
            * Complex64::new(0.0, -1.0);
        folded[k] = even + turn * odd;
        folded[half - k] = (even - turn * odd).conj();
    }
    folded
}

/// Frequencies of the FRFs, k·step for k = 1, 2, ...: each takes the lines of a record's
/// transform that lie nearer to it than to its neighbours, so that no line serves twice
/// and errors of neighbours are nearly independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// Distance of frequencies, Hz.
    pub step_hz: f64,
    /// Number of frequencies.
    pub count: usize,
}

impl Grid {
    /// Frequencies `step_hz` apart whose lines all lie above 0 Hz and below half the
    /// sampling rate.
    pub(super) fn new(step_hz: f64, sample_rate_hz: f64) -> Self {
        let count = (0.5 * sample_rate_hz / step_hz - 0.5).floor().max(0.0) as usize;
        Self { step_hz, count }
    }

    /// The finest grid that leaves `lines` of the transform of `samples` to each frequency.
    pub(super) fn finest(lines: usize, samples: usize, sample_rate_hz: f64) -> Self {
        Self::new(
            lines as f64 * sample_rate_hz / samples as f64,
            sample_rate_hz,
        )
    }

    /// Frequency k, Hz.
    pub(super) fn frequency_hz(&self, k: usize) -> f64 {
        (k + 1) as f64 * self.step_hz
    }

    /// Lines of the transform of `samples` that frequency `k` takes, and where they lie
    /// within half a step, −1 to 1.
    pub(super) fn lines(&self, k: usize, samples: usize, sample_rate_hz: f64) -> Lines {
        let step = self.step_hz * samples as f64 / sample_rate_hz;
        let centre = (k + 1) as f64 * step;
        let edge = |at: f64| (at - LINE_ROUNDING).ceil() as usize;
        let range = edge(centre - 0.5 * step)..edge(centre + 0.5 * step).min(samples / 2);
        Lines {
            range,
            centre,
            half_width: 0.5 * step,
        }
    }

    /// Refuses a grid that leaves fewer than `least` lines to a frequency.
    pub(super) fn check(&self, least: usize, samples: usize, sample_rate_hz: f64) -> Result<()> {
        let lines =
            (self.step_hz * samples as f64 / sample_rate_hz + LINE_ROUNDING).floor() as usize;
        if self.count > 0 && lines >= least {
            return Ok(());
        }
        Err(Error::bad_data("too few lines for a local fit")
            .field("block")
            .found(format!(
                "{lines} lines of the transform of {samples} samples per line of the FRFs"
            ))
            .expected(format!("at least {least}"))
            .help("choose a shorter `block`, measure a longer record, or take `estimator h1`"))
    }
}

/// Lines of a transform that one frequency takes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lines {
    /// Their numbers.
    pub range: Range<usize>,
    /// Frequency in lines.
    centre: f64,
    /// Half a step of the grid in lines.
    half_width: f64,
}

impl Lines {
    /// Place of each line, −1 to 1.
    pub(super) fn places(&self) -> impl Iterator<Item = f64> + '_ {
        self.range
            .clone()
            .map(|line| (line as f64 - self.centre) / self.half_width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_folded_transform_is_the_transform() {
        for count in [2, 4, 6, 30, 126] {
            let samples: Vec<f64> = (0..count)
                .map(|k| (k as f64 * 1.7).sin() + 0.1 * k as f64)
                .collect();
            for (line, value) in spectrum(&samples).iter().enumerate() {
                let sum: Complex64 = samples
                    .iter()
                    .enumerate()
                    .map(|(k, x)| {
                        x * Complex64::from_polar(1.0, -TAU * (k * line) as f64 / count as f64)
                    })
                    .sum();
                assert!(
                    (sum - value).norm() < 1e-10,
                    "{count} {line}: {sum} {value}"
                );
            }
        }
    }

    #[test]
    fn lengths_are_even_and_have_small_factors() {
        assert_eq!(smooth_length(15_360_000), 15_360_000);
        assert_eq!(smooth_length(1021), 1008);
        assert_eq!((smooth_length(1), smooth_length(3)), (0, 2));
    }

    #[test]
    fn every_line_serves_one_frequency() {
        for (step_hz, samples) in [(1.3, 1000), (2.0, 997 * 2), (13.0 / 7.3, 7300)] {
            let grid = Grid::new(step_hz, 1000.0);
            let all: Vec<usize> = (0..grid.count)
                .flat_map(|k| grid.lines(k, samples, 1000.0).range)
                .collect();
            assert!(all.windows(2).all(|pair| pair[1] == pair[0] + 1));
            assert!(all[0] > 0 && all[all.len() - 1] < samples / 2);
            let places: Vec<f64> = grid.lines(3, samples, 1000.0).places().collect();
            assert!(places.iter().all(|place| place.abs() <= 1.0 + 1e-6));
        }
    }
}
