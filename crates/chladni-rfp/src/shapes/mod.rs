//! Enters: residues, or columns at given poles; leaves: shapes, participations and their
//! error bars.

pub(crate) mod acceleration;
pub(crate) mod alternation;
mod around;
mod attempt;
pub(crate) mod error_bars;
pub(crate) mod factor;
pub(crate) mod force_drop;
mod force_noise;
pub(crate) mod found;
mod from_moments;
pub(crate) mod growth;
pub(crate) mod influence;
mod inverse_root;
mod leakage_into_lines;
mod leaked;
mod levels;
mod limits;
pub(crate) mod line_bars;
pub(crate) mod line_products;
pub(crate) mod low_rank;
mod order;
mod own_noise;
pub(crate) mod residues;
pub(crate) mod scale;
pub(crate) mod search;
pub(crate) mod step;
pub(crate) mod structure;
pub(crate) mod tangent;
pub(crate) mod target;
pub(crate) mod term_noise;
