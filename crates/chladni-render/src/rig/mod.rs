//! The real rig: a measured field enters; how it agrees with its prediction, what is wrong
//! with the rig, and a corrected drive leave.
//!
//! `field` (a measured field laid over the operator) → `agreement` (how near) →
//! `diagnosis` (why not nearer) → `evaluation` (both beside the indices). `structured` and
//! `kalman` (two corrections of the operator) → `correction` (which of them, and the
//! drive).

mod agreement;
mod correction;
mod diagnosis;
mod evaluation;
mod field;
mod kalman;
mod structured;

pub use agreement::{Agreement, PointAgreement};
pub use correction::{correct, ChannelGain, Correction, Estimator, TakenField};
pub use diagnosis::{Hypothesis, Place};
pub use evaluation::{evaluate_field, FieldEvaluation};
pub use kalman::KalmanOperator;
