//! Every method of the family on the same cases: a new method is a new row.

use chladni_frf::{Damping, FrfSet, FrfValues, ModalModel, Mode, Trust};
use chladni_plate::{cramer_rao, simulate, Panel, Synthetic};
use chladni_rfp::{fit, stabilization, FitError, FitOptions, Method, Stability};
use ndarray::Array1;

fn run(frf: &FrfSet, method: Method, modes: Option<usize>) -> Result<ModalModel, FitError> {
    fit(
        frf,
        &FitOptions {
            method,
            modes,
            ..FitOptions::default()
        },
    )
    .map(|fit| fit.model)
}

/// Six separate modes, 24 FRFs.
fn easy() -> Synthetic {
    Synthetic {
        natural_frequency_hz: vec![31.0, 52.0, 78.0, 101.0, 133.0, 160.0],
        loss_factor: vec![0.01, 0.012, 0.008, 0.01, 0.015, 0.01],
        responses: 12,
        references: 2,
        frequency_hz: Array1::range(20.0, 180.0, 0.1),
        snr_db: 40.0,
        seed: 2,
        ..Synthetic::default()
    }
}

/// A hundred modes on a fine axis, four FRFs, no noise.
fn hundred() -> Synthetic {
    Synthetic {
        natural_frequency_hz: (0..100)
            .map(f64::from)
            .map(|n| 30.0 + 10.0 * n + 2.0 * n.sin())
            .collect(),
        loss_factor: vec![0.01],
        responses: 4,
        references: 1,
        frequency_hz: Array1::range(20.0, 1035.0, 0.26),
        snr_db: f64::INFINITY,
        ..Synthetic::default()
    }
}

/// |λ − λ_true| of the nearest mode, in half-bandwidths, per true mode.
fn errors(truth: &ModalModel, model: &ModalModel) -> Vec<f64> {
    let distance = |a: &Mode, b: &Mode| {
        let half = 0.5 * b.loss_factor * b.frequency_hz;
        ((a.frequency_hz - b.frequency_hz) / half).hypot(a.loss_factor / b.loss_factor - 1.0)
    };
    truth
        .in_band_modes()
        .map(|t| {
            model
                .in_band_modes()
                .map(|m| distance(m, t))
                .fold(f64::INFINITY, f64::min)
        })
        .collect()
}

fn worst(truth: &ModalModel, model: &ModalModel) -> f64 {
    errors(truth, model).into_iter().fold(0.0, f64::max)
}

fn zeroed(frf: &FrfSet) -> FrfSet {
    let mut frf = frf.clone();
    if let FrfValues::F64(values) = &mut frf.values {
        values.fill(Default::default());
    }
    frf
}

/// Largest error in half-bandwidths on the easy case: the method's own bias, some times
/// the noise.
const TOLERANCE: [(Method, f64); 10] = [
    (Method::Auto, 0.01),
    (Method::Lean, 0.01),
    (Method::Vf, 0.01),
    (Method::Lscf, 0.03),
    (Method::Plscf, 0.1),
    (Method::Aaa, 0.3),
    (Method::Rfp, 0.3),
    (Method::Grfp, 0.3),
    (Method::Peak, 0.3),
    (Method::Circle, 0.1),
];

#[test]
fn every_method_finds_separate_modes_and_says_its_name() {
    assert_eq!(TOLERANCE.map(|(method, _)| method), Method::ALL);
    let set = easy().build().unwrap();
    for (method, tolerance) in TOLERANCE {
        for modes in [None, Some(6)] {
            let model = run(&set.frf, method, modes).unwrap();
            let worst = worst(&set.truth, &model);
            assert!(worst < tolerance, "{method} {modes:?}: {worst}");
            assert_eq!(model.in_band_modes().count(), 6, "{method} {modes:?}");
            assert_eq!(model.method, method.as_str());
            assert!(model.quality.trusted, "{method}: {:?}", model.quality);
            assert!(
                model.quality.relative_error < 0.05,
                "{method}: {}",
                model.quality.relative_error
            );
        }
    }
}

#[test]
fn bars_of_every_method_hold_its_bias() {
    let set = easy().build().unwrap();
    for method in Method::ALL {
        // the law of the truth: the other one shifts the frequency by η²/4, more than the
        // bars
        let options = FitOptions {
            method,
            modes: Some(6),
            damping: Some(Damping::Structural),
            ..FitOptions::default()
        };
        let model = fit(&set.frf, &options).unwrap().model;
        let pulls = set.truth.in_band_modes().zip(model.in_band_modes());
        let rms = (pulls
            .map(|(t, m)| ((m.frequency_hz - t.frequency_hz) / m.frequency_std_hz).powi(2))
            .sum::<f64>()
            / 6.0)
            .sqrt();
        assert!(rms < 3.0, "{method}: errors are {rms} standard deviations");
    }
}

#[test]
fn every_method_lets_the_data_choose_the_law() {
    for law in [Damping::Structural, Damping::Viscous] {
        let set = Synthetic {
            damping: law,
            snr_db: 60.0,
            ..easy()
        }
        .build()
        .expect("a set");
        for method in Method::ALL {
            let model = run(&set.frf, method, Some(6)).expect("a fit");
            assert_eq!(model.damping, law, "{method}");
            let asked = FitOptions {
                method,
                modes: Some(6),
                damping: Some(law.other()),
                ..FitOptions::default()
            };
            let model = fit(&set.frf, &asked).expect("a fit").model;
            assert_eq!(model.damping, law.other(), "{method}");
            let mut findings = model.quality.findings.iter();
            assert!(
                findings.any(|finding| finding.code == "law-contradicted"),
                "{method}, {law:?}"
            );
        }
    }
}

#[test]
fn a_hundred_poles_without_noise_are_exact() {
    let set = hundred().build().unwrap();
    for method in [Method::Lean, Method::Vf, Method::Aaa] {
        let model = run(&set.frf, method, Some(100)).unwrap();
        // half a bandwidth is 0.005 of the frequency
        let worst = 0.005 * worst(&set.truth, &model);
        assert!(worst < 1e-10, "{method}: {worst:e}");
        assert!(model.quality.relative_error < 1e-8);
    }
}

/// Normal equations square the condition: half of the digits remain.
#[test]
fn lscf_without_noise_keeps_half_of_the_digits() {
    let set = Synthetic {
        snr_db: f64::INFINITY,
        ..easy()
    }
    .build()
    .unwrap();
    for method in [Method::Lscf, Method::Plscf] {
        let model = run(&set.frf, method, None).unwrap();
        assert_eq!(model.in_band_modes().count(), 6, "{method}");
        let worst = 0.005 * worst(&set.truth, &model);
        assert!(worst < 1e-6, "{method}: {worst:e}");
    }
}

#[test]
fn lean_stands_at_the_cramer_rao_bound() {
    // 10 seeds x 6 modes: the ratio of a chi-square of 60 to its mean lies within
    // 0.7..1.3 (3 sigma)
    let (mut frequency, mut loss) = (0.0, 0.0);
    for seed in 0..10 {
        let set = Synthetic {
            seed: 50 + seed,
            ..easy()
        }
        .build()
        .unwrap();
        let bound = cramer_rao(
            &set.truth,
            &set.frf.frequency_hz,
            set.noise_variance,
            &[-2, 0, 2, 4],
        )
        .unwrap();
        let model = run(&set.frf, Method::Lean, Some(6)).unwrap();
        assert_eq!(model.in_band_modes().count(), 6);
        for (n, (truth, mode)) in set
            .truth
            .in_band_modes()
            .zip(model.in_band_modes())
            .enumerate()
        {
            frequency +=
                ((mode.frequency_hz - truth.frequency_hz) / bound.frequency_std_hz[n]).powi(2);
            loss += ((mode.loss_factor - truth.loss_factor) / bound.loss_factor_std[n]).powi(2);
        }
    }
    let (frequency, loss) = ((frequency / 60.0_f64).sqrt(), (loss / 60.0_f64).sqrt());
    assert!((0.7..1.3).contains(&frequency), "frequency {frequency}");
    assert!((0.7..1.3).contains(&loss), "loss factor {loss}");
}

/// Bands with so few lines per bandwidth that some modes lie between two lines, where a pool puts
/// poles of noise in their places.
#[test]
fn lean_finds_as_many_modes_as_it_is_told_of_between_the_lines() {
    for seed in 0..12_u64 {
        let draw = |n: u64| {
            let turns = 0.618_033_988_75 * (n + 1) as f64 + 0.414_213_562_37 * seed as f64;
            turns.fract()
        };
        let count = 15 + seed as usize;
        // one mode in each cell of 25 Hz, 7 Hz apart or more
        let place = |n: usize| 20.0 + 25.0 * n as f64 + 18.0 * draw(n as u64);
        let last = 20.0 + 25.0 * count as f64;
        let set = Synthetic {
            natural_frequency_hz: (0..count).map(place).collect(),
            loss_factor: vec![0.005],
            responses: 20,
            references: 2,
            // 0.05 to 1.7 lines per bandwidth
            frequency_hz: Array1::range(10.0, last + 10.0, 2.0),
            snr_db: 50.0,
            seed,
            ..Synthetic::default()
        }
        .build()
        .unwrap();
        let model = run(&set.frf, Method::Lean, Some(count)).unwrap();
        let (found, worst) = (model.in_band_modes().count(), worst(&set.truth, &model));
        assert!(found == count && worst < 0.3, "{found} of {count}: {worst}");
    }
}

#[test]
fn the_demonstration_panel_loses_no_mode() {
    let panel = simulate(&Panel::from_toml("", 2 << 30).unwrap(), None, None).unwrap();
    let count = panel.truth.in_band_modes().count();
    for method in [
        Method::Lean,
        Method::Vf,
        Method::Lscf,
        Method::Plscf,
        Method::Aaa,
    ] {
        for modes in [None, Some(count)] {
            let model = run(&panel.frf, method, modes).unwrap();
            let worst = worst(&panel.truth, &model);
            assert!(worst < 0.5, "{method} {modes:?}: {worst}");
            let sure = model
                .in_band_modes()
                .filter(|mode| mode.trust == Trust::Sure)
                .count();
            assert!(sure <= count, "{method} {modes:?}: {sure} sure of {count}");
            // greedy choices of support points hang on roundings, and the poles with them
            let most = if method == Method::Aaa { 0.02 } else { 0.012 };
            assert!(
                model.quality.relative_error < most,
                "{method} {modes:?}: {}",
                model.quality.relative_error
            );
        }
    }
}

#[test]
fn what_cannot_be_fitted_is_an_error_or_not_trusted() {
    let set = easy().build().unwrap();
    let mut noise = set.frf.clone();
    if let FrfValues::F64(values) = &mut noise.values {
        values.fill(Default::default());
        chladni_plate::add_noise_of_variance(values, 1.0, 5);
    }
    let mut turned = set.frf.clone();
    turned.conjugate();
    for method in Method::ALL {
        assert_eq!(
            run(&zeroed(&set.frf), method, None).unwrap_err(),
            FitError::NoData,
            "{method}"
        );
        for modes in [None, Some(4)] {
            for (what, frf) in [("noise", &noise), ("wrong time sign", &turned)] {
                let model = run(frf, method, modes)
                    .unwrap_or_else(|error| panic!("{method} {modes:?} on {what}: {error}"));
                assert!(
                    !model.quality.trusted,
                    "{method} {modes:?} on {what}: {:?}",
                    model.quality
                );
            }
        }
        for lines in [9, 12, 20, 40] {
            let band_hz = Some([50.0, 49.95 + 0.1 * f64::from(lines)]);
            for modes in [
                None,
                Some(1),
                Some(lines as usize - 8),
                Some(lines as usize),
            ] {
                let options = FitOptions {
                    method,
                    modes,
                    band_hz,
                    ..FitOptions::default()
                };
                match fit(&set.frf, &options) {
                    Err(FitError::TooFewLines { .. }) => {}
                    Err(error) => panic!("{method}, {lines} lines, {modes:?}: {error}"),
                    Ok(fit) => assert!(fit.model.in_band_modes().count() <= lines as usize),
                }
            }
        }
    }
}

#[test]
fn one_frf_is_enough() {
    let set = Synthetic {
        responses: 1,
        references: 1,
        snr_db: 60.0,
        ..easy()
    }
    .build()
    .unwrap();
    for (method, least) in [
        (Method::Lean, 6),
        (Method::Vf, 6),
        (Method::Lscf, 5),
        (Method::Plscf, 5),
        (Method::Aaa, 5),
        (Method::Circle, 4),
    ] {
        let model = run(&set.frf, method, None).unwrap();
        let found = errors(&set.truth, &model)
            .into_iter()
            .filter(|error| *error < 0.2)
            .count();
        assert!(found >= least, "{method}: {found} of 6");
    }
}

#[test]
fn methods_in_the_z_plane_need_an_even_grid_and_say_so() {
    let uneven = Synthetic {
        frequency_hz: (0..1500)
            .map(|k| 20.0 * 9.0_f64.powf(f64::from(k) / 1499.0))
            .collect(),
        ..easy()
    };
    let set = uneven.build().unwrap();
    for method in Method::ALL {
        match run(&set.frf, method, None) {
            Err(FitError::UnevenAxis { method: named, .. }) => {
                assert_eq!(named, method);
                assert!([Method::Lscf, Method::Plscf].contains(&method));
            }
            Err(error) => panic!("{method}: {error}"),
            Ok(_) => assert!(![Method::Lscf, Method::Plscf].contains(&method)),
        }
    }
    // lines missing from an even grid do not matter
    let mut holes = easy().build().unwrap();
    if let FrfValues::F64(values) = &mut holes.frf.values {
        values
            .slice_mut(ndarray::s![0, 0, 200..260])
            .fill(num_complex::Complex64::new(f64::NAN, 0.0));
    }
    assert!(worst(&holes.truth, &run(&holes.frf, Method::Lscf, None).unwrap()) < 0.03);
}

#[test]
fn the_poly_reference_form_needs_the_whole_matrix_and_says_so() {
    let mut set = easy().build().unwrap();
    if let FrfValues::F64(values) = &mut set.frf.values {
        values
            .slice_mut(ndarray::s![3, 1, ..])
            .fill(Default::default());
    }
    let error = run(&set.frf, Method::Plscf, None).unwrap_err();
    assert_eq!(
        error,
        FitError::IncompleteMatrix {
            method: Method::Plscf,
            present: 23,
            total: 24
        }
    );
    assert!(worst(&set.truth, &run(&set.frf, Method::Lscf, None).unwrap()) < 0.03);
}

#[test]
fn every_mode_is_a_column_of_the_stabilization_diagram() {
    let set = easy().build().unwrap();
    let diagram = stabilization(&set.frf, &FitOptions::default()).unwrap();
    assert!(diagram.orders.windows(2).all(|pair| pair[0] < pair[1]));
    for truth in set.truth.in_band_modes() {
        let near =
            |f: f64| (f - truth.frequency_hz).abs() < 0.1 * truth.loss_factor * truth.frequency_hz;
        let stable = diagram
            .poles
            .iter()
            .filter(|pole| pole.stability == Stability::Stable && near(pole.frequency_hz))
            .count();
        assert!(
            2 * stable > diagram.orders.len(),
            "{} Hz: {stable} of {}",
            truth.frequency_hz,
            diagram.orders.len()
        );
    }
    let of_fit = |method| {
        fit(
            &set.frf,
            &FitOptions {
                method,
                ..FitOptions::default()
            },
        )
        .unwrap()
        .stabilization
    };
    assert_eq!(of_fit(Method::Lscf), Some(diagram));
    assert!(of_fit(Method::Plscf).is_some());
    assert!(of_fit(Method::Vf).is_none());
}

#[test]
fn threads_do_not_change_a_bit_of_any_method() {
    let set = easy().build().unwrap();
    for method in Method::ALL {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            serde_json::to_string(&pool.install(|| run(&set.frf, method, None).unwrap())).unwrap()
        };
        assert_eq!(on(1), on(2), "{method}");
    }
}

#[test]
fn a_narrow_band_of_many_frfs_takes_no_sketch_for_the_frfs() {
    let set = Synthetic {
        responses: 64,
        references: 3,
        ..easy()
    };
    let frf = set.build().unwrap().frf;
    // 60 lines, fewer than the columns of the sketch of 192 FRFs
    let options = FitOptions {
        band_hz: Some([130.0, 135.9]),
        method: Method::Vf,
        ..FitOptions::default()
    };
    let model = fit(&frf, &options).unwrap().model;
    let mode = model.in_band_modes().next().expect("one mode");
    assert!(
        (mode.frequency_hz - 133.0).abs() < 0.01,
        "{}",
        mode.frequency_hz
    );
    assert_eq!(mode.shape.0.len(), 64);
    assert!(model.quality.relative_error < 0.1);
}
