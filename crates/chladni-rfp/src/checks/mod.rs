//! Enters: a model and what may be asked of its data; leaves: remarks on what is wrong with
//! the data.

pub(crate) mod around;
pub(crate) mod case;
pub(crate) mod common_delay;
pub(crate) mod correlation;
pub(crate) mod delay;
pub(crate) mod delayed_response;
pub(crate) mod estimation;
pub(crate) mod examine;
pub(crate) mod hidden;
pub(crate) mod kind;
mod limits;
pub(crate) mod line_shape;
pub(crate) mod moving;
pub(crate) mod noise;
mod phases;
pub(crate) mod reciprocal;
pub(crate) mod split;
pub(crate) mod turned_response;
pub(crate) mod window_bias;
pub(crate) mod witness;
