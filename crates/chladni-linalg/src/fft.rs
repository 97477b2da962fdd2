//! Fourier transforms of any length, not scaled.
//!
//! Planned here alone: rustfft's planner is generic, and a crate that calls it compiles
//! every algorithm again.

pub use rustfft::Fft;
use rustfft::FftPlanner;
use std::sync::Arc;

/// Σ_n x_n·e^(−j2πkn/length) for every k, in place.
///
/// ```
/// use num_complex::Complex64;
///
/// let mut values = [1.0, 2.0].map(Complex64::from);
/// chladni_linalg::fft::forward(2).process(&mut values);
/// assert_eq!(values, [3.0, -1.0].map(Complex64::from));
/// ```
pub fn forward(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(length)
}

/// Σ_k X_k·e^(j2πkn/length) for every n, in place: `length` times the inverse of [`forward`].
pub fn inverse(length: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_inverse(length)
}
