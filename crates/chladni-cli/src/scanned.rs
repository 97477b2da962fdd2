//! A simulated field as a scanner would measure it.

use chladni_frf::{Dof, FieldPoint, MeasuredField, Result};
use chladni_plate::add_white_noise;
use ndarray::Array3;
use num_complex::Complex64;

/// White noise of a scanner.
#[derive(Debug, Clone, Copy)]
pub struct ScannerNoise {
    /// Rms of the field over rms of the noise, dB; infinite without noise.
    pub snr_db: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// The field that a scanner measures while weights are played.
///
/// * `velocities`: velocity of each response, m/s
/// * `weights_sha256`: checksum of the weights file
///
/// # Errors
/// A signal-to-noise ratio that is not a number.
pub fn scanned(
    velocities: &[(Dof, Complex64)],
    frequency_hz: f64,
    weights_sha256: String,
    noise: ScannerNoise,
) -> Result<MeasuredField> {
    let mut values = Array3::from_shape_fn((velocities.len(), 1, 1), |(i, ..)| velocities[i].1);
    let variance = add_white_noise(&mut values, noise.snr_db, noise.seed)?;
    let point = |((response, _), &velocity_m_per_s): (&(Dof, Complex64), &Complex64)| FieldPoint {
        response: *response,
        velocity_m_per_s,
        std_m_per_s: (variance > 0.0).then(|| variance.sqrt()),
        repeats: 1,
    };
    Ok(MeasuredField {
        frequency_hz,
        weights_sha256: Some(weights_sha256),
        magnitudes_only: false,
        points: velocities.iter().zip(&values).map(point).collect(),
    })
}
