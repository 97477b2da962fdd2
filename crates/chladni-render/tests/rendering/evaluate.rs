//! Given weights on other data: measured lines and other models.

use crate::common::{cell_scene, panel, truth};
use chladni_frf::{ErrorKind, FrfKind, FrfSet, FrfValues};
use chladni_render::{evaluate, render, On, Rendering, Scene, Weights};
use num_complex::Complex64;

fn corner() -> (Scene, Rendering) {
    let scene = cell_scene([2, 2], 1, "");
    let rendering = render(truth(), &scene, &Default::default()).unwrap();
    (scene, rendering)
}

fn noisy() -> FrfSet {
    panel().frf.clone()
}

#[test]
fn the_model_itself_gives_back_the_indices_of_the_rendering() {
    let (scene, rendering) = corner();
    let evaluation = evaluate(&rendering.weights, &scene, On::Model(truth())).unwrap();
    assert_eq!(evaluation.indices, rendering.weights.indices);
    assert_eq!(evaluation.field, rendering.field);
}

#[test]
fn a_measured_line_confirms_the_drive() {
    let (scene, rendering) = corner();
    let evaluation = evaluate(&rendering.weights, &scene, On::Frf(&noisy())).unwrap();
    assert_eq!(evaluation.frequency_hz, 300.0);
    assert!(
        evaluation.indices.points.min_ratio >= 0.95,
        "{:?}",
        evaluation.indices
    );
    assert_eq!(evaluation.indices.points.silence_ratio, 53.0 / 68.0);
    assert!(evaluation.indices.area.unwrap().hot_ratio.unwrap() > 0.9);
}

#[test]
fn every_kind_of_frf_gives_the_same_indices() {
    let (scene, rendering) = corner();
    let of = |frf: &FrfSet| {
        evaluate(&rendering.weights, &scene, On::Frf(frf))
            .unwrap()
            .field
            .velocity_m_per_s
    };
    let mobility = of(&noisy());
    for kind in [FrfKind::Receptance, FrfKind::Accelerance] {
        let other = of(&noisy().to_kind(kind).unwrap());
        let error = mobility
            .iter()
            .zip(&other)
            .map(|(a, b)| (a - b).norm())
            .fold(0.0, f64::max);
        assert!(error < 1e-15, "{kind}: {error} m/s");
    }
    let unknown = FrfSet {
        kind: None,
        ..noisy()
    };
    assert_eq!(
        evaluate(&rendering.weights, &scene, On::Frf(&unknown))
            .unwrap_err()
            .kind,
        ErrorKind::UnknownFrfKind
    );
}

#[test]
fn the_line_must_lie_within_half_a_line_of_the_drive() {
    let (scene, rendering) = corner();
    let at = |frequency_hz: f64| {
        let weights = Weights {
            frequency_hz,
            ..rendering.weights.clone()
        };
        evaluate(&weights, &scene, On::Frf(&noisy()))
    };
    // Lines every 10 Hz from 100 to 1000 Hz.
    let near = at(304.9).unwrap();
    assert_eq!(near.frequency_hz, 300.0);
    assert!(
        near.findings
            .iter()
            .any(|warning| warning.contains("the line at 300 Hz")),
        "{:?}",
        near.findings
    );
    assert!(
        near.findings
            .iter()
            .any(|warning| warning.contains("judged there, not at the scene's 300 Hz")),
        "{:?}",
        near.findings
    );
    assert_eq!(at(95.1).unwrap().frequency_hz, 100.0);
    for outside in [94.9, 1005.1] {
        let error = at(outside).unwrap_err().to_string();
        assert!(
            error.contains("no line at the drive frequency") && error.contains("100 to 1000 Hz"),
            "{error}"
        );
    }
}

#[test]
fn unmeasured_pairs_matter_only_where_they_are_driven() {
    let (scene, rendering) = corner();
    let mut frf = noisy();
    let FrfValues::F64(values) = &mut frf.values else {
        panic!("double precision")
    };
    values
        .slice_mut(ndarray::s![7, 3, ..])
        .fill(Complex64::new(f64::NAN, f64::NAN));
    let evaluation = evaluate(&rendering.weights, &scene, On::Frf(&frf)).unwrap();
    assert_eq!(evaluation.field.responses.len(), 76);
    assert!(
        evaluation
            .findings
            .iter()
            .any(|warning| warning.contains("1 response not judged")),
        "{:?}",
        evaluation.findings
    );
    let mut without = rendering.weights.clone();
    (without.weights[3].re, without.weights[3].im) = (0.0, 0.0);
    assert_eq!(
        evaluate(&without, &scene, On::Frf(&frf))
            .unwrap()
            .field
            .responses
            .len(),
        77
    );
}

#[test]
fn an_actuator_that_the_data_lack_is_named() {
    let (scene, rendering) = corner();
    let mut weights = rendering.weights;
    weights.weights[5].reference = "999:+Z".parse().unwrap();
    let error = evaluate(&weights, &scene, On::Model(truth())).unwrap_err();
    let help = error.help.as_deref();
    assert_eq!(
        help,
        Some("render the scene again with this model or these data")
    );
    let error = error.to_string();
    assert!(
        error.contains("999:+Z") && error.contains("the weights drive"),
        "{error}"
    );
}

#[test]
fn weights_in_volts_are_not_judged_on_forces() {
    let (scene, mut rendering) = corner();
    rendering
        .weights
        .weights
        .iter_mut()
        .for_each(|weight| weight.unit = chladni_frf::ReferenceUnit::Volt);
    let error = evaluate(&rendering.weights, &scene, On::Model(truth()))
        .unwrap_err()
        .to_string();
    assert!(error.contains("different units"), "{error}");
}

#[test]
fn a_reference_of_the_opposite_sense_turns_its_weight_round() {
    let (scene, rendering) = corner();
    let mut weights = rendering.weights.clone();
    let first = &mut weights.weights[0];
    (first.reference, first.re, first.im) = ("101:-Z".parse().unwrap(), -first.re, -first.im);
    assert_eq!(
        evaluate(&weights, &scene, On::Model(truth()))
            .unwrap()
            .field,
        rendering.field
    );
}

#[test]
fn silence_scores_the_cold_points() {
    let (scene, mut rendering) = corner();
    rendering
        .weights
        .weights
        .iter_mut()
        .for_each(|weight| (weight.re, weight.im) = (0.0, 0.0));
    let points = evaluate(&rendering.weights, &scene, On::Frf(&noisy()))
        .unwrap()
        .indices
        .points;
    assert_eq!(
        (points.hot_ratio, points.cold_ratio, points.min_ratio),
        (0.0, 1.0, 0.0)
    );
    assert_eq!(points.success_ratio, points.silence_ratio);
    assert_eq!((points.contrast_db, points.margin_db), (None, None));
}

#[test]
fn limits_and_tones_of_the_scene_that_weights_do_not_keep_are_named() {
    let (scene, rendering) = corner();
    let found = |scene: &Scene, code: &str| {
        let evaluation = evaluate(&rendering.weights, scene, On::Model(truth())).unwrap();
        let mut findings = evaluation.findings.into_iter();
        findings.find(|finding| finding.code == code)
    };
    let largest = rendering.weights.indices.points.max_force_n.unwrap();
    let at_most =
        |limit: f64| cell_scene([2, 2], 1, &format!("[actuators]\nmax_force_n = {limit}"));
    let beyond = found(&at_most(0.1 * largest), "drive-beyond-limit").unwrap();
    assert!(beyond.text.contains("10.000 times"), "{beyond:?}");
    assert!(found(&at_most(largest), "drive-beyond-limit").is_none());
    // a limit holds where none is named, too
    let mut loud = rendering.weights.clone();
    for weight in &mut loud.weights {
        (weight.re, weight.im) = (weight.re * 0.2 / largest, weight.im * 0.2 / largest);
    }
    let judged = evaluate(&loud, &scene, On::Model(truth())).unwrap();
    let beyond = |finding: &&chladni_frf::Finding| finding.code == "drive-beyond-limit";
    let told = judged.findings.iter().find(beyond).unwrap();
    assert!(told.text.contains("2.000 times"), "{told:?}");
    let zones = "[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n";
    let two = crate::common::scene(&format!("frequency_hz = [300.0, 310.0]\n{zones}"));
    let silent = found(&two, "tone-without-drive").unwrap();
    assert!(silent.text.contains("310 Hz"), "{silent:?}");
    assert!(found(&scene, "tone-without-drive").is_none());
}

#[test]
fn limits_of_volts_current_and_effort_are_held_against_a_drive() {
    let mut model = truth().clone();
    model.reference_unit = chladni_frf::ReferenceUnit::Volt;
    let weights = render(&model, &cell_scene([2, 2], 1, ""), &Default::default())
        .unwrap()
        .weights;
    let largest = weights.indices.points.max_voltage_v.unwrap();
    let squares = weights.weights.iter().map(|w| w.re.powi(2) + w.im.powi(2));
    let effort = squares.sum::<f64>().sqrt();
    let found = |actuators: &str| {
        let scene = cell_scene([2, 2], 1, &format!("[actuators]\n{actuators}\n"));
        let evaluation = evaluate(&weights, &scene, On::Model(&model)).unwrap();
        let mut findings = evaluation.findings.into_iter();
        findings.find(|finding| finding.code == "drive-beyond-limit")
    };
    let volts = |times: f64| format!("max_voltage_v = {}", largest / times);
    let current = |times: f64| {
        format!(
            "max_current_a = {}\nresistance_ohm = 8",
            largest / times / 8.0
        )
    };
    let all = |times: f64| format!("max_effort = {}", effort / times);
    let [each, of_all] = ["V per actuator", "V on the root of the sum of squares"];
    for (actuators, times, limit) in [
        (volts(4.0), "4.000 times", each),
        (current(4.0), "4.000 times", each),
        (all(4.0), "4.000 times", of_all),
        (volts(8.0) + "\n" + &all(4.0), "8.000 times", each),
        (volts(4.0) + "\n" + &all(8.0), "8.000 times", of_all),
        (volts(0.5) + "\n" + &all(4.0), "4.000 times", of_all),
    ] {
        let said = found(&actuators).expect(&actuators).text;
        assert!(
            said.contains(times) && said.ends_with(limit),
            "{actuators}: {said}"
        );
    }
    for actuators in [
        volts(0.5),
        current(0.5),
        all(0.5),
        volts(1.0) + "\n" + &all(1.0),
    ] {
        assert!(found(&actuators).is_none(), "{actuators}");
    }
}

#[test]
fn a_hot_polygon_without_a_response_is_named() {
    let square = |x: f64| {
        let far = x + 0.1;
        format!("[[{x}, 0.02], [{far}, 0.02], [{far}, 0.06], [{x}, 0.06]]")
    };
    let polygon = |kind: &str, points: String| {
        format!("[[zones.polygon]]\nkind = \"{kind}\"\npoints_m = {points}\n")
    };
    let scene = |second: String| {
        let [ignored, first] = [polygon("ignore", square(0.2)), polygon("hot", square(0.0))];
        crate::common::scene(&format!(
            "frequency_hz = 300.0\n[zones]\n{ignored}{first}{second}"
        ))
    };
    let of = |scene: &Scene| {
        let weights = render(truth(), scene, &Default::default()).unwrap().weights;
        let mut findings = weights.findings.iter().cloned();
        findings.find(|finding| finding.code == "zone-without-response")
    };
    assert!(of(&scene(String::new())).is_none());
    let far = of(&scene(polygon("hot", square(1.0)))).unwrap();
    assert!(far.text.contains("polygon 3"), "{far:?}");
}

#[test]
fn motion_far_above_the_threshold_is_warned_about() {
    let (scene, mut rendering) = corner();
    rendering
        .weights
        .weights
        .iter_mut()
        .for_each(|weight| (weight.re, weight.im) = (100.0 * weight.re, 100.0 * weight.im));
    let warnings = evaluate(&rendering.weights, &scene, On::Model(truth()))
        .unwrap()
        .findings;
    assert!(
        warnings
            .iter()
            .any(|warning| warning.contains("dB above the threshold")),
        "{warnings:?}"
    );
}
