//! Actuator weights that move a panel here and keep it quiet there.
//!
//! A [`Scene`] says what is to be felt where; [`render`] takes it and a modal model to
//! [`Weights`] and the field they make; [`evaluate`] judges given weights on other data.
//!
//! ```
//! use chladni_plate::{simulate, Panel};
//! use chladni_render::{evaluate, render, On, RenderOptions, Scene};
//! # let mut panel = Panel::default();
//! # (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 50.0);
//! let measured = simulate(&panel, None, None).unwrap();
//! let text = "
//!     frequency_hz = 300.0
//!     [zones]
//!     grid = [2, 2]
//!     hot = [1]
//!     cells_m = [0.0, 0.0, 0.268, 0.170]";
//! let scene = Scene::parse(text, std::path::Path::new("")).unwrap();
//! let rendering = render(&measured.truth, &scene, &RenderOptions::default()).unwrap();
//! assert!(rendering.weights.feasible);
//! let judged = evaluate(&rendering.weights, &scene, On::Frf(&measured.frf)).unwrap();
//! assert!(judged.indices.points.min_ratio > 0.95);
//! ```
//!
//! | you have | you call | you get |
//! |---|---|---|
//! | a model and a scene | [`render`](render()) with [`RenderOptions`] | [`Rendering`]: weights, field, indices |
//! | weights and other data | [`evaluate`](evaluate()) | [`Evaluation`] |
//! | a field measured under them | [`evaluate_field`], [`correct`], [`calibrate`] | [`FieldEvaluation`], corrected weights, [`Calibration`] |
//! | a scene with `[time]` | [`play`](play()) | [`Played`], and from it a [`Signal`] |
//! | doubts | [`sweep`], [`stress`](stress()), [`stress_in_time`] | other frequencies, panels that are not the model |
//!
//! Errors are [`chladni_frf::Error`]; the feature `system` computes with LAPACK.
//!
//! The way through the crate:
//!
//! `scene` → `zones` (what is asked of each place) → `operator` (what the panel does at
//! the drive frequency) → `covariance` (how wrong that may be) → `problem` (judged rows
//! and limits) → `methods` (one file each) → `field` → `indices` → `weights`.
//!
//! The idea that carries the methods: v = H·A with the mobility H of the model, |v| at
//! least threshold + limen on hot ground and at most threshold − limen on cold ground,
//! and an error bar ‖L·A‖ of v from the model's own standard deviations, so that no drive
//! leans on what the model does not know.

mod band;
mod branches;
mod ceiling;
mod climb;
mod conic;
mod count;
mod covariance;
mod drift;
mod drive_error;
mod drive_program;
mod dual;
mod effort;
mod endurance;
mod evaluate;
mod fewest_actuators;
mod fewest_modes;
mod field;
mod finger;
mod folding;
mod frequency_sweep;
mod gain;
mod indices;
mod interpolation;
mod kernel_error;
mod lattice;
mod least_squares;
mod methods;
mod modal_field;
mod operator;
mod options;
mod outcome;
mod plane;
mod problem;
mod render;
mod rig;
mod rig_draw;
mod scene;
mod setup;
mod shortcomings;
mod signals;
mod stress;
#[cfg(test)]
mod test_model;
mod threshold;
mod time;
mod tolerances;
mod tones;
mod touch;
mod weights;
mod zones;

pub use band::{needed_band, NeededBand};
pub use ceiling::Ceiling;
pub use count::Count;
pub use covariance::Covariance;
pub use drift::Drift;
pub use effort::Effort;
pub use endurance::Endurance;
pub use evaluate::{evaluate, Evaluation, On};
pub use field::{AreaField, AreaGrid, Field};
pub use finger::{finger_places, Finger};
pub use frequency_sweep::{sweep, FrequencySweep, SweptFrequency};
pub use indices::{AreaIndices, Indices, PointIndices};
pub use methods::{Method, MethodChoice, ModalSteps, StepMatrix};
pub use operator::Operator;
pub use options::RenderOptions;
pub use plane::{Position, Rectangle};
pub use render::{render, render_measured, render_with_others, Rendering};
pub use rig::{
    calibrate, correct, evaluate_field, evaluate_signal, play, poles_of_fields, stress_in_time,
    Agreement, CalibratedMode, CalibratedOperator, Calibration, ChannelGain, Correction, Estimator,
    FieldEvaluation, GainTable, Hypothesis, KalmanOperator, Place, PointAgreement, PolesOfFields,
    TableGain, TakenField, CALIBRATION_FORMAT, CALIBRATION_VERSION,
};
pub use rig_draw::StressOptions;
pub use scene::{
    Actuators, Circuit, Limits, Load, Scene, DEFAULT_LIMEN_DB, DEFAULT_MAX_FORCE_N,
    DEFAULT_TRANSITION_M,
};
pub use signals::signal_csv;
pub use stress::stress;
pub use threshold::{Threshold, ThresholdTable};
pub use time::{
    modal_ramp, AreaFrames, AreaMeasures, Burst, Channel, ChannelMap, Fade, Level, Mapped, Measure,
    Move, PlayOptions, Played, RampTime, Ramps, Recorded, SampleFormat, Sidecar, Signal,
    SignalOptions, TimeEvent, TimeFrames, TimeIndices, TimeMeasure, TimeStressRow, TimeTable,
    TimeTraces, SIGNAL_FORMAT, SIGNAL_VERSION,
};
pub use tolerances::AREA_STEP_M;
pub use tones::{Share, Tone};
pub use touch::{Touch, TouchCriterion, TouchIndices, TouchPlaces, TouchPoints, Touching};
pub use weights::{StressRow, Weight, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
pub use zones::{Ground, PolygonKind, ZoneLayout, ZoneMap, ZonePolygon, Zones};
