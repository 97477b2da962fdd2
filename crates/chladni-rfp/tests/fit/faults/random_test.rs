//! A random test: records cut out of the motion under white force, windowed, averaged.

use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_linalg::fft;
use chladni_rfp::Window;
use ndarray::Array3;
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Samples of a record, and their rate: lines every 0.5 Hz up to 256 Hz.
pub(super) const RECORD: usize = 1024;

pub(super) const RATE_HZ: f64 = 512.0;

/// Averages; the leakage error of the mean falls with their root.
pub(super) const RECORDS: usize = 1500;

/// (Hz, ζ): 2.4, 3.3, 5.1 and 9.2 lines per bandwidth.
pub(super) const MODES: [(f64, f64); 4] = [
    (60.0, 0.01),
    (110.0, 0.0075),
    (170.0, 0.0075),
    (230.0, 0.01),
];

pub(super) const RESPONSES: usize = 3;

pub(super) fn pole((frequency_hz, zeta): (f64, f64)) -> Complex64 {
    TAU * frequency_hz * Complex64::new(-zeta, (1.0 - zeta * zeta).sqrt())
}

/// H1 of three velocities under white random force: the structure runs on, records are
/// cut out of it and windowed. The force acts during the first `acting` of each record
/// (1: all the time).
pub(super) fn random_test(window: Window, acting: f64, seed: u64) -> FrfSet {
    random_test_of(&MODES, &taper(window), acting, seed)
}

/// Values of a window on a record.
pub(super) fn taper(window: Window) -> Vec<f64> {
    let cosines = |c: &[f64], m: usize| -> f64 {
        let turn = TAU * m as f64 / RECORD as f64;
        c.iter()
            .enumerate()
            .map(|(n, c)| c * (n as f64 * turn).cos())
            .sum()
    };
    let value = |m: usize| match window {
        Window::Hann => cosines(&[0.5, -0.5], m),
        Window::Hamming => cosines(&[0.54, -0.46], m),
        Window::Blackman => cosines(&[0.42, -0.5, 0.08], m),
        Window::Flattop => cosines(&[1.0, -1.933, 1.286, -0.388, 0.028], m),
        Window::Kaiser { beta } => {
            // I₀ by its integral
            let x = beta * (1.0 - (2.0 * m as f64 / RECORD as f64 - 1.0).powi(2)).sqrt();
            (0..400)
                .map(|k| (x * (TAU * f64::from(k) / 400.0).cos()).exp())
                .sum()
        }
        _ => 1.0,
    };
    (0..RECORD).map(value).collect()
}

/// The same of any modes and window.
pub(super) fn random_test_of(
    modes: &[(f64, f64)],
    taper: &[f64],
    acting: f64,
    seed: u64,
) -> FrfSet {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut gauss = || -> f64 { (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0 };
    let shapes = [
        [1.0, 0.8, -0.7, 0.9],
        [0.6, -1.0, 0.5, 0.7],
        [-0.8, 0.3, 1.0, -0.5],
    ];
    let step: Vec<Complex64> = modes.iter().map(|&m| (pole(m) / RATE_HZ).exp()).collect();
    let fft = fft::forward(RECORD);
    let lines = RECORD / 2 + 1;
    let mut state = vec![Complex64::default(); modes.len()];
    let (mut cross, mut force) = (
        vec![vec![Complex64::default(); lines]; RESPONSES],
        vec![0.0; lines],
    );
    for record in 0..RECORDS + 4 {
        let mut channels = vec![vec![Complex64::default(); RECORD]; RESPONSES + 1];
        for m in 0..RECORD {
            let x = if m as f64 <= acting * RECORD as f64 {
                gauss()
            } else {
                0.0
            };
            channels[RESPONSES][m] = Complex64::new(x * taper[m], 0.0);
            state
                .iter_mut()
                .zip(&step)
                .for_each(|(z, step)| *z = *z * step + x);
            for (i, shape) in shapes.iter().enumerate() {
                let y: f64 = state
                    .iter()
                    .zip(shape)
                    .zip(&shapes[0])
                    .map(|((z, a), b)| a * b * z.re)
                    .sum();
                channels[i][m] = Complex64::new(y * taper[m], 0.0);
            }
        }
        if record < 4 {
            continue; // the structure is not yet in its stationary state
        }
        channels.iter_mut().for_each(|channel| fft.process(channel));
        for k in 0..lines {
            force[k] += channels[RESPONSES][k].norm_sqr();
            (0..RESPONSES)
                .for_each(|i| cross[i][k] += channels[i][k] * channels[RESPONSES][k].conj());
        }
    }
    FrfSet {
        frequency_hz: (0..lines)
            .map(|k| k as f64 * RATE_HZ / RECORD as f64)
            .collect(),
        values: FrfValues::F64(Array3::from_shape_fn((RESPONSES, 1, lines), |(i, _, k)| {
            cross[i][k] / (force[k] * RATE_HZ)
        })),
        responses: (1..=RESPONSES)
            .map(|node| format!("{node}:+Z").parse().unwrap())
            .collect(),
        references: vec!["1:+Z".parse().unwrap()],
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: Geometry::default(),
    }
}
