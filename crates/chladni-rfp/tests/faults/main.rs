//! Faults of the data, made with known truth: each is cured, or named with its evidence.

mod channels;
mod kinds;
mod lines;
mod windows;

use chladni_frf::{FrfSet, FrfValues, ModalModel, Mode, Trust};
use chladni_plate::Synthetic;
use chladni_rfp::{fit, FitOptions};
use ndarray::{Array1, Array3};
use num_complex::Complex64;

/// Eight separate modes, six responses, two references that are responses too.
fn easy(snr_db: f64, seed: u64) -> Synthetic {
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

fn fitted(frf: &FrfSet) -> ModalModel {
    fitted_with(frf, &FitOptions::default())
}

fn fitted_with(frf: &FrfSet, options: &FitOptions) -> ModalModel {
    fit(frf, options, &|_| {}).expect("a fit").model
}

/// The values of a set, to be spoilt.
fn values(frf: &mut FrfSet) -> &mut Array3<Complex64> {
    match &mut frf.values {
        FrfValues::F64(values) => values,
        FrfValues::F32(_) => panic!("synthetic sets are in double precision"),
    }
}

/// Spoils each value by (response, reference, frequency in Hz, value).
fn spoil(frf: &mut FrfSet, change: impl Fn(usize, usize, f64, Complex64) -> Complex64) {
    let axis = frf.frequency_hz.clone();
    for ((i, j, k), value) in values(frf).indexed_iter_mut() {
        *value = change(i, j, axis[k], *value);
    }
}

/// True modes that no mode matches within a bandwidth, modes that match no true one, and how many of these are `sure`.
fn missed_spurious_false(truth: &ModalModel, model: &ModalModel) -> (usize, usize, usize) {
    let near = |a: &Mode, b: &Mode| (a.frequency_hz - b.frequency_hz).abs() < 0.5 * b.frequency_hz * b.loss_factor;
    let missed = truth.in_band_modes().filter(|t| !model.in_band_modes().any(|m| near(m, t))).count();
    let spurious: Vec<&Mode> = model.in_band_modes().filter(|m| !truth.in_band_modes().any(|t| near(m, t))).collect();
    (missed, spurious.len(), spurious.iter().filter(|m| m.trust == Trust::Sure).count())
}

/// Largest relative frequency error over all true modes.
fn worst_frequency(truth: &ModalModel, model: &ModalModel) -> f64 {
    let nearest = |f: f64| model.in_band_modes().map(|m| (m.frequency_hz / f - 1.0).abs()).fold(f64::MAX, f64::min);
    truth.in_band_modes().map(|t| nearest(t.frequency_hz)).fold(0.0, f64::max)
}

fn says(model: &ModalModel, words: &str) -> bool {
    model.quality.warnings.iter().any(|warning| warning.contains(words))
}
