//! No more modes and actuators than a scene needs.

use crate::common::{cell_scene, disturbed, panel, truth, FIT_40_DB};
use chladni_frf::{ErrorKind, FrfKind, ModalModel};
use chladni_plate::{simulate, Panel};
use chladni_render::{
    evaluate, needed_band, render, render_measured, render_with_others, Count, Method, On,
    RenderOptions, Rendering, Scene, Tone, Weights,
};
use num_complex::Complex64;

fn at(frequency_hz: f64, grid: [usize; 2], cell: usize) -> Scene {
    Scene {
        frequency_hz,
        ..cell_scene(grid, cell, "")
    }
}

fn with_actuators(model: &ModalModel, scene: &Scene, actuators: Count) -> Rendering {
    render(
        model,
        scene,
        &RenderOptions {
            actuators,
            ..Default::default()
        },
    )
    .unwrap()
}

#[test]
fn a_few_actuators_serve_a_scene() {
    for (frequency_hz, grid, cell, most) in [
        (335.0, [2, 2], 1, 7),
        (300.0, [2, 2], 1, 9),
        (300.0, [3, 3], 1, 5),
        (335.0, [3, 3], 1, 5),
    ] {
        let scene = at(frequency_hz, grid, cell);
        let rendering = with_actuators(&disturbed(truth(), FIT_40_DB, 1), &scene, Count::Auto);
        let used = rendering.weights.actuators_used;
        assert!(
            rendering.weights.feasible && rendering.weights.kappa.unwrap() >= 0.99,
            "{frequency_hz} Hz, {grid:?}"
        );
        assert!(
            used <= most,
            "{frequency_hz} Hz, {grid:?}: {used} actuators"
        );
        assert_eq!(
            rendering.weights.weights.len(),
            34,
            "actuators without a job are listed with weight 0"
        );
        let on_truth = evaluate(&rendering.weights, &scene, On::Model(truth()))
            .unwrap()
            .indices
            .points;
        assert!(
            on_truth.success_ratio >= 0.95,
            "{frequency_hz} Hz, {grid:?}: {on_truth:?}"
        );
    }
}

#[test]
fn a_number_of_actuators_is_kept() {
    let scene = at(300.0, [2, 2], 1);
    let [few, many] =
        [5, 20].map(|number| with_actuators(truth(), &scene, Count::Number(number)).weights);
    assert_eq!((few.actuators_used, few.feasible), (5, false));
    assert!(
        few.findings
            .iter()
            .any(|warning| warning.contains("5 were asked for")),
        "{:?}",
        few.findings
    );
    assert_eq!((many.actuators_used, many.feasible), (20, true));
    let all = with_actuators(truth(), &scene, Count::Number(50)).weights;
    assert_eq!(all.actuators_used, 34);
    assert!(
        all.findings
            .iter()
            .any(|warning| warning.contains("50 actuators were asked for, 34 may be used")),
        "{:?}",
        all.findings
    );
}

#[test]
fn an_impossible_scene_uses_all_actuators_and_says_so() {
    let scene = cell_scene([2, 2], 1, "[actuators]\nmax_force_n = 1e-4\n");
    let weights = with_actuators(truth(), &scene, Count::Auto).weights;
    assert_eq!(weights.actuators_used, 34);
    assert!(
        weights
            .findings
            .iter()
            .any(|warning| warning.contains("not even all of them")),
        "{:?}",
        weights.findings
    );
}

#[test]
fn a_few_modes_and_residual_terms_do_as_well_as_all() {
    let served = |rendering: &Rendering, scene: &Scene| {
        evaluate(&rendering.weights, scene, On::Model(truth()))
            .unwrap()
            .indices
    };
    for (frequency_hz, most) in [(300.0, 9), (335.0, 14)] {
        let scene = at(frequency_hz, [2, 2], 1);
        let all = render(truth(), &scene, &Default::default()).unwrap();
        let few = render(
            truth(),
            &scene,
            &RenderOptions {
                modes: Count::Auto,
                ..Default::default()
            },
        )
        .unwrap();
        assert!(
            few.weights.modes_used <= most,
            "{frequency_hz} Hz: {} modes",
            few.weights.modes_used
        );
        let (few, all) = (served(&few, &scene), served(&all, &scene));
        assert!(
            few.points.success_ratio >= all.points.success_ratio - 0.01,
            "{frequency_hz} Hz: {few:?}"
        );
        let area = |indices: &chladni_render::Indices| {
            indices.area.unwrap().cold_ratio.unwrap() + indices.area.unwrap().hot_ratio.unwrap()
        };
        assert!(
            area(&few) >= area(&all) - 0.03,
            "{frequency_hz} Hz: {few:?} {all:?}"
        );
    }
}

#[test]
fn the_measured_line_judges_how_many_modes_are_enough() {
    let model = disturbed(truth(), FIT_40_DB, 2);
    let scene = at(300.0, [2, 2], 1);
    let options = RenderOptions {
        modes: Count::Auto,
        ..Default::default()
    };
    let few = render_measured(&model, &scene, &options, Some(&panel().frf))
        .unwrap()
        .weights;
    assert!(few.modes_used <= 12, "{} modes", few.modes_used);
    assert!(
        evaluate(&few, &scene, On::Frf(&panel().frf))
            .unwrap()
            .indices
            .points
            .success_ratio
            >= 0.98
    );
    let refused = |scene: &Scene, frf| {
        render_measured(&model, scene, &options, Some(frf))
            .map(|_| ())
            .unwrap_err()
    };
    let error = refused(&at(90.0, [2, 2], 1), &panel().frf);
    assert!(
        error.to_string().contains("no line at the drive frequency"),
        "{error}"
    );
    let mut other = panel().frf.clone();
    other.references[3] = "999:+Z".parse().unwrap();
    let error = refused(&scene, &other);
    assert!(
        error.to_string().contains("104:+Z") && error.kind == ErrorKind::BadData,
        "{error}"
    );
}

#[test]
fn a_scene_that_one_mode_alone_meets_is_not_met() {
    let scene = at(300.0, [2, 2], 1);
    let options = RenderOptions {
        modes: Count::Number(1),
        ..Default::default()
    };
    let weights = render(&disturbed(truth(), FIT_40_DB, 1), &scene, &options)
        .unwrap()
        .weights;
    assert!(weights.is_met() && !weights.feasible);
    let doubt = weights.reservation().unwrap();
    assert!(doubt.contains("with 1 mode, not in the whole"), "{doubt}");
}

/// Modes that are counted by the evidence grow to what the actuators chosen need; a number that is
/// asked for stays, and its drive is refuted.
#[test]
fn modes_are_judged_with_the_actuators_that_were_chosen() {
    let scene = at(300.0, [2, 2], 1);
    let model = disturbed(truth(), FIT_40_DB, 1);
    let with = |modes: Count| {
        let options = RenderOptions {
            modes,
            actuators: Count::Auto,
            ..Default::default()
        };
        render(&model, &scene, &options).unwrap().weights
    };
    let one = with(Count::Number(1));
    assert!(one.modes_used == 1 && one.is_met() && !one.feasible);
    assert!(with(Count::Auto).feasible);
}

#[test]
fn what_some_actuators_cannot_is_not_impossible() {
    let scene = at(300.0, [2, 2], 1);
    let weights = with_actuators(truth(), &scene, Count::Number(3)).weights;
    let has = |code: &str| weights.findings.iter().any(|finding| finding.code == code);
    assert!(!weights.feasible && weights.ceiling.unwrap().forbids());
    assert!(has("too-few-actuators") && has("scene-not-met") && !has("scene-impossible"));
}

#[test]
fn one_actuator_is_asked_for_in_the_singular() {
    let weights = with_actuators(truth(), &at(300.0, [2, 2], 1), Count::Number(1)).weights;
    let told = weights.own_finding("too-few-actuators").unwrap();
    for words in ["1 was asked for", "another one may serve more"] {
        assert!(told.text.contains(words), "{told}");
    }
}

#[test]
fn where_too_few_modes_are_asked_for_the_replay_says_so() {
    let scene = at(335.0, [2, 2], 1);
    let options = RenderOptions {
        modes: Count::Number(1),
        method: Method::Tikhonov.into(),
        ..Default::default()
    };
    let weights = render(truth(), &scene, &options).unwrap().weights;
    assert_eq!(weights.modes_used, 1);
    assert!(
        weights
            .findings
            .iter()
            .any(|warning| warning.contains("replayed through the whole model")),
        "{:?}",
        weights.findings
    );
}

#[test]
fn viscous_models_fold_their_modes_too() {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 300.0);
    let mut model = simulate(&panel, None, None).unwrap().truth;
    model.damping = chladni_frf::Damping::Viscous;
    let scene = at(300.0, [2, 2], 1);
    let few = render(
        &model,
        &scene,
        &RenderOptions {
            modes: Count::Auto,
            ..Default::default()
        },
    )
    .unwrap();
    assert!(few.weights.modes_used <= 9, "{}", few.weights.modes_used);
    let on_whole = evaluate(&few.weights, &scene, On::Model(&model))
        .unwrap()
        .indices
        .points;
    assert_eq!(on_whole.min_ratio, 1.0);
}

#[test]
fn the_method_of_modal_coefficients_is_given_at_least_one_mode() {
    let options = RenderOptions {
        method: Method::Modal.into(),
        modes: Count::Auto,
        ..Default::default()
    };
    for frequency_hz in [300.0, 330.0] {
        let scene = at(frequency_hz, [2, 2], 1);
        let weights = render(truth(), &scene, &options).unwrap().weights;
        let steps = weights.modal.unwrap();
        assert!(weights.modes_used >= 1, "{frequency_hz} Hz");
        assert_eq!(steps.frequency_hz.len(), weights.modes_used);
    }
}

#[test]
fn counts_are_words_or_numbers() {
    assert_eq!(
        ["all", "auto", "12"].map(|text| text.parse::<Count>().unwrap()),
        [Count::All, Count::Auto, Count::Number(12)]
    );
    for text in ["0", "-1", "many", ""] {
        assert_eq!(
            text.parse::<Count>().unwrap_err().kind,
            ErrorKind::Usage,
            "{text}"
        );
    }
}

#[test]
fn one_subset_of_actuators_serves_several_scenes() {
    let scenes = [at(335.0, [2, 2], 1), at(335.0, [2, 2], 4)];
    let options = RenderOptions {
        actuators: Count::Auto,
        ..Default::default()
    };
    let used = |rendering: &Rendering| -> Vec<bool> {
        rendering
            .weights
            .weights
            .iter()
            .map(|weight| weight.amplitude > 0.0)
            .collect()
    };
    let count = |used: &[bool]| used.iter().filter(|&&used| used).count();
    let together = [0, 1].map(|k| {
        render_with_others(truth(), &scenes[k], &scenes[1 - k..2 - k], &options, None).unwrap()
    });
    let alone = scenes
        .each_ref()
        .map(|scene| with_actuators(truth(), scene, Count::Auto));
    assert_eq!(
        used(&together[0]),
        used(&together[1]),
        "the same actuators, whichever scene is rendered"
    );
    assert!(together.iter().all(|rendering| rendering.weights.feasible));
    // opposite corners alone take different actuators; a subset for both is smaller than
    // the two together
    let both: Vec<bool> = used(&alone[0])
        .iter()
        .zip(used(&alone[1]))
        .map(|(a, b)| *a || b)
        .collect();
    let shared = count(&used(&together[0]));
    assert!(
        shared < count(&both) && shared >= count(&used(&alone[0])),
        "{shared} of {}",
        count(&both)
    );
}

/// Each tone and each scene keeps other modes; a rig has one set of actuators.
#[test]
fn the_actuators_are_the_same_where_every_scene_keeps_its_own_modes() {
    let options = RenderOptions {
        modes: Count::Auto,
        actuators: Count::Auto,
        ..Default::default()
    };
    let used = |weights: &Weights| -> Vec<bool> {
        let driven = weights.weights.iter();
        driven.map(|weight| weight.amplitude > 0.0).collect()
    };
    let mut chord = at(335.0, [2, 2], 1);
    let second = Tone {
        frequency_hz: 300.0,
        share: chord.share,
    };
    chord.other_tones.push(second);
    let other = at(320.0, [2, 2], 4);
    let with = |scene: &Scene, other: &Scene| {
        let others = std::slice::from_ref(other);
        render_with_others(truth(), scene, others, &options, None).unwrap()
    };
    let (first, second) = (with(&chord, &other).weights, with(&other, &chord).weights);
    let tone = &first.other_tones[0];
    assert!(first.feasible && tone.feasible && second.feasible);
    assert_eq!(used(&first), used(tone), "tones of one scene");
    assert_eq!(used(&first), used(&second), "scenes");
    assert!(used(&first).contains(&false));
}

#[test]
fn a_scene_needs_a_part_of_the_band() {
    let whole = [2.0, 1000.0];
    for frequency_hz in [150.0, 300.0, 335.0] {
        let scene = at(frequency_hz, [2, 2], 1);
        let needed = needed_band(truth(), &scene, whole).unwrap();
        let [low, high] = needed.band_hz;
        assert!(
            low < frequency_hz && frequency_hz < high && high < whole[1],
            "{frequency_hz} Hz: {needed:?}"
        );
        assert!(
            needed.inside_hz.iter().all(|hz| (low..high).contains(hz))
                && !needed.left_out_hz.iter().any(|hz| (low..high).contains(hz))
        );
        // modes alone, the others as the first terms of their series about zero and
        // infinity
        let omega = |hz: f64| std::f64::consts::TAU * hz;
        let x = Complex64::from(omega(frequency_hz).powi(2));
        let mut error = ndarray::Array2::<Complex64>::zeros((77, 34));
        for mode in truth()
            .modes
            .iter()
            .filter(|mode| needed.left_out_hz.contains(&mode.frequency_hz))
        {
            let s = omega(mode.frequency_hz).powi(2) * Complex64::new(1.0, mode.loss_factor);
            let series: Complex64 = match s.norm() > x.norm() {
                true => (0..3).map(|p| x.powi(p) / s.powi(p + 1)).sum(),
                false => (0..2).map(|p| -s.powi(p) / x.powi(p + 1)).sum(),
            };
            let rest = Complex64::new(0.0, omega(frequency_hz)) * ((s - x).inv() - series);
            error.indexed_iter_mut().for_each(|((i, j), error)| {
                *error += rest * mode.shape.0[i] * mode.participation.0[j]
            });
        }
        let norm = |matrix: &ndarray::Array2<Complex64>| {
            matrix.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
        };
        let left_out = norm(&error) / norm(&truth().frf_matrix(FrfKind::Mobility, frequency_hz));
        assert!(
            left_out <= 4e-3 && left_out <= 2.0 * needed.error_relative,
            "{frequency_hz} Hz: {left_out} of {}",
            needed.error_relative
        );
    }
}
