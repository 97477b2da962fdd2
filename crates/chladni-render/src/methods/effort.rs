//! Effort spent on finding weights.

use crate::tolerances;

/// Effort spent on the search for the largest κ: it moves the conic methods along the
/// front of speed and success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Most drives that `robust` climbs from, the best first; `best` takes
    /// three or more.
    pub starts: usize,
    /// Most conic programs in a row for each thing that is sought: κ, then margin, then
    /// peak force or effort.
    pub conic_rounds: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            starts: 1,
            conic_rounds: tolerances::ROUNDS,
        }
    }
}
