//! The methods on the virtual panel, judged on its truth.

use crate::common::{
    actuators_m, cell_scene, disturbed, panel, scene, truth, Errors, DRIFT, FIT_40_DB,
};
use chladni_frf::{ErrorKind, ModalModel};
use chladni_plate::{simulate, Panel};
use chladni_render::{
    evaluate, render, Drift, Method, MethodChoice, On, RenderOptions, Rendering, Scene,
};
use std::fmt::Write as _;

fn options(method: Method) -> RenderOptions {
    RenderOptions {
        method: method.into(),
        ..Default::default()
    }
}

fn rendered(model: &ModalModel, scene: &Scene, method: Method) -> Rendering {
    render(model, scene, &options(method)).unwrap()
}

/// Hot and cold ratio on other data.
fn ratios(rendering: &Rendering, scene: &Scene, model: &ModalModel) -> (f64, f64) {
    let points = evaluate(&rendering.weights, scene, On::Model(model))
        .unwrap()
        .indices
        .points;
    (points.hot_ratio, points.cold_ratio)
}

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
    (panel.responses.grid, panel.responses.spacing_m) = ([22, 15], 0.0105);
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
    let places: Vec<[f64; 2]> = area
        .y_m
        .iter()
        .flat_map(|&y| area.x_m.iter().map(move |&x| [x, y]))
        .collect();
    let drive: ndarray::Array1<_> = rendering
        .weights
        .weights
        .iter()
        .map(|weight| weight.value())
        .collect();
    let true_field = panel()
        .plate
        .mobility_matrix(&places, &actuators_m(), 300.0)
        .unwrap()
        .dot(&drive);
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
fn a_force_limit_is_kept_and_said_to_bind() {
    for method in Method::ALL {
        let free = rendered(truth(), &cell_scene([2, 2], 1, ""), method);
        let limit = 0.3 * free.weights.indices.points.max_force_n.unwrap();
        let scene = cell_scene([2, 2], 1, &format!("[actuators]\nmax_force_n = {limit}\n"));
        let limited = rendered(truth(), &scene, method);
        let force = limited.weights.indices.points.max_force_n.unwrap();
        assert!(
            force <= limit * (1.0 + 1e-12),
            "{method}: {force} N of {limit} N"
        );
        if [Method::PressureMatching, Method::Mls].contains(&method) {
            assert!(
                limited.weights.findings.iter().any(|w| w.contains("binds")),
                "{method}: {:?}",
                limited.weights.findings
            );
        }
    }
}

#[test]
fn a_tight_force_limit_is_met_by_a_more_economical_drive() {
    let free = rendered(truth(), &cell_scene([2, 2], 1, ""), Method::Mls)
        .weights
        .indices
        .points
        .max_force_n
        .unwrap();
    let scene = cell_scene(
        [2, 2],
        1,
        &format!("[actuators]\nmax_force_n = {}\n", 0.6 * free),
    );
    let limited = rendered(truth(), &scene, Method::Mls).weights;
    assert!(
        limited.indices.points.min_ratio > 0.9,
        "{:?}",
        limited.indices.points
    );
}

#[test]
fn an_infeasible_scene_says_what_is_possible() {
    let scene = cell_scene([2, 2], 1, "[actuators]\nmax_force_n = 1e-5\n");
    let weights = rendered(truth(), &scene, Method::Robust).weights;
    assert!(!weights.feasible && weights.kappa.unwrap() < 0.0);
    let said = weights
        .findings
        .iter()
        .find(|warning| warning.contains("impossible"))
        .expect("what is possible");
    assert!(
        said.contains("% of the hot") && said.contains("4.0 dB"),
        "{said}"
    );
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
        drive_relative: 0.0,
    };
    assert_eq!(
        of(none).kappa,
        None,
        "without any model error there is no scale"
    );
}

#[test]
fn actuators_can_be_chosen_and_unknown_ones_are_refused() {
    let chosen = rendered(
        truth(),
        &cell_scene(
            [2, 2],
            1,
            "[actuators]\nuse = [\"120Z\", \"101:-Z\", \"110:+Z\"]\n",
        ),
        Method::Mls,
    );
    let mut names = String::new();
    chosen
        .weights
        .weights
        .iter()
        .for_each(|weight| write!(names, "{} ", weight.reference).unwrap());
    assert_eq!(
        names, "101:+Z 110:+Z 120:+Z ",
        "in the model's order and sense"
    );
    let scene = cell_scene([2, 2], 1, "[actuators]\nuse = [\"135:+Z\"]\n");
    let error = render(truth(), &scene, &options(Method::Mls)).unwrap_err();
    assert_eq!(error.kind, ErrorKind::BadData);
    assert!(
        error.to_string().contains("135:+Z")
            && error.to_string().contains("one of the 34 references"),
        "{error}"
    );
}

#[test]
fn a_single_actuator_is_driven_with_a_warning() {
    for method in Method::ALL {
        let rendering = rendered(
            truth(),
            &cell_scene([2, 2], 1, "[actuators]\nuse = [\"101:+Z\"]\n"),
            method,
        );
        assert!(
            rendering
                .weights
                .findings
                .iter()
                .any(|w| w.contains("a single actuator (101:+Z)")),
            "{method}"
        );
        assert!(!rendering.weights.feasible);
    }
}

#[test]
fn a_mode_that_no_actuator_can_drive_is_named() {
    let mut model = truth().clone();
    model.modes[2].participation.0.fill(0.0.into());
    let warnings = rendered(&model, &cell_scene([2, 2], 1, ""), Method::Mls)
        .weights
        .findings;
    let expected = format!(
        "no actuator in use can drive or stop the mode at {:.1} Hz",
        model.modes[2].frequency_hz
    );
    assert!(
        warnings
            .iter()
            .any(|warning| warning.text.starts_with(&expected)),
        "{warnings:?}"
    );
}

#[test]
fn a_zone_without_responses_is_refused() {
    let text =
        "frequency_hz = 300\n[zones]\ngrid = [27, 17]\nhot = [1]\ncells_m = [0, 0, 0.268, 0.170]\n";
    let error = render(truth(), &scene(text), &options(Method::Mls)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no response lies in the hot zone")
            && error.to_string().contains("transition_m"),
        "{error}"
    );
    let all_hot = "frequency_hz = 300\n[zones]\ngrid = [1, 1]\nhot = [1]\n";
    let error = render(truth(), &scene(all_hot), &options(Method::Mls)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no response lies in the cold zone"),
        "{error}"
    );
}

#[test]
fn nan_in_a_model_is_named() {
    let mut model = truth().clone();
    model.modes[3].shape.0[5].im = f64::NAN;
    let error = render(&model, &cell_scene([2, 2], 1, ""), &options(Method::Mls)).unwrap_err();
    assert!(
        error.to_string().contains("modes[4]") && error.to_string().contains("NaN"),
        "{error}"
    );
    let mut model = truth().clone();
    model.residual_terms.terms[0].matrix.0[[0, 0]].re = f64::INFINITY;
    let error = render(&model, &cell_scene([2, 2], 1, ""), &options(Method::Mls)).unwrap_err();
    assert!(
        error.to_string().contains("residual_terms.terms[1]"),
        "{error}"
    );
    let mut model = truth().clone();
    model.modes[0].participation.0.pop();
    let error = render(&model, &cell_scene([2, 2], 1, ""), &options(Method::Mls)).unwrap_err();
    assert!(
        error.to_string().contains("sizes disagree")
            && error.to_string().contains("modes[1].participation"),
        "{error}"
    );
}

#[test]
fn a_model_that_does_not_move_is_refused() {
    let mut model = truth().clone();
    model.modes.clear();
    model.residual_terms.terms.clear();
    let error = render(&model, &cell_scene([2, 2], 1, ""), &options(Method::Mls)).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no actuator in use moves any response"),
        "{error}"
    );
    model = truth().clone();
    model.modes.iter_mut().for_each(|mode| mode.in_band = false);
    let error = render(&model, &cell_scene([2, 2], 1, ""), &options(Method::Modal)).unwrap_err();
    assert!(
        error.to_string().contains("no mode inside its band"),
        "{error}"
    );
}

#[test]
fn volts_have_a_limit_of_their_own() {
    let mut model = truth().clone();
    model.reference_unit = chladni_frf::ReferenceUnit::Volt;
    let error = render(
        &model,
        &cell_scene([2, 2], 1, "[actuators]\nmax_force_n = 1\n"),
        &options(Method::Mls),
    )
    .unwrap_err();
    assert!(
        error.to_string().contains("actuators.max_voltage_v"),
        "{error}"
    );
    let unlimited = rendered(&model, &cell_scene([2, 2], 1, ""), Method::Mls).weights;
    assert!(unlimited
        .findings
        .iter()
        .any(|w| w.contains("no limit was kept")));
    assert_eq!(unlimited.indices.points.max_force_n, None);
    let limited = rendered(
        &model,
        &cell_scene([2, 2], 1, "[actuators]\nmax_voltage_v = 0.001\n"),
        Method::Mls,
    )
    .weights;
    assert!(limited.indices.points.max_voltage_v.unwrap() <= 0.001 * (1.0 + 1e-12));
}

#[test]
fn unusual_scenes_are_warned_about() {
    let warned = |text: &str, expected: &str| {
        let warnings = rendered(truth(), &scene(text), Method::PressureMatching)
            .weights
            .findings;
        assert!(
            warnings.iter().any(|warning| warning.contains(expected)),
            "{expected}: {warnings:?}"
        );
    };
    let zones = "[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n";
    let many = "[zones]\ngrid = [2, 2]\nhot = [1, 2, 3]\ncells_m = [0.0, 0.0, 0.268, \
                0.170]\n[actuators]\nuse = [\"101:+Z\", \"110:+Z\"]\n";
    warned(
        &format!("frequency_hz = 300\n{many}"),
        "3 hot cells or polygons for 2 actuators",
    );
    warned(&format!("frequency_hz = 240\n{zones}"), "250 to 350 Hz");
    warned(
        &format!("frequency_hz = 300\n{zones}area_m = [0, 0, 0.268, 0.170]\n"),
        "nothing outside them is judged",
    );
}

#[test]
fn responses_that_cannot_be_judged_are_left_out_and_named() {
    let mut model = truth().clone();
    model.responses[0] = "1:+X".parse().unwrap();
    model.nodes.retain(|node| node.label != 2);
    model.nodes[3].xyz_m = model.nodes[4].xyz_m;
    let rendering = rendered(&model, &cell_scene([2, 2], 4, ""), Method::PressureMatching);
    assert_eq!(rendering.field.responses.len(), 74);
    for expected in [
        "1 response left out: not along Z",
        "1 response left out: no position",
        "at the place of another one",
    ] {
        assert!(
            rendering
                .weights
                .findings
                .iter()
                .any(|warning| warning.contains(expected)),
            "{:?}",
            rendering.weights.findings
        );
    }
    model.nodes.clear();
    let error = render(&model, &cell_scene([2, 2], 4, ""), &options(Method::Mls)).unwrap_err();
    assert!(
        error.to_string().contains("no response can be judged"),
        "{error}"
    );
}

#[test]
fn a_response_measured_downwards_is_turned_round() {
    let scene = cell_scene([2, 2], 1, "");
    let mut model = truth().clone();
    model.responses[30] = "31:-Z".parse().unwrap();
    for mode in &mut model.modes {
        mode.shape.0[30] *= -1.0;
    }
    for term in &mut model.residual_terms.terms {
        term.matrix.0.row_mut(30).mapv_inplace(|value| -value);
    }
    for method in Method::ALL {
        let (turned, straight) = (
            rendered(&model, &scene, method),
            rendered(truth(), &scene, method),
        );
        assert_eq!(
            turned.field.velocity_m_per_s, straight.field.velocity_m_per_s,
            "{method}"
        );
    }
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
