//! The least that a scene needs: a scene over a model enters; modes, actuators or a band leave.
//!
//! `folding` says exactly what is lost where a mode becomes a part of the residual terms.
//! `fewest_modes` and `band` ask it; `fewest_actuators` asks the programs of `solving`.

pub(crate) mod band;
pub(crate) mod fewest_actuators;
pub(crate) mod fewest_modes;
mod folding;
