//! Constants that decide something, under the file that uses them: meaning, unit, origin.

// driving_point.rs

/// Part of a sum that must have one sign (or one phase): noise and a band without
/// resonances bring it down.
pub(crate) const CLEAR: f64 = 0.5;
/// The mean phase at resonances must lie this near to a multiple of 90°, rad.
pub(crate) const NEAR: f64 = std::f64::consts::FRAC_PI_6;
/// Apparent masses |F/a| of anything that is tested, kg: from a grain of sand to a large
/// ship.
pub(crate) const PLAUSIBLE_KG: [f64; 2] = [1e-6, 1e8];
/// Fewer lines say nothing.
pub(crate) const LEAST_LINES: usize = 16;

// estimation.rs

/// Decimals of a time or rate in words.
pub(crate) const DECIMALS: i32 = 6;

// finding.rs

/// Relative distance within which a frequency of a finding is that of a mode: refinement
/// after the finding moves poles by less.
pub(crate) const SAME_MODE: f64 = 1e-3;

// model.rs

/// Part of the other errors that rounding leaves at most: a difference of equal
/// squares is known to the root of the last digit, 1e-8.
pub(crate) const ROUNDING: f64 = 1e-4;

// nearest_word.rs

/// Letters of a word that are compared: no name is longer, and the cost grows with the
/// square.
pub(crate) const LONGEST: usize = 64;

// selection.rs

/// Points of the frequency grid around each mode on which a dropped part is weighed.
pub(crate) const POINTS_PER_MODE: usize = 40;
/// Points of the same grid evenly over the band.
pub(crate) const POINTS_OVER_BAND: usize = 400;
/// Half-bandwidths between a mode before and after a new fit, at most: farther ones are
/// two.
pub(crate) const SELECTION_SAME_MODE: (f64, f64) = (1.0, 0.0);
/// The same between an added mode and the place where it was seen, and the part of its
/// frequency that a reader's eye may be off.
pub(crate) const AS_SEEN: (f64, f64) = (4.0, 5e-3);
