//! The methods, one file each: a [`Setup`](crate::problems::setup::Setup) enters, a
//! [`Solution`](solution::Solution) leaves. None knows files or flags.
//!
//! `options` (what a user may set) → `choice` (the method that runs) → `method` (its file) →
//! `solution`. `mls` iterates by `magnitudes` and `split`; `robust` and `min_effort` climb from
//! its drive. `gain` scales a drive, `drive_error` finds the error of amplifiers that it tolerates.

pub(crate) mod choice;
pub(crate) mod contrast;
pub(crate) mod drive_error;
pub(crate) mod effort;
pub(crate) mod gain;
mod magnitudes;
pub(crate) mod method;
pub(crate) mod min_effort;
pub(crate) mod mls;
pub(crate) mod modal;
pub(crate) mod modal_steps;
pub(crate) mod options;
pub(crate) mod pressure_matching;
pub(crate) mod robust;
pub(crate) mod solution;
mod split;
pub(crate) mod tikhonov;
pub(crate) mod time_reversal;
pub(crate) mod tsvd;
pub(crate) mod vast;
