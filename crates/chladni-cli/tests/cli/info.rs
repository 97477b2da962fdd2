//! `info`: contents and faults of files.

use crate::common::Folder;

#[test]
fn a_universal_file_is_listed_dataset_by_dataset() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.uff -q").exits(0);
    let json = folder.run("info panel.uff --json").exits(0).json();
    let file = &json["files"][0];
    for key in [
        "file",
        "format",
        "sha256",
        "frf_kind",
        "nodes",
        "responses",
        "references",
        "warnings",
        "datasets",
    ] {
        assert!(file.get(key).is_some(), "no key {key}");
    }
    assert_eq!(
        (&file["format"], &file["frf_kind"]),
        (&"uff".into(), &"mobility".into())
    );
    assert_eq!(file["responses"][0], "1:+Z");
    assert_eq!(file["references"][0], "101:+Z");
    assert_eq!(file["nodes"], 34);
    let datasets = file["datasets"].as_array().unwrap();
    let of = |number: u64| {
        datasets
            .iter()
            .filter(move |info| info["number"] == number)
            .collect::<Vec<_>>()
    };
    assert_eq!(of(58).len(), 240);
    let first = of(58)[0];
    assert_eq!(
        (&first["function"], &first["response"], &first["values"]),
        (&"frf".into(), &"1:+Z".into(), &381.into())
    );
    assert_eq!(of(2411)[0]["nodes"], 34);

    let text = folder.run("info panel.uff").exits(0).stdout;
    assert!(text.contains("function (240 of them)"), "{text}");
    let all = folder.run("info -v panel.uff").exits(0).stdout;
    assert!(all.lines().count() > 240);
}

#[test]
fn what_physics_denies_at_a_driving_point_is_said() {
    let folder = Folder::new();
    folder.write(
        "panel.toml",
        "[responses]\ngrid = [2, 2]\nspacing_m = 0.05\nat_references = \
         true\n[references]\nedge_count = [1, 1]\n[frf]\nstart_hz = 20.0\nstop_hz = 400.0\n",
    );
    folder.run("simulate panel.toml -o panel.h5 -q").exits(0);
    let warnings = |flags: &str| {
        folder
            .run(&format!("info panel.h5 --json {flags}"))
            .exits(0)
            .json()["files"][0]["findings"]
            .to_string()
    };
    assert!(!warnings("").contains("driving point"), "{}", warnings(""));
    let wrong = warnings("--frf-kind accelerance");
    assert!(
        wrong.contains("driving point 101:+Z") && wrong.contains("--frf-kind mobility"),
        "{wrong}"
    );
    let mirrored = warnings("--time-sign -");
    assert!(mirrored.contains("--time-sign +"), "{mirrored}");
}

#[cfg(unix)]
#[test]
fn a_file_larger_than_memory_is_listed_by_its_headers() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.uff -q").exits(0);
    // the first function grows to 64 GiB, as a hole in the file
    let count = 1_u64 << 32;
    let text = String::from_utf8_lossy(&folder.read("panel.uff")).into_owned();
    let start = text.find("    -1\n    58b").unwrap();
    let header: Vec<&str> = text[start..].split_inclusive('\n').take(13).collect();
    let record_7 = format!("{}{count:>10}{}", &header[8][..10], &header[8][20..]);
    let head = [
        &text[..start],
        &header[..8].concat(),
        &record_7,
        &header[9..].concat(),
    ]
    .concat();
    let file = std::fs::File::create(folder.path().join("huge.uff")).unwrap();
    std::os::unix::fs::FileExt::write_all_at(&file, head.as_bytes(), 0).unwrap();
    std::os::unix::fs::FileExt::write_all_at(&file, b"    -1\n", head.len() as u64 + 16 * count)
        .unwrap();
    let run = folder.run("info huge.uff --json").exits(0);
    let listed = &run.json()["files"][0];
    assert_eq!(
        (
            &listed["frf_kind"],
            &listed["responses"][0],
            &listed["nodes"]
        ),
        (&"mobility".into(), &"1:+Z".into(), &34.into())
    );
    assert!(
        listed["sha256"].is_null() && listed["findings"].to_string().contains("headers"),
        "{listed}"
    );
    let last = listed["datasets"].as_array().unwrap().last().unwrap();
    assert_eq!(
        (&last["number"], &last["values"]),
        (&58.into(), &count.into())
    );
}

#[test]
fn what_is_damaged_is_listed_beside_what_is_sound() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.unv -q").exits(0);
    let text = folder.text("panel.unv");
    folder.write("truncated.unv", &text[..text.len() * 3 / 5]);
    let run = folder.run("info truncated.unv --json").exits(1);
    let datasets = run.json()["files"][0]["datasets"]
        .as_array()
        .unwrap()
        .clone();
    let damaged = datasets
        .iter()
        .filter(|info| !info["warnings"].as_array().unwrap().is_empty())
        .count();
    assert_eq!(damaged, 1, "{datasets:?}");
    assert!(datasets.len() > 100);
    assert!(run.stderr.contains("fault    truncated.unv"));
}

#[test]
fn one_missing_file_does_not_hide_the_others() {
    let folder = Folder::with_panel();
    let run = folder
        .run("info panel.h5 nowhere.h5 truth.json --json")
        .exits(1);
    let files = run.json()["files"].as_array().unwrap().clone();
    assert_eq!(
        files
            .iter()
            .map(|file| file["format"].clone())
            .collect::<Vec<_>>(),
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
        std::fs::copy(
            folder.path().join("scan_1.uff"),
            folder.path().join(format!("scan_{k}.uff")),
        )
        .unwrap();
    }
    let brief = folder.run("info scan_*.uff").exits(0).stdout;
    assert_eq!(
        brief.lines().filter(|line| line.contains("scan_")).count(),
        8,
        "{brief}"
    );
    assert!(
        brief.lines().count() < 12 && brief.contains("-v"),
        "{brief}"
    );
    assert!(folder
        .run("info -v scan_*.uff")
        .exits(0)
        .stdout
        .contains("function"));
}
