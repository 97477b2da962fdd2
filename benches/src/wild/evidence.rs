//! Evidence of one mode in a measurement: what a fit without it would leave.

use super::measurement::Measurement;
use crate::mode_columns::{columns_of_unit_length, residue_factor};
use chladni_frf::Mode;
use chladni_linalg::{matmul, matmul_h, qr_thin};
use ndarray::{Array1, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Powers of ω that stand for the world outside.
const POWERS: [i32; 4] = [-2, 0, 2, 4];
/// Modes farther away than this many bandwidths cannot take over any of it.
const NEAR_BANDWIDTHS: f64 = 30.0;
/// The part that a mode must take out of the residual of M FRFs, in units of their noise
/// beyond M: that of (8) of theory.md, twice, so that chance does not decide what is
/// hidden.
const CERTAINTY: f64 = 2.0;

/// Energy of the mode `k` of the truth that neither its neighbours, with their poles free
/// to move, nor residual terms can take over, over what a fit needs to see of it. Below 1
/// the data do not show the mode.
pub(super) fn evidence(measured: &Measurement, k: usize) -> f64 {
    let Measurement {
        frf,
        truth,
        noise_variance,
        tones,
    } = measured;
    let omega: Vec<f64> = frf.frequency_hz.iter().map(|f| TAU * f).collect();
    let kind = |w: f64| truth.frf_kind.from_receptance(w);
    let factor = |mode: &Mode| -> Vec<Complex64> {
        omega
            .iter()
            .map(|&w| residue_factor(mode, truth.damping, w))
            .collect()
    };
    let column = |values: &dyn Fn(usize) -> Complex64| -> Array1<Complex64> {
        (0..omega.len())
            .map(|l| kind(omega[l]) * values(l))
            .collect()
    };
    let wanted = &truth.modes[k];
    let near = |mode: &Mode| {
        let distance_hz = (mode.frequency_hz - wanted.frequency_hz).abs();
        distance_hz < NEAR_BANDWIDTHS * wanted.loss_factor * wanted.frequency_hz
    };
    let mut columns = Vec::new();
    for (n, other) in truth.modes.iter().enumerate() {
        if n != k && near(other) {
            let own = factor(other);
            columns.push(column(&|l| own[l]));
            columns.push(column(&|l| own[l] * own[l]));
        }
    }
    let top = omega.last().copied().unwrap_or(1.0);
    columns.extend(POWERS.map(|power| column(&|l| (omega[l] / top).powi(power).into())));
    let own = factor(wanted);
    let own = column(&|l| own[l]).insert_axis(Axis(1));
    let Ok((q, _)) = qr_thin(columns_of_unit_length(&columns).view()) else {
        return f64::NAN;
    };
    let left = &own - &matmul(q.view(), matmul_h(q.view(), own.view()).view());
    let left: f64 = left.iter().map(|v| v.norm_sqr()).sum();
    let references = truth.references.len();
    let signal: f64 = noise_variance
        .iter()
        .enumerate()
        .map(|(pair, variance)| {
            let (i, j) = (pair / references, pair % references);
            (wanted.shape.0[i] * wanted.participation.0[j]).norm_sqr() / (variance * (1.0 + tones))
        })
        .sum();
    let frfs = noise_variance.len() as f64;
    let looks = (4.0 * omega.len() as f64).ln();
    left * signal / (CERTAINTY * 1.5 * (2.0 * (frfs * looks).sqrt() + 2.0 * looks))
}
