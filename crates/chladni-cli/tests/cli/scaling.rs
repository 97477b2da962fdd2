//! Mass-scaled shapes without a driving point: `fit --panel`, `fit --scale`.

use crate::common::{Folder, Run};
use serde_json::Value;

/// The panel of the study, and a band that begins below its first mode.
const MEASURED: &str = "[frf]\nstart_hz = 5.0\nstop_hz = 500.0\nstep_hz = 1.0\n";
/// The assumed panel, whose Poisson's ratio is 20 % off.
const BELIEVED: &str = "[plate]\npoisson_ratio = 0.252\n";

fn fitted(panel: &str, options: &str) -> (Folder, Run) {
    let folder = Folder::new();
    folder.write("true.toml", panel);
    folder.write("believed.toml", BELIEVED);
    folder
        .run("simulate true.toml -o panel.h5 --truth truth.json -q")
        .exits(0);
    let run = folder.run(&format!("fit panel.h5 -o model.json --json {options}"));
    (folder, run)
}

fn shapes(model: &Value, top_hz: f64) -> Vec<(f64, f64)> {
    let modes = model["modes"].as_array().unwrap().iter();
    let in_band = modes.filter(|mode| mode["in_band"].as_bool().unwrap());
    let own = in_band.map(|mode| {
        let part = |name: &str| -> f64 {
            let values = mode["shape"][name].as_array().unwrap().iter();
            values.map(|v| v.as_f64().unwrap().powi(2)).sum()
        };
        (
            mode["frequency_hz"].as_f64().unwrap(),
            part("re") + part("im"),
        )
    });
    own.filter(|(hz, _)| *hz < top_hz).collect()
}

/// Rms relative error of ψψᵀ below 420 Hz.
fn error_of(folder: &Folder) -> f64 {
    let [model, truth] = ["model.json", "truth.json"]
        .map(|name| serde_json::from_str::<Value>(&folder.text(name)).unwrap());
    let [own, truth] = [&model, &truth].map(|model| shapes(model, 420.0));
    assert_eq!(own.len(), truth.len());
    let pairs = own.iter().zip(&truth);
    let squares = pairs.map(|((f, a), (g, b))| {
        assert!((f - g).abs() < 0.1, "{f} {g} Hz");
        (a / b - 1.0).powi(2)
    });
    (squares.sum::<f64>() / own.len() as f64).sqrt()
}

fn finding<'a>(model: &'a Value, code: &str) -> &'a Value {
    let findings = model["findings"].as_array().unwrap();
    findings
        .iter()
        .find(|finding| finding["code"] == code)
        .unwrap_or_else(|| panic!("no {code} in {findings:?}"))
}

#[test]
fn a_panel_scales_a_fit_within_a_percent_and_says_what_it_weighs() {
    for route in ["continuity", "mass"] {
        let options = format!("--panel believed.toml --scale {route}");
        let (folder, run) = fitted(MEASURED, &options);
        let said = run.exits(0).json();
        assert_eq!(said["scaling"], "unit_modal_mass");
        let scaled = finding(&said, "scaled-by-panel");
        let value = |name: &str| scaled["values"][name].as_f64().unwrap();
        let error = error_of(&folder);
        assert!(error <= 0.01, "{route}: {error}");
        assert!(value("disagreement") < 0.03, "{scaled}");
        let plate_kg = 0.268 * 0.170 * 0.0007 * 2440.0;
        assert!((value("mass_kg") / plate_kg - 1.0).abs() < 1e-3, "{scaled}");
        assert!(value("coil_mass_kg") < 5e-6, "{scaled}");
        let sources = said["source"].as_array().unwrap();
        assert_eq!(sources[1]["file"], "believed.toml");
        assert_eq!(said["options"]["scale"], route);
    }
}

#[test]
fn coils_of_half_a_gram_are_found_and_the_scale_is_as_good_as_it_says() {
    let panel = format!("[references]\nmass_kg = 0.5e-3\n{MEASURED}");
    let (folder, run) = fitted(&panel, "--panel believed.toml");
    let said = run.exits(0).json();
    let scaled = finding(&said, "scaled-by-panel");
    let value = |name: &str| scaled["values"][name].as_f64().unwrap();
    assert!((value("coil_mass_kg") - 0.5e-3).abs() < 0.05e-3, "{scaled}");
    let error = error_of(&folder);
    // ψψᵀ errs twice as much as ψ, whose error the file states
    let model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    let modes = model["modes"].as_array().unwrap().iter();
    let stated = modes.filter_map(|mode| mode["scale_std"].as_f64());
    let least = stated.fold(f64::INFINITY, f64::min);
    assert!(error <= 2.0 * least, "{error} {least} {scaled}");
}

#[test]
fn a_scale_that_cannot_be_had_is_refused_or_said() {
    // the band begins above the first modes, so that the mass of the coils is not known
    let panel = "[references]\nmass_kg = 0.5e-3\n[frf]\nstart_hz = 150.0\nstop_hz = 450.0\n";
    let (folder, run) = fitted(panel, "--panel believed.toml");
    let said = run.exits(0).json();
    assert_eq!(said["scaling"], "unscaled");
    let refused = finding(&said, "scale-refused");
    assert_eq!(refused["severity"], "caution");
    assert!(
        refused["help"].as_str().unwrap().contains("mass_kg"),
        "{refused}"
    );
    let again = "fit panel.h5 -o other.json --panel believed.toml --scale mass";
    let run = folder.run(again).exits(65);
    assert!(
        run.said().contains("between continuity and mass"),
        "{}",
        run.said()
    );
    assert!(!folder.path().join("other.json").exists());
    let run = folder.run("fit panel.h5 --scale driving").exits(65);
    assert!(run.said().contains("no driving point"), "{}", run.said());
    let run = folder.run("fit panel.h5 --scale mass").exits(2);
    assert!(run.said().contains("--panel PANEL.toml"), "{}", run.said());
    let both = "fit panel.h5 --scale driving --panel believed.toml";
    assert!(folder.run(both).exits(2).said().contains("need no panel"));
}
