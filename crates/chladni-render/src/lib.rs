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
//! The way of the data, room by room:
//!
//! `scene` (what is asked of each place) → `panel` (what the panel does at the drive
//! frequency, and how wrong that may be) → `problems` (judged rows and limits) → `methods`
//! (one file each; their mathematics is in `solving`) → `judging` (indices of the field,
//! ceiling, endurance) → `results` (weights). `reduction` leaves out modes and actuators that
//! a scene does not need. `render` walks this way. `rig` (measured fields), `time` (scenes in
//! time) and `touch` (fingers) have rooms of their own. Constants are in `tolerances`.
//!
//! The idea that carries the methods: v = H·A with the mobility H of the model, |v| at
//! least threshold + limen on hot ground and at most threshold − limen on cold ground,
//! and an error bar ‖L·A‖ of v from the model's own standard deviations, so that no drive
//! leans on what the model does not know.

mod digits;
mod judging;
mod methods;
mod panel;
mod problems;
mod reduction;
mod render;
mod results;
mod rig;
mod scene;
mod solving;
#[cfg(test)]
mod test_model;
mod time;
mod tolerances;
mod touch;

pub use judging::ceiling::Ceiling;
pub use judging::endurance::Endurance;
pub use judging::frequency_sweep::{sweep, FrequencySweep, SweptFrequency};
pub use judging::indices::{AreaIndices, Indices, PointIndices};
pub use judging::rig_draw::StressOptions;
pub use methods::choice::MethodChoice;
pub use methods::effort::Effort;
pub use methods::method::Method;
pub use methods::modal_steps::{ModalSteps, StepMatrix};
pub use methods::options::RenderOptions;
pub use panel::covariance::Covariance;
pub use panel::field::{AreaField, AreaGrid, Field};
pub use panel::finger::{finger_places, Finger};
pub use panel::operator::Operator;
pub use reduction::band::{needed_band, NeededBand};
pub use render::{render, render_measured, render_with_others, Rendering};
pub use results::evaluate::{evaluate, Evaluation, On};
pub use results::signals::signal_csv;
pub use results::stress::stress;
pub use results::weights::{StressRow, Weight, Weights, WEIGHTS_FORMAT, WEIGHTS_VERSION};
pub use rig::{
    calibrate, correct, evaluate_field, poles_of_fields, Agreement, CalibratedMode,
    CalibratedOperator, Calibration, ChannelGain, Correction, Estimator, FieldEvaluation,
    GainTable, Hypothesis, KalmanOperator, Place, PlayedField, PointAgreement, PolesOfFields,
    TableGain, TakenField, CALIBRATION_FORMAT, CALIBRATION_VERSION,
};
pub use scene::actuators::{Actuators, DEFAULT_MAX_FORCE_N};
pub use scene::circuit::{Circuit, Load};
pub use scene::count::Count;
pub use scene::drift::Drift;
pub use scene::limits::Limits;
pub use scene::plane::{Position, Rectangle};
pub use scene::read_threshold::DEFAULT_LIMEN_DB;
pub use scene::read_zones::DEFAULT_TRANSITION_M;
pub use scene::scene_file::Scene;
pub use scene::threshold::{Threshold, ThresholdTable};
pub use scene::tones::{Share, Tone};
pub use scene::zones::{Ground, PolygonKind, ZoneLayout, ZoneMap, ZonePolygon, Zones};
pub use time::{
    evaluate_signal, modal_ramp, play, stress_in_time, AreaFrames, AreaMeasures, Burst, Channel,
    ChannelMap, Fade, Level, Mapped, Measure, Move, PlayOptions, Played, RampTime, Ramps, Recorded,
    SampleFormat, Sidecar, Signal, SignalOptions, TimeEvent, TimeFrames, TimeIndices, TimeMeasure,
    TimeStressRow, TimeTable, TimeTraces, SIGNAL_FORMAT, SIGNAL_VERSION,
};
pub use tolerances::AREA_STEP_M;
pub use touch::{Touch, TouchCriterion, TouchIndices, TouchPlaces, TouchPoints, Touching};
