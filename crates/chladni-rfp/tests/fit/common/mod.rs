//! The set that most tests start from, and how a model is held against its truth.

#![allow(dead_code)] // every test file uses its own part

use chladni_frf::{FrfSet, ModalModel, Mode};
use chladni_plate::Synthetic;
use chladni_rfp::{fit, FitOptions};
use ndarray::Array1;

/// Eight separate modes, six responses, two references that are responses too.
pub fn easy(snr_db: f64, seed: u64) -> Synthetic {
    Synthetic {
        natural_frequency_hz: vec![31.0, 52.0, 78.0, 101.0, 133.0, 160.0, 187.0, 215.0],
        loss_factor: vec![0.01, 0.012, 0.008, 0.01, 0.015, 0.01, 0.009, 0.011],
        responses: 6,
        references: 2,
        frequency_hz: Array1::range(20.0, 240.0, 0.1),
        snr_db,
        seed,
        ..Synthetic::default()
    }
}

pub fn fitted(frf: &FrfSet, options: &FitOptions) -> ModalModel {
    fit(frf, options).expect("a fit").model
}

/// True modes that no mode of the model matches within half a bandwidth, and modes of the
/// model that match no true one.
pub fn missed_and_spurious<'a>(
    truth: &'a ModalModel,
    model: &'a ModalModel,
) -> (Vec<&'a Mode>, Vec<&'a Mode>) {
    let near = |a: &Mode, b: &Mode| {
        (a.frequency_hz - b.frequency_hz).abs() < 0.5 * b.frequency_hz * b.loss_factor
    };
    let missed = truth
        .in_band_modes()
        .filter(|t| !model.in_band_modes().any(|m| near(m, t)))
        .collect();
    let spurious = model
        .in_band_modes()
        .filter(|m| !truth.in_band_modes().any(|t| near(m, t)))
        .collect();
    (missed, spurious)
}

/// Rms of the data less what the model alone synthesises, over rms data.
pub fn resynthesis_error(model: &ModalModel, frf: &FrfSet) -> f64 {
    let (mut error, mut total) = (0.0, 0.0);
    for ((i, j, k), value) in model.synthesise(&frf.frequency_hz).indexed_iter() {
        error += (value - frf.values.get(i, j, k)).norm_sqr();
        total += frf.values.get(i, j, k).norm_sqr();
    }
    (error / total).sqrt()
}
