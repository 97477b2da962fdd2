//! Doubts that a set deserves, and none that it does not.

use chladni_frf::{
    BlockWindow, Estimation, Estimator, Forcing, FrfValues, ModalModel, Severity, Trust,
};
use chladni_plate::Synthetic;
use chladni_rfp::{fit, FitOptions, Window};
use ndarray::{s, Array1};
use num_complex::Complex64;

fn structure() -> Synthetic {
    Synthetic {
        natural_frequency_hz: vec![40.0, 80.0, 120.0, 160.0],
        loss_factor: vec![0.02],
        responses: 8,
        references: 3,
        frequency_hz: Array1::range(10.0, 200.5, 0.5),
        snr_db: 50.0,
        ..Synthetic::default()
    }
}

fn has(model: &ModalModel, code: &str) -> bool {
    model.quality.findings.iter().any(|f| f.code == code)
}

fn sure_hz(model: &ModalModel) -> Vec<f64> {
    let sure = model.in_band_modes().filter(|m| m.trust == Trust::Sure);
    sure.map(|m| m.frequency_hz.round()).collect()
}

#[test]
fn modes_of_a_repeated_pole_are_not_one_that_moves() {
    for seed in 1..6 {
        let set = Synthetic {
            natural_frequency_hz: vec![60.0, 100.0, 100.0, 150.0],
            seed,
            ..structure()
        };
        let model = fit(&set.build().unwrap().frf, &FitOptions::default()).unwrap();
        let sure = sure_hz(&model.model);
        assert_eq!(sure, [60.0, 100.0, 100.0, 150.0], "seed {seed}");
    }
}

#[test]
fn a_window_that_the_records_did_not_have_is_contradicted() {
    let set = structure().build().unwrap();
    let under = |window| {
        let options = FitOptions {
            window,
            ..FitOptions::default()
        };
        fit(&set.frf, &options).unwrap().model
    };
    for window in [Window::Hann, Window::Flattop, Window::Rectangular] {
        assert!(has(&under(Some(window)), "window-contradicted"), "{window}");
    }
    assert!(!has(&under(Some(Window::None)), "window-contradicted"));
    assert!(!has(&under(None), "window-contradicted"));
}

#[test]
fn an_frf_with_gaps_costs_no_mode_of_the_others() {
    let mut set = structure().build().unwrap();
    let FrfValues::F64(values) = &mut set.frf.values else {
        panic!("synthetic sets are double")
    };
    let nothing = Complex64::new(f64::NAN, f64::NAN);
    values.slice_mut(s![7, 2, 180..]).fill(nothing);
    let model = fit(&set.frf, &FitOptions::default()).unwrap().model;
    assert_eq!(sure_hz(&model), [40.0, 80.0, 120.0, 160.0]);
    assert!(has(&model, "frfs-incomplete"));
    // its values follow from the shapes
    let found = model.receptance(120.0)[[7, 2]];
    let expected = set.truth.receptance(120.0)[[7, 2]];
    assert!((found - expected).norm() < 0.02 * expected.norm());
}

#[test]
fn gaps_that_must_cost_lines_are_a_caution_and_lines_that_none_has_a_note() {
    for (rows, severity) in [(7..8, Severity::Caution), (0..8, Severity::Note)] {
        let mut set = structure().build().unwrap();
        let FrfValues::F64(values) = &mut set.frf.values else {
            panic!("synthetic sets are double")
        };
        let nothing = Complex64::new(f64::NAN, f64::NAN);
        values.slice_mut(s![rows, .., ..60]).fill(nothing);
        let model = fit(&set.frf, &FitOptions::default()).unwrap().model;
        let mut findings = model.quality.findings.iter();
        let lost = findings.find(|f| f.code == "lines-without-values");
        assert_eq!(lost.unwrap().severity, severity);
        assert!(!has(&model, "frfs-incomplete"));
    }
}

#[test]
fn sure_modes_slower_than_an_exponential_window_end_in_no_trust() {
    let set = structure().build().unwrap();
    // decays are 2.5 to 10 1/s
    for (alpha, left, fault) in [(1.0, 4, false), (4.0, 3, true), (50.0, 0, true)] {
        let options = FitOptions {
            exponential_window_per_s: Some(alpha),
            ..FitOptions::default()
        };
        let model = fit(&set.frf, &options).unwrap().model;
        assert_eq!(sure_hz(&model).len(), left, "{alpha}");
        assert_eq!(has(&model, "decays-not-windowed"), fault, "{alpha}");
        assert_eq!(model.quality.trusted, !fault, "{alpha}");
        assert_eq!(has(&model, "no-mode"), left == 0, "{alpha}");
    }
}

#[test]
fn averages_of_h2_are_not_fitted_with_the_line_shape_of_h1() {
    let mut set = structure().build().unwrap().frf;
    let of = |estimator| Estimation {
        estimator,
        window: BlockWindow::Hann,
        forcing: Some(Forcing::Continuous),
        transform_s: 2.0,
        gate_s: 2.0,
        hop_s: 1.0,
        averages: [40; 2],
        lines_per_value: 1,
    };
    for (estimator, modelled) in [
        (Estimator::H1, true),
        (Estimator::H2, false),
        (Estimator::Hv, false),
    ] {
        set.estimation = Some(of(estimator));
        let model = fit(&set, &FitOptions::default()).unwrap().model;
        assert_eq!(has(&model, "window-modelled"), modelled, "{estimator}");
    }
}
