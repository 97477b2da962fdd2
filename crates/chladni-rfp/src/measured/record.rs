//! The record that a search is part of.

use super::limits::NOISE_WINDOW;
use crate::data::columns::Columns;
use crate::data::peaks::Peak;
use crate::data::window::block_errors::BlockErrors;
use ndarray::Array1;

/// The properties of its record that a search needs.
pub(crate) struct Record<'a> {
    /// Scaled columns on all lines used.
    pub work: &'a Columns,
    /// Additive noise variance per line.
    pub noise: &'a Array1<f64>,
    /// Visible peaks.
    pub seen: &'a [Peak],
    /// Number of FRFs.
    pub frfs: usize,
    /// Factors from columns to FRFs; `None` where the columns are mixtures.
    pub scales: Option<Array1<f64>>,
    /// True where all FRFs were measured from one reference.
    pub one_reference: bool,
    /// True where the records went through a window that broadens lines.
    pub windowed: bool,
    /// True where errors are known to be largest beside modes.
    pub leaks: bool,
    /// True where noise of lines is told to be largest there, as under a force that drops.
    pub loud_at_peaks: bool,
    /// Errors of lines, where their noise alone correlates neighbours.
    pub correlated_noise: Option<&'a BlockErrors>,
    /// Hz per √x.
    pub hz: f64,
}

impl Record<'_> {
    /// True if poles are refined on all weighted lines. Refined on a mode's own lines alone
    /// they would be less exact, and their errors would not be those that bars hold.
    pub fn needs_all_lines(&self) -> bool {
        self.leaks || self.loud_at_peaks || self.correlated_noise.is_some()
    }
}

/// Half window, in lines, of the noise under the peaks of `lines` lines.
pub(crate) fn noise_window(lines: usize) -> usize {
    let (one_in, least, most) = NOISE_WINDOW;
    (lines / one_in).clamp(least, most)
}
