//! Actuators, responses, models and scenes out of the ordinary: refused, named or warned
//! about.

use super::rendered::{options, rendered};
use crate::common::{cell_scene, scene, truth};
use chladni_frf::{ErrorKind, Severity};
use chladni_render::{render, Method};
use std::fmt::Write as _;

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
fn many_responses_above_each_other_are_refused_and_many_at_one_place_are_warned_about() {
    let scene = cell_scene([2, 2], 4, "");
    let mut model = truth().clone();
    model.nodes[0].xyz_m = model.nodes[8].xyz_m;
    model.nodes[0].xyz_m[2] = -0.003; // a driving point on the back
    assert!(render(&model, &scene, &options(Method::PressureMatching)).is_ok());
    for k in 0..8 {
        model.nodes[k].xyz_m = model.nodes[8].xyz_m;
    }
    let rendering = rendered(&model, &scene, Method::PressureMatching);
    let mut findings = rendering.weights.findings.iter();
    let coincide = findings.find(|finding| finding.code == "responses-coincide");
    assert_eq!(coincide.unwrap().severity, Severity::Caution);
    model.nodes[3].xyz_m[2] = 0.01;
    let error = render(&model, &scene, &options(Method::PressureMatching)).unwrap_err();
    assert_eq!(error.field.as_deref(), Some("responses"), "{error}");
    assert!(error.to_string().contains("z = 0.01 m"), "{error}");
}
