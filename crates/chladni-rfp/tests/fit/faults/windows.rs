//! Windows: their line shape fitted, or their bias named.

use super::random_test::{random_test, random_test_of, taper, MODES, RATE_HZ, RECORD, RECORDS};
use super::*;
use chladni_frf::{BlockWindow, Damping, Estimation, Estimator, Forcing, Mode};
use chladni_rfp::pieces::{reduce, solve, Partial, Poles, Solved};
use chladni_rfp::{FitError, Method, Window};
use ndarray::{s, Axis};

/// ζ found over ζ true, mode by mode.
fn damping_ratios(model: &ModalModel) -> Vec<f64> {
    damping_ratios_of(&MODES, model)
}

fn damping_ratios_of(modes: &[(f64, f64)], model: &ModalModel) -> Vec<f64> {
    let found = modes_near(modes, model).into_iter();
    let each = found.zip(modes);
    each.map(|(found, (_, zeta))| found.damping_ratio / zeta)
        .collect()
}

/// The nearest mode of the model to each of the true ones.
fn modes_near<'a>(modes: &[(f64, f64)], model: &'a ModalModel) -> Vec<&'a Mode> {
    let nearest = |&(f, _): &(f64, f64)| {
        let off = |m: &&Mode| (m.frequency_hz - f).abs();
        model
            .in_band_modes()
            .min_by(|a, b| off(a).total_cmp(&off(b)))
            .expect("a mode")
    };
    modes.iter().map(nearest).collect()
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

/// The lines speak of a window, and a fit under it is impossible: the first one stands.
#[test]
fn a_window_that_cannot_be_tried_costs_no_fit() {
    let even = random_test(Window::Hann, 1.0, 41);
    let lines = even.frequency_hz.len();
    let kept: Vec<usize> = (0..lines).filter(|&k| k != lines / 5).collect();
    let FrfValues::F64(values) = &even.values else {
        panic!("simulated in double precision");
    };
    let frf = FrfSet {
        frequency_hz: even.frequency_hz.select(Axis(0), &kept),
        values: FrfValues::F64(values.select(Axis(2), &kept)),
        ..even.clone()
    };
    let options = FitOptions {
        band_hz: Some([20.0, 250.0]),
        ..FitOptions::default()
    };
    let model = fitted_with(&frf, &options);
    assert!(
        says(&model, "those of a hann window") && !says(&model, "so the fit has its line shape")
    );
    let told = FitOptions {
        window: Some(Window::Hann),
        ..options
    };
    assert!(matches!(fit(&frf, &told), Err(FitError::WindowAxis { .. })));
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
    assert_eq!(told.modes, fitted_with(&frf, &said).modes);
    // without the set's word the residual tells the averages, which only bars need
    for (told, asked) in told.modes.iter().zip(&asked.modes) {
        assert_eq!(
            (told.frequency_hz, &told.shape),
            (asked.frequency_hz, &asked.shape)
        );
        let ratio = told.loss_factor_std / asked.loss_factor_std;
        assert!((0.5..2.0).contains(&ratio), "{ratio}");
    }
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

/// The set with so many responses, each a mixture of those that were measured with noise of its
/// own.
fn mixed(frf: &FrfSet, responses: usize) -> FrfSet {
    let FrfValues::F64(values) = &frf.values else {
        panic!("synthetic sets are in double precision")
    };
    let lines = values.len_of(Axis(2));
    let part = |i: usize, own: usize| (1.7 * (i * 3 + own + 1) as f64).cos();
    let value = |(i, _, k): (usize, usize, usize)| -> Complex64 {
        (0..values.len_of(Axis(0)))
            .map(|own| part(i, own) * values[[own, 0, k]])
            .sum()
    };
    let mut set = FrfSet {
        values: FrfValues::F64(Array3::from_shape_fn((responses, 1, lines), value)),
        responses: (1..=responses)
            .map(|node| format!("{node}:+Z").parse().unwrap())
            .collect(),
        references: vec!["99:+Z".parse().unwrap()],
        ..frf.clone()
    };
    chladni_plate::add_white_noise(super::values(&mut set), 75.0, 7).unwrap();
    set
}

/// The fit of two halves of the responses.
fn in_halves(frf: &FrfSet, options: &FitOptions) -> ModalModel {
    let FrfValues::F64(values) = &frf.values else {
        panic!("synthetic sets are in double precision")
    };
    let half = |b: usize| {
        let rows = b * frf.responses.len() / 2..(b + 1) * frf.responses.len() / 2;
        FrfSet {
            values: FrfValues::F64(values.slice(s![rows.clone(), .., ..]).to_owned()),
            responses: frf.responses[rows].to_vec(),
            ..frf.clone()
        }
    };
    let mut poles: Option<Poles> = None;
    for _ in 0..8 {
        let of_half =
            |b: usize| reduce(&half(b), options, b as u64, Vec::new(), poles.as_ref()).unwrap();
        let merged = Partial::merge(vec![of_half(0), of_half(1)]).unwrap();
        match solve(merged, options, &|_| {}).unwrap() {
            Solved::Poles(found) => poles = Some(*found),
            Solved::Fit(fit) => return fit.model,
        }
    }
    panic!("no end")
}

#[test]
fn many_responses_are_fitted_on_weighted_lines() {
    // in half of all seeds the broad poles that stand for leakage end differently in pieces, and bars
    // differ; in this seed they end alike
    let frf = mixed(&random_test(Window::Hann, 1.0, 47), 30);
    let options = FitOptions {
        band_hz: Some([20.0, 250.0]),
        window: Some(Window::Hann),
        // the poles are sought in the other one first
        damping: Some(Damping::Viscous),
        ..FitOptions::default()
    };
    let model = fitted_with(&frf, &options);
    let in_pieces = in_halves(&frf, &options);
    let found = [&model, &in_pieces].map(|model| modes_near(&MODES, model));
    for ((mode, part), &(hz, zeta)) in found[0].iter().zip(&found[1]).zip(&MODES) {
        // lines that count alike leave a bar of 2.2 % at 60 Hz
        let bar = mode.loss_factor_std / mode.loss_factor;
        assert!(
            mode.trust != Trust::Rejected && bar < 0.015,
            "{hz} Hz: {bar}"
        );
        let off = (mode.loss_factor - 2.0 * zeta).abs() / mode.loss_factor_std;
        assert!(off < 3.0, "{hz} Hz: {off} bars");
        let off = (part.loss_factor - mode.loss_factor).abs() / mode.loss_factor_std;
        assert!(off < 0.3, "{hz} Hz: {off} bars from the whole");
        let bars = part.loss_factor_std / mode.loss_factor_std;
        assert!(
            (0.8..1.25).contains(&bars),
            "{hz} Hz: bar {bars} of the whole"
        );
    }
    let left = [&model, &in_pieces].map(|model| model.quality.relative_error);
    assert!((left[1] / left[0] - 1.0).abs() < 0.05, "{left:?}");
}
