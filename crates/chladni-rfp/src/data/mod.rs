//! Enters: FRFs and options; leaves: sketches, products, and numbers of each FRF.

pub(crate) mod columns;
pub(crate) mod error;
pub(crate) mod fourth_difference;
pub(crate) mod given_noise;
pub(crate) mod grade;
mod incomplete;
pub(crate) mod information;
pub(crate) mod inner_products;
pub(crate) mod layout;
mod limits;
pub(crate) mod line_variance;
pub(crate) mod memory;
pub(crate) mod noise_levels;
pub(crate) mod noise_weights;
pub(crate) mod noisy_frfs;
pub(crate) mod onset;
pub(crate) mod options;
pub(crate) mod outliers;
pub(crate) mod pair_weights;
pub(crate) mod peaks;
pub(crate) mod products;
pub(crate) mod reading;
pub(crate) mod screening;
pub(crate) mod sketch;
pub(crate) mod source;
pub(crate) mod watch;
pub(crate) mod window;
