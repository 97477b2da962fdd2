//! The weights file: exactly the fields of the contract, and a faithful round trip.

use chladni_render::{render, Method, RenderOptions, Weights};
use serde_json::Value;

fn weights() -> Weights {
    render(
        crate::common::truth(),
        &crate::common::cell_scene([2, 2], 1, ""),
        &RenderOptions {
            method: Method::PressureMatching.into(),
            ..Default::default()
        },
    )
    .unwrap()
    .weights
}

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    keys
}

#[test]
fn the_fields_are_those_of_the_contract() {
    let value: Value = serde_json::from_str(&weights().to_json().unwrap()).unwrap();
    let expected = "actuators_used created_by feasible findings format frequency_hz indices kappa method modes_used options scene source version \
                    warnings weights";
    assert_eq!(
        keys(&value),
        expected.split_whitespace().collect::<Vec<_>>()
    );
    assert_eq!(
        keys(&value["weights"][0]),
        ["amplitude", "im", "phase_deg", "re", "reference", "unit"]
    );
    assert_eq!(keys(&value["indices"]), ["area", "points"]);
    assert_eq!(keys(&value["indices"]["area"]), ["cold_ratio", "hot_ratio"]);
    let points = "cold_ratio contrast_db hot_ratio margin_db max_force_n min_ratio silence_ratio \
                  success_ratio";
    assert_eq!(
        keys(&value["indices"]["points"]),
        points.split_whitespace().collect::<Vec<_>>()
    );
    assert_eq!(
        (value["format"].as_str(), value["version"].as_u64()),
        (Some("chladni.weights"), Some(1))
    );
    assert_eq!(
        (
            value["weights"][0]["reference"].as_str(),
            value["weights"][0]["unit"].as_str()
        ),
        (Some("101:+Z"), Some("N"))
    );
    assert_eq!(value["options"]["method"], "pressure-matching");
    for key in ["contrast_db", "margin_db", "max_force_n"] {
        assert!(value["indices"]["points"][key].is_f64(), "{key}");
    }
    assert!(value["kappa"].is_f64());
}

#[test]
fn what_is_written_is_read_back_bit_by_bit() {
    let weights = weights();
    assert_eq!(
        Weights::parse(&weights.to_json().unwrap()).unwrap(),
        weights
    );
}

#[test]
fn amplitude_and_phase_are_those_of_the_phasor() {
    for weight in weights().weights {
        let back =
            num_complex::Complex64::from_polar(weight.amplitude, weight.phase_deg.to_radians());
        assert!((back - weight.value()).norm() <= 1e-15 * weight.amplitude.max(1.0));
        assert!((-180.0..=180.0).contains(&weight.phase_deg));
    }
}

#[test]
fn damaged_files_are_refused_with_the_reason() {
    let text = weights().to_json().unwrap();
    for (old, new, message) in [
        (
            "chladni.weights",
            "chladni.model",
            "chladni.weights version 1",
        ),
        ("\"version\": 1", "\"version\": 2", "version 2"),
        ("\"102:+Z\"", "\"101:-Z\"", "an actuator occurs twice"),
        ("\"102:+Z\"", "\"102\"", "no DOF"),
        (
            "\"frequency_hz\": 300.0",
            "\"frequency_hz\": -300.0",
            "no drive frequency",
        ),
        (
            "\"frequency_hz\": 300.0,",
            "",
            "missing field `frequency_hz`",
        ),
        ("\"N\"", "\"V\"", "units of the weights differ"),
        ("\"N\"", "\"kgf\"", "unknown variant"),
        ("\"im\": ", "\"im\": null, \"was\": ", "null"),
        (
            "\"im\": ",
            "\"im\": 1e999, \"was\": ",
            "number out of range",
        ),
        ("{", "[", "not a weights file"),
        (
            "\"amplitude\": ",
            "\"amplitude\": 3.5, \"was\": ",
            "told in two ways; found amplitude 3.500e0 N",
        ),
        (
            "\"phase_deg\": ",
            "\"phase_deg\": 720.5, \"was\": ",
            "re and im are what is driven",
        ),
        (
            "\"re\": ",
            "\"re\": 1e200, \"was\": ",
            "no actuator can have; found 1e200 N",
        ),
    ] {
        assert!(text.contains(old), "{old}");
        let error = Weights::parse(&text.replacen(old, new, 1)).unwrap_err();
        assert!(
            error.to_string().contains(message),
            "`{message}` is not in: {error}"
        );
    }
    let mut none = weights();
    none.weights.clear();
    assert!(Weights::parse(&none.to_json().unwrap())
        .unwrap_err()
        .to_string()
        .contains("no weight"));
}

#[test]
fn other_files_in_place_of_weights_are_called_by_their_kind() {
    let model = serde_json::to_string(crate::common::truth()).unwrap();
    let calibration = r#"{"format": "chladni.calibration", "version": 1}"#;
    for (text, message) in [
        (&*model, "a model, not a weights file"),
        (calibration, "a calibration file, not a weights file"),
    ] {
        let error = Weights::parse(text).unwrap_err();
        assert_eq!(error.message, message);
        assert_eq!(error.field.as_deref(), Some("format"));
        assert_eq!(error.expected.as_deref(), Some("chladni.weights version 1"));
        assert!(error.help.is_some());
    }
}
