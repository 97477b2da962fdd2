//! Modal identification from FRFs: natural frequencies, loss factors, mode shapes and their error bars, without a person
//! picking poles.
#![allow(dead_code)]

mod error;
mod fit;
mod law;
mod measured;
mod methods;
mod model;
mod options;
mod order;
mod pool;
mod project;
mod prune;
mod refine;
mod screen;
mod seeds;
mod structure;
mod tolerances;
mod validation;
mod viscous;
mod whiteness;
mod work;

pub use error::FitError;
pub use fit::{fit, Fit};
pub use validation::{cmif, mac, mac_matrix, mpc};
pub use options::{FitOptions, Method};
