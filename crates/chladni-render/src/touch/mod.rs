//! Touch as a part of the scene: `[touch]` enters; a drive that tolerates it, and how it does
//! under the fingers, leave.
//!
//! `table` (what the scene says) → `plan` (fingers at places: the touched mobility) →
//! `program` (the drive) → `judged` (how it does, and what no drive tolerates).

mod judged;
mod plan;
mod program;
mod table;

pub(crate) use judged::{corrected_finding, findings};
pub use judged::{TouchIndices, TouchPoints};
pub(crate) use plan::TouchPlan;
pub(crate) use program::{drive_under_fingers, judged, touched_kappa, TouchDrive};
pub(crate) use table::read_touch;
pub use table::{Touch, TouchCriterion, TouchPlaces, Touching};
