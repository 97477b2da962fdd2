//! How many responses a method serves, and what it says of its modes.

use super::rendered::{options, ratios, rendered};
use crate::common::{cell_scene, disturbed, true_area_field, truth, Errors, DRIFT, FIT_40_DB};
use chladni_frf::ErrorKind;
use chladni_plate::{simulate, Panel};
use chladni_render::{render, Drift, Method, MethodChoice, RenderOptions};

#[test]
fn mls_from_a_fitted_model_serves_every_response_of_every_quarter() {
    for cell in 1..=4 {
        let scene = cell_scene([2, 2], cell, "");
        for seed in 1..=2 {
            let fitted = disturbed(truth(), FIT_40_DB, seed);
            let rendering = rendered(&fitted, &scene, Method::Mls);
            assert!(rendering.weights.feasible, "cell {cell}");
            let (hot, cold) = ratios(&rendering, &scene, truth());
            assert!(
                hot >= 0.95 && cold >= 0.95,
                "cell {cell}, seed {seed}: hot {hot}, cold {cold}"
            );
            let force = rendering.weights.indices.points.max_force_n.unwrap();
            assert!(force < 0.01, "{force} N");
        }
    }
}

/// A measurement so dense that the default takes the quick method first.
#[test]
fn the_default_leaves_no_response_that_the_thorough_method_serves() {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 300.0);
    (panel.responses.grid, panel.responses.spacing_m) = ([44, 28], 0.0057);
    let model = simulate(&panel, None, None).unwrap().truth;
    let least = |method: MethodChoice, limen: &str| {
        let scene = cell_scene([2, 2], 1, limen);
        let options = RenderOptions {
            method,
            ..Default::default()
        };
        let weights = render(&model, &scene, &options).unwrap().weights;
        (weights.indices.points.min_ratio, weights.method)
    };
    let hard = "[threshold]\nlimen_db = 3.0\n";
    let [quick, thorough] = [Method::Mls, Method::Robust].map(|m| least(m.into(), hard));
    assert!(quick.0 < thorough.0, "{quick:?} {thorough:?}");
    assert_eq!(least(MethodChoice::Default, hard), thorough);
    let easy = "[threshold]\nlimen_db = 1.0\n";
    assert_eq!(
        least(MethodChoice::Default, easy),
        least(Method::Mls.into(), easy)
    );
}

#[test]
fn mls_holds_when_the_panel_drifts() {
    let scene = cell_scene([2, 2], 1, "");
    let rendering = rendered(&disturbed(truth(), FIT_40_DB, 1), &scene, Method::Mls);
    for seed in 0..10 {
        let (hot, cold) = ratios(&rendering, &scene, &disturbed(truth(), DRIFT, seed));
        assert!(
            hot >= 0.95 && cold >= 0.95,
            "seed {seed}: hot {hot}, cold {cold}"
        );
    }
}

#[test]
fn mls_serves_the_ground_between_the_responses() {
    let scene = cell_scene([2, 2], 1, "");
    let rendering = rendered(&disturbed(truth(), FIT_40_DB, 1), &scene, Method::Mls);
    let predicted = rendering.weights.indices.area.unwrap();
    let area = rendering.area.as_ref().unwrap();
    let true_field = true_area_field(&rendering, 300.0);
    let share = |ground, inside: &dyn Fn(f64) -> bool| {
        let on: Vec<bool> = true_field
            .iter()
            .zip(&area.ground)
            .filter(|(_, g)| **g == ground)
            .map(|(v, _)| inside(v.norm()))
            .collect();
        on.iter().filter(|&&inside| inside).count() as f64 / on.len() as f64
    };
    let hot = share(chladni_render::Ground::Hot, &|v| {
        rendering.limits.is_felt(v)
    });
    let cold = share(chladni_render::Ground::Cold, &|v| {
        rendering.limits.is_quiet(v)
    });
    assert!(hot >= 0.95 && cold >= 0.95, "hot {hot}, cold {cold}");
    assert!(
        (predicted.hot_ratio.unwrap() - hot).abs() < 0.03
            && (predicted.cold_ratio.unwrap() - cold).abs() < 0.03,
        "{predicted:?}"
    );
}

#[test]
fn mls_serves_the_four_kinds_of_cells_of_a_3_by_3_grid() {
    for cell in [1, 2, 4, 5] {
        let scene = cell_scene([3, 3], cell, "");
        let rendering = rendered(&disturbed(truth(), FIT_40_DB, 3), &scene, Method::Mls);
        let (hot, cold) = ratios(&rendering, &scene, truth());
        assert!(
            hot >= 0.95 && cold >= 0.95,
            "cell {cell}: hot {hot}, cold {cold}"
        );
    }
}

#[test]
fn methods_rank_as_in_the_study() {
    let scene = cell_scene([2, 2], 1, "");
    let min_ratio = |method| {
        rendered(truth(), &scene, method)
            .weights
            .indices
            .points
            .min_ratio
    };
    let [one_phase, free_phase, two_step] =
        [Method::PressureMatching, Method::Mls, Method::Modal].map(min_ratio);
    assert_eq!(free_phase, 1.0);
    assert!(
        (0.80..1.0).contains(&one_phase),
        "pressure matching {one_phase}"
    );
    assert!(two_step < one_phase, "two-step {two_step}");
}

#[test]
fn the_two_step_method_says_that_psi_is_rank_deficient() {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.stop_hz, panel.frf.step_hz) = (10.0, 1210.0, 600.0);
    let model = simulate(&panel, None, None).unwrap().truth;
    let rendering = rendered(&model, &cell_scene([2, 2], 1, ""), Method::Modal);
    // With the three rigid-body modes 34, as many as actuators; by their symmetry the
    // panel cannot set them independently.
    assert_eq!(rendering.weights.modes_used, 31);
    let warning = rendering
        .weights
        .findings
        .iter()
        .find(|warning| warning.text.starts_with("Psi"))
        .expect("a warning about Psi");
    assert!(
        warning.contains("rank deficient") && warning.contains("singular values"),
        "{warning}"
    );
    assert!(rendering
        .weights
        .findings
        .iter()
        .any(|warning| warning.contains("baseline")));
}

#[test]
fn modes_are_counted_by_the_bands_they_lie_in() {
    let rendering = rendered(truth(), &cell_scene([2, 2], 1, ""), Method::Modal);
    assert_eq!(
        rendering.weights.modes_used,
        truth().in_band_modes().count()
    );
    assert_eq!(rendering.weights.actuators_used, 34);
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    for method in Method::ALL {
        let once = || {
            rendered(truth(), &cell_scene([2, 2], 2, ""), method)
                .weights
                .to_json()
                .unwrap()
        };
        assert_eq!(once(), once(), "{method}");
    }
}

#[test]
fn kappa_is_the_least_slack_in_standard_deviations() {
    let scene = cell_scene([2, 2], 1, "");
    let of = |drift| {
        render(
            truth(),
            &scene,
            &RenderOptions {
                drift,
                ..options(Method::PressureMatching)
            },
        )
        .unwrap()
        .weights
    };
    let weights = of(Drift::default());
    assert!(
        !weights.feasible && weights.kappa.unwrap() < 0.0,
        "pressure matching misses some"
    );
    let mls = rendered(truth(), &scene, Method::Mls).weights;
    assert!(mls.kappa.unwrap() >= 1.0 && mls.indices.points.margin_db.unwrap() > 0.0);
    let none = Drift {
        frequency_relative: 0.0,
        loss_factor_relative: 0.0,
        shape_relative: 0.0,
        isotropic_relative: 0.0,
        drive_relative: Some(0.0),
    };
    assert_eq!(
        of(none).kappa,
        None,
        "without any model error there is no scale"
    );
}

#[test]
fn a_model_without_error_bars_still_gets_a_robust_drive() {
    // The standard deviations of the truth are zero; the drift of the options stands in
    // for them.
    let scene = cell_scene([2, 2], 1, "");
    let rendering = rendered(truth(), &scene, Method::Mls);
    let wrong = disturbed(
        truth(),
        Errors {
            frequency: 1e-3,
            loss_factor: 0.1,
            shape: 0.005,
            residual: 0.002,
        },
        4,
    );
    let (hot, cold) = ratios(&rendering, &scene, &wrong);
    assert!(hot >= 0.9 && cold >= 0.9, "hot {hot}, cold {cold}");
}

#[test]
fn method_names_are_those_of_the_command_line() {
    for method in Method::ALL {
        assert_eq!(method.to_string().parse::<Method>().unwrap(), method);
    }
    let error = "magic".parse::<Method>().unwrap_err();
    assert_eq!(error.kind, ErrorKind::Usage);
    assert!(error.to_string().contains("mls"), "{error}");
}
