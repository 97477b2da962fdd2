//! FRFs estimated from simulated records: against the structure behind them, and against
//! the simulation's own H1.

use chladni_frf::{BlockWindow, Estimator, ModalModel, Mode};
use chladni_plate::{Excitation, TimeTest};
use chladni_signal::{estimate, Estimate, EstimateOptions};
use num_complex::Complex64;
use std::f64::consts::TAU;

fn test(excitation: Excitation, window: BlockWindow, snr_db: f64) -> TimeTest {
    TimeTest {
        natural_frequency_hz: vec![40.0, 95.0, 140.0],
        damping_ratio: vec![0.02, 0.01, 0.015],
        responses: 3,
        sample_rate_hz: 1024.0,
        record_s: 4.0,
        padding: 1,
        band_hz: [10.0, 200.0],
        averages: 12,
        excitation,
        window,
        snr_db,
        seed: 7,
    }
}

fn estimated(test: &TimeTest, window: BlockWindow, estimator: Estimator) -> Estimate {
    let options = EstimateOptions {
        estimator: Some(estimator),
        window: Some(window),
        overlap: Some(0.0),
        ..EstimateOptions::default()
    };
    estimate(&test.runs().unwrap(), &options).unwrap()
}

#[test]
fn two_ways_to_h1_agree() {
    let hammer = Excitation::Hammer { contact_s: 0.002 };
    for (excitation, window) in [
        (hammer, BlockWindow::Rectangular),
        (hammer, BlockWindow::Exponential { rate_per_s: 3.0 }),
        (Excitation::Random, BlockWindow::Hann),
    ] {
        let test = test(excitation, window, 50.0);
        let reference = test.build().unwrap().frf;
        let result = estimated(&test, window, Estimator::H1);
        assert_eq!(result.estimation.averages, [12, 12]);
        let largest = reference
            .values
            .frf(0, 0)
            .iter()
            .map(|v| v.norm())
            .fold(0.0, f64::max);
        let first = result
            .frf
            .frequency_hz
            .iter()
            .position(|f| (f - reference.frequency_hz[0]).abs() < 1e-9)
            .unwrap();
        for (k, f) in reference.frequency_hz.iter().enumerate() {
            assert!((result.frf.frequency_hz[first + k] - f).abs() < 1e-9);
            for i in 0..3 {
                let (a, b) = (
                    result.frf.values.get(i, 0, first + k),
                    reference.values.get(i, 0, k),
                );
                assert!(
                    (a - b).norm() < 1e-9 * largest,
                    "{excitation:?} {f} Hz: {a} {b}"
                );
            }
        }
    }
}

/// The response of the sampled structure: between samples the force is a straight line
/// (theory.md, eq. 25), so that each pole gives s·r·(I₀ − I₁ + I₁z)/(z − E) with z =
/// e^{jωΔ}, and its conjugate the same.
fn sampled(
    truth: &ModalModel,
    sample_rate_hz: f64,
    frequency_hz: f64,
    response: usize,
) -> Complex64 {
    let dt = 1.0 / sample_rate_hz;
    let z = Complex64::from_polar(1.0, TAU * frequency_hz * dt);
    let of = |pole: Complex64, residue: Complex64| {
        let e = (pole * dt).exp();
        let (i0, i1) = ((e - 1.0) / pole, (e - 1.0 - pole * dt) / (pole * pole * dt));
        pole * residue * (i0 - i1 + i1 * z) / (z - e)
    };
    let mode = |mode: &Mode| {
        let pole = mode.viscous_pole();
        let residue =
            mode.shape.0[response] * mode.participation.0[0] / Complex64::new(0.0, 2.0 * pole.im);
        of(pole, residue) + of(pole.conj(), residue.conj())
    };
    truth.modes.iter().map(mode).sum()
}

#[test]
fn a_hammer_test_shows_the_structure_within_its_own_error_bars() {
    // the slowest mode decays by e^{-20} in a record: nothing leaks
    let test = test(
        Excitation::Hammer { contact_s: 0.002 },
        BlockWindow::Rectangular,
        40.0,
    );
    let truth = test.build().unwrap().truth;
    let result = estimated(&test, BlockWindow::Rectangular, Estimator::H1);
    let (mut squares, mut count) = (0.0, 0.0);
    for (k, &f) in result
        .frf
        .frequency_hz
        .iter()
        .enumerate()
        .filter(|(_, f)| (20.0..180.0).contains(*f))
    {
        for i in 0..3 {
            let error = result.frf.values.get(i, 0, k) - sampled(&truth, test.sample_rate_hz, f, i);
            squares += error.norm_sqr() / result.frf.variance.as_ref().unwrap()[[i, 0, k]];
            count += 1.0;
        }
    }
    // errors over their bars, squared: their mean is (n − 1)/(n − 2) = 1.1 for the 12
    // blows, and scatters by some 0.04 over these lines
    let ratio = squares / count;
    assert!((0.9..1.3).contains(&ratio), "{ratio} over {count} values");
}
