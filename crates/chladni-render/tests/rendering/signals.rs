//! Drive signals: what is played is what the weights say.

use chladni_frf::ErrorKind;
use chladni_render::{render, signal_csv, wav, Method, RenderOptions, SignalOptions, Weights};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::io::Cursor;

fn weights() -> Weights {
    let options = RenderOptions {
        method: Method::PressureMatching.into(),
        ..Default::default()
    };
    render(
        crate::common::truth(),
        &crate::common::cell_scene([2, 2], 1, ""),
        &options,
    )
    .unwrap()
    .weights
}

#[test]
fn each_channel_carries_the_phasor_of_its_weight() {
    let weights = weights();
    let options = SignalOptions {
        duration_s: 0.3,
        ramp_s: 0.05,
        gains: (0..34).map(|k| 1.0 + 0.1 * k as f64).collect(),
        ..Default::default()
    };
    let bytes = wav(&weights, &options).unwrap();
    let mut reader = hound::WavReader::new(Cursor::new(bytes)).unwrap();
    assert_eq!(
        (
            reader.spec().channels,
            reader.spec().sample_rate,
            reader.spec().bits_per_sample
        ),
        (34, 48_000, 32)
    );
    let samples: Vec<f32> = reader.samples::<f32>().map(Result::unwrap).collect();
    assert_eq!(samples.len(), 14_400 * 34);
    // from 0.1 to 0.2 s are 30 periods of 300 Hz: the demodulated sum is the phasor
    for (k, weight) in weights.weights.iter().enumerate() {
        let phasor: Complex64 = (4800..9600)
            .map(|n| {
                f64::from(samples[34 * n + k])
                    * Complex64::from_polar(2.0 / 4800.0, -TAU * 300.0 * n as f64 / 48_000.0)
            })
            .sum();
        let expected = weight.value() * (1.0 + 0.1 * k as f64);
        assert!(
            (phasor - expected).norm() < 1e-6 * expected.norm(),
            "{}: {phasor} {expected}",
            weight.reference
        );
    }
    assert!(
        samples[..34].iter().all(|&sample| sample == 0.0),
        "no click at the beginning"
    );
}

#[test]
fn the_table_lists_amplitude_and_phase() {
    let (weights, text) = (weights(), signal_csv(&weights()));
    assert_eq!(text.lines().count(), 35);
    let cells: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
    assert_eq!((cells[0], cells[1], cells[4]), ("101:+Z", "300", "N"));
    assert_eq!(
        cells[2].parse::<f64>().unwrap(),
        weights.weights[0].amplitude
    );
}

#[test]
fn signals_that_cannot_be_are_refused() {
    let refused = |options: SignalOptions, field: &str| {
        let error = wav(&weights(), &options).map(|_| ()).unwrap_err();
        assert!(
            error.kind == ErrorKind::Usage && error.field.as_deref() == Some(field),
            "{error}"
        );
    };
    refused(
        SignalOptions {
            sample_rate_hz: 500,
            ..Default::default()
        },
        "sample_rate_hz",
    );
    refused(
        SignalOptions {
            duration_s: 0.0,
            ..Default::default()
        },
        "duration_s",
    );
    refused(
        SignalOptions {
            duration_s: 1e9,
            ..Default::default()
        },
        "duration_s",
    );
    refused(
        SignalOptions {
            burst_s: Some([0.2, 0.1]),
            ..Default::default()
        },
        "burst_s",
    );
    refused(
        SignalOptions {
            gains: vec![1.0; 3],
            ..Default::default()
        },
        "gains",
    );
}
