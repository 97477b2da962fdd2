//! `evaluate --field` and `correct` on the command line.

use crate::common::Folder;
use serde_json::Value;

/// A mass-scaled model, its weights, and the field that they make in it, one channel dead.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write(
        "panel.toml",
        "[responses]\nat_references = true\n[frf]\nstart_hz = 100\nstop_hz = 1000\nstep_hz = 10\n",
    );
    folder
        .run("simulate panel.toml -o panel.h5 --truth model.json -q")
        .exits(0);
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

fn field(folder: &Folder, unit: &str) -> String {
    use chladni_frf::FrfKind;
    use num_complex::Complex64;
    let weights: Value = serde_json::from_str(&folder.text("w0.json")).unwrap();
    let model = chladni_io::read_model(&folder.path().join("model.json")).unwrap();
    let mobility = model.frf_matrix(FrfKind::Mobility, 330.0);
    let dead = strongest(&weights);
    let drive: Vec<Complex64> = weights["weights"]
        .as_array()
        .unwrap()
        .iter()
        .enumerate()
        .map(|(k, weight)| match k == dead {
            true => Complex64::ZERO,
            false => Complex64::new(
                weight["re"].as_f64().unwrap(),
                weight["im"].as_f64().unwrap(),
            ),
        })
        .collect();
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
    assert!(run.stdout.contains("dead") && run.stdout.contains(dead.as_str().unwrap()));

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
