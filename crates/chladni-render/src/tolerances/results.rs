//! Constants of weights files: meaning, unit, origin.

/// Largest weight of a file, N or V: no actuator comes near it, and what is printed of it
/// is still read.
pub const MOST_WEIGHT: f64 = 1e15;

/// Difference of a weight's amplitude and phase from its parts, relative, that decimals of
/// other programs may leave.
pub const SAME_WEIGHT: f64 = 1e-2;

// digits.rs

/// Numbers that sentences write without an exponent: beyond them, zeros hide the digits.
pub const PLAIN: std::ops::Range<f64> = 1e-9..1e15;
