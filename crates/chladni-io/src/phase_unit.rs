//! Units of a phase, degrees or radians, by name or by the size of the numbers.

use crate::limits::{SURELY_DEGREES, WRAPPED_DEGREES};
use serde::Serialize;
use std::str::FromStr;

/// Unit of phases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub enum PhaseUnit {
    /// A 360th of a turn.
    #[serde(rename = "deg")]
    Degree,
    /// A turn over 2π.
    #[serde(rename = "rad")]
    Radian,
}

const DEGREES: [&str; 7] = ["deg", "degs", "degree", "degrees", "°", "º", "â°"];
const RADIANS: [&str; 4] = ["rad", "rads", "radian", "radians"];

impl PhaseUnit {
    /// The unit that a label or a word of a header names.
    pub(super) fn named(label: &str) -> Option<Self> {
        let label = label.trim().to_lowercase();
        if DEGREES.contains(&label.as_str()) {
            Some(Self::Degree)
        } else if RADIANS.contains(&label.as_str()) {
            Some(Self::Radian)
        } else {
            None
        }
    }

    /// Factor to radians.
    pub(super) fn to_radians(self) -> f64 {
        match self {
            Self::Degree => 1f64.to_radians(),
            Self::Radian => 1.0,
        }
    }

    /// The word in messages and options.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Degree => "deg",
            Self::Radian => "rad",
        }
    }

    /// The unit of phases without one, by their size; `None` where they may be either. Zeros
    /// are the same in both.
    pub(super) fn by_size(phases: impl IntoIterator<Item = f64>) -> Option<Self> {
        let largest = phases
            .into_iter()
            .filter(|phase| phase.is_finite())
            .fold(0.0_f64, |most, phase| most.max(phase.abs()));
        let told = largest == 0.0 || (SURELY_DEGREES..=WRAPPED_DEGREES).contains(&largest);
        told.then_some(Self::Degree)
    }
}

impl FromStr for PhaseUnit {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Self::named(text).ok_or_else(|| format!("`{text}` is no unit of a phase; write deg or rad"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_sizes() {
        for (label, unit) in [
            ("deg", Some(PhaseUnit::Degree)),
            (" Degrees ", Some(PhaseUnit::Degree)),
            ("°", Some(PhaseUnit::Degree)),
            ("radians", Some(PhaseUnit::Radian)),
            ("RAD", Some(PhaseUnit::Radian)),
            ("mrad", None),
            ("", None),
        ] {
            assert_eq!(PhaseUnit::named(label), unit, "{label}");
        }
        for (phases, unit) in [
            (&[-179.9, 3.0][..], Some(PhaseUnit::Degree)),
            (&[0.0, f64::NAN], Some(PhaseUnit::Degree)),
            (&[-3.1, 3.1], None),
            (&[-20.0, 0.0], None),
            (&[-900.0, 0.0], None),
        ] {
            assert_eq!(
                PhaseUnit::by_size(phases.iter().copied()),
                unit,
                "{phases:?}"
            );
        }
    }
}
