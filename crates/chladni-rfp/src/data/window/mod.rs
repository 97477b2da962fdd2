//! Enters: how records were windowed and excited; leaves: what that does to lines, to the
//! columns of poles and to the errors of neighbours.

pub(crate) mod band;
pub(crate) mod block_errors;
pub(crate) mod kernel;
pub(crate) mod kinds;
pub(crate) mod lanes;
pub(crate) mod leakage;
pub(crate) mod of_set;
mod ramps;
