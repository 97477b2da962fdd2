//! The real rig: a measured field enters; how it agrees with its prediction, what is wrong
//! with the rig, and a corrected drive leave.
//!
//! `field` (a measured field laid over the operator) → `agreement` (how near) →
//! `diagnosis` (why not nearer) → `evaluation` (both beside the indices). `structured` and
//! `kalman` (two corrections of the operator) → `correction` (which of them, and the
//! drive); `calibration` keeps what was learned, `calibrated` starts the next scene with
//! it.

mod agreement;
mod calibrated;
pub(crate) mod calibration;
mod correction;
mod diagnosis;
mod evaluation;
mod field;
mod kalman;
mod over_time;
mod structured;

pub use agreement::{Agreement, PointAgreement};
pub(crate) use calibrated::{gain_of, Calibrated};
pub use calibration::{
    CalibratedMode, CalibratedOperator, Calibration, ChannelGain, Estimator, CALIBRATION_FORMAT,
    CALIBRATION_VERSION,
};
pub use correction::{calibrate, correct, Correction, TakenField};
pub use diagnosis::{Hypothesis, Place};
pub use evaluation::{evaluate_field, FieldEvaluation};
pub use kalman::KalmanOperator;
pub use over_time::{evaluate_signal, play, stress_in_time};
