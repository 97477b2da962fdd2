//! Faults of the data, made with known truth: each is cured, or named with its evidence.

mod channels;
mod common_delay;
mod doubts;
mod exponential;
mod kinds;
mod lines;
mod moved_sides;
mod random_test;
mod windows;

use crate::common::{easy, fitted as fitted_with};
use chladni_frf::{FrfSet, FrfValues, ModalModel, Trust};
use chladni_plate::Synthetic;
use chladni_rfp::{fit, FitOptions};
use ndarray::{Array1, Array3};
use num_complex::Complex64;

fn fitted(frf: &FrfSet) -> ModalModel {
    fitted_with(frf, &FitOptions::default())
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

/// Number of true modes missed, of spurious modes, and of those among these that are
/// `sure`.
fn missed_spurious_false(truth: &ModalModel, model: &ModalModel) -> (usize, usize, usize) {
    let (missed, spurious) = crate::common::missed_and_spurious(truth, model);
    (
        missed.len(),
        spurious.len(),
        spurious.iter().filter(|m| m.trust == Trust::Sure).count(),
    )
}

/// Largest relative frequency error over all true modes.
fn worst_frequency(truth: &ModalModel, model: &ModalModel) -> f64 {
    let nearest = |f: f64| {
        model
            .in_band_modes()
            .map(|m| (m.frequency_hz / f - 1.0).abs())
            .fold(f64::MAX, f64::min)
    };
    truth
        .in_band_modes()
        .map(|t| nearest(t.frequency_hz))
        .fold(0.0, f64::max)
}

fn says(model: &ModalModel, words: &str) -> bool {
    model
        .quality
        .findings
        .iter()
        .any(|warning| warning.contains(words))
}
