//! `fit --poles-of`: shapes of a known model, poles of a few new FRFs.

use crate::common::{Folder, PANEL};
use serde_json::Value;

#[test]
fn a_warmer_panel_is_followed_by_a_few_frfs_and_said_in_kelvin() {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o model.json -q").exits(0);
    // 0.2 % lower: Young's modulus 0.4 % less
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
    let refused = folder.run("fit later.h5 --per-kelvin -1e-4").exits(2);
    assert!(refused.said().contains("--poles-of"), "{}", refused.said());
    folder.run("fit later.h5 --poles-of scene.toml").exits(65);
    folder.run("fit later.h5 --poles-of none.json").exits(66);
    folder
        .run("fit later.h5 --poles-of model.json --band 30:300")
        .exits(2);
}
