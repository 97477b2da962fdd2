//! Conic programs and the certified ceiling, judged by the truth of the virtual panel.

use crate::common::{actuators_m, cell_scene, disturbed, panel, truth, DRIFT, FIT_40_DB};
use chladni_frf::ModalModel;
use chladni_plate::{simulate, Panel};
use chladni_render::{
    evaluate, render, Ceiling, Ground, Method, MethodChoice, On, RenderOptions, Rendering, Scene,
    Weights,
};
use ndarray::Array1;
use num_complex::Complex64;

fn rendered(model: &ModalModel, scene: &Scene, method: impl Into<MethodChoice>) -> Rendering {
    render(
        model,
        scene,
        &RenderOptions {
            method: method.into(),
            ..Default::default()
        },
    )
    .unwrap()
}

fn drive(rendering: &Rendering) -> Array1<Complex64> {
    rendering
        .weights
        .weights
        .iter()
        .map(|weight| weight.value())
        .collect()
}

/// Hot, cold and all ground served on the true plate, on a 4 mm grid over the scanned
/// window.
fn on_window(rendering: &Rendering) -> [f64; 3] {
    let step = |first: f64, count: usize| (0..count).map(move |k| first + 0.004 * k as f64);
    let places: Vec<[f64; 2]> = step(0.025, 31)
        .flat_map(|y| step(0.034, 51).map(move |x| [x, y]))
        .collect();
    let field = panel()
        .plate
        .mobility_matrix(&places, &actuators_m(), 300.0)
        .unwrap()
        .dot(&drive(rendering));
    let served = |ground, inside: &dyn Fn(f64) -> bool| {
        let on = field
            .iter()
            .zip(&places)
            .filter(|(_, place)| rendering.zones.classify(**place) == ground);
        let judged: Vec<bool> = on.map(|(v, _)| inside(v.norm())).collect();
        (
            judged.iter().filter(|&&inside| inside).count() as f64,
            judged.len() as f64,
        )
    };
    let hot = served(Ground::Hot, &|v| rendering.limits.is_felt(v));
    let cold = served(Ground::Cold, &|v| rendering.limits.is_quiet(v));
    [
        hot.0 / hot.1,
        cold.0 / cold.1,
        (hot.0 + cold.0) / (hot.1 + cold.1),
    ]
}

#[test]
fn every_quarter_is_served_between_the_responses_and_under_drift_by_two_millinewtons() {
    for cell in 1..=4 {
        let scene = cell_scene([2, 2], cell, "");
        let rendering = rendered(
            &disturbed(truth(), FIT_40_DB, cell as u64),
            &scene,
            Method::Robust,
        );
        assert!(
            rendering.weights.feasible && rendering.weights.kappa.unwrap() > 1.0,
            "cell {cell}: {:?}",
            rendering.weights.kappa
        );
        let [hot, cold, total] = on_window(&rendering);
        assert!(
            hot >= 0.97 && cold >= 0.97 && total >= 0.98,
            "cell {cell}: hot {hot}, cold {cold}, total {total}"
        );
        let points = evaluate(&rendering.weights, &scene, On::Model(truth()))
            .unwrap()
            .indices
            .points;
        assert!(
            points.success_ratio >= 0.99 && points.max_force_n.unwrap() <= 2e-3,
            "cell {cell}: {points:?}"
        );
        for seed in 0..5 {
            let drifted = evaluate(
                &rendering.weights,
                &scene,
                On::Model(&disturbed(truth(), DRIFT, seed)),
            )
            .unwrap()
            .indices
            .points;
            assert!(
                drifted.success_ratio >= 0.97,
                "cell {cell}, seed {seed}: {drifted:?}"
            );
        }
    }
}

#[test]
fn the_four_kinds_of_cells_of_a_3_by_3_grid_are_served_between_the_responses() {
    for cell in [1, 2, 4, 5] {
        let rendering = rendered(
            &disturbed(truth(), FIT_40_DB, 3),
            &cell_scene([3, 3], cell, ""),
            Method::Robust,
        );
        let [hot, _, total] = on_window(&rendering);
        assert!(
            hot >= 0.90 && total >= 0.96,
            "cell {cell}: hot {hot}, total {total}"
        );
    }
}

/// The panel scanned to its edges: 23 × 15 responses.
fn whole_panel() -> ModalModel {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 300.0);
    (panel.responses.grid, panel.responses.spacing_m) = ([23, 15], 0.012_142);
    simulate(&panel, None, None).unwrap().truth
}

fn wide(cell: usize) -> Scene {
    cell_scene([3, 3], cell, "transition_m = 0.020\n")
}

#[test]
fn the_centre_of_the_whole_panel_is_proven_impossible() {
    let rendering = rendered(&whole_panel(), &wide(5), Method::Robust);
    let Ceiling {
        possible_db,
        asked_db,
        reached_db,
    } = rendering.weights.ceiling.expect("a ceiling");
    assert!(!rendering.weights.feasible);
    // the study, on a slightly other grid: proven 3.49 dB, found 3.47 dB
    assert!(
        (3.3..3.9).contains(&possible_db) && (asked_db - 4.0).abs() < 1e-9,
        "possible {possible_db}, asked {asked_db}"
    );
    assert!(
        reached_db <= possible_db && reached_db > possible_db - 0.2,
        "found {reached_db}, possible {possible_db}"
    );
    let said = rendering
        .weights
        .findings
        .iter()
        .find(|warning| warning.contains("impossible"))
        .expect("a warning");
    assert!(
        said.contains("possible 3.") && said.contains("asked 4.0 dB"),
        "{said}"
    );
}

#[test]
fn conic_programs_come_within_a_fifth_of_a_decibel_of_what_is_proven_on_symmetric_scenes() {
    let model = whole_panel();
    for cell in [2, 4] {
        let Ceiling {
            possible_db,
            reached_db,
            ..
        } = rendered(&model, &wide(cell), MethodChoice::Best)
            .weights
            .ceiling
            .expect("a ceiling");
        assert!(
            reached_db <= possible_db + 1e-6 && reached_db > possible_db - 0.2,
            "cell {cell}: {reached_db} of {possible_db} dB"
        );
    }
}

#[test]
fn telling_cases_apart_brings_the_proof_within_a_fifth_of_a_decibel_where_phases_matter() {
    let model = whole_panel();
    // more is asked than can be, so that it is proven
    for cell in [4, 5] {
        let scene = cell_scene(
            [3, 3],
            cell,
            "transition_m = 0.010\n[threshold]\nlimen_db = 3.0\n",
        );
        let [quick, thorough] =
            [MethodChoice::Only(Method::Robust), MethodChoice::Best].map(|method| {
                rendered(&model, &scene, method)
                    .weights
                    .ceiling
                    .expect("a ceiling of what is not met")
            });
        assert!(
            thorough.possible_db < quick.possible_db,
            "cell {cell}: {thorough:?}, {quick:?}"
        );
        assert!(
            thorough.reached_db <= thorough.possible_db
                && thorough.reached_db > thorough.possible_db - 0.2,
            "cell {cell}: {thorough:?}"
        );
    }
}

#[test]
fn the_ceiling_of_a_drive_that_no_row_bounds_alone_is_proven_as_well() {
    // of these rows few count, and a drive is left that none of them sees
    let effort = "frequency_hz = 330.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[actuators]\n\
                  max_effort = 0.0005\n";
    let mut dead = truth().clone();
    dead.modes
        .iter_mut()
        .for_each(|mode| mode.participation.0[0] = 0.0.into());
    let terms = dead.residual_terms.terms.iter_mut();
    terms.for_each(|term| term.matrix.0.column_mut(0).fill(0.0.into()));
    let force = "frequency_hz = 330.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[actuators]\n\
                 max_force_n = 0.0005\n";
    for (model, text) in [(truth(), effort), (&dead, force)] {
        let weights = rendered(model, &crate::common::scene(text), MethodChoice::Best).weights;
        let ceiling = weights.ceiling.expect("a ceiling");
        assert!(
            !weights.feasible && ceiling.reached_db <= ceiling.possible_db,
            "{ceiling:?}"
        );
    }
}

#[test]
fn a_scene_that_mls_meets_within_a_tight_limit_is_met_by_the_conic_methods() {
    let scene = crate::common::scene(
        "frequency_hz = 264.17\n[zones]\ngrid = [3, 2]\nhot = [6]\n\
         area_m = [0.05, 0.05, 0.2, 0.12]\ntransition_m = 0.02\n[actuators]\n\
         max_force_n = 0.0002576\nmax_effort = 0.000955\n[drift]\nisotropic_relative = 0.0\n\
         drive_relative = 0.0\n",
    );
    for method in [
        Method::Mls.into(),
        MethodChoice::Default,
        MethodChoice::Best,
        Method::MinEffort.into(),
    ] {
        let weights = rendered(truth(), &scene, method).weights;
        assert!(weights.feasible, "{method}: {:?}", weights.indices.points);
    }
}

#[test]
fn margin_takes_little_of_the_force_that_is_allowed() {
    let with = |limit: &str| {
        let text = format!(
            "frequency_hz = 335.0\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = \
                            [0.0, 0.0, 0.268, 0.170]\n{limit}"
        );
        let points = rendered(truth(), &crate::common::scene(&text), Method::Robust)
            .weights
            .indices
            .points;
        (points.max_force_n.unwrap(), points.margin_db.unwrap())
    };
    let [(little, none), (given, some), (much, more)] = [
        "[actuators]\nmax_force_n = 0.02\n",
        "",
        "[actuators]\nmax_force_n = 0.4\n",
    ]
    .map(with);
    assert!(
        little < 0.8 * given && given <= 0.02 * 0.1 && much <= 0.02 * 0.4,
        "{little} {given} {much} N"
    );
    assert!(
        none > 0.0 && none < some && none < more,
        "{none} {some} {more} dB"
    );
}

#[test]
fn no_method_beats_the_certified_ceiling() {
    let scene = cell_scene([2, 2], 1, "[actuators]\nmax_force_n = 2e-4\n");
    let ceiling = rendered(truth(), &scene, Method::Robust)
        .weights
        .ceiling
        .expect("a scene that is not met has a ceiling");
    for method in Method::ALL {
        let rendering = rendered(truth(), &scene, method);
        let points = rendering.weights.indices.points;
        // scaled so that the loudest cold response meets its limit, or the strongest
        // actuator its own
        let cold = rendering
            .field
            .ground
            .iter()
            .zip(&rendering.field.velocity_m_per_s)
            .filter(|(g, _)| **g == Ground::Cold);
        let loudest = cold.map(|(_, v)| v.norm()).fold(0.0, f64::max);
        let gain =
            (rendering.limits.cold_m_per_s / loudest).min(2e-4 / points.max_force_n.unwrap());
        let hot = rendering
            .field
            .ground
            .iter()
            .zip(&rendering.field.velocity_m_per_s)
            .filter(|(g, _)| **g == Ground::Hot);
        let least = hot.map(|(_, v)| v.norm()).fold(f64::INFINITY, f64::min);
        let level = 20.0 * (gain * least / rendering.limits.cold_m_per_s).log10();
        assert!(
            level <= ceiling.possible_db + 1e-6,
            "{method}: {level} dB of {ceiling:?}"
        );
    }
    assert!(
        ceiling.forbids() && ceiling.reached_db <= ceiling.possible_db,
        "{ceiling:?}"
    );
}

#[test]
fn least_effort_needs_less_than_any_other_method_that_serves_every_response() {
    let scene = cell_scene([2, 2], 1, "");
    let effort = |method: Method| {
        let rendering = rendered(truth(), &scene, method);
        (
            rendering.weights.feasible,
            drive(&rendering)
                .iter()
                .map(Complex64::norm_sqr)
                .sum::<f64>()
                .sqrt(),
        )
    };
    let (feasible, least) = effort(Method::MinEffort);
    assert!(feasible);
    for method in [Method::Robust, Method::Mls] {
        let (feasible, other) = effort(method);
        assert!(
            feasible && least < other,
            "{method}: {other} N, least {least} N"
        );
    }
}

#[test]
fn both_limits_of_the_drive_are_kept() {
    let free = rendered(truth(), &cell_scene([2, 2], 1, ""), Method::Robust);
    let effort = drive(&free)
        .iter()
        .map(Complex64::norm_sqr)
        .sum::<f64>()
        .sqrt();
    for (limits, each, all) in [
        (format!("max_effort = {}", 0.7 * effort), 0.1, 0.7 * effort),
        (
            format!(
                "max_force_n = {}",
                0.8 * free.weights.indices.points.max_force_n.unwrap()
            ),
            0.8 * free.weights.indices.points.max_force_n.unwrap(),
            1.0,
        ),
    ] {
        for method in Method::ALL {
            let rendering = rendered(
                truth(),
                &cell_scene([2, 2], 1, &format!("[actuators]\n{limits}\n")),
                method,
            );
            let drive = drive(&rendering);
            let peak = drive.iter().map(|weight| weight.norm()).fold(0.0, f64::max);
            let sum = drive.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
            assert!(
                peak <= each * (1.0 + 1e-9) && sum <= all * (1.0 + 1e-9),
                "{method}, {limits}: {peak} N, {sum} N"
            );
        }
    }
}

#[test]
fn the_default_is_robust_and_fast_is_pressure_matching() {
    let scene = cell_scene([2, 2], 1, "");
    let method = |choice: &str| {
        rendered(truth(), &scene, choice.parse::<MethodChoice>().unwrap())
            .weights
            .method
    };
    assert_eq!(
        ["default", "best", "fast", "vast"].map(method),
        ["robust", "robust", "pressure-matching", "vast"]
    );
}

/// The usual error of amplifiers is borne unasked between modes; beside the mode at 299.4 Hz
/// it is not, and a note says so. An error that the scene names holds whatever it costs.
#[test]
fn usual_amplifiers_are_borne_where_margin_allows() {
    let weights = |frequency_hz, drift| {
        let scene = Scene {
            frequency_hz,
            ..cell_scene([2, 2], 1, drift)
        };
        rendered(truth(), &scene, Method::Robust).weights
    };
    let borne = |weights: &Weights| weights.options["drift"]["drive_relative"].as_f64();
    let is_noted = |weights: &Weights| {
        let mut findings = weights.findings.iter();
        findings.any(|finding| finding.code == "few-drive-errors-borne")
    };
    let between = weights(330.0, "");
    assert!(borne(&between) == Some(0.02) && !is_noted(&between));
    let beside = weights(300.0, "");
    assert!(borne(&beside) == Some(0.0) && is_noted(&beside));
    let named = weights(330.0, "[drift]\ndrive_relative = 0.0\n");
    assert!(borne(&named) == Some(0.0) && !is_noted(&named));
    assert_eq!(
        borne(&weights(300.0, "[drift]\ndrive_relative = 0.02\n")),
        Some(0.02)
    );
    assert_eq!(borne(&weights(275.0, "")), Some(0.01));
    let of_ninth = |drift| {
        let scene = Scene {
            frequency_hz: 350.0,
            ..cell_scene([3, 3], 2, drift)
        };
        let weights = rendered(truth(), &scene, Method::Robust).weights;
        weights.endurance.unwrap().survival_ratio
    };
    let [bearing, not] = ["", "[drift]\ndrive_relative = 0.0\n"].map(of_ninth);
    assert!(bearing > not + 0.3, "{bearing}, {not}");
}

#[test]
fn without_any_model_error_both_sides_share_the_margin() {
    let none = chladni_render::Drift {
        frequency_relative: 0.0,
        loss_factor_relative: 0.0,
        shape_relative: 0.0,
        isotropic_relative: 0.0,
        drive_relative: Some(0.0),
    };
    let options = RenderOptions {
        drift: none,
        method: Method::Robust.into(),
        ..Default::default()
    };
    let weights = render(truth(), &cell_scene([2, 2], 1, ""), &options)
        .unwrap()
        .weights;
    assert!(
        weights.feasible
            && weights.kappa.is_none()
            && weights.indices.points.margin_db.unwrap() > 1.0,
        "{:?}",
        weights.indices
    );
}

#[test]
fn a_louder_zone_moves_more() {
    let zones = |level: &str| {
        format!(
            "frequency_hz = 300\n[zones]\n[[zones.polygon]]\nkind = \"hot\"\npoints_m = [[0, 0], [0.09, 0], [0.09, 0.085], [0, 0.085]]\n{level}\n\
             [[zones.polygon]]\nkind = \"hot\"\npoints_m = [[0.178, 0.085], [0.268, 0.085], [0.268, 0.17], [0.178, 0.17]]\n"
        )
    };
    let least = |text: &str| {
        let rendering = rendered(truth(), &crate::common::scene(text), Method::Robust);
        assert!(
            rendering.weights.feasible,
            "{:?}",
            rendering.weights.findings
        );
        let field = &rendering.field;
        let hot = |low: bool| {
            let all = (0..field.ground.len()).filter(|&k| {
                field.ground[k] == Ground::Hot && (field.positions_m[k][0] < 0.134) == low
            });
            all.map(|k| field.velocity_m_per_s[k].norm())
                .fold(f64::INFINITY, f64::min)
        };
        [hot(true), hot(false)].map(|v| 20.0 * (v / rendering.limits.hot_m_per_s).log10())
    };
    let [equal, louder] = [least(&zones("")), least(&zones("level_db = 3.0"))];
    assert!(
        equal[0] >= -1e-9 && equal[1] >= -1e-9 && louder[0] >= 3.0 - 1e-9 && louder[1] >= -1e-9,
        "{equal:?} {louder:?}"
    );
}
