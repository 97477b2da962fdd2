//! Damaged scenes and panels by the thousand: never a panic, never a hang. As
//! `crates/chladni-io/tests/mutation`; `CHLADNI_FUZZ_SECONDS` makes it long.

#[path = "../../chladni-io/tests/mutation/engine.rs"]
mod engine;
#[path = "mutation/targets.rs"]
mod targets;

use chladni_plate::Panel;
use chladni_render::Scene;
use std::path::Path;

/// A scene with a table of its own, as the mutations begin with it.
const WITH_TABLE: &str =
    "frequency_hz = 60.0\n[threshold]\nprofile = \"table.csv\"\nlimen_db = 2.0\n\
                          [zones]\n[[zones.polygon]]\nkind = \"hot\"\nlevel_db = 1.5\n\
                          points_m = [[-0.1, -0.1], [0.05, -0.1], [0.05, 0.2], [-0.1, 0.2]]\n\
                          [actuators]\nmax_force_n = 0.1\n[drift]\nfrequency_relative = 1e-3\n\
                          \n---\nfrequency_hz,velocity_m_per_s\n10.0,1e-4\n100,2e-4\n";

/// Bytes of FRFs that a panel may ask for here.
const LARGEST_PANEL: u64 = 1 << 28;

#[test]
fn scene_and_panel_toml() {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let mut seeds: Vec<Vec<u8>> = Vec::new();
    for name in [
        "scene-corner.toml",
        "panel.toml",
        "panel-driving-points.toml",
    ] {
        seeds.extend(std::iter::repeat_n(
            std::fs::read(fixtures.join(name)).unwrap(),
            5,
        ));
    }
    for class in ["scene", "panel"] {
        let mut files: Vec<_> = std::fs::read_dir(fixtures.join("malformed").join(class))
            .unwrap()
            .flatten()
            .map(|entry| entry.path())
            .collect();
        files.sort();
        seeds.extend(files.iter().map(|file| std::fs::read(file).unwrap()));
    }
    engine::run_files("scene_and_panel_toml", "toml", &seeds, |path, bytes| {
        std::fs::write(path, bytes).unwrap();
        let _ = Scene::read(path);
        let _ = Panel::read(path, LARGEST_PANEL);
    });
}

#[test]
fn scene_and_threshold_table() {
    let sound: Vec<Vec<u8>> = ["scene-corner.toml", "malformed/scene/profile.toml"]
        .map(|name| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../../fixtures")
                .join(name);
            let table: &[u8] = b"20,1e-5\n# a remark\n400.5,1e-3\n";
            [&std::fs::read(path).unwrap(), targets::SEPARATOR, table].concat()
        })
        .into_iter()
        .chain([WITH_TABLE.into(), WITH_TABLE.into()])
        .collect();
    engine::run_files(
        "scene_and_threshold_table",
        "toml",
        &sound,
        targets::scene_and_table,
    );
}

#[test]
fn model_and_what_is_rendered_of_it() {
    let text = include_str!("../../../fixtures/malformed/base/model.json");
    // numbers without exponents are replaced as whole words: one long line is as good
    let seeds = [text.into(), text.replace('\n', " ").into_bytes()];
    engine::run_files(
        "model_and_what_is_rendered_of_it",
        "json",
        &seeds,
        targets::model,
    );
}
