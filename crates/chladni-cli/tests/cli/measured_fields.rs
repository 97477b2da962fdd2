//! `evaluate --field` and `correct` on the command line.

use crate::common::Folder;
use serde_json::Value;

/// A mass-scaled model, its weights, and the field that they make in it, one channel dead.
fn prepared() -> Folder {
    let folder = Folder::with_glass();
    folder.write(
        "scene.toml",
        "frequency_hz = 330.0\n[zones]\ngrid = [2, 2]\nhot = [1]\narea_m = [0.034, 0.025, 0.234, \
         0.145]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n",
    );
    folder
        .run("render model.json scene.toml -o w0.json -q")
        .exits(0);
    folder.write("field.csv", field(&folder, "# unit = mm/s\n"));
    folder
}

/// The strongest channel of the weights.
fn strongest(weights: &Value) -> usize {
    let list = weights["weights"].as_array().unwrap();
    let size = |k: &usize| list[*k]["amplitude"].as_f64().unwrap();
    (0..list.len())
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .unwrap()
}

fn weights_in(folder: &Folder, file: &str) -> Value {
    serde_json::from_str(&folder.text(file)).unwrap()
}

/// The channel that moves nothing.
fn dead_channel(folder: &Folder) -> String {
    let weights = weights_in(folder, "w0.json");
    let dead = &weights["weights"][strongest(&weights)]["reference"];
    dead.as_str().unwrap().to_owned()
}

/// The field of the first weights.
fn field(folder: &Folder, unit: &str) -> String {
    field_of(folder, "w0.json", unit)
}

/// The field that weights truly make, mm/s.
fn field_of(folder: &Folder, file: &str, unit: &str) -> String {
    use chladni_frf::FrfKind;
    use num_complex::Complex64;
    let weights = weights_in(folder, file);
    let model = chladni_io::read_model(&folder.path().join("model.json")).unwrap();
    let mobility = model.frf_matrix(FrfKind::Mobility, 330.0);
    let dead = dead_channel(folder);
    let mut drive = vec![Complex64::ZERO; model.references.len()];
    for weight in weights["weights"].as_array().unwrap() {
        let name = weight["reference"].as_str().unwrap();
        let channel = model
            .references
            .iter()
            .position(|dof| dof.to_string() == name);
        let part = |key: &str| weight[key].as_f64().unwrap();
        if name != dead {
            drive[channel.unwrap()] = Complex64::new(part("re"), part("im"));
        }
    }
    let mut text = format!("# frequency_hz = 330.0\n{unit}response,re,im\n");
    for (response, row) in model.responses.iter().zip(mobility.rows()) {
        let v: Complex64 = row.iter().zip(&drive).map(|(h, a)| h * a * 1e3).sum();
        text += &format!("{response},{:e},{:e}\n", v.re, v.im);
    }
    text
}

#[test]
fn a_played_field_is_what_was_foretold() {
    let folder = prepared();
    folder
        .run("simulate panel.toml --play w0.json -o played.csv --snr-db 40 --seed 3 -q")
        .exits(0);
    let text = folder.text("played.csv");
    assert!(text.contains("# weights_sha256 = ") && text.contains("response,re,im,std"));
    let json = folder
        .run("evaluate w0.json --scene scene.toml --on model.json --field played.csv --json")
        .exits(0)
        .json();
    assert_eq!(json["agreement"]["hypotheses"][0]["kind"], "nothing");
    assert!(json["agreement"]["coefficient"].as_f64().unwrap() > 0.999);
    assert_eq!(json["indices"]["points"]["min_ratio"], 1.0);
    // another panel has other references
    folder.write("other.toml", "[references]\nedge_count = [3, 2]\n");
    let run = folder
        .run("simulate other.toml --play w0.json -o other.csv -q")
        .exits(65);
    assert!(
        run.stderr.contains("has no such reference"),
        "{}",
        run.stderr
    );
    assert!(!folder.names().contains(&"other.csv".to_owned()));
}

#[test]
fn a_dead_channel_is_named_and_corrected() {
    let folder = prepared();
    let run = folder
        .run("evaluate w0.json --scene scene.toml --on model.json --field field.csv --json")
        .exits(0);
    let (json, said) = (run.json(), run.said());
    let weights: Value = serde_json::from_str(&folder.text("w0.json")).unwrap();
    let dead = &weights["weights"][strongest(&weights)]["reference"];
    let likeliest = &json["agreement"]["hypotheses"][0];
    assert_eq!(
        (&likeliest["kind"], &likeliest["place"]),
        (&"dead".into(), dead),
        "{json}"
    );
    assert!(json["agreement"]["nis"].as_f64().unwrap() > 3.0);
    assert!(
        said.contains("does not say how sure its values are"),
        "{said}"
    );
    let run = folder
        .run("evaluate w0.json --scene scene.toml --on model.json --field field.csv")
        .exits(0);
    let cause = format!("channel {} gives no force", dead.as_str().unwrap());
    assert!(run
        .stdout
        .starts_with("field.csv at 330 Hz\nThe measured field"));
    assert_eq!(run.stdout.matches(&cause).count(), 2, "{}", run.stdout);

    let run = folder
        .run("correct model.json scene.toml --weights w0.json --field field.csv -o w1.json --json")
        .exits(0);
    let told = &run.json()["correction"];
    assert_eq!(
        (&told["iteration"], &told["predicted"]),
        (&1.into(), &1.0.into()),
        "{told}"
    );
    let written: Value = serde_json::from_str(&folder.text("w1.json")).unwrap();
    assert_eq!(&written["correction"], told);
    assert_eq!(written["source"].as_array().unwrap().len(), 4);
}

#[test]
fn bad_fields_are_refused_by_name() {
    let folder = prepared();
    let good = folder.text("field.csv");
    for (name, text, words) in [
        (
            "frequency",
            good.replace("330.0", "331.0"),
            "another frequency",
        ),
        ("unit", field(&folder, ""), "does not say its unit"),
        ("stranger", good.replace("\n7:+Z", "\n4711:+Z"), "4711:+Z"),
        (
            "other",
            format!("# weights_sha256 = {}\n{good}", "0".repeat(64)),
            "the field is of other weights",
        ),
    ] {
        let file = format!("{name}.csv");
        folder.write(&file, text);
        for line in [
            format!("evaluate w0.json --scene scene.toml --on model.json --field {file}"),
            format!("correct model.json scene.toml --weights w0.json --field {file} -o no.json"),
        ] {
            let run = folder.run(&line).exits(65);
            assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
        }
        assert!(!folder.names().contains(&"no.json".to_owned()));
    }
    let run = folder
        .run("correct model.json scene.toml --weights w0.json w0.json --field field.csv")
        .exits(2);
    assert!(!run.stderr.is_empty());
}

#[test]
fn permuted_rows_are_the_same_field_and_half_of_the_points_are_used_as_such() {
    let folder = prepared();
    let good = folder.text("field.csv");
    let (head, rows) = good.split_at(good.find("response,").unwrap());
    let mut lines: Vec<&str> = rows.lines().collect();
    let name = lines.remove(0);
    let file = |lines: &[&str]| format!("{head}{name}\n{}\n", lines.join("\n"));
    let corrected = |field: &str| {
        let line = format!("correct model.json scene.toml --weights w0.json --field {field}.csv");
        folder
            .run(&format!("{line} -o {field}.json --force -q"))
            .exits(0);
        weights_in(&folder, &format!("{field}.json"))
    };
    let half: Vec<&str> = lines.iter().copied().step_by(2).collect();
    folder.write("half.csv", file(&half));
    lines.reverse();
    folder.write("permuted.csv", file(&lines));
    assert_eq!(
        corrected("permuted")["weights"],
        corrected("field")["weights"]
    );
    let on = "evaluate w0.json --scene scene.toml --on model.json --field half.csv --json";
    let run = folder.run(on).exits(0);
    let findings = run.json()["findings"].to_string();
    assert!(findings.contains("56 of the 111 responses"), "{findings}");
    let dead = dead_channel(&folder);
    let likeliest = &run.json()["agreement"]["hypotheses"][0];
    assert_eq!(likeliest["place"], dead.as_str(), "{likeliest}");
    let told = &corrected("half")["correction"];
    assert!(told["predicted"].as_f64().unwrap() > 0.99, "{told}");
}

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
