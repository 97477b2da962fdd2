//! `evaluate --field` and `correct` on the command line.

use crate::common::Folder;
use serde_json::Value;

/// A mass-scaled model, its weights, and their field in it with a dead channel.
pub(super) fn prepared() -> Folder {
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
pub(super) fn strongest(weights: &Value) -> usize {
    let list = weights["weights"].as_array().unwrap();
    let size = |k: &usize| list[*k]["amplitude"].as_f64().unwrap();
    (0..list.len())
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .unwrap()
}

pub(super) fn weights_in(folder: &Folder, file: &str) -> Value {
    serde_json::from_str(&folder.text(file)).unwrap()
}

/// The dead channel.
pub(super) fn dead_channel(folder: &Folder) -> String {
    let weights = weights_in(folder, "w0.json");
    let dead = &weights["weights"][strongest(&weights)]["reference"];
    dead.as_str().unwrap().to_owned()
}

/// The field of the first weights.
fn field(folder: &Folder, unit: &str) -> String {
    field_of(folder, "w0.json", unit)
}

/// The true field of weights, mm/s.
pub(super) fn field_of(folder: &Folder, file: &str, unit: &str) -> String {
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
