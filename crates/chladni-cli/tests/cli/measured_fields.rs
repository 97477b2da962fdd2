//! `evaluate --field` and `correct` on the command line.

use crate::common::Folder;
use serde_json::Value;

/// A mass-scaled model, its weights, and their field in it with a dead channel.
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

/// The dead channel.
fn dead_channel(folder: &Folder) -> String {
    let weights = weights_in(folder, "w0.json");
    let dead = &weights["weights"][strongest(&weights)]["reference"];
    dead.as_str().unwrap().to_owned()
}

/// The field of the first weights.
fn field(folder: &Folder, unit: &str) -> String {
    field_of(folder, "w0.json", unit)
}

/// The true field of weights, mm/s.
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
    folder.write("copy.csv", good.clone());
    for again in ["field.csv", "copy.csv"] {
        let run = folder
            .run(&format!(
                "correct model.json scene.toml --weights w0.json --field field.csv --weights w0.json \
                 --field {again} -o no.json"
            ))
            .exits(65);
        assert!(run.stderr.contains("given twice"), "{}", run.stderr);
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

fn negative(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(positive) => positive.to_owned(),
        None => format!("-{number}"),
    }
}

#[test]
fn of_several_fields_the_bad_one_is_named() {
    let folder = prepared();
    let good = folder.text("field.csv");
    folder.write("other.csv", good.replace("= 330.0", "= 331.0"));
    folder.write("stranger.csv", good.replace("\n1:+Z,", "\n4711:+Z,"));
    let sha256 = format!("# weights_sha256 = {}\n{good}", "ab".repeat(32));
    folder.write("foreign.csv", sha256);
    folder.write("words.csv", good.replace("\n1:+Z,", "\n1:+Z,x"));
    folder.write("again.csv", format!("# measured again\n{good}"));
    let mut turned = String::new();
    for line in good.lines() {
        let parts: Vec<&str> = line.split(',').collect();
        turned += &match parts[..] {
            [response, re, im] if im != "im" => format!("{response},{re},{}\n", negative(im)),
            _ => format!("{line}\n"),
        };
    }
    folder.write("turned.csv", turned);
    folder.write(
        "scene-2.toml",
        folder.text("scene.toml").replace("330.0", "331.0"),
    );
    folder
        .run("render model.json scene-2.toml -o w-2.json -q")
        .exits(0);
    let line = |weights: &str, field: &str| {
        format!(
            "correct model.json scene.toml --weights w0.json --field field.csv \
             --weights {weights} --field {field} -o no.json --json"
        )
    };
    for (weights, field, named) in [
        ("w0.json", "other.csv", "other.csv"),
        ("w0.json", "stranger.csv", "stranger.csv"),
        ("w0.json", "foreign.csv", "foreign.csv"),
        ("w0.json", "words.csv", "words.csv"),
        ("w-2.json", "again.csv", "w-2.json"),
        ("w0.json", "turned.csv", "turned.csv"),
    ] {
        let error = folder.run(&line(weights, field)).exits(65).json();
        assert_eq!(error["error"]["file"], named, "{error}");
    }
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
fn a_panel_in_volts_takes_weights_in_volts() {
    let folder = Folder::new();
    let measured = "[responses]\nspacing_m = 0.02\n[frf]\nstop_hz = 400.0\nstep_hz = 2.0\n";
    folder.write("newtons.toml", measured);
    folder.write(
        "volts.toml",
        format!("{measured}[references]\nnewtons_per_volt = 0.05\n"),
    );
    for name in ["newtons", "volts"] {
        let line = format!("simulate {name}.toml -o {name}.h5 --truth {name}.json --snr-db inf -q");
        folder.run(&line).exits(0);
    }
    // the FRFs are those of the model: a twentieth of the FRFs per newton
    let models = ["newtons", "volts"]
        .map(|n| chladni_io::read_model(&folder.path().join(format!("{n}.json"))));
    let [newtons, volts] = models.map(Result::unwrap);
    assert_eq!(volts.reference_unit, chladni_frf::ReferenceUnit::Volt);
    for hz in [10.0, 100.0, 333.0] {
        let [own, other] =
            [&newtons, &volts].map(|m| m.frf_matrix(chladni_frf::FrfKind::Mobility, hz));
        let error = own.iter().zip(&other).map(|(a, b)| (a * 0.05 - b).norm());
        let largest = other.iter().map(|b| b.norm()).fold(0.0, f64::max);
        assert!(error.fold(0.0, f64::max) < 1e-12 * largest, "{hz} Hz");
    }
    let files = [folder.path().join("volts.h5")];
    let (frf, ..) = chladni_io::read_frf(&files, &Default::default()).unwrap();
    assert_eq!(frf.reference_unit, volts.reference_unit);
    folder.write(
        "scene.toml",
        "frequency_hz = 330.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[actuators]\nmax_voltage_v = 2.0\n",
    );
    let render = "render volts.json scene.toml -o w.json -q";
    folder.run(render).exits(0);
    let run = folder
        .run("convert newtons.json w.json -o field.unv")
        .exits(65);
    assert!(run.stderr.contains("different units"), "{}", run.stderr);
    let play = "simulate volts.toml --play w.json -o field.csv --snr-db 60 -q";
    folder.run(play).exits(0);
    let judge = "evaluate w.json --scene scene.toml --on volts.json --field field.csv --json";
    let judged = folder.run(judge).exits(0).json();
    let likeliest = &judged["agreement"]["hypotheses"][0]["kind"];
    assert_eq!(likeliest, "nothing", "{judged}");
    let run = folder
        .run("simulate newtons.toml --play w.json -o no.csv")
        .exits(65);
    assert!(run.stderr.contains("newtons_per_volt"), "{}", run.stderr);
}
