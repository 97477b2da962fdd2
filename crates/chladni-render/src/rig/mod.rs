//! The real rig: a measured field enters; how it agrees with its prediction, what is wrong
//! with the rig, and a corrected drive leave.
//!
//! `field` (a measured field laid over the operator) → `agreement` (how near) →
//! `diagnosis` (why not nearer; `swapped`: two cables, held against `channel_faults`) →
//! `evaluation` (both beside the indices). `seen` (the field as updates take it) →
//! `structured` (gains and poles: `parts`, weighed by `evidence`) and `kalman` (the operator
//! itself) → `estimators` → `learned` (which of them counts) → `explained` (whether a faulty
//! rig makes such a field) → `correct` (the drive; `given`: or the best measured one).
//! `calibration` keeps what was learned (`gain_table`: over frequency, `gain_file`: as people
//! write it; `known_keys` refuses misspelt keys), `calibrated` starts the next scene with it;
//! `prior` is what stands before any field. `poles_of_fields` moves the poles of a model alone.

mod agreement;
mod calibrated;
pub(crate) mod calibration;
mod channel_faults;
mod correct;
mod correction;
mod diagnosis;
mod estimators;
mod evaluation;
mod evidence;
mod expectation;
mod explained;
mod field;
mod gain_file;
mod gain_table;
mod given;
mod hypothesis;
mod kalman;
mod known_keys;
mod learned;
mod lone_points;
mod normal;
mod parts;
mod played_field;
mod poles_of_fields;
mod prior;
mod seen;
mod structured;
mod swapped;
mod weighed;

pub use agreement::{Agreement, PointAgreement};
pub(crate) use calibrated::{at_tone, gain_of, Calibrated};
pub use calibration::{
    CalibratedMode, CalibratedOperator, Calibration, ChannelGain, Estimator, CALIBRATION_FORMAT,
    CALIBRATION_VERSION,
};
pub use correct::{calibrate, correct};
pub use correction::{Correction, TakenField};
pub use evaluation::{evaluate_field, FieldEvaluation};
pub use gain_table::{GainTable, TableGain};
pub use hypothesis::{Hypothesis, Place};
pub use kalman::KalmanOperator;
pub use played_field::PlayedField;
pub use poles_of_fields::{poles_of_fields, PolesOfFields};
