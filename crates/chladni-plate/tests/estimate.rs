//! FRFs estimated from simulated records: against the structure behind them, and against the simulation's own H1.

use chladni_frf::estimate::{estimate, BlockWindow, Estimate, EstimateOptions, Estimator};
use chladni_plate::{Excitation, TimeTest, Window};
use num_complex::Complex64;

fn test(excitation: Excitation, window: Window, snr_db: f64) -> TimeTest {
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
    let options = EstimateOptions { estimator, window: Some(window), overlap: Some(0.0), ..EstimateOptions::default() };
    estimate(&test.runs().unwrap(), &options).unwrap()
}

#[test]
fn two_ways_to_h1_agree() {
    for (excitation, window, block_window) in [
        (Excitation::Hammer { contact_s: 0.002 }, Window::Rectangular, BlockWindow::Rectangular),
        (Excitation::Hammer { contact_s: 0.002 }, Window::Exponential { rate_per_s: 3.0 }, BlockWindow::Exponential { rate_per_s: 3.0 }),
        (Excitation::Random, Window::Hann, BlockWindow::Hann),
    ] {
        let test = test(excitation, window, 50.0);
        let reference = test.build().unwrap().frf;
        let result = estimated(&test, block_window, Estimator::H1);
        assert_eq!(result.averages, [12, 12]);
        let largest = reference.values.frf(0, 0).iter().map(|v| v.norm()).fold(0.0, f64::max);
        let first = result.frf.frequency_hz.iter().position(|f| (f - reference.frequency_hz[0]).abs() < 1e-9).unwrap();
        for (k, f) in reference.frequency_hz.iter().enumerate() {
            assert!((result.frf.frequency_hz[first + k] - f).abs() < 1e-9);
            for i in 0..3 {
                let (a, b) = (result.frf.values.get(i, 0, first + k), reference.values.get(i, 0, k));
                assert!((a - b).norm() < 1e-9 * largest, "{excitation:?} {f} Hz: {a} {b}");
            }
        }
    }
}

#[test]
fn a_hammer_test_shows_the_structure_within_its_own_error_bars() {
    // the slowest mode decays by e^{-20} in a record: nothing leaks
    let test = test(Excitation::Hammer { contact_s: 0.002 }, Window::Rectangular, 40.0);
    let truth = test.build().unwrap().truth;
    for estimator in [Estimator::H1, Estimator::Hv] {
        let result = estimated(&test, BlockWindow::Rectangular, estimator);
        let in_band: Vec<usize> =
            (0..result.frf.frequency_hz.len()).filter(|&k| (20.0..180.0).contains(&result.frf.frequency_hz[k])).collect();
        let (mut squares, mut said, mut count) = (0.0, 0.0, 0.0);
        for &k in &in_band {
            let exact = truth.frf_matrix(chladni_frf::FrfKind::Mobility, result.frf.frequency_hz[k]);
            for i in 0..3 {
                let error: Complex64 = result.frf.values.get(i, 0, k) - exact[[i, 0]];
                squares += error.norm_sqr() / result.variance[[i, 0, k]];
                said += f64::from(result.frf.coherence.as_ref().unwrap()[[i, 0, k]]);
                count += 1.0;
            }
        }
        // errors over their bars, squared: their mean is n/(n-2) = 1.1 with the 11 degrees of freedom of 12 blows, and scatters by
        // some 0.04 over these lines. Hv, which gives part of the noise to the force, is near.
        let ratio = squares / count;
        assert!((0.8..1.5).contains(&ratio), "{estimator:?}: {ratio}");
        assert!(said / count > 0.9);
    }
}
