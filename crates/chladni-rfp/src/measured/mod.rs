//! The measured-data path: what to do where the residual is not white.
//!
//! Real misfit is 1–20 % of |Y| (leakage, cut or padded records, windows, poles that move
//! between FRFs), so "significant against white noise" is the wrong question there. A
//! mode is instead what is visible, what several orders and both halves of the lines
//! agree on, and what its own neighbourhood cannot do without. Every pole is then graded,
//! with reasons.

mod candidates;
mod consensus;
mod evidence;
mod grade;
mod local;
mod path;
mod record;
mod resolved;
mod sandwich;
mod search;
mod twins;
mod weights;

pub(crate) use path::{measured_path, on_columns, strongest};
