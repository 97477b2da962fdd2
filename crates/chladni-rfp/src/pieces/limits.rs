//! Every constant of this room: meaning, unit, where it comes from, and what happens at other
//! values where that was tried.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// file.rs

/// Version of the content; another one is refused.
pub(super) const VERSION: u64 = 8;
/// Most bytes of the first line.
pub(super) const HEAD_MOST: usize = 1024;

// merged.rs

/// Largest share of a pole's column (its square) outside the basis of a pilot with which
/// one pass is enough: so much of what the data say of that pole is lost at most.
pub(super) const PILOT_SHARE: f64 = 0.01;

// partial.rs

/// Missing blocks that a finding names by their numbers.
pub(super) const MISSING_NAMED: usize = 10;

// sound.rs

/// Longest run of blocks: two of them can be one.
pub(super) const RUN_MOST: u64 = 1 << 62;
/// Most FRFs in one column of a sketch: sums of many are numbers.
pub(super) const FRFS_MOST: u64 = 1 << 48;
/// Most passes and rounds that a fit can have made.
pub(super) const ROUNDS_MOST: usize = 1 << 10;
