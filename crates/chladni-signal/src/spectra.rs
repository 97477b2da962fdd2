//! Averaged products of the transforms of windowed blocks (Welch).

use super::excitation::acting_part;
use super::setting::BlockSetting;
use super::still::moving;
use super::takes::Takes;
use super::window::{independent_blocks, level, window_values};
use crate::limits::BURST_MOST;
use chladni_frf::{Dof, Run};
use chladni_linalg::fft::{self, Fft};
use ndarray::{s, Array3};
use num_complex::Complex64;
use std::sync::Arc;

/// Averages for one response: the matrix of the products z·z^H of z = (references,
/// response), summed over blocks.
pub(super) struct Averages {
    /// Axes (line, row, column); the response is the last row and column.
    pub products: Array3<Complex64>,
    /// Blocks summed.
    pub blocks: usize,
    /// Independent blocks that these are worth.
    pub independent: f64,
    /// The blocks one by one, where they do not overlap.
    pub takes: Takes,
}

impl Averages {
    /// Lines from the first above 0 Hz to the last below half the sampling rate.
    pub(super) fn lines(&self) -> usize {
        self.products.dim().0
    }

    /// Averages over all runs in which `response` moves.
    pub(super) fn of(
        runs: &[&Run],
        references: &[Dof],
        response: Dof,
        setting: &BlockSetting,
    ) -> Self {
        let (window, block, hop) = (setting.window, setting.block, setting.hop());
        let fft = fft::forward(block);
        let lines = block.div_ceil(2) - 1;
        let size = references.len() + 1;
        let mut averages = Self {
            products: Array3::zeros((lines, size, size)),
            blocks: 0,
            independent: 0.0,
            takes: Takes::default(),
        };
        for (at, run) in runs.iter().enumerate() {
            let Some(answer) = moving(run).find(|channel| channel.dof == response) else {
                continue;
            };
            let drives = references
                .iter()
                .filter_map(|dof| run.references().find(|channel| channel.dof == *dof));
            let channels: Vec<&[f64]> = drives
                .chain([answer])
                .map(|channel| channel.samples.as_slice())
                .collect();
            if channels.len() != size {
                continue;
            }
            let values = window_values(window, block, run.sample_rate_hz);
            let mut start = 0;
            let mut count = 0;
            while start + block <= run.samples() {
                let spectra = averages.add(&channels, start, &values, &fft, |block| {
                    level(window, block)
                });
                if hop >= block {
                    let is_start = count == 0 && goes_on(&channels[..size - 1], block);
                    averages.takes.keep([at, count], is_start, &spectra);
                }
                start += hop;
                count += 1;
            }
            averages.blocks += count;
            averages.independent += independent_blocks(&values, hop, count);
        }
        averages
    }

    /// Adds one block; returns its transforms.
    fn add(
        &mut self,
        channels: &[&[f64]],
        start: usize,
        window: &[f64],
        fft: &Arc<dyn Fft<f64>>,
        level: impl Fn(&[f64]) -> f64,
    ) -> Vec<Vec<Complex64>> {
        let block = window.len();
        let spectra: Vec<Vec<Complex64>> = channels
            .iter()
            .map(|samples| {
                let samples = &samples[start..start + block];
                let level = level(samples);
                let mut buffer: Vec<Complex64> = samples
                    .iter()
                    .zip(window)
                    .map(|(x, w)| Complex64::from((x - level) * w))
                    .collect();
                fft.process(&mut buffer);
                buffer
            })
            .collect();
        for k in 0..self.lines() {
            let mut products = self.products.slice_mut(s![k, .., ..]);
            for (row, a) in spectra.iter().enumerate() {
                for (column, b) in spectra.iter().enumerate() {
                    products[[row, column]] += a[k + 1] * b[k + 1].conj();
                }
            }
        }
        spectra
    }
}

/// True where a force acts until the first block ends, or leaves no time to die out, and another block
/// follows.
fn goes_on(references: &[&[f64]], block: usize) -> bool {
    let acts = |samples: &&[f64]| {
        samples.len() >= 2 * block && acting_part(&samples[..block], block) > BURST_MOST
    };
    references.iter().any(acts)
}
