//! Enters: pole estimates on compressed columns; leaves: a modal model in the law that
//! holds.

mod above_noise;
pub(crate) mod build;
pub(crate) mod decide;
pub(crate) mod exponential;
pub(crate) mod fewer_poles;
pub(crate) mod free_fit;
pub(crate) mod given;
pub(crate) mod identified;
pub(crate) mod in_law;
mod limits;
pub(crate) mod modes;
pub(crate) mod moved_poles;
pub(crate) mod outlier_lines;
pub(crate) mod residual_energy;
pub(crate) mod residues;
