//! Enters: columns and a damping law; leaves: refined poles, their covariance, and whether
//! the residual is white.

pub(crate) mod by_hand;
pub(crate) mod chain;
pub(crate) mod delay_alone;
pub(crate) mod descent;
pub(crate) mod estimate;
pub(crate) mod first_look;
pub(crate) mod limits;
pub(crate) mod noise_variance;
pub(crate) mod normal;
pub(crate) mod passes;
pub(crate) mod pole;
pub(crate) mod pool;
pub(crate) mod prune;
pub(crate) mod rank;
pub(crate) mod refine;
pub(crate) mod removal;
pub(crate) mod scan;
pub(crate) mod sections;
pub(crate) mod settle;
pub(crate) mod significance;
pub(crate) mod sketched;
pub(crate) mod start;
pub(crate) mod whiteness;
pub(crate) mod zeros;
