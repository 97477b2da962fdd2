//! The data of a page.

use crate::inputs::{f32s, input, rendering, scene, small};
use chladni_frf::{Checksum, Finding, Reason, Source, Trust};
use chladni_render::{evaluate, On};
use chladni_report::{data, html, scene_data, RenderedScene, ReportInput, Table};
use serde_json::json;

#[test]
fn the_data_hold_every_part_of_the_report() {
    let rendering = rendering(&small().truth);
    let tables = vec![Table {
        name: "accuracy.csv".into(),
        header: vec!["case".into()],
        rows: vec![vec!["panel".into()]],
    }];
    let input = ReportInput {
        tables,
        ..input(&small().truth, Some(&small().frf), &rendering)
    };
    let all = data(&input).unwrap();
    let modes = small().truth.in_band_modes().count();
    for part in ["model", "frfs", "cmif", "stabilization", "mac", "geometry"] {
        assert!(all[part].is_object(), "{part}");
    }
    assert_eq!(
        (
            all["frfs"]["total_pairs"].as_u64(),
            all["frfs"]["full"].as_array().map(Vec::len)
        ),
        (Some(288), Some(12))
    );
    assert_eq!(all["mac"]["count"].as_u64(), Some(modes as u64));
    let mac = f32s(&all["mac"]["values"]);
    assert!(
        (0..modes).all(|k| (mac[k * (modes + 1)] - 1.0).abs() < 1e-6),
        "a shape agrees with itself"
    );
    assert!(all["stabilization"]["orders"]
        .as_array()
        .is_some_and(|orders| orders.len() > 5));
    let scene = &all["scenes"][0];
    assert_eq!(
        scene["weights"].as_array().unwrap().len(),
        small().truth.references.len()
    );
    let velocity = f32s(&scene["field"]["velocity"]);
    for (k, v) in rendering.field.velocity_m_per_s.iter().enumerate() {
        assert!(
            (f64::from(velocity[2 * k]) - v.re).abs() < 1e-6 * v.norm()
                && (f64::from(velocity[2 * k + 1]) - v.im).abs() < 1e-6 * v.norm()
        );
    }
    assert_eq!(scene_data(&input), *scene);
    assert_eq!(all["tables"][0]["rows"][0][0], "panel");
}

#[test]
fn of_many_sources_the_first_are_named() {
    let mut model = small().truth.clone();
    model.source = (1..=34)
        .map(|k| Source {
            file: format!("scan_{k}.uff"),
            checksum: Checksum::Sha256("ab".repeat(32)),
        })
        .collect();
    let facts = data(&ReportInput {
        model: Some(&model),
        ..Default::default()
    })
    .unwrap()["model"]["facts"]
        .to_string();
    assert!(
        facts.contains("scan_1.uff, scan_2.uff, scan_3.uff and 31 more") && !facts.contains("abab"),
        "{facts}"
    );
}

#[test]
fn findings_come_by_weight_with_what_they_are_about_beside_the_sentence() {
    let mut model = small().truth.clone();
    (model.modes[1].trust, model.modes[1].reasons) = (
        Trust::Weak,
        vec![Reason::new("hardly", "hardly above the noise")].into(),
    );
    model.quality.findings = vec![
        Finding::caution("look", "look here"),
        Finding::fault("wrong", "this is wrong").help("mend it"),
    ];
    let all = data(&ReportInput {
        title: "Panel".into(),
        model: Some(&model),
        ..Default::default()
    })
    .unwrap();
    let findings = all["findings"].as_array().unwrap();
    let codes: Vec<&str> = findings
        .iter()
        .map(|finding| finding["code"].as_str().unwrap())
        .collect();
    assert_eq!(codes, ["wrong", "look"]);
    assert_eq!(findings[0]["about"], "Model");
    let sentence = all["sentence"].as_str().unwrap();
    assert!(
        sentence.contains(", 1 weak; together they explain"),
        "{sentence}"
    );
    assert_eq!(
        all["model"]["modes"][1]["reasons"][0],
        "hardly above the noise"
    );
}

#[test]
fn what_is_missing_is_null_and_the_rest_is_there() {
    let rendering = rendering(&small().truth);
    let without_frfs = data(&input(&small().truth, None, &rendering)).unwrap();
    assert!(
        without_frfs["frfs"]["residuals"].is_null()
            && without_frfs["frfs"]["sums"]["measured"].is_null()
    );
    assert_eq!(without_frfs["cmif"]["of"], "of the synthesis");
    assert!(without_frfs["stabilization"].is_null());
    let weights = data(&ReportInput {
        scenes: vec![RenderedScene::of_weights(&rendering.weights)],
        ..Default::default()
    })
    .unwrap();
    assert!(
        weights["scenes"][0]["field"].is_null()
            && weights["scenes"][0]["weights"].is_array()
            && weights["model"].is_null()
    );
    let frfs = data(&ReportInput {
        measured: Some(&small().frf),
        ..Default::default()
    })
    .unwrap();
    assert!(frfs["frfs"]["residuals"].is_object() && frfs["frfs"]["sums"]["synthesis"].is_null());
    assert!(html(&ReportInput::default()).is_ok());
    let mut bare = small().truth.clone();
    bare.nodes.clear();
    assert!(data(&ReportInput {
        model: Some(&bare),
        ..Default::default()
    })
    .unwrap()["geometry"]
        .is_null());
}

#[test]
fn a_beam_has_a_structure_and_no_map() {
    let mut beam = small().truth.clone();
    for (k, node) in beam.nodes.iter_mut().enumerate() {
        node.xyz_m = [0.01 * k as f64, 0.0, 0.0];
    }
    (beam.lines, beam.faces) = (Vec::new(), Vec::new());
    let input = ReportInput {
        model: Some(&beam),
        ..Default::default()
    };
    let shown = data(&input).unwrap();
    assert!(shown["geometry"].is_null());
    let structure = &shown["structure"];
    assert_eq!(
        structure["lines"].as_array().unwrap().len(),
        1,
        "{structure}"
    );
    assert_eq!(
        structure["moves"].as_array().unwrap().len(),
        beam.responses.len()
    );
    let plate = ReportInput {
        model: Some(&small().truth),
        ..Default::default()
    };
    let faces = data(&plate).unwrap()["structure"]["faces"].clone();
    assert_eq!(faces.as_array().unwrap().len(), small().truth.faces.len());
    assert!(!small().truth.faces.is_empty());
}

#[test]
fn weights_judged_on_the_measured_line_name_it() {
    let rendering = rendering(&small().truth);
    let evaluation = evaluate(&rendering.weights, &scene(), On::Frf(&small().frf)).unwrap();
    let scenes = vec![RenderedScene::of_evaluation(
        &rendering.weights,
        &evaluation,
        "panel.h5 <1>",
    )];
    let all = data(&ReportInput {
        scenes,
        ..Default::default()
    })
    .unwrap();
    assert_eq!(all["scenes"][0]["judged_on"], "panel.h5 <1>");
}

#[test]
fn a_scene_says_the_rigs_that_are_served_and_a_mode_on_the_drive() {
    let mut rendering = rendering(&small().truth);
    let weights = &mut rendering.weights;
    weights.feasible = true;
    let endurance = json!({
        "survival_ratio": 0.004, "rigs": 600, "gain_error": 0.03, "amplifiers_alone": 0.0,
        "frequencies_alone": 1.0, "finger_alone": 1.0, "touch_is_known": true,
    });
    weights.endurance = Some(serde_json::from_value(endurance).unwrap());
    let mode = Finding {
        modes: vec![9],
        ..Finding::note(
            "mode-on-drive",
            "the mode at 299.4 Hz is 0.6 Hz from the drive",
        )
    };
    let sensitive = Finding::caution("rig-sensitive", "survives on 0 %");
    weights.findings = vec![mode, sensitive].into();
    let all = data(&input(&small().truth, None, &rendering)).unwrap();
    let facts: Vec<[String; 2]> =
        serde_json::from_value(all["scenes"][0]["facts"].clone()).unwrap();
    let fact = |word: &str| facts.iter().find(|[known, _]| known == word).unwrap()[1].as_str();
    assert!(fact("Scene").ends_with("in the model, but mode 9 lies on the drive"));
    assert_eq!(fact("Rigs that are served"), "0 % of 600 simulated");
    assert!(fact("Mode on the drive").contains("0.6 Hz from the drive"));
}
