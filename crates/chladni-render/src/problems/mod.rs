//! The scene laid over the panel: both enter; what every method solves leaves.
//!
//! `setup` classifies the responses by the zones, and keeps the judged ones with the limits
//! as the [`Problem`](problem::Problem); `problem` scores drives on them.

pub(crate) mod problem;
pub(crate) mod setup;
