//! Windows: their line shape fitted, or their bias named; the exponential window taken off the poles.

use super::*;
use chladni_frf::{
    BlockWindow, Damping, Estimation, Estimator, Forcing, FrfKind, Geometry, Mode, ReferenceUnit,
};
use chladni_rfp::{FitError, Method, Window};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustfft::FftPlanner;
use std::f64::consts::TAU;

/// Samples of a record, and their rate: lines every 0.5 Hz up to 256 Hz.
const RECORD: usize = 1024;
const RATE_HZ: f64 = 512.0;
/// Averages; the leakage error of the mean falls with their root.
const RECORDS: usize = 1500;
/// (Hz, ζ): 2.4, 3.3, 5.1 and 9.2 lines per bandwidth.
const MODES: [(f64, f64); 4] = [
    (60.0, 0.01),
    (110.0, 0.0075),
    (170.0, 0.0075),
    (230.0, 0.01),
];
const RESPONSES: usize = 3;

fn pole((frequency_hz, zeta): (f64, f64)) -> Complex64 {
    TAU * frequency_hz * Complex64::new(-zeta, (1.0 - zeta * zeta).sqrt())
}

/// H1 of three velocities under white random force: the structure runs on, records are
/// cut out of it and windowed. The force acts during the first `acting` of each record
/// (1: all the time).
fn random_test(window: Window, acting: f64, seed: u64) -> FrfSet {
    random_test_of(&MODES, &taper(window), acting, seed)
}

/// Values of a window on a record.
fn taper(window: Window) -> Vec<f64> {
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
fn random_test_of(modes: &[(f64, f64)], taper: &[f64], acting: f64, seed: u64) -> FrfSet {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut gauss = || -> f64 { (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0 };
    let shapes = [
        [1.0, 0.8, -0.7, 0.9],
        [0.6, -1.0, 0.5, 0.7],
        [-0.8, 0.3, 1.0, -0.5],
    ];
    let step: Vec<Complex64> = modes.iter().map(|&m| (pole(m) / RATE_HZ).exp()).collect();
    let fft = FftPlanner::new().plan_fft_forward(RECORD);
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

/// ζ found over ζ true, mode by mode.
fn damping_ratios(model: &ModalModel) -> Vec<f64> {
    damping_ratios_of(&MODES, model)
}

fn damping_ratios_of(modes: &[(f64, f64)], model: &ModalModel) -> Vec<f64> {
    let nearest = |f: f64| {
        let off = |m: &&Mode| (m.frequency_hz - f).abs();
        model
            .in_band_modes()
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .expect("a mode")
    };
    modes
        .iter()
        .map(|&(f, zeta)| nearest(f).damping_ratio / zeta)
        .collect()
}

#[test]
fn the_bias_of_a_known_window_is_gone() {
    for (window, at_least) in [(Window::Rectangular, 1.09), (Window::Hann, 1.09)] {
        let frf = random_test(window, 1.0, 41);
        let options = |window| FitOptions {
            band_hz: Some([20.0, 250.0]),
            window,
            ..FitOptions::default()
        };
        let before = damping_ratios(&fitted_with(&frf, &options(Some(Window::None))));
        assert!(before[0] > at_least, "{window}: {before:?}");
        let unsaid = fitted_with(&frf, &options(None));
        assert_eq!(damping_ratios(&unsaid), before);
        assert!(
            says(&unsaid, "1/(πb)") && says(&unsaid, "which window was used"),
            "{:?}",
            unsaid.quality.findings
        );
        // the lines themselves tell a Hann window, but not their errors, which are noise of
        // no sensor; a rectangular one bends the decay too little to be told at 2.4 lines
        // per bandwidth
        assert_eq!(
            says(&unsaid, "those of a hann window"),
            window == Window::Hann
        );
        let cured = fitted_with(&frf, &options(Some(window)));
        let after = damping_ratios(&cured);
        assert!(
            after.iter().all(|r| (r - 1.0).abs() < 0.04),
            "{window}: {after:?} instead of {before:?}"
        );
        assert!(!says(&cured, "1/(πb)"));
    }
}

#[test]
fn a_burst_has_no_bias() {
    let frf = random_test(Window::Rectangular, 0.5, 46);
    let model = fitted_with(
        &frf,
        &FitOptions {
            band_hz: Some([20.0, 250.0]),
            window: Some(Window::None),
            ..FitOptions::default()
        },
    );
    let ratios = damping_ratios(&model);
    assert!(
        ratios.iter().all(|r| (0.98..1.05).contains(r)),
        "{ratios:?}"
    );
    let known = |f: f64| {
        MODES
            .iter()
            .any(|&(mode, zeta)| (f - mode).abs() < 2.0 * zeta * mode)
    };
    let false_sure: Vec<f64> = model
        .in_band_modes()
        .filter(|m| m.trust == Trust::Sure)
        .map(|m| m.frequency_hz)
        .filter(|&f| !known(f))
        .collect();
    assert!(false_sure.is_empty(), "{false_sure:?}");
    assert!(
        model.quality.trusted && !says(&model, "1/(πb)"),
        "{:?}",
        model.quality
    );
    // nobody said that it was a burst: the lines must not speak of a window
    let unsaid = fitted_with(
        &frf,
        &FitOptions {
            band_hz: Some([20.0, 250.0]),
            ..FitOptions::default()
        },
    );
    assert!(
        !says(&unsaid, "those of a"),
        "{:?}",
        unsaid.quality.findings
    );
}

/// One, 1.5 and two lines per half-power bandwidth.
fn few_lines() -> Vec<(f64, f64)> {
    let step_hz = RATE_HZ / RECORD as f64;
    [(60.0, 1.0), (130.0, 1.5), (210.0, 2.0)]
        .map(|(hz, lines)| (hz, 0.5 * lines * step_hz / hz))
        .to_vec()
}

#[test]
fn few_lines_per_bandwidth_keep_their_damping_under_every_window() {
    let modes = few_lines();
    let burst = Window::Burst { part: 0.9 };
    for (window, acting, least_bias) in [
        (Window::Rectangular, 1.0, 1.3),
        (Window::Hann, 1.0, 1.5),
        (Window::Hamming, 1.0, 1.4),
        (Window::Blackman, 1.0, 1.5),
        (Window::Kaiser { beta: 8.6 }, 1.0, 1.5),
        (burst, 0.9, 1.2),
    ] {
        let frf = random_test_of(&modes, &taper(window), acting, 51);
        let options = |window| FitOptions {
            band_hz: Some([20.0, 250.0]),
            window,
            ..FitOptions::default()
        };
        let plain = options(Some(Window::None));
        let before = damping_ratios_of(&modes, &fitted_with(&frf, &plain));
        assert!(before[0] > least_bias, "{window}: {before:?}");
        for damping in [Damping::Structural, Damping::Viscous] {
            let asked = FitOptions {
                damping: Some(damping),
                ..options(Some(window))
            };
            let model = fitted_with(&frf, &asked);
            let after = damping_ratios_of(&modes, &model);
            assert!(
                after.iter().all(|ratio| (ratio - 1.0).abs() < 0.04),
                "{window} {damping:?}: {after:?} instead of {before:?}, {:?}",
                model.quality
            );
            assert_eq!(
                model.in_band_modes().count(),
                modes.len(),
                "{:?}",
                model.modes
            );
            assert!(says(&model, "line shape"), "{:?}", model.quality.findings);
        }
    }
}

/// Table of docs/accuracy.md: mean of found over true damping of a fit that does not know
/// the window, and of one that does, by lines per bandwidth.
#[test]
#[ignore = "a table, no test"]
fn ratios_of_all_windows() {
    let seeds = std::env::var("CHLADNI_ROUNDS").map_or(2, |text| text.parse().unwrap());
    let step_hz = RATE_HZ / RECORD as f64;
    for window in [
        Window::Rectangular,
        Window::Hann,
        Window::Hamming,
        Window::Blackman,
        Window::Flattop,
        Window::Kaiser { beta: 8.6 },
        Window::Burst { part: 0.9 },
    ] {
        let acting = if let Window::Burst { part } = window {
            part
        } else {
            1.0
        };
        for lines in [1.0, 2.0, 4.0] {
            let modes = [60.0, 130.0, 210.0].map(|hz| (hz, 0.5 * lines * step_hz / hz));
            let mut sums = [Vec::new(), Vec::new()];
            for seed in 0..seeds {
                let frf = random_test_of(&modes, &taper(window), acting, 60 + seed);
                for (known, sum) in [Window::None, window].into_iter().zip(&mut sums) {
                    let options = FitOptions {
                        band_hz: Some([20.0, 250.0]),
                        window: Some(known),
                        ..FitOptions::default()
                    };
                    sum.extend(damping_ratios_of(&modes, &fitted_with(&frf, &options)));
                }
            }
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let worst = |values: &[f64]| values.iter().map(|r| (r - 1.0).abs()).fold(0.0, f64::max);
            println!(
                "{window}, {lines} lines: {:.3} plain, {:.3} known (largest error {:.3})",
                mean(&sums[0]),
                mean(&sums[1]),
                worst(&sums[1])
            );
        }
    }
}

#[test]
fn other_methods_take_the_window_off_too() {
    let modes = few_lines();
    let frf = random_test_of(&modes, &taper(Window::Hann), 1.0, 52);
    for method in [Method::Lean, Method::Lscf, Method::Vf] {
        let options = FitOptions {
            band_hz: Some([20.0, 250.0]),
            window: Some(Window::Hann),
            modes: Some(modes.len()),
            method,
            ..FitOptions::default()
        };
        let model = fitted_with(&frf, &options);
        let after = damping_ratios_of(&modes, &model);
        assert!(
            after.iter().all(|ratio| (ratio - 1.0).abs() < 0.05),
            "{method}: {after:?}"
        );
    }
}

#[test]
fn a_set_says_its_window_itself() {
    let mut frf = random_test(Window::Hann, 1.0, 53);
    let said = FitOptions {
        window: Some(Window::Hann),
        ..FitOptions::default()
    };
    let asked = fitted_with(&frf, &said);
    let record_s = RECORD as f64 / RATE_HZ;
    frf.estimation = Some(Estimation {
        estimator: Estimator::H1,
        window: BlockWindow::Hann,
        forcing: Some(Forcing::Continuous),
        transform_s: record_s,
        gate_s: record_s,
        hop_s: record_s,
        averages: [RECORDS; 2],
        lines_per_value: 1,
    });
    let told = fitted_with(&frf, &FitOptions::default());
    assert_eq!(told.modes, asked.modes);
    // whoever fits may know better
    let none = FitOptions {
        window: Some(Window::None),
        ..FitOptions::default()
    };
    assert!(damping_ratios(&fitted_with(&frf, &none))[0] > 1.09);
    // of a local method nothing is undone, and nothing said
    frf.estimation = frf.estimation.map(|made| Estimation {
        estimator: Estimator::Lrm,
        ..made
    });
    let local = fitted_with(&frf, &FitOptions::default());
    assert_eq!(local.modes, fitted_with(&frf, &none).modes);
    assert!(!says(&local, "1/(πb)"));
}

#[test]
fn a_window_asks_for_even_lines() {
    let options = FitOptions {
        window: Some(Window::Hann),
        ..FitOptions::default()
    };
    let mut set = easy(40.0, 42).build().unwrap(); // begins at 20 Hz
    fitted_with(&set.frf, &options);
    let none = FitOptions {
        window: Some(Window::None),
        ..FitOptions::default()
    };
    assert_eq!(fitted_with(&set.frf, &none).modes, fitted(&set.frf).modes);
    set.frf.frequency_hz[7] += 0.1;
    assert!(matches!(
        fit(&set.frf, &options),
        Err(FitError::WindowAxis { .. })
    ));
}

#[test]
fn an_exponential_window_comes_off_the_pole() {
    let viscous = Synthetic {
        damping: Damping::Viscous,
        ..easy(f64::INFINITY, 43)
    };
    let structural = easy(f64::INFINITY, 43);
    // twice the decay of the lowest mode: its damping is tripled by the window
    let alpha = 2.0;
    for synthetic in [viscous, structural] {
        for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
            let synthetic = Synthetic {
                kind,
                ..synthetic.clone()
            };
            let set = synthetic.build().unwrap();
            let mut windowed = set.frf.clone();
            let measured = values(&mut windowed);
            for (k, f) in set.frf.frequency_hz.iter().enumerate() {
                measured
                    .slice_mut(ndarray::s![.., .., k])
                    .assign(&at(&set.truth, Complex64::new(alpha, TAU * f)));
            }
            chladni_plate::add_white_noise(values(&mut windowed), 60.0, 44).unwrap();
            let options = FitOptions {
                exponential_window_per_s: Some(alpha),
                damping: Some(set.truth.damping),
                ..FitOptions::default()
            };
            let model = fitted_with(&windowed, &options);
            assert_eq!(
                missed_spurious_false(&set.truth, &model),
                (0, 0, 0),
                "{:?}",
                model.quality
            );
            for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
                let what = format!("{kind} {:?} {} Hz", model.damping, truth.frequency_hz);
                let off = (mode.frequency_hz - truth.frequency_hz).abs()
                    / (truth.frequency_hz * truth.loss_factor);
                assert!(off < 0.006, "{what}: {off} bandwidths off");
                let ratio = mode.loss_factor / truth.loss_factor;
                assert!((ratio - 1.0).abs() < 0.01, "{what}: damping ratio {ratio}");
                // ψ² at the driving point
                let scale = (mode.shape.0[0] * mode.participation.0[0]
                    / (truth.shape.0[0] * truth.participation.0[0]))
                    .norm();
                let strong = truth.shape.0[0].norm() > 0.5;
                assert!(
                    !strong || (scale - 1.0).abs() < 0.02,
                    "{what}: modal constant {scale}"
                );
            }
            assert!(says(&model, "without the exponential window"));
        }
    }
}

/// The FRF matrix of a model at s = jω + α in the complex plane: what windowed responses
/// have on line ω.
fn at(truth: &ModalModel, s: Complex64) -> ndarray::Array2<Complex64> {
    let kind = s.powi(truth.frf_kind.omega_power());
    let mut out = ndarray::Array2::zeros((truth.responses.len(), truth.references.len()));
    for mode in &truth.modes {
        let omega = TAU * mode.frequency_hz;
        let denominator = match truth.damping {
            Damping::Structural => omega * omega * Complex64::new(1.0, mode.loss_factor) + s * s,
            Damping::Viscous => s * s + mode.loss_factor * omega * s + omega * omega,
        };
        for ((i, j), value) in out.indexed_iter_mut() {
            *value += kind * mode.shape.0[i] * mode.participation.0[j] / denominator;
        }
    }
    out
}

#[test]
fn a_window_that_decays_faster_than_the_modes_is_not_trusted() {
    let set = easy(40.0, 45).build().unwrap();
    let model = fitted_with(
        &set.frf,
        &FitOptions {
            exponential_window_per_s: Some(1000.0),
            ..FitOptions::default()
        },
    );
    assert!(
        !model.quality.trusted && says(&model, "decay more slowly"),
        "{:?}",
        model.quality.findings
    );
    assert_eq!(model.in_band_modes().count(), 0);
}
