//! Modes added by hand: fitted with the others, and graded like them.

use crate::common::Folder;
use serde_json::Value;

/// Frequencies, Hz, and grades of the modes of the band, rejected ones too.
fn modes(model: &Value) -> Vec<(f64, String)> {
    let modes = model["modes"].as_array().unwrap().iter();
    modes
        .filter(|mode| mode["in_band"] == true)
        .map(|mode| {
            let hz = mode["frequency_hz"].as_f64().unwrap();
            (hz, mode["trust"].as_str().unwrap().to_owned())
        })
        .collect()
}

fn model(folder: &Folder, name: &str) -> Value {
    serde_json::from_str(&folder.text(name)).unwrap()
}

fn counted(model: &Value) -> usize {
    modes(model)
        .iter()
        .filter(|mode| mode.1 != "rejected")
        .count()
}

fn error_of(model: &Value) -> f64 {
    model["quality"]["relative_error"].as_f64().unwrap()
}

/// The mode of the model at a frequency.
fn near(model: &Value, hz: f64) -> Option<(f64, String)> {
    let mut modes = modes(model).into_iter();
    modes.find(|mode| (mode.0 / hz - 1.0).abs() < 1e-3 && mode.1 != "rejected")
}

/// A folder with the model `few.json`, in which modes are left out, and the frequency, Hz,
/// of the first of these.
fn with_few() -> (Folder, f64) {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o whole.json -q").exits(0);
    let whole = model(&folder, "whole.json");
    let asked = counted(&whole) - 4;
    let run = folder.run(&format!("fit panel.h5 --modes {asked} -o few.json -q"));
    assert!(run.code <= 1, "{}", run.stderr);
    let few = model(&folder, "few.json");
    let mut all = modes(&whole).into_iter();
    let (hz, _) = all.find(|mode| near(&few, mode.0).is_none()).unwrap();
    (folder, hz)
}

#[test]
fn a_mode_that_was_left_out_comes_back_and_changes_the_model() {
    let (folder, hz) = with_few();
    let few = model(&folder, "few.json");
    // the reader reads the peak half a line off
    folder.write(
        "add.toml",
        format!("add = [{{frequency_hz = {:.1}}}]\n", hz + 0.4),
    );
    let said = folder.run("select few.json add.toml -o more.json").exits(0);
    assert!(said.stdout.contains("added at"), "{}", said.stdout);
    let more = model(&folder, "more.json");
    assert_eq!(counted(&more), counted(&few) + 1);
    let (found, _) = near(&more, hz).unwrap();
    assert!((found / hz - 1.0).abs() < 1e-4, "{found} {hz}");
    assert!(
        error_of(&more) < 0.9 * error_of(&few),
        "{} {}",
        error_of(&more),
        error_of(&few)
    );
    let place = &more["options"]["selections"][0]["add"][0]["frequency_hz"];
    assert!((place.as_f64().unwrap() - hz).abs() < 0.5, "{place}");

    // with a mode dropped by its old number
    let drop = format!("add = [{{frequency_hz = {hz:.1}}}]\ndrop = [1]\n");
    folder.write("both.toml", drop);
    folder
        .run("select few.json both.toml -o both.json -q")
        .exits(0);
    let both = model(&folder, "both.json");
    assert_eq!(counted(&both), counted(&few));
    assert!(near(&both, modes(&few)[0].0).is_none() && near(&both, hz).is_some());
    // with some modes kept: the added mode is kept too
    let keep = format!("add = [{{frequency_hz = {hz:.1}}}]\nkeep = [2]\n");
    folder.write("keep.toml", keep);
    folder
        .run("select few.json keep.toml -o kept.json -q")
        .exits(0);
    let kept = model(&folder, "kept.json");
    assert_eq!(counted(&kept), 2);
    assert!(near(&kept, modes(&few)[1].0).is_some() && near(&kept, hz).is_some());
}

#[test]
fn without_the_frfs_no_mode_is_added() {
    let (folder, hz) = with_few();
    folder.write("add.toml", format!("add = [{{frequency_hz = {hz:.1}}}]\n"));
    let path = |name: &str| folder.path().join(name);
    std::fs::create_dir(path("there")).unwrap();
    std::fs::rename(path("few.json"), path("there/few.json")).unwrap();
    let lost = folder.run("select there/few.json add.toml -o lost.json");
    assert_eq!(lost.code, 65);
    assert!(lost.said().contains("--measured"), "{}", lost.stderr);
    folder
        .run("select there/few.json add.toml -o found.json --measured panel.h5 -q")
        .exits(0);
    assert!(near(&model(&folder, "found.json"), hz).is_some());
}

#[test]
fn frfs_without_a_dof_of_the_model_are_refused_with_the_option_that_named_them() {
    let (folder, hz) = with_few();
    folder.write("add.toml", format!("add = [{{frequency_hz = {hz:.1}}}]\n"));
    let rows =
        "# unit = m/s/N\nresponse,reference,f,re,im\n9001Z,9002Z,100,1,2\n9001Z,9002Z,101,3,4\n";
    folder.write("other.csv", rows);
    let run = folder.run("select few.json add.toml -o x.json --measured other.csv");
    assert_eq!(run.code, 65);
    let said = run.said();
    assert!(
        said.contains("no DOF pair of the model") && said.contains("name with --measured the file"),
        "{said}"
    );
}

#[test]
fn a_mode_added_where_nothing_is_is_rejected() {
    let folder = Folder::with_panel();
    folder.run("fit panel.h5 -o whole.json -q").exits(0);
    let whole = model(&folder, "whole.json");
    let known = modes(&whole);
    // in the middle of the widest gap
    let gap = known
        .windows(2)
        .max_by(|a, b| (a[1].0 - a[0].0).total_cmp(&(b[1].0 - b[0].0)));
    let hz = gap.map(|pair| 0.5 * (pair[0].0 + pair[1].0)).unwrap();
    let both = format!(
        "add = [{{frequency_hz = {hz}}}, {{frequency_hz = {}}}]\n",
        known[0].0
    );
    folder.write("add.toml", both);
    let said = folder
        .run("select whole.json add.toml -o added.json")
        .exits(0);
    assert!(
        said.stdout
            .contains("rejected: more likely absent than present"),
        "{}",
        said.stdout
    );
    let added = model(&folder, "added.json");
    assert_eq!(
        counted(&added),
        counted(&whole),
        "it is no mode, and the other was known"
    );
    let rejected = modes(&added)
        .into_iter()
        .find(|mode| mode.1 == "rejected")
        .unwrap();
    assert!((rejected.0 / hz - 1.0).abs() < 0.1, "{rejected:?} {hz}");
    assert!((error_of(&added) / error_of(&whole) - 1.0).abs() < 0.01);
}

#[test]
fn wrong_additions_say_line_and_key() {
    let folder = Folder::with_panel();
    for (text, words) in [
        ("add = [123.4]\n", "table"),
        ("add = [{frequency_hz = -1}]\n", "frequency_hz"),
        ("add = [{hz = 100}]\n", "hz"),
        ("add = []\n", "names no mode"),
    ] {
        folder.write("add.toml", text);
        let run = folder.run("select truth.json add.toml -o out.json");
        assert_eq!(run.code, 65, "{text}");
        assert!(run.said().contains(words), "{text}: {}", run.stderr);
    }
}
