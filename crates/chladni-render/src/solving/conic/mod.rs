//! Second-order cone programs in the words of this crate.
//!
//! minimise qᵀx with every expression that was added non-negative, and the first of every
//! cone at least the norm of the rest. The rows of a drive are dense, and programs of
//! dense rows have a solver of their own (module [`interior_point`]); where its steps lead
//! nowhere, that of `clarabel` decides (module [`sparse`]). Both are deterministic and
//! run on one thread.

mod cones;
mod interior_point;
mod normal_equations;
pub(crate) mod program;
mod solve;
mod sparse;
