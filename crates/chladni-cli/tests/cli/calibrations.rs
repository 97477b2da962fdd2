//! Calibrations: what `correct` learns of a rig, what people write, and the scenes that start
//! with it.

use crate::common::Folder;
use crate::measured_fields::{dead_channel, field_of, prepared, strongest, weights_in};
use serde_json::{json, Value};

/// The scene on the opposite corner, with more lines under [actuators].
fn next_scene(folder: &Folder, actuators: &str) -> String {
    let scene = folder.text("scene.toml").replace("hot = [1]", "hot = [4]");
    format!("{scene}[actuators]\n{actuators}\n")
}

#[test]
fn a_calibration_starts_the_next_scene_corrected() {
    let folder = prepared();
    let run = folder
        .run(
            "correct model.json scene.toml --weights w0.json --field field.csv -o w1.json \
             --calibration rig.json --json",
        )
        .exits(0);
    assert_eq!(run.json()["calibration"], "rig.json");
    let calibration: Value = serde_json::from_str(&folder.text("rig.json")).unwrap();
    assert_eq!(calibration["format"], "chladni.calibration");
    assert_eq!(calibration["dead"][0], dead_channel(&folder).as_str());
    assert_eq!(calibration["source"].as_array().unwrap().len(), 4);

    folder.write(
        "next.toml",
        next_scene(&folder, "calibration = \"rig.json\""),
    );
    let said = folder
        .run("render model.json next.toml -o w2.json")
        .exits(0)
        .said();
    assert!(!said.contains("another model"), "{said}");
    let weights = weights_in(&folder, "w2.json");
    assert_eq!(weights["source"][2]["file"], "rig.json");
    assert_eq!(weights["weights"].as_array().unwrap().len(), 33);
    folder.write(
        "field2.csv",
        field_of(&folder, "w2.json", "# unit = mm/s\n"),
    );
    let on = "--on model.json --field field2.csv --json";
    let json = folder
        .run(&format!("evaluate w2.json --scene next.toml {on}"))
        .exits(0)
        .json();
    assert_eq!(json["indices"]["points"]["min_ratio"], 1.0);
    assert_eq!(
        json["agreement"]["hypotheses"][0]["kind"], "nothing",
        "{json}"
    );
    folder
        .run("play model.json next.toml --weights w2.json -o drive.csv -q")
        .exits(0);

    // a field counts once
    let again = "correct model.json next.toml --weights w0.json --field field.csv -o no.json";
    let run = folder.run(again).exits(65);
    assert!(
        run.stderr.contains("holds this field already"),
        "{}",
        run.stderr
    );
    let newer = "correct model.json next.toml --weights w2.json --field field2.csv -o w3.json \
                 --calibration rig-2.json -q";
    folder.run(newer).exits(0);
    let newer: Value = serde_json::from_str(&folder.text("rig-2.json")).unwrap();
    assert_eq!(
        (&newer["fields"], &newer["operators"][0]["fields"]),
        (&2.into(), &2.into())
    );
}

#[test]
fn bad_calibrations_are_refused_by_name() {
    let folder = prepared();
    folder
        .run(
            "correct model.json scene.toml --weights w0.json --field field.csv -o w1.json \
             --calibration rig.json -q",
        )
        .exits(0);
    let good = folder.text("rig.json");
    folder.write("weights.json", folder.text("w0.json"));
    folder.write("stranger.json", good.replace("\"101:+Z\"", "\"4711:+Z\""));
    folder.write("short.json", &good[..good.len() / 2]);
    for matrix in ["mobility", "covariance"] {
        let known = format!("\"{matrix}\":{{");
        let misspelt = good.replace(&known, &format!("{known}\"rm\":[],"));
        assert_ne!(misspelt, good);
        folder.write(&format!("{matrix}.json"), misspelt);
    }
    folder.write(
        "volts.json",
        good.replace("\"unit\":\"N\"", "\"unit\":\"V\""),
    );
    for (actuators, words) in [
        ("calibration = \"none.json\"", "no such file"),
        ("calibration = \"weights.json\"", "not a calibration file"),
        ("calibration = \"short.json\"", "not a calibration file"),
        ("calibration = \"stranger.json\"", "4711:+Z"),
        ("calibration = \"volts.json\"", "another unit"),
        ("calibration = \"mobility.json\"", "unknown field `rm`"),
        ("calibration = \"covariance.json\"", "expected re or im"),
        ("dead = [\"4711:+Z\"]", "4711:+Z"),
    ] {
        folder.write("next.toml", next_scene(&folder, actuators));
        let run = folder
            .run("render model.json next.toml -o no.json")
            .exits(65);
        assert!(run.stderr.contains(words), "{actuators}: {}", run.stderr);
    }
    for line in [
        "correct model.json scene.toml --weights w0.json --field field.csv -o one.json \
         --calibration one.json",
        "correct model.json scene.toml --weights w0.json --field field.csv -o one.json \
         --calibration ./one.json",
        "render model.json scene.toml -o one.json --wav ./one.wav",
    ] {
        let run = folder.run(line).exits(2);
        assert!(run.stderr.contains("two outputs"), "{line}: {}", run.stderr);
    }
    assert!(!folder.names().contains(&"no.json".to_owned()));
}

/// The gains of every channel over frequency, as a data sheet has them.
const GAINS: &str = "frequency_hz,gain_db,phase_deg\n200,0,-10\n400,-2,-30\n";

#[test]
fn a_person_may_write_a_calibration() {
    let folder = prepared();
    folder.write("gains.csv", GAINS);
    folder.write(
        "gains.json",
        r#"{"format": "chladni.calibration", "version": 1, "gain_tables": [
            {"frequency_hz": [200, 400], "gain": [1.0, 0.7943282347242815],
             "phase_deg": [-10, -30]}]}"#,
    );
    let scene = folder.text("scene.toml");
    let largest = |name: &str, calibration: &str| -> f64 {
        folder.write(name, format!("{scene}[actuators]\n{calibration}\n"));
        let line = format!("render model.json {name} -o {name}.json --force");
        folder.run(&line).exits(0);
        let weights = weights_in(&folder, &format!("{name}.json"));
        weights["weights"][strongest(&weights)]["amplitude"]
            .as_f64()
            .unwrap()
    };
    let plain = largest("plain.toml", "");
    // 330 Hz lies at 65 % of the way
    folder.write("there.csv", "gain_db,phase_deg\n-1.3,-23\n");
    let there = largest("there.toml", "calibration = \"there.csv\"");
    assert!((there / plain - 1.0).abs() > 0.01, "{there} {plain}");
    for file in ["gains.csv", "gains.json"] {
        let own = largest("own.toml", &format!("calibration = \"{file}\""));
        assert!((own / there - 1.0).abs() < 1e-5, "{file}: {own} {there}");
    }
    let drive = "play model.json own.toml --weights own.toml.json -o drive.csv -q";
    folder.run(drive).exits(0);
    folder
        .run("evaluate own.toml.json --scene own.toml --on model.json -q")
        .exits(0);
    // a frequency outside the table, and invalid tables
    let narrow = GAINS.replace("400,", "320,");
    let wrong_name = GAINS.replace("gain_db", "level");
    let wrong_key = folder.text("gains.json").replace("phase_deg", "phase");
    for (file, text, words) in [
        ("narrow.csv", narrow, "200 to 320 Hz"),
        ("wrong.csv", wrong_name, "level"),
        ("wrong.json", wrong_key, "unknown field `phase`"),
    ] {
        folder.write(file, text);
        folder.write(
            "bad.toml",
            format!("{scene}[actuators]\ncalibration = \"{file}\"\n"),
        );
        let run = folder
            .run("render model.json bad.toml -o no.json")
            .exits(65);
        assert!(
            run.stderr.contains(words) && run.stderr.contains(file),
            "{file}: {}",
            run.stderr
        );
    }
}

#[test]
fn of_a_gain_that_no_channel_has_the_field_is_named() {
    let folder = prepared();
    let weights = weights_in(&folder, "w0.json");
    let gains = weights["weights"].as_array().unwrap().iter().map(|weight| {
        let reference = &weight["reference"];
        json!({"reference": reference, "re": 30.0, "im": 0.0, "std": 0.0, "odd": false})
    });
    let gains: Vec<Value> = gains.collect();
    let rig = json!({"format": "chladni.calibration", "version": 1, "gains": gains});
    folder.write("rig.json", rig.to_string());
    let scene = folder.text("scene.toml");
    folder.write(
        "loud.toml",
        format!("{scene}[actuators]\ncalibration = \"rig.json\"\n"),
    );
    // 305 times the field without gains, ten times the prediction
    folder.write("loud.csv", field_of(&folder, "w0.json", "# unit = ft/s\n"));
    let line = "correct model.json loud.toml --weights w0.json --field loud.csv --json";
    let error = folder.run(line).exits(65).json()["error"].clone();
    assert_eq!(error["field"], "gains", "{error}");
    assert_eq!(error["file"], "loud.csv", "{error}");
}
