//! Measurements simulated in time, judged by the modal sum they must come to.

use chladni_frf::{BlockWindow, ModalModel};
use chladni_plate::{Excitation, TimeSet, TimeTest};
use num_complex::Complex64;
use std::f64::consts::TAU;

fn test() -> TimeTest {
    TimeTest {
        natural_frequency_hz: vec![40.0, 90.0],
        damping_ratio: vec![0.02],
        responses: 2,
        sample_rate_hz: 2048.0,
        record_s: 4.0,
        padding: 1,
        band_hz: [10.0, 150.0],
        averages: 1,
        excitation: Excitation::Hammer { contact_s: 0.002 },
        window: BlockWindow::Rectangular,
        snr_db: f64::INFINITY,
        seed: 3,
    }
}

/// Ratio of estimate and truth, with the same law of hold for both: a smooth factor, the
/// same for all modes and responses.
fn worst_ratio(set: &TimeSet, truth: &ModalModel) -> f64 {
    let expected = truth.synthesise(&set.frf.frequency_hz);
    expected
        .indexed_iter()
        .map(|((i, j, k), v)| (set.frf.values.get(i, j, k) / v - 1.0).norm())
        .fold(0.0, f64::max)
}

#[test]
fn a_hammer_blow_that_dies_out_gives_the_modal_sum() {
    // decay over the record: e^{−ζωT} = 2e-9; the hold's images add (f/fs)² of a smooth
    // term
    let set = test().build().unwrap();
    assert!(
        worst_ratio(&set, &set.truth) < 0.02,
        "{}",
        worst_ratio(&set, &set.truth)
    );
    let finer = TimeTest {
        sample_rate_hz: 16384.0,
        ..test()
    }
    .build()
    .unwrap();
    assert!(
        worst_ratio(&finer, &finer.truth) < 1e-3,
        "{}",
        worst_ratio(&finer, &finer.truth)
    );
}

#[test]
fn an_exponential_window_moves_the_poles() {
    let rate_per_s = 1.5;
    let set = TimeTest {
        sample_rate_hz: 16384.0,
        window: BlockWindow::Exponential { rate_per_s },
        ..test()
    }
    .build()
    .unwrap();
    let mut moved = set.truth.clone();
    for mode in &mut moved.modes {
        let omega = TAU * mode.frequency_hz;
        let pole = Complex64::new(
            -mode.damping_ratio * omega - rate_per_s,
            omega * (1.0 - mode.damping_ratio.powi(2)).sqrt(),
        );
        mode.frequency_hz = pole.norm() / TAU;
        mode.damping_ratio = -pole.re / pole.norm();
        mode.loss_factor = 2.0 * mode.damping_ratio;
    }
    // velocity as derivative of a windowed displacement differs by α/ω of a term without
    // poles of its own: 0.6 % at 40 Hz
    assert!(
        worst_ratio(&set, &moved) < 0.05,
        "{}",
        worst_ratio(&set, &moved)
    );
    assert!(
        worst_ratio(&set, &set.truth) > 0.1,
        "the unmoved poles do not explain it"
    );
}

#[test]
fn continuous_noise_leaks_and_averages() {
    let few = TimeTest {
        excitation: Excitation::Random,
        window: BlockWindow::Hann,
        averages: 8,
        ..test()
    }
    .build()
    .unwrap();
    let many = TimeTest {
        excitation: Excitation::Random,
        window: BlockWindow::Hann,
        averages: 128,
        ..test()
    }
    .build()
    .unwrap();
    let rms = |set: &TimeSet| {
        let expected = set.truth.synthesise(&set.frf.frequency_hz);
        let (mut error, mut total) = (0.0, 0.0);
        for ((i, j, k), v) in expected.indexed_iter() {
            error += (set.frf.values.get(i, j, k) - v).norm_sqr();
            total += v.norm_sqr();
        }
        f64::sqrt(error / total)
    };
    // 16 times the averages: a quarter of the random part, and the window's bias stays
    assert!(
        rms(&many) < 0.6 * rms(&few) && rms(&many) > 1e-4,
        "{} {}",
        rms(&few),
        rms(&many)
    );
}
