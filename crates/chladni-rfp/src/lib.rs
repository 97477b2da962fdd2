//! Modal identification from FRFs: natural frequencies, loss factors, mode shapes and their
//! error bars, without manual pole picking.
//!
//! `driver.rs` is the walk: screen the data, run the fast chain (maximum likelihood for
//! white noise), hand over to the measured-data path where the residual is not white, choose
//! the damping law, turn residues into shapes. The equations are in `docs/theory.md`.

mod checks;
mod damping;
mod data;
mod driver;
mod measured;
mod methods;
mod model;
pub mod pieces;
mod poles;
mod shapes;
mod tolerances;
mod validation;

pub use data::error::FitError;
pub use data::options::{Effort, FitOptions, Method, RfpOptions, RfpWeight, ShapeModel, Window};
pub use driver::{fit, Fit};
pub use methods::bars::stabilization;
pub use methods::found::{OrderPole, Stability, Stabilization};
pub use validation::cmif::cmif;
pub use validation::complexity::{mean_phase_deviation_deg, modal_complexity_factor, mpc};
pub use validation::mac::{auto_mac, mac, mac_matrix};
pub use validation::reciprocity::{reciprocity, ReciprocalPair};
pub use validation::reconstruction::reconstruction_error;
