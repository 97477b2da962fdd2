//! Damaged scenes and panels by the thousand: never a panic, never a hang. As
//! `crates/chladni-io/tests/mutation`; `CHLADNI_FUZZ_SECONDS` makes it long.

#[path = "../../chladni-io/tests/mutation/engine.rs"]
mod engine;

use chladni_plate::Panel;
use chladni_render::Scene;
use std::path::Path;

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
