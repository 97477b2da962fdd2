//! `demo`: the whole way on the built-in panel.

use crate::common::Folder;

#[test]
fn the_demonstration_finds_its_known_truth() {
    let folder = Folder::new();
    let run = folder.run("demo --json").exits(0);
    let json = run.json();
    assert_eq!(
        json["modes"],
        serde_json::json!({"known": 25, "missed": 0, "spurious": 0})
    );
    let scenes = json["scenes"].as_array().unwrap();
    assert_eq!(scenes.len(), 4);
    for scene in scenes {
        for ratio in ["hot_ratio", "cold_ratio"] {
            assert!(
                scene["on_panel"][ratio].as_f64().unwrap() >= 0.95,
                "{scene}"
            );
        }
    }
    for name in json["files"].as_array().unwrap() {
        assert!(
            folder
                .path()
                .join("chladni-demo")
                .join(name.as_str().unwrap())
                .is_file(),
            "{name}"
        );
    }
    assert_eq!(json["files"].as_array().unwrap().len(), 14);

    // the field names the dead actuator and corrects the weights
    let dead = &json["dead_actuator"];
    assert_eq!(dead["likeliest"]["kind"], "dead", "{dead}");
    assert_eq!(dead["likeliest"]["place"], dead["dead"], "{dead}");
    let kept = |when: &str| dead[when]["min_ratio"].as_f64().unwrap();
    assert!(kept("before") < 0.6 && kept("after") >= 0.95, "{dead}");
    folder
        .run(
            "correct chladni-demo/model.json chladni-demo/scene-1.toml --weights \
             chladni-demo/weights-1.json --field chladni-demo/field-1.csv -o again.json -q",
        )
        .exits(0);
    assert!(folder.read("again.json") == folder.read("chladni-demo/weights-1-corrected.json"));

    // the demonstration does what the commands do
    folder
        .run("fit chladni-demo/panel.h5 -o model.json -q")
        .exits(0);
    assert!(folder.read("model.json") == folder.read("chladni-demo/model.json"));

    // by default a result fits on a terminal of 80 by 24, the next prompt with it
    for line in [
        "fit chladni-demo/panel.h5",
        "render chladni-demo/model.json chladni-demo/scene-1.toml",
    ] {
        let run = folder.run(line);
        let shown = format!("{}{}", run.stdout, run.stderr);
        assert!(shown.lines().count() < 24, "{shown}");
        // the length of a command to copy depends on its names
        let lines = shown.lines().filter(|line| !line.contains("chladni-demo/"));
        let widest = lines.map(|line| line.chars().count()).max();
        assert!(widest <= Some(80), "{shown}");
    }

    let again = folder.run("demo").exits(73);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
}
