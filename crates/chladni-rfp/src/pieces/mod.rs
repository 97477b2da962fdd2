//! The fit in pieces, for data larger than memory and for many machines (theory.md,
//! section 11).
//!
//! ```text
//! block ── reduce ──> partial ─┐                       ┌─ reduce (with poles) ──> partial ─┐
//! block ── reduce ──> partial ─┴─ merge ── solve ──> poles                                 ├─ merge ── solve ──> fit
//! block ── ...                                         └─ reduce (with poles) ──> partial ─┘
//! ```
//!
//! A block is any part of the FRFs with a number of its own. The first pass leaves a
//! count sketch, the second the products with the basis of the poles that the sketch
//! showed; both are sums over FRFs, a few megabytes whatever the size of the data. Sums
//! are made in an order that the numbers of the blocks fix: the same blocks give the same
//! bits in whatever order and grouping they arrive.
//!
//! The walk from sums to a model is that of every fit (`driver.rs`): it stops at a pass
//! that is not made yet, and goes on from there. What needs single FRFs is left out, and a
//! fit says so: the checks for poles that move between FRFs or split, references that are
//! not reciprocal, and windows.

pub(crate) mod block;
pub(crate) mod error;
pub(crate) mod file;
pub(crate) mod given;
mod limits;
pub(crate) mod merged;
pub(crate) mod partial;
pub(crate) mod plan;
pub(crate) mod poles;
pub(crate) mod second_pass;
pub(crate) mod solve;
pub(crate) mod sound;
pub(crate) mod whole;

pub use block::{reduce, Reducer};
pub use error::PieceError;
pub use given::residues;
pub use partial::Partial;
pub use poles::Poles;
pub use solve::{solve, solve_watched, Solved};
