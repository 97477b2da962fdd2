//! Enters: a sketch whose residual is not white; leaves: poles with evidence and grades.
//!
//! Real misfit is 1–20 % of |Y| (leakage, cut or padded records, windows, poles that move
//! between FRFs), so "significant against white noise" is the wrong question there. A
//! mode is instead what is visible, what several orders and both halves of the lines
//! agree on, and what its own neighbourhood cannot do without. Every pole is then graded,
//! with reasons.

pub(crate) mod candidates;
pub(crate) mod consensus;
mod correlated_noise;
pub(crate) mod error_model;
pub(crate) mod evidence;
pub(crate) mod grade;
pub(crate) mod impulse;
mod limits;
pub(crate) mod local;
pub(crate) mod moving_pairs;
pub(crate) mod path;
pub(crate) mod record;
pub(crate) mod resolved;
pub(crate) mod sandwich;
pub(crate) mod search;
