//! Transform of a whole record, and the lines that belong to each line of the FRFs.

use crate::limits::{LARGEST_FACTOR, LEAST_STEP, LINE_ROUNDING};
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

/// Lines from one frequency to the next, at least, where a fit wants `wanted`.
pub(super) fn least_step(wanted: usize) -> usize {
    (LEAST_STEP * wanted as f64).ceil() as usize
}

/// Frequencies of the FRFs, k·step for k = 1, 2, ...: each takes the lines of a record's
/// transform that lie symmetrically about it. Where the step is less than what a fit wants,
/// neighbours share lines: while these are few, their values err nearly independently (theory.md,
/// eq. F4k).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// Distance of frequencies, Hz.
    pub step_hz: f64,
    /// Number of frequencies.
    pub count: usize,
    /// Lines of a transform that a fit wants.
    wanted: usize,
}

impl Grid {
    /// Frequencies `step_hz` apart, each with the lines that it takes of a transform of `samples`
    /// below half the sampling rate.
    ///
    /// # Errors
    ///
    /// [`chladni_frf::ErrorKind::BadData`] where the transform has too few lines per step.
    pub(super) fn new(
        step_hz: f64,
        wanted: usize,
        samples: usize,
        sample_rate_hz: f64,
    ) -> Result<Self> {
        let step = step_hz * samples as f64 / sample_rate_hz;
        let half_width = 0.5 * step.max(wanted as f64);
        let grid = Self {
            step_hz,
            count: ((0.5 * samples as f64 - half_width) / step + LINE_ROUNDING).max(0.0) as usize,
            wanted,
        };
        let least = least_step(wanted);
        if grid.count > 0 && step + LINE_ROUNDING >= least as f64 {
            return Ok(grid);
        }
        Err(Error::bad_data("too few lines for a local fit")
            .field("block")
            .found(format!(
                "{:.1} lines of the transform of {samples} samples per line of the FRFs",
                (10.0 * step + LINE_ROUNDING).floor() / 10.0
            ))
            .expected(format!("at least {least}"))
            .help("choose a shorter `block`, measure a longer record, or take `estimator h1`"))
    }

    /// The finest grid for a transform of `samples`.
    pub(super) fn finest(wanted: usize, samples: usize, sample_rate_hz: f64) -> Result<Self> {
        let step_hz = least_step(wanted) as f64 * sample_rate_hz / samples as f64;
        Self::new(step_hz, wanted, samples, sample_rate_hz)
    }

    /// Frequency k, Hz.
    pub(super) fn frequency_hz(&self, k: usize) -> f64 {
        (k + 1) as f64 * self.step_hz
    }

    /// Lines of a transform from one frequency to the next; `record_s`: its length.
    pub(super) fn step(&self, record_s: f64) -> f64 {
        self.step_hz * record_s
    }

    /// Lines of a transform that one frequency takes, an odd number; `record_s`: its length.
    pub(super) fn lines_per_value(&self, record_s: f64) -> usize {
        self.least_lines(self.step(record_s)) | 1
    }

    /// All lines within half a step, or those that a fit wants.
    fn least_lines(&self, step: f64) -> usize {
        ((step - LINE_ROUNDING).ceil() as usize).max(self.wanted)
    }

    /// Lines of the transform of `samples` that frequency `k` takes, and where they lie
    /// within half of them, −1 to 1.
    pub(super) fn lines(&self, k: usize, samples: usize, sample_rate_hz: f64) -> Lines {
        let step = self.step_hz * samples as f64 / sample_rate_hz;
        let centre = (k + 1) as f64 * step;
        // an odd number of lines about a line, an even one about the middle between two
        let middle_twice = (2.0 * centre).round() as usize;
        let least = self.least_lines(step);
        let even = least + usize::from((least + middle_twice).is_multiple_of(2));
        // line 0 and the last one are real: they do not belong to the sum of a local fit
        let count = even.min(middle_twice - 1).min(samples - 1 - middle_twice);
        let first = (middle_twice + 1 - count) / 2;
        Lines {
            range: first..first + count,
            centre,
            half_width: 0.5 * step.max(self.wanted as f64),
        }
    }
}

/// Lines of a transform that one frequency takes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lines {
    /// Their numbers.
    pub range: Range<usize>,
    /// Frequency in lines.
    centre: f64,
    /// Half of what they span, in lines.
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
    fn lines_lie_symmetrically_about_their_frequency() {
        for (step, samples) in [(13.0, 1000), (8.0, 997 * 2), (26.0, 7300), (8.6, 1500)] {
            let rate = 1000.0;
            let grid = Grid::new(step * rate / samples as f64, 13, samples, rate).unwrap();
            for k in 0..grid.count {
                let lines = grid.lines(k, samples, rate);
                let (first, last) = (lines.range.start, lines.range.end - 1);
                assert!(first > 0 && last < samples / 2, "{step} {k}");
                assert!(last + 1 - first >= 13, "{step} {k}");
                let middle = 0.5 * (first + last) as f64;
                assert!((middle - (k + 1) as f64 * step).abs() < 0.25 + 1e-6);
                assert!(lines.places().all(|place| place.abs() <= 1.1));
            }
        }
    }

    #[test]
    fn the_finest_grid_shares_lines_between_neighbours() {
        let grid = Grid::finest(13, 1300, 1000.0).unwrap();
        let mut taken = vec![0; 651];
        (0..grid.count)
            .flat_map(|k| grid.lines(k, 1300, 1000.0).range)
            .for_each(|line| taken[line] += 1);
        let within = &taken[16..8 * (grid.count - 1)];
        assert_eq!(within.iter().sum::<usize>() * 8, within.len() * 13);
        assert!(Grid::new(0.99 * grid.step_hz, 13, 1300, 1000.0).is_err());
        assert_eq!((grid.lines_per_value(1.3), least_step(17)), (13, 11));
        let coarse = Grid::new(20.0, 13, 1300, 1000.0).unwrap();
        assert_eq!(coarse.lines_per_value(1.3), 27);
        assert_eq!(coarse.lines(4, 1300, 1000.0).range.len(), 27);
    }

    #[test]
    fn all_lines_of_an_odd_block_have_a_value() {
        for (samples, block) in [(8192, 9), (8192, 11), (4096, 301), (1000, 7)] {
            let grid = Grid::new(1000.0 / block as f64, 13, samples, 1000.0).unwrap();
            assert_eq!(grid.count, (block - 1) / 2, "{samples} {block}");
        }
    }
}
