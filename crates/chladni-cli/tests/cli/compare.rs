//! `chladni compare`: a model beside its truth, a second seed, another program's shapes.

use crate::common::Folder;
use serde_json::{json, Value};

fn numbers(comparison: &Value) -> Vec<(u64, u64)> {
    let number = |pair: &Value, key: &str| pair[key].as_u64().unwrap();
    let pairs = comparison["pairs"].as_array().unwrap();
    pairs
        .iter()
        .map(|pair| (number(pair, "a"), number(pair, "b")))
        .collect()
}

fn same(count: u64) -> Vec<(u64, u64)> {
    (1..=count).map(|n| (n, n)).collect()
}

fn compared(folder: &Folder, files: &str) -> Value {
    let result = folder.run(&format!("compare {files} --json")).exits(0);
    result.json()["comparisons"][0].clone()
}

/// A model file, changed.
fn changed(folder: &Folder, from: &str, to: &str, change: impl Fn(&mut Value)) {
    let mut model: Value = serde_json::from_str(&folder.text(from)).unwrap();
    change(&mut model);
    folder.write(to, model.to_string());
}

#[test]
fn a_model_beside_its_truth_and_a_second_measurement() {
    let folder = Folder::with_panel();
    folder
        .run("simulate panel.toml --seed 7 -o second.h5 -q")
        .exits(0);
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    folder.run("fit second.h5 -o second.json -q").exits(0);
    for other in ["truth.json", "second.json"] {
        let found = compared(&folder, &format!("model.json {other}"));
        let pairs = found["pairs"].as_array().unwrap();
        assert!(pairs.len() > 3 && numbers(&found) == same(pairs.len() as u64));
        assert_eq!(found["only_in_a"], json!([]));
        for pair in pairs {
            let number = |key: &str| pair[key].as_f64().unwrap();
            // the exact MAC is 1: within the bar in all but one of twenty cases
            let missing = 1.0 - (number("mac") - number("mac_noise_bias"));
            assert!(missing.abs() < 4.0 * number("mac_std"), "{other}: {pair}");
            assert!(number("frequency_shift_sigmas").abs() < 5.0, "{pair}");
        }
    }
    let table = folder.run("compare model.json second.json").exits(0).stdout;
    assert!(
        table.contains("24 DOFs in common, paired by name") && table.contains("MAC, 95 %"),
        "{table}"
    );
    let tracked = folder
        .run("compare truth.json model.json second.json --against previous --json")
        .exits(0)
        .json();
    assert_eq!(tracked["tracks"][0], json!([1, 1, 1]));
    assert_eq!(tracked["comparisons"].as_array().unwrap().len(), 2);
    let table = folder
        .run("compare truth.json model.json second.json")
        .exits(0)
        .stdout;
    assert!(
        table.contains("followed through 3 files") && table.contains("least MAC"),
        "{table}"
    );
}

/// Number of modes of the truth, each of which is paired with itself.
fn mode_count(folder: &Folder) -> u64 {
    let found = compared(folder, "truth.json truth.json");
    found["pairs"].as_array().unwrap().len() as u64
}

/// Places of the modes in the band.
fn in_band(model: &Value) -> Vec<usize> {
    let modes = model["modes"].as_array().unwrap();
    (0..modes.len())
        .filter(|&n| modes[n]["in_band"] == true)
        .collect()
}

#[test]
fn modes_that_are_swapped_are_paired_all_the_same() {
    let folder = Folder::with_panel();
    changed(&folder, "truth.json", "swapped.json", |model| {
        let places = in_band(model);
        let [one, other] = [1, 2].map(|k| model["modes"][places[k]].clone());
        for key in ["shape", "participation"] {
            model["modes"][places[1]][key] = other[key].clone();
            model["modes"][places[2]][key] = one[key].clone();
        }
    });
    let mut swapped = same(mode_count(&folder));
    (swapped[1].1, swapped[2].1) = (3, 2);
    assert_eq!(
        numbers(&compared(&folder, "truth.json swapped.json")),
        swapped
    );
}

#[test]
fn a_missing_mode_is_named_and_the_others_are_paired() {
    let folder = Folder::with_panel();
    changed(&folder, "truth.json", "missing.json", |model| {
        let place = in_band(model)[1];
        model["modes"].as_array_mut().unwrap().remove(place);
    });
    let found = compared(&folder, "truth.json missing.json");
    assert_eq!(found["only_in_a"][0]["mode"], 2);
    assert_eq!(numbers(&found)[1], (3, 2));
    let table = folder.run("compare truth.json missing.json").exits(0);
    assert!(table.stdout.contains("only in a:"), "{}", table.stdout);
}

#[test]
fn every_second_response_from_the_last_to_the_first_is_enough_to_pair() {
    let folder = Folder::with_panel();
    let of = |list: &Value| -> Value {
        list.as_array()
            .unwrap()
            .iter()
            .step_by(2)
            .rev()
            .cloned()
            .collect()
    };
    changed(&folder, "truth.json", "half.json", |model| {
        model["responses"] = of(&model["responses"]);
        model["residual_terms"]["terms"] = json!([]);
        for mode in model["modes"].as_array_mut().unwrap() {
            mode["shape_std"] = of(&mode["shape_std"]);
            for part in ["re", "im"] {
                mode["shape"][part] = of(&mode["shape"][part]);
            }
        }
    });
    let found = compared(&folder, "truth.json half.json");
    assert_eq!(numbers(&found), same(mode_count(&folder)));
    assert_eq!(found["common_dofs"], 12);
    for pair in found["pairs"].as_array().unwrap() {
        assert!((pair["mac"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{pair}");
    }
}

#[test]
fn shapes_in_universal_files_are_compared_like_models() {
    let folder = Folder::with_panel();
    folder.run("convert truth.json -o shapes.unv -q").exits(0);
    let found = compared(&folder, "truth.json shapes.unv");
    let pairs = found["pairs"].as_array().unwrap();
    assert!(!pairs.is_empty() && numbers(&found) == same(pairs.len() as u64));
    assert!(pairs
        .iter()
        .all(|pair| pair["mac"].as_f64().unwrap() > 0.999_999));
    let nearest = compared(&folder, "truth.json shapes.unv --pair-dofs nearest");
    assert_eq!(nearest["paired_by"], "nearest");
    assert_eq!(nearest["common_dofs"], found["common_dofs"]);
}
