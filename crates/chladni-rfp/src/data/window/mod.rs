//! Enters: window and excitation of records; leaves: their effect on the columns of poles and on
//! the errors of neighbouring lines.

pub(crate) mod band;
pub(crate) mod block_errors;
pub(crate) mod kernel;
pub(crate) mod kinds;
pub(crate) mod lanes;
pub(crate) mod leakage;
pub(crate) mod of_set;
mod ramps;
