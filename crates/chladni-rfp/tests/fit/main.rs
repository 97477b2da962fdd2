//! The fit, against closed forms, bounds and measured sets.

mod above_noise;
mod common;
mod doubts;
mod family;
mod faults;
mod force_noise;
mod identification;
mod law;
mod limits;
mod measured;
mod measured_faults;
mod moved_poles;
mod noise_only;
mod number_of_modes;
mod pieces;
mod simulated_in_time;
mod structure;
mod unequal_noise;
mod validation;
mod viscous;
