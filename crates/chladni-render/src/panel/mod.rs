//! The panel at the drive frequency: a modal model enters; the mobility, how wrong it may be,
//! and the fields of drives leave.
//!
//! `operator` (mobility at the responses) → `covariance` (error of a drive) → `field` (the
//! drive's velocities, between the responses by `interpolation`). `modal_field` is that field
//! mode by mode, for panels that differ from the model, and `finger` one that is touched.

pub(crate) mod covariance;
pub(crate) mod drive;
pub(crate) mod field;
pub(crate) mod finger;
pub(crate) mod interpolation;
pub(crate) mod kernel_error;
mod lattice;
pub(crate) mod modal_field;
pub(crate) mod operator;
