//! Folders as inputs, and what a conversion cannot carry.

use crate::common::Folder;

fn warnings(result: &serde_json::Value) -> String {
    result["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| format!("{}\n", warning.as_str().unwrap()))
        .collect()
}

#[test]
fn a_folder_is_read_whatever_else_lies_in_it() {
    let folder = Folder::with_panel();
    std::fs::create_dir(folder.path().join("scans")).unwrap();
    folder
        .run("convert panel.h5 -o scans/panel.uff -q")
        .exits(0);
    folder.write(
        "scans/README.txt",
        "Measured on Monday\n12 10 2026\n\n  1. hammer\n  2. vibrometer\n",
    );
    folder.write("scans/notes.md", "# Notes\n");
    folder.write("scans/plate.png", b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR");
    folder.write("scans/.DS_Store", b"\x00\x00\x00\x01Bud1");
    folder.write("scans/truth.json", folder.text("truth.json"));

    let written = folder.run("convert scans -o all.h5 --json").exits(0);
    assert_eq!(written.json()["responses"], 24);
    let sources = written.json()["source"].as_array().unwrap().clone();
    assert_eq!(sources.len(), 1, "{sources:?}");
    let said = warnings(&written.json());
    let in_full = folder.run("convert scans -o again.h5 -v").exits(0).said();
    for words in [
        "README.txt, notes.md (text without rows of numbers)",
        "plate.png (not a format",
        "truth.json: left out, a result",
    ] {
        assert!(said.contains(words), "no {words:?} in {said}");
        assert!(in_full.contains(words), "{in_full}");
    }
    assert!(!said.contains("DS_Store"));

    let listed = folder.run("info scans --json").exits(0).json();
    assert_eq!(listed["files"].as_array().unwrap().len(), 2, "{listed}");
    assert!(warnings(&listed).contains("README.txt"));

    let fitted = folder.run("fit scans --json").exits(0).json();
    assert_eq!(fitted["source"].as_array().unwrap().len(), 1);
    assert!(warnings(&fitted).contains("plate.png"));

    // named by the user, the same file is an error
    assert!(folder
        .run("convert scans/panel.uff scans/README.txt -o two.h5")
        .exits(65)
        .stderr
        .contains("README.txt"));
}

#[test]
fn a_damaged_table_in_a_folder_is_no_stray_file() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("scans")).unwrap();
    folder.write("scans/one.csv", "f,re,im\n10,1,0\n20,2,1\n30,1,0\n");
    folder.write("scans/two.csv", "f,re,im\n10,1,0\n20,two,1\n30,1,0\n");
    let run = folder
        .run("convert scans --frf-kind mobility -o all.h5")
        .exits(65);
    assert!(run.stderr.contains("two.csv: line 3"), "{}", run.stderr);
}

#[test]
fn what_a_conversion_cannot_carry_is_named() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.unv -q").exits(0);
    let unknown = "    -1\n  2430\n     1     2\n    -1\n";
    folder.write("more.unv", folder.text("panel.unv") + unknown + unknown);
    let carried = folder
        .run("convert more.unv -o more.h5 --json")
        .exits(0)
        .json();
    assert!(warnings(&carried).contains("dataset 2430"), "{carried}");
    assert!(warnings(&carried).contains("2 of them"), "{carried}");
    let table = folder
        .run("convert panel.h5 -o panel.csv --json")
        .exits(0)
        .json();
    assert!(
        warnings(&table).contains("no geometry: 34 nodes"),
        "{table}"
    );
}
