//! Modal identification from FRFs: natural frequencies, loss factors, mode shapes and their
//! error bars, without manual pole picking.
//!
//! ```
//! use chladni_plate::{simulate, Panel};
//! use chladni_rfp::{fit, FitOptions};
//! # let mut panel = Panel::default();
//! # panel.frf.stop_hz = 300.0;
//!
//! let frf = simulate(&panel, None, None)?.frf; // or an FrfSet of your own
//! let model = fit(&frf, &FitOptions::default())?.model;
//! for mode in model.in_band_modes() {
//!     println!("{:.3} Hz, loss factor {:.4}", mode.frequency_hz, mode.loss_factor);
//! }
//! assert!(model.quality.trusted);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | you have | you call | you get |
//! |---|---|---|
//! | FRFs | [`fit()`] with [`FitOptions`]; [`fit_watched`] with progress and a [`CancelToken`] | [`Fit`]: the model with error bars and grades |
//! | FRFs, before a fit | [`cmif()`], [`stabilization`], [`reciprocity()`] | indicator functions, diagrams, checks |
//! | two models | [`compare()`], [`track`] | modes paired, MAC with its uncertainty, shifts |
//! | a model and a few new FRFs | [`poles_of`] | [`MovedPoles`]: the model with its poles moved, shapes kept |
//! | more FRFs than memory | [`pieces`] | the same fit, block by block |
//!
//! Errors are [`FitError`]; the feature `system` computes with LAPACK.
//!
//! `driver.rs` is the walk: screen the data, run the fast chain (maximum likelihood for
//! white noise), hand over to the measured-data path where the residual is not white, choose
//! the damping law, turn residues into shapes. The equations are in `docs/theory.md`.

mod checks;
mod damping;
mod data;
mod driver;
mod in_memory;
mod measured;
mod methods;
mod model;
pub mod pieces;
mod poles;
mod shapes;
mod tolerances;
mod validation;

pub use checks::correlation::Correlation;
pub use checks::witness::{error_witness, Witness};
pub use data::error::FitError;
pub use data::options::{Effort, FitOptions, Method, RfpOptions, RfpWeight, ShapeModel};
pub use data::watch::CancelToken;
pub use data::window::kinds::Window;
pub use in_memory::{fit, fit_watched};
pub use methods::fit::Fit;
pub use methods::found::{OrderPole, Stability, Stabilization};
pub use methods::lscf::stabilization;
pub use model::moved_poles::{poles_of, MovedPoles};
pub use validation::cmif::cmif;
pub use validation::compare::{
    compare, track, CompareOptions, Comparison, LoneMode, MacEstimate, ModePair, ModeTrack,
    PairDofs, TrackAgainst, Tracking,
};
pub use validation::complexity::{mean_phase_deviation_deg, modal_complexity_factor, mpc};
pub use validation::mac::{auto_mac, mac, mac_matrix};
pub use validation::reciprocity::{reciprocity, ReciprocalPair};
