//! A simulated field as a scanner would tell it.

use chladni_frf::{Dof, FieldPoint, MeasuredField, Result};
use chladni_plate::add_white_noise;
use ndarray::Array3;
use num_complex::Complex64;

/// The field of weights with white noise.
///
/// * `velocities`: of each response, m/s
/// * `weights_sha256`: of the file of the weights
///
/// # Errors
/// A noise level that is none.
pub fn scanned(
    velocities: &[(Dof, Complex64)],
    frequency_hz: f64,
    weights_sha256: String,
    (snr_db, seed): (f64, u64),
) -> Result<MeasuredField> {
    let mut values = Array3::from_shape_fn((velocities.len(), 1, 1), |(i, ..)| velocities[i].1);
    let variance = add_white_noise(&mut values, snr_db, seed)?;
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
