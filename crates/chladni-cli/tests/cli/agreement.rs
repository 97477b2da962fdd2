//! Both linear-algebra back ends give the same numbers, those of one committed file.
//!
//! The numbers are no truth; the back ends only have to agree. After a change of the numerics the
//! file is written anew by `CHLADNI_WRITE=1 cargo test --release --test
//! agreement`, in the default flavour.

use crate::common::Folder;
use serde_json::{json, Value};
use std::path::Path;

/// Largest relative difference.
const AGREEMENT: f64 = 1e-9;

fn file() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/agreement.json")
}

/// Poles of a fit and weights of two methods, by plain names.
fn numbers() -> Value {
    let folder = Folder::with_panel();
    folder
        .run("fit panel.h5 -o model.json --damping structural -q")
        .exits(0);
    let model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    let of_modes = |key: &str| -> Vec<f64> {
        let modes = model["modes"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|m| m["in_band"] == true);
        modes.map(|m| m[key].as_f64().unwrap()).collect()
    };
    let mut numbers =
        json!({"frequency_hz": of_modes("frequency_hz"), "loss_factor": of_modes("loss_factor")});
    for method in ["pressure-matching", "mls"] {
        folder.run(&format!(
            "render model.json scene.toml -o {method}.json --method {method} -q"
        ));
        let weights: Value = serde_json::from_str(&folder.text(&format!("{method}.json"))).unwrap();
        let parts = weights["weights"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|w| [w["re"].as_f64().unwrap(), w["im"].as_f64().unwrap()]);
        numbers[method] = json!(parts.collect::<Vec<f64>>());
    }
    numbers
}

#[test]
fn poles_and_weights_agree_between_the_flavours() {
    let found = numbers();
    if std::env::var_os("CHLADNI_WRITE").is_some() {
        std::fs::write(file(), serde_json::to_string_pretty(&found).unwrap() + "\n").unwrap();
    }
    let expected: Value = serde_json::from_str(&std::fs::read_to_string(file()).unwrap()).unwrap();
    for (name, expected) in expected.as_object().unwrap() {
        let list = |value: &Value| -> Vec<f64> {
            value
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap())
                .collect()
        };
        let (expected, found) = (list(expected), list(&found[name]));
        assert_eq!(expected.len(), found.len(), "{name}");
        // poles one by one; weights against the largest, since many are nearly zero
        let largest = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let worst = expected
            .iter()
            .zip(&found)
            .map(|(e, f)| (e - f).abs() / if name.contains('_') { e.abs() } else { largest });
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < AGREEMENT, "{name}: {worst:e}");
    }
}
