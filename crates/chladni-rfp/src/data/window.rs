//! The window's bias, undone where the window is known and named where it is not.
//!
//! An FRF estimated from continuous random excitation in windowed records of length T is,
//! in the mean, not the transform of h(t) but of h(t)·ρ(t), ρ the autocorrelation of the
//! window: every line is broadened, and damping comes out too high by about 1/(πb), b
//! lines per half-power bandwidth. No residual shows it. The inverse transform, divided
//! by ρ up to T/2 and cut there, gives h(t) itself; on every second line the cut record
//! is exactly a sum of modes again.
//!
//! Theory.md, eq. F4; J. Bendat, A. Piersol, Random Data, 4th ed. (2010), chapter 11. For
//! the exponential window see `model/exponential.rs`.

use crate::data::error::FitError;
use crate::data::limits;
use crate::data::options::Window;
use chladni_frf::{FrfSet, FrfValues};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;

/// The FRFs that records without a window would have given, in the mean, on every second
/// line; `None` for [`Window::None`].
///
/// # Errors
/// [`FitError::WindowAxis`]: the axis is not even, does not begin at 0 Hz or one line
/// above it, or a measured FRF has gaps.
pub(crate) fn undo(frf: &FrfSet, window: Window) -> Result<Option<FrfSet>, FitError> {
    if window == Window::None {
        return Ok(None);
    }
    let axis = &frf.frequency_hz;
    let (responses, references, lines) = frf.values.dim();
    let step = (axis[lines.max(1) - 1] - axis[0]) / (lines.max(2) - 1) as f64;
    let missing = (axis[0] / step).round() as usize; // lines below the first
    let off = axis
        .iter()
        .enumerate()
        .any(|(k, f)| (f - (k + missing) as f64 * step).abs() > limits::EVEN * step);
    if lines < 16 || missing > 1 || off {
        return Err(FitError::WindowAxis {
            found: format!(
                "{lines} lines from {} to {} Hz",
                axis[0],
                axis[lines.max(1) - 1]
            ),
        });
    }
    let half = lines - 1 + missing; // samples up to T/2
    let mut planner = FftPlanner::new();
    let (back, forth) = (
        planner.plan_fft_inverse(2 * half),
        planner.plan_fft_forward(half),
    );
    let single = |i: usize, j: usize| -> Result<Vec<Complex64>, FitError> {
        let mut spectrum = vec![Complex64::default(); 2 * half];
        for k in 1..=half {
            let value = frf.values.get(i, j, k - missing);
            spectrum[2 * half - k] = value.conj();
            spectrum[k] = value;
        }
        // the lowest line is garbage in many files (coupled through a capacitor); the
        // highest has no imaginary part
        spectrum[0] = Complex64::new(spectrum[1].re, 0.0);
        spectrum[half] = Complex64::new(spectrum[half].re, 0.0);
        let gaps = spectrum.iter().filter(|v| !v.is_finite()).count();
        if gaps >= 2 * half - 2 {
            return Ok(vec![Complex64::new(f64::NAN, f64::NAN); half / 2 + 1]); // not measured
        }
        if gaps > 0 {
            return Err(FitError::WindowAxis {
                found: format!("an FRF without a value on {} lines", gaps.div_ceil(2)),
            });
        }
        back.process(&mut spectrum);
        let samples = 2.0 * half as f64;
        let mut response: Vec<Complex64> = (0..half)
            .map(|m| {
                Complex64::new(
                    spectrum[m].re / (samples * window.autocorrelation(m as f64 / samples)),
                    0.0,
                )
            })
            .collect();
        forth.process(&mut response);
        response.truncate(half / 2 + 1);
        Ok(response)
    };
    let kept = half / 2 + 1;
    let rows: Vec<Result<Vec<Complex64>, FitError>> = (0..responses * references)
        .into_par_iter()
        .map(|l| single(l / references, l % references))
        .collect();
    let mut values = Array3::zeros((responses, references, kept));
    for (l, row) in rows.into_iter().enumerate() {
        values
            .slice_mut(ndarray::s![l / references, l % references, ..])
            .assign(&Array1::from(row?));
    }
    let frequency_hz = (0..kept).map(|k| 2.0 * k as f64 * step).collect();
    Ok(Some(FrfSet {
        frequency_hz,
        values: FrfValues::F64(values),
        responses: frf.responses.clone(),
        references: frf.references.clone(),
        kind: frf.kind,
        reference_unit: frf.reference_unit,
        coherence: None,
        variance: None,
        estimation: frf.estimation,
        geometry: frf.geometry.clone(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn autocorrelations_are_those_of_the_windows() {
        let n = 20_000;
        for window in [Window::Rectangular, Window::Hann] {
            let value = |u: f64| {
                if window == Window::Hann {
                    0.5 - 0.5 * (TAU * u).cos()
                } else {
                    1.0
                }
            };
            let sum = |lag: f64| {
                (0..n)
                    .map(|k| (k as f64 + 0.5) / n as f64)
                    .filter(|u| u + lag < 1.0)
                    .map(|u| value(u) * value(u + lag))
                    .sum::<f64>()
            };
            for lag in [0.0, 0.1, 0.25, 0.5, 0.9] {
                assert!(
                    (sum(lag) / sum(0.0) - window.autocorrelation(lag)).abs() < 1e-3,
                    "{window} at {lag}"
                );
            }
        }
    }
}
