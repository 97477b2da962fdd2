//! Enters: shapes, models, FRF sets; leaves: yardsticks of modal testing, of shapes (MAC, phase
//! collinearity and deviation, complexity) and of FRFs (mode indicator, reciprocity); two models
//! side by side.

pub(crate) mod cmif;
pub(crate) mod compare;
pub(crate) mod complexity;
mod limits;
pub(crate) mod mac;
pub(crate) mod reciprocity;
