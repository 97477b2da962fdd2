//! Doubts about the damping of a mode that is there.

use super::limits::{FEWEST_LINES, INDICATIVE};
use crate::measured::evidence::Evidence;
use chladni_frf::Finding;

/// A doubt about the damping of a mode that is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DampingDoubt {
    /// Too few lines within the half-power bandwidth.
    UpperBound,
    /// A peak without the shape of a resonance.
    Indicative,
}

impl DampingDoubt {
    /// The doubt that this evidence leaves.
    pub fn of(evidence: &Evidence) -> Option<Self> {
        if 2.0 * evidence.half_width_lines < FEWEST_LINES {
            Some(Self::UpperBound)
        } else if evidence.misfit > INDICATIVE {
            Some(Self::Indicative)
        } else {
            None
        }
    }

    /// The finding about modes at these frequencies, rising; none without a mode.
    pub fn finding(self, places_hz: Vec<f64>) -> Option<Finding> {
        let subject = match places_hz.as_slice() {
            [] => return None,
            [one] => format!("the mode at {one:.2} Hz"),
            [first, .., last] => {
                format!("{} modes, {first:.1} to {last:.1} Hz", places_hz.len())
            }
        };
        let finding = match self {
            Self::UpperBound => Finding::caution(
                "damping-upper-bound",
                format!(
                    "{subject}: fewer than two lines within the half-power bandwidth; the damping \
                     is an upper bound"
                ),
            )
            .help("measure longer records for finer lines"),
            Self::Indicative => Finding::caution(
                "damping-indicative",
                format!("{subject}: no shape of a resonance; the damping is indicative only"),
            )
            .help("measure at a lower level, or fit these modes in a narrow band"),
        };
        Some(finding.modes_hz(places_hz))
    }
}
