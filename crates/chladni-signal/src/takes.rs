//! Spectra of single blocks of one response, on the lines on which it is strongest: what is
//! compared where blocks should tell the same FRF.

use crate::limits::{TAKES_LINES, TAKES_MOST};
use num_complex::Complex64;

/// Blocks of one response under one reference.
#[derive(Debug, Default)]
pub(super) struct Takes {
    /// Samples of a block.
    pub samples: usize,
    /// Lines kept, ascending.
    pub lines: Vec<usize>,
    pub takes: Vec<Take>,
}

/// One block.
#[derive(Debug)]
pub(super) struct Take {
    /// Its run among those of the group, and its place in that run.
    pub of: [usize; 2],
    /// The structure starts from rest, under a force that goes on: the block after it does not.
    pub is_start: bool,
    /// Reference and response on each line kept.
    pub pairs: Vec<[Complex64; 2]>,
}

impl Takes {
    /// Keeps a block of one reference: the first blocks alone, where there are very many. Under
    /// several references no single block tells an FRF.
    pub(super) fn keep(&mut self, of: [usize; 2], is_start: bool, spectra: &[Vec<Complex64>]) {
        let [reference, response] = spectra else {
            return;
        };
        if self.takes.len() == TAKES_MOST {
            return;
        }
        if self.lines.is_empty() {
            self.samples = response.len();
            self.lines = strongest(response);
        }
        let pairs = self.lines.iter().map(|&k| [reference[k], response[k]]);
        let pairs = pairs.collect();
        self.takes.push(Take {
            of,
            is_start,
            pairs,
        });
    }
}

/// The strongest lines of a transform above 0 Hz and below half the sampling rate, ascending.
fn strongest(spectrum: &[Complex64]) -> Vec<usize> {
    let mut lines: Vec<usize> = (1..spectrum.len().div_ceil(2)).collect();
    if lines.len() > TAKES_LINES {
        let falling = |a: &usize, b: &usize| {
            let [a, b] = [a, b].map(|&k| spectrum[k].norm_sqr());
            b.total_cmp(&a)
        };
        lines.select_nth_unstable_by(TAKES_LINES, falling);
        lines.truncate(TAKES_LINES);
        lines.sort_unstable();
    }
    lines
}
