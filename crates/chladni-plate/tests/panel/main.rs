//! The simulated panel, against closed forms and tables.

mod cramer_rao;
mod estimate;
mod fixtures;
mod frequencies;
mod leakage;
mod response;
mod scaling;
mod time;
