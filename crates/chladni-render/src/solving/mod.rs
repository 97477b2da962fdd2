//! The mathematics that methods share: rows and limits enter; a drive, or a bound on all
//! drives, leaves.
//!
//! Quick: `least_squares`. Thorough: `climb` goes from one `drive_program` to the next, each
//! solved by `conic`. Bounds: `dual`, tightened by `branches`.

pub(crate) mod branches;
pub(crate) mod climb;
pub(crate) mod conic;
pub(crate) mod drive_program;
pub(crate) mod dual;
pub(crate) mod least_squares;
