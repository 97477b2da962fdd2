//! The spatio-temporal inverse filter (Pantera and Hudin, 2018): the drive whose field is
//! a given one at every frequency, by regularised least squares, frequency by frequency.
//!
//! Its target here is the field of the steady drive, under a raised-cosine burst. It knows
//! no cause and effect: the force begins before the burst.

use chladni_frf::{FrfKind, ModalModel};
use chladni_linalg::{cholesky, matmul_h, solve_lower, solve_lower_adjoint, svd_thin, LinalgError};
use chladni_render::{Recorded, Weights};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Samples per second of the drive.
const RATE_HZ: f64 = 8000.0;
/// Length of the record, s.
const RECORD_S: f64 = 0.75;
/// Half of the band about the carrier that the burst is made of, Hz.
const HALF_BAND_HZ: f64 = 260.0;
/// Ridge over the largest singular value: the study's best.
const RIDGE: f64 = 1e-3;

/// A raised-cosine burst.
pub(super) struct Burst {
    pub(super) start_s: f64,
    pub(super) duration_s: f64,
    pub(super) ramp_s: f64,
}

impl Burst {
    fn at(&self, time_s: f64) -> f64 {
        let within = time_s - self.start_s;
        let to_end = within.min(self.duration_s - within);
        match to_end {
            t if t <= 0.0 => 0.0,
            t if t < self.ramp_s => 0.5 - 0.5 * (PI * t / self.ramp_s).cos(),
            _ => 1.0,
        }
    }
}

/// The drive.
pub(super) fn drive(
    model: &ModalModel,
    steady: &Weights,
    burst: &Burst,
) -> Result<Recorded, LinalgError> {
    let carrier_hz = steady.frequency_hz;
    let weights: Array1<Complex64> = steady.weights.iter().map(|weight| weight.value()).collect();
    let target = model
        .frf_matrix(FrfKind::Mobility, carrier_hz)
        .dot(&weights);
    let frames = (RECORD_S * RATE_HZ) as usize;
    let lines = (HALF_BAND_HZ * RECORD_S) as i64;
    let mut envelope = Array2::<Complex64>::zeros((frames, weights.len()));
    for line in -lines..=lines {
        let offset_hz = line as f64 / RECORD_S;
        let part: Complex64 = (0..frames)
            .map(|k| {
                let time_s = k as f64 / RATE_HZ;
                burst.at(time_s)
                    * Complex64::from_polar(1.0 / frames as f64, -TAU * offset_hz * time_s)
            })
            .sum();
        let mobility = model.frf_matrix(FrfKind::Mobility, carrier_hz + offset_hz);
        let force = inverted(&mobility, &target.mapv(|value| value * part))?;
        for (k, mut row) in envelope.rows_mut().into_iter().enumerate() {
            let time_s = k as f64 / RATE_HZ;
            row.scaled_add(Complex64::from_polar(1.0, TAU * offset_hz * time_s), &force);
        }
    }
    let drive = Array2::from_shape_fn(envelope.dim(), |(k, j)| {
        let turn = Complex64::from_polar(1.0, TAU * carrier_hz * k as f64 / RATE_HZ);
        (envelope[[k, j]] * turn).re
    });
    Ok(Recorded {
        rate_hz: RATE_HZ,
        references: model.references.clone(),
        drive,
    })
}

/// The same without what comes before `start_s`.
pub(super) fn cut(mut recorded: Recorded, start_s: f64) -> Recorded {
    let first = (start_s * recorded.rate_hz) as usize;
    for mut row in recorded.drive.rows_mut().into_iter().take(first) {
        row.fill(0.0);
    }
    recorded
}

/// (HᴴH + ε²)⁻¹Hᴴv.
fn inverted(
    mobility: &Array2<Complex64>,
    target: &Array1<Complex64>,
) -> Result<Array1<Complex64>, LinalgError> {
    let (_, singular, _) = svd_thin(mobility.view())?;
    let ridge = (RIDGE * singular[0]).powi(2);
    let mut gram = matmul_h(mobility.view(), mobility.view());
    gram.diag_mut().mapv_inplace(|value| value + ridge);
    let lower = cholesky(gram.view())?;
    let right = matmul_h(mobility.view(), target.view().insert_axis(Axis(1)));
    let half = solve_lower(lower.view(), right.view())?;
    Ok(solve_lower_adjoint(lower.view(), half.view())?
        .column(0)
        .to_owned())
}
