//! Input and findings of a correction, as weights files carry it.

use super::calibration::{ChannelGain, Estimator};
use serde::{Deserialize, Serialize};

/// Input and result of a correction; `/correction` of a weights file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[must_use]
#[non_exhaustive]
pub struct Correction {
    /// Number of fields that were taken in.
    pub iteration: usize,
    /// The operator that the drive was made for.
    pub estimator: Estimator,
    /// Smaller of hot and cold ratio to be expected under the error bars of the corrected
    /// operator; as measured where a measured drive is given again.
    pub predicted: f64,
    /// A new scan of FRFs is due.
    pub scan_due: bool,
    /// The reason that it is due.
    pub scan_reason: Option<String>,
    /// The measured fields, in order.
    pub fields: Vec<TakenField>,
    /// The field, from 1, of the best measured drive.
    pub best_measured: Option<usize>,
    /// True where that drive is given again: it serves, or no better one is foretold.
    pub kept: bool,
    /// Gains that the fields tell, channel by channel.
    pub gains: Vec<ChannelGain>,
    /// Relative shift of all natural frequencies that they tell.
    pub common_shift: f64,
}

/// A field that was taken in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TakenField {
    /// mean |v − v̂|²/(‖L·A‖² + σ²) against what was foretold before it was taken in.
    pub nis: f64,
    /// Smaller of hot and cold ratio as measured; `None` where it holds no hot or no cold
    /// response.
    pub min_ratio: Option<f64>,
}
