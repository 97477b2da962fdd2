//! Enters: lines and poles; leaves: columns, derivatives and inner products in one damping
//! law, and which law holds.

pub(crate) mod bars;
pub(crate) mod basis;
pub(crate) mod columns;
mod filled;
pub(crate) mod findings;
pub(crate) mod gram;
pub(crate) mod law;
mod limits;
pub(crate) mod measured_model;
mod mixing;
mod partial_fractions;
pub(crate) mod phased;
pub(crate) mod places;
pub(crate) mod plane;
pub(crate) mod saved;
pub(crate) mod synthesis;
pub(crate) mod verdict;
pub(crate) mod viscous;
