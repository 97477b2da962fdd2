//! `info`: what is inside, and what is wrong with it.

mod common;

use common::Folder;

#[test]
fn a_universal_file_is_listed_dataset_by_dataset() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.uff -q").exits(0);
    let json = folder.run("info panel.uff --json").exits(0).json();
    let file = &json["files"][0];
    for key in ["file", "format", "sha256", "frf_kind", "nodes", "responses", "references", "warnings", "datasets"] {
        assert!(file.get(key).is_some(), "no key {key}");
    }
    assert_eq!((&file["format"], &file["frf_kind"]), (&"uff".into(), &"mobility".into()));
    assert_eq!(file["responses"][0], "1:+Z");
    assert_eq!(file["references"][0], "101:+Z");
    assert_eq!(file["nodes"], 34);
    let datasets = file["datasets"].as_array().unwrap();
    let of = |number: u64| datasets.iter().filter(move |info| info["number"] == number).collect::<Vec<_>>();
    assert_eq!(of(58).len(), 240);
    let first = of(58)[0];
    assert_eq!((&first["function"], &first["response"], &first["values"]), (&"frf".into(), &"1:+Z".into(), &381.into()));
    assert_eq!(of(2411)[0]["nodes"], 34);

    let text = folder.run("info panel.uff").exits(0).stdout;
    assert!(text.contains("function (240 of them)"), "{text}");
    let all = folder.run("info -v panel.uff").exits(0).stdout;
    assert!(all.lines().count() > 240);
}

#[test]
fn what_is_damaged_is_listed_beside_what_is_sound() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.unv -q").exits(0);
    let text = folder.text("panel.unv");
    folder.write("truncated.unv", &text[..text.len() * 3 / 5]);
    let run = folder.run("info truncated.unv --json").exits(1);
    let datasets = run.json()["files"][0]["datasets"].as_array().unwrap().clone();
    let damaged = datasets.iter().filter(|info| !info["warnings"].as_array().unwrap().is_empty()).count();
    assert_eq!(damaged, 1, "{datasets:?}");
    assert!(datasets.len() > 100);
    assert!(run.stderr.contains("warning: truncated.unv"));
}

#[test]
fn one_missing_file_does_not_hide_the_others() {
    let folder = Folder::with_panel();
    let run = folder.run("info panel.h5 nowhere.h5 truth.json --json").exits(1);
    let files = run.json()["files"].as_array().unwrap().clone();
    assert_eq!(
        files.iter().map(|file| file["format"].clone()).collect::<Vec<_>>(),
        ["hdf5".into(), serde_json::Value::Null, "model".into()]
    );
    let modes = files[2]["datasets"].as_array().unwrap();
    assert!(modes.iter().all(|mode| mode["frequency_hz"].is_number()));
}

#[test]
fn an_unknown_kind_is_a_warning_here() {
    let folder = Folder::new();
    folder.write("one.csv", "f,re,im\n10,1,0\n20,2,1\n30,1,0\n");
    let run = folder.run("info one.csv").exits(0);
    assert!(run.stderr.contains("--frf-kind"), "{}", run.stderr);
}

#[test]
fn many_files_are_a_line_each() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o scan_1.uff -q").exits(0);
    for k in 2..=8 {
        std::fs::copy(folder.path().join("scan_1.uff"), folder.path().join(format!("scan_{k}.uff"))).unwrap();
    }
    let brief = folder.run("info scan_*.uff").exits(0).stdout;
    assert_eq!(brief.lines().filter(|line| line.contains("scan_")).count(), 8, "{brief}");
    assert!(brief.lines().count() < 12 && brief.contains("-v"), "{brief}");
    assert!(folder.run("info -v scan_*.uff").exits(0).stdout.contains("function"));
}
