//! Every constant of this room: meaning, unit, where it comes from, and what happens at other
//! values where that was tried.

// build.rs

/// χ² per degree of freedom beyond which one shape per mode does not hold.
pub(super) const SHAPE_MISFIT: f64 = 1.5;
/// FRFs per block of what is done FRF by FRF.
pub(super) const BUILD_BLOCK: usize = 1024;

/// Part of the data's energy that such a rise loses to rounding.
pub(super) const RISE_ROUNDING: f64 = 1e-12;

// decide.rs

/// Loss factor below which the two damping laws differ by less (about η²/4 in frequency)
/// than measured line shapes can tell.
pub(super) const LAW_ALIKE: f64 = 0.02;

// modes.rs

/// Largest standard deviation of a loss factor in the file: a mode that vibrates has one
/// below 2.
pub(super) const LOSS_FACTOR_UNKNOWN: f64 = 2.0;

// residual_energy.rs

/// Part of an FRF's energy that the difference of such sums knows a residual to; less,
/// and it is rounding.
pub(super) const KNOWN: f64 = 1e-9;
/// FRFs per block.
pub(super) const RESIDUAL_ENERGY_BLOCK: usize = 256;
