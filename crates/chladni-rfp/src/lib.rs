//! Modal identification from FRFs: natural frequencies, loss factors, mode shapes and
//! their error bars, without a person picking poles.
//!
//! The walk is in `fit.rs`: screen the data, run the fast chain (maximum likelihood for
//! white noise), hand over to the measured-data path where the residual is not white,
//! choose the damping law, turn residues into shapes. The equations are in
//! `docs/theory.md`; every constant is in `tolerances.rs`.

mod acceleration;
mod alternation;
mod blocks;
mod cauchy;
mod decide;
mod descent;
mod error;
mod family;
mod faults;
mod first_look;
mod fit;
mod found;
mod given_noise;
mod head;
mod law;
mod measured;
mod methods;
mod model;
mod normal;
mod options;
mod order;
mod passes;
pub mod pieces;
mod pool;
mod project;
mod prune;
mod reading;
mod refine;
mod removal;
mod scan;
mod screen;
mod section;
mod seeds;
mod settle;
mod sketch;
mod structure;
mod structured;
mod tolerances;
mod unequal;
mod validation;
mod viscous;
mod whiteness;
mod wide;
mod work;

pub use error::FitError;
pub use family::stabilization;
pub use fit::{fit, Fit};
pub use methods::{OrderPole, Stability, Stabilization};
pub use options::{Effort, FitOptions, Method, ShapeModel, Window};
pub use validation::{
    auto_mac, cmif, mac, mac_matrix, mean_phase_deviation_deg, modal_complexity_factor, mpc,
    reciprocity, reconstruction_error, ReciprocalPair,
};
