//! The data types that every other crate speaks: what a measurement is, and what a modal
//! model is.
//!
//! The way of the data starts here: a file becomes an [`FrfSet`] (measured FRFs with
//! axes, DOFs, kind and geometry), and the fit of `chladni-rfp` turns that into a
//! [`ModalModel`]. This crate knows neither files nor fitting nor rendering.
//!
//! ```
//! use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
//! use ndarray::{Array1, Array3};
//!
//! let set = FrfSet {
//!     frequency_hz: Array1::range(10.0, 60.0, 0.5),
//!     values: FrfValues::F64(Array3::zeros((2, 1, 100))),
//!     responses: vec!["1:+Z".parse()?, "2:+Z".parse()?],
//!     references: vec!["101:+Z".parse()?],
//!     kind: Some(FrfKind::Mobility),
//!     reference_unit: ReferenceUnit::Newton,
//!     coherence: None,
//!     variance: None,
//!     geometry: Geometry::default(),
//!     estimation: None,
//! };
//! let set = set.checked()?; // sizes and axis agree
//! assert_eq!(set.values.dim(), (2, 1, 100));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | what | types |
//! |---|---|
//! | a measurement | [`FrfSet`], [`FrfValues`], [`Dof`], [`FrfKind`], [`Geometry`], [`Estimation`] |
//! | time records | [`Run`], [`Channel`] |
//! | a model | [`ModalModel`], [`Mode`], [`Selection`], [`ShapeSet`] |
//! | a measured field | [`MeasuredField`] |
//! | what was found | [`Finding`], [`Severity`] |
//!
//! Errors are [`Error`], everywhere in Chladni: what was found, what was expected, what to
//! do, with file, line and field. No features.
//!
//! Conventions, kept everywhere: time sign e^{+jωt}, SI units, peak amplitudes, FRF
//! arrays with the axes (response, reference, line), lines contiguous.

mod dof;
mod driving_point;
mod driving_points;
mod error;
mod estimation;
mod finding;
mod findings;
mod frf_set;
mod geometry;
mod kind;
mod limits;
mod measured_field;
mod model;
mod nearest_word;
mod printable;
mod selection;
mod shape_set;
mod shared_errors;
mod source;
mod synthesis;
mod time_record;

pub use dof::{Direction, Dof};
pub use driving_point::driving_point_faults;
pub use driving_points::{driving_points, DrivingPoint};
pub use error::{Error, ErrorKind, Result};
pub use estimation::{BlockWindow, Estimation, Estimator, Forcing};
pub use finding::{numbered, warnings, Finding, Reason, Reasons, Severity, Values, MODES_HZ};
pub use findings::Findings;
pub use frf_set::{FrfSet, FrfValues};
pub use geometry::{Geometry, Node};
pub use kind::{FrfKind, ReferenceUnit, TimeSign};
pub use measured_field::{FieldPoint, MeasuredField};
pub use model::{
    ComplexMatrix, ComplexVector, Damping, ModalModel, Mode, Quality, ResidualTerm, ResidualTerms,
    Scaling, Trust, MODEL_FORMAT,
};
pub use nearest_word::nearest_word;
pub use printable::{counted, printable};
pub use selection::{ModeName, ModePick, Selected, Selection};
pub use shape_set::{ShapeMode, ShapeSet};
pub use shared_errors::shared_power;
pub use source::{Checksum, Source};
pub use time_record::{Channel, Run, SignalUnit};

/// The name and version that every result carries in `created_by`.
pub const CREATED_BY: &str = concat!("chladni ", env!("CARGO_PKG_VERSION"));
