//! Weights as files hold them: a judged drive enters, and leaves as [`Weights`](weights::Weights).
//!
//! `outcome` makes the `weights` of a rendered drive, `signals` a table of them. `evaluate`
//! judges given weights on other data, `stress` on panels that are not the model.

pub(crate) mod evaluate;
pub(crate) mod outcome;
pub(crate) mod signals;
pub(crate) mod stress;
pub(crate) mod weights;
