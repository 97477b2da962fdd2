//! The lines and faces of a measurement on their way through fit, files and report.

use crate::common::Folder;
use serde_json::Value;

/// The usual grid of 11 × 7 points, which 60 elements join; few lines and actuators.
const PANEL: &str = "[references]\nedge_count = [3, 2]\nspacing_m = 0.06\n[frf]\nstart_hz = 20.0\n\
                     stop_hz = 200.0\nstep_hz = 1.0\n";

fn faces(model: &Value) -> usize {
    model["faces"].as_array().map_or(0, Vec::len)
}

/// The data that a page carries.
fn data_of(page: &str) -> Value {
    let start = "<script type=\"application/json\" id=\"data\">";
    let text = page
        .split_once(start)
        .unwrap()
        .1
        .split_once("</script>")
        .unwrap()
        .0;
    serde_json::from_str(text).unwrap()
}

#[test]
fn sixty_elements_reach_model_vtu_uff_and_report() {
    let folder = Folder::new();
    folder.write("panel.toml", PANEL);
    folder.run("simulate panel.toml -o panel.uff -q").exits(0);
    let shells = b"\n  2412";
    let file = folder.read("panel.uff");
    assert!(file.windows(shells.len()).any(|bytes| bytes == shells));
    folder.run("fit panel.uff -o model.json -q").exits(0);
    let model: Value = serde_json::from_str(&folder.text("model.json")).unwrap();
    assert_eq!(faces(&model), 60);
    assert_eq!(model["faces"][0].as_array().unwrap().len(), 4);
    // by way of HDF5, and what a selection leaves
    folder.write("drop.toml", "drop = [1]\n");
    folder
        .run("select model.json drop.toml -o selected.h5 -q")
        .exits(0);
    folder
        .run("convert selected.h5 -o selected.json -q")
        .exits(0);
    let selected: Value = serde_json::from_str(&folder.text("selected.json")).unwrap();
    assert_eq!(selected["faces"], model["faces"]);
    folder.run("convert model.json -o m.vtu -q").exits(0);
    assert!(
        folder.text("m.vtu").contains("NumberOfCells=\"60\""),
        "{}",
        folder.text("m.vtu")
    );
    folder.run("convert model.json -o shapes.uff -q").exits(0);
    folder.run("convert shapes.uff -o again.vtu -q").exits(0);
    assert!(folder.text("again.vtu").contains("NumberOfCells=\"60\""));
    folder
        .run("report model.json -o report.html --charts figures -q")
        .exits(0);
    let data = data_of(&folder.text("report.html"));
    assert_eq!(data["structure"]["faces"].as_array().unwrap().len(), 60);
    assert!(folder.read("figures/mode-01.gif").starts_with(b"GIF89a"));
}
