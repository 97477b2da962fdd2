//! `fit --poles-of`: shapes of a known model, poles of a few new FRFs.

use crate::common::{Folder, PANEL};
use serde_json::Value;

#[test]
fn a_warmer_panel_is_followed_by_a_few_frfs_and_said_in_kelvin() {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    // frequencies 0.2 % lower: Young's modulus 0.4 % less
    let later = PANEL.replace(
        "[frf]",
        "[plate]\nyoungs_modulus_pa = 71.214e9\n[frf]\nseed = 9\nsnr_db = 40\n",
    );
    folder.write("later.toml", later);
    folder
        .run("simulate later.toml -o later.h5 --truth later.json -q")
        .exits(0);
    let line = "fit later.h5 -o today.json --poles-of model.json --per-kelvin -1e-4 --json";
    let said = folder.run(line).exits(0).json();
    let findings = said["findings"].as_array().unwrap();
    let value = |code: &str, name: &str| {
        let found = findings.iter().find(|finding| finding["code"] == code);
        found.unwrap_or_else(|| panic!("no {code} in {findings:?}"))["values"][name]
            .as_f64()
            .unwrap()
    };
    let shift = value("poles-followed", "common_shift");
    assert!((shift + 2e-3).abs() < 2e-5, "{shift}");
    assert!((value("drift-in-kelvin", "kelvin") - 20.0).abs() < 0.2);
    let read = |name: &str| serde_json::from_str::<Value>(&folder.text(name)).unwrap();
    let [before, today, truth] = ["model.json", "today.json", "later.json"].map(read);
    for (k, mode) in today["modes"].as_array().unwrap().iter().enumerate() {
        assert_eq!(mode["shape"], before["modes"][k]["shape"]);
        if mode["in_band"] == true {
            let hz = mode["frequency_hz"].as_f64().unwrap();
            let near = truth["modes"].as_array().unwrap().iter();
            let near = near.map(|mode| (mode["frequency_hz"].as_f64().unwrap() / hz - 1.0).abs());
            assert!(near.fold(1.0, f64::min) < 1e-4, "{hz} Hz");
        }
    }
    let sources = today["source"].as_array().unwrap();
    assert_eq!(
        [&sources[0]["file"], &sources[1]["file"]],
        ["later.h5", "model.json"]
    );
    // the explained part of the known model says nothing about these data
    let told = folder.run("fit later.h5 --poles-of model.json").stdout;
    assert!(
        told.contains("Poles of a model, followed: natural frequencies moved"),
        "{told}"
    );
    assert!(!told.contains("of the data"), "{told}");
    let refused = folder.run("fit later.h5 --per-kelvin -1e-4").exits(2);
    assert!(refused.said().contains("--poles-of"), "{}", refused.said());
    folder.run("fit later.h5 --poles-of scene.toml").exits(65);
    folder.run("fit later.h5 --poles-of none.json").exits(66);
    // options that the known model has decided already
    for asked in [
        "--band 30:300",
        "--exponential-window 2",
        "--modes 3",
        "--damping viscous",
    ] {
        folder
            .run(&format!("fit later.h5 --poles-of model.json {asked}"))
            .exits(2);
    }
}

/// A field of a panel with frequencies 1 % lower, under weights for the panel as it was. A field
/// of one frequency determines the shift that all modes share.
#[test]
fn a_warmer_panel_is_followed_by_a_rendered_field() {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    folder
        .run("render model.json scene.toml -o weights.json -q")
        .exits(0);
    let later = PANEL.replace("[frf]", "[plate]\nyoungs_modulus_pa = 70.07e9\n[frf]\n");
    folder.write("later.toml", later);
    let line = "simulate later.toml --play weights.json -o field.csv --snr-db 40 -q";
    folder.run(line).exits(0);
    let line = "fit field.csv -o today.json --poles-of model.json --weights weights.json --json";
    let said = folder.run(line).exits(0).json();
    let findings = said["findings"].as_array().unwrap();
    let told = findings
        .iter()
        .find(|finding| finding["code"] == "poles-followed")
        .unwrap_or_else(|| panic!("{findings:?}"));
    let [shift, std] =
        ["common_shift", "common_shift_std"].map(|name| told["values"][name].as_f64().unwrap());
    assert!(
        (shift + 0.01).abs() < 2.0 * std && std < 4e-3,
        "{shift} ± {std}"
    );
    let read = |name: &str| serde_json::from_str::<Value>(&folder.text(name)).unwrap();
    let [before, today] = ["model.json", "today.json"].map(read);
    let modes = [&before, &today].map(|model| model["modes"].as_array().unwrap());
    for (before, today) in modes[0].iter().zip(modes[1]) {
        assert_eq!(before["shape"], today["shape"]);
    }
    let names = today["source"].as_array().unwrap().iter();
    let names: Vec<&str> = names.map(|of| of["file"].as_str().unwrap()).collect();
    assert_eq!(names, ["field.csv", "weights.json", "model.json"]);
    let line = "fit field.csv -o dry.json --poles-of model.json --weights weights.json --dry-run";
    folder.run(line).exits(0);
    assert!(!folder.path().join("dry.json").exists());
    folder
        .run("fit field.csv field.csv --poles-of model.json --weights weights.json")
        .exits(2);
    folder.run("fit field.csv --weights weights.json").exits(2);
    let listed = folder.run("info field.csv").exits(0).stdout;
    assert!(listed.contains("a measured field at"), "{listed}");
    let refused = folder.run("fit field.csv --poles-of model.json").said();
    assert!(refused.contains("--weights"), "{refused}");
}
