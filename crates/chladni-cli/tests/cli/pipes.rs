//! Inputs that can be read once: pipes, FIFOs, the standard input.

use crate::common::{Folder, Run};
use serde_json::Value;
use std::process::Command;

/// Runs a line of bash in which `chladni` is the program.
pub fn bash(folder: &Folder, line: &str) -> Run {
    let script = format!(
        "chladni() {{ \"{}\" \"$@\"; }}; {line}",
        env!("CARGO_BIN_EXE_chladni")
    );
    let output = Command::new("bash")
        .args(["-c", &script])
        .current_dir(folder.path())
        .output()
        .unwrap();
    Run::of(output)
}

/// The ways to pass a file that can be read only once.
const WAYS: [&str; 5] = [
    "cat FILE | chladni fit - OPTIONS",
    "cat FILE | chladni fit /dev/stdin OPTIONS",
    "chladni fit <(cat FILE) OPTIONS",
    "mkfifo FILE.fifo; cat FILE > FILE.fifo & chladni fit FILE.fifo OPTIONS",
    "chladni fit - OPTIONS < FILE",
];

/// The bytes of a model file without the name of its source.
fn nameless(folder: &Folder, name: &str) -> String {
    let text = folder.text(name);
    let model: Value = serde_json::from_str(&text).unwrap();
    let source = &model["source"][0];
    assert!(source["sha256"].is_string());
    let of = source["file"].as_str().unwrap();
    // the name in the list of sources, and before a warning
    text.replace(&format!("\"{of}\""), "\"\"")
        .replace(&format!("\"{of}: "), "\"")
}

#[test]
fn every_format_is_read_whole_from_a_pipe() {
    let folder = Folder::with_panel();
    for (k, extension) in ["csv", "h5", "npz", "uff", "unv"].iter().enumerate() {
        let file = format!("data.{extension}");
        folder
            .run(&format!("convert panel.h5 -o {file} -q"))
            .exits(0);
        folder
            .run(&format!("fit {file} --frf-kind mobility -o {file}.json -q"))
            .exits(0);
        // a table in every way, the other files in one way each
        let ways = if k == 0 { &WAYS[..] } else { &WAYS[k..=k] };
        for way in ways {
            let options = "--frf-kind mobility -o piped.json -q --force";
            let line = way.replace("FILE", &file).replace("OPTIONS", options);
            bash(&folder, &line).exits(0);
            let [piped, own] =
                ["piped.json", &format!("{file}.json")].map(|name| nameless(&folder, name));
            assert!(piped == own, "{line}");
        }
    }
    // only results are left: the stored pipes are removed
    assert!(folder.names().iter().all(|name| !name.contains("tmp")));
}

#[test]
fn every_verb_reads_its_inputs_from_pipes() {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.csv -q").exits(0);
    folder.write("keep.toml", "keep = [1, 2]\n");
    for (name, line, piped) in [
        (
            "b.unv",
            "convert panel.csv -o a.unv",
            "cat panel.csv | chladni convert - -o b.unv",
        ),
        (
            "b.json",
            "render truth.json scene.toml -o a.json",
            "chladni render <(cat truth.json) - -o b.json < scene.toml",
        ),
        (
            "b.part",
            "block reduce panel.h5 -o a.part",
            "cat panel.h5 | chladni block reduce - -o b.part",
        ),
        (
            "b.h5",
            "select truth.json keep.toml -o a.h5",
            "chladni select <(cat truth.json) <(cat keep.toml) -o b.h5",
        ),
    ] {
        folder.run(&format!("{line} -q"));
        bash(&folder, &format!("{piped} -q"));
        let own = folder.read(&name.replace('b', "a"));
        let [own, from_pipe] = [own, folder.read(name)].map(|bytes| bytes.len());
        // names of sources differ, and so do their lengths
        assert!(own.abs_diff(from_pipe) < 200, "{line}: {own} {from_pipe}");
    }
    let said = bash(&folder, "cat panel.csv | chladni info - --json").exits(0);
    let own = folder.run("info panel.csv --json").exits(0).json();
    let from_pipe = said.json();
    assert_eq!(own["files"][0]["sha256"], from_pipe["files"][0]["sha256"]);
    assert_eq!(
        own["files"][0]["datasets"],
        from_pipe["files"][0]["datasets"]
    );
    let on_pipe = "evaluate a.json --scene scene.toml --on";
    let own = folder.run(&format!("{on_pipe} panel.h5 --json")).json();
    let piped = bash(
        &folder,
        &format!("cat panel.h5 | chladni {on_pipe} - --json"),
    );
    assert_eq!(own["indices"], piped.exits(0).json()["indices"]);
    bash(&folder, "cat truth.json | chladni report - -o r.html -q").exits(0);
}

#[test]
fn a_pipe_larger_than_the_memory_allowed_is_read_in_parts() {
    let folder = Folder::with_panel();
    for file in ["panel.h5", "panel.unv"] {
        if file != "panel.h5" {
            folder
                .run(&format!("convert panel.h5 -o {file} -q"))
                .exits(0);
        }
        let fit =
            |from: &str, to: &str| format!("chladni fit {from} --memory 1M -o {to} --force -q");
        bash(&folder, &fit(file, "file.json")).exits(0);
        bash(&folder, &format!("cat {file} | {}", fit("-", "pipe.json"))).exits(0);
        assert_eq!(
            nameless(&folder, "pipe.json"),
            nameless(&folder, "file.json")
        );
    }
}

#[test]
fn the_standard_input_is_one_file() {
    let folder = Folder::with_panel();
    for line in [
        "fit - -",
        "render - -",
        "evaluate - --scene scene.toml --on -",
    ] {
        let error = folder.run(&format!("{line} --json")).exits(2).json()["error"].clone();
        assert!(error["message"].as_str().unwrap().contains('-'), "{error}");
        assert_eq!(error["found"], "2 times `-`", "{error}");
    }
    bash(&folder, "echo 5:+Z,101:+Z | chladni info - --dofs -").exits(2);
    // the value of an option is no file
    bash(
        &folder,
        "cat panel.h5 | chladni fit - --time-sign - --json > out",
    )
    .exits(1);
}

#[cfg(target_os = "linux")]
#[test]
fn a_device_without_end_is_refused_at_once() {
    let folder = Folder::with_panel();
    let scene = format!(
        "{}[threshold]\nprofile = \"/dev/zero\"\n",
        crate::common::SCENE
    );
    folder.write("endless.toml", scene);
    for line in [
        "fit /dev/zero",
        "info /dev/zero",
        "render truth.json /dev/zero",
        "render truth.json endless.toml",
    ] {
        let error = folder.run(&format!("{line} --json")).exits(65).json()["error"].clone();
        assert_eq!(error["file"], "/dev/zero", "{error}");
        assert_eq!(error["found"], "a device", "{error}");
    }
}
