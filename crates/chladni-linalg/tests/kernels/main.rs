//! The kernels of either flavour, against identities.

mod nist;
mod scaled_residuals;
