//! Wrong inputs: what is said, as text and as JSON, and the exit status.

mod common;

use common::Folder;

/// One wrong input: the command, the exit status, the kind, and words that the message must hold.
struct Wrong {
    line: &'static str,
    code: i32,
    kind: &'static str,
    words: &'static [&'static str],
}

const WRONG: &[Wrong] = &[
    Wrong { line: "fit nowhere.uff", code: 66, kind: "no_input", words: &["nowhere.uff", "no such file", "check the path"] },
    Wrong { line: "fit truncated.unv", code: 65, kind: "bad_data", words: &["truncated.unv", "dataset 58", "line"] },
    Wrong { line: "fit letters.unv", code: 65, kind: "bad_data", words: &["letters.unv", "dataset 58", "line", "abcdefg"] },
    Wrong { line: "fit panel.h5 --band 5000:6000", code: 65, kind: "bad_data", words: &["--band", "5000:6000", "20 to 400 Hz"] },
    Wrong { line: "fit panel.h5 --band 300:200", code: 2, kind: "usage", words: &["--band", "300:200", "LO:HI"] },
    Wrong { line: "fit panel.h5 --band low:high", code: 2, kind: "usage", words: &["--band", "low:high", "LO:HI"] },
    Wrong { line: "fit panel.h5 --bend 20:300", code: 2, kind: "usage", words: &["--bend", "--band", "chladni fit --help"] },
    Wrong { line: "fit panel.h5 --modes 0", code: 2, kind: "usage", words: &["--modes", "found 0", "auto"] },
    Wrong { line: "fit panel.h5 --damping none", code: 2, kind: "usage", words: &["--damping", "none", "viscous"] },
    Wrong { line: "fit panel.h5 --threads 0", code: 2, kind: "usage", words: &["--threads"] },
    Wrong { line: "fit", code: 2, kind: "usage", words: &["FRF"] },
    Wrong { line: "fix panel.h5", code: 2, kind: "usage", words: &["fix", "fit"] },
    Wrong { line: "fit kindless.csv", code: 65, kind: "unknown_frf_kind", words: &["kindless.csv", "--frf-kind", "mobility"] },
    Wrong { line: "fit truth.json", code: 65, kind: "bad_data", words: &["truth.json", "a model"] },
    Wrong { line: "fit panel.h5 -o old.json", code: 73, kind: "cannot_create", words: &["old.json", "exists", "--force"] },
    Wrong { line: "fit panel.h5 -o no/such/model.json", code: 73, kind: "cannot_create", words: &["no such folder", "no/such"] },
    Wrong { line: "fit panel.h5 -o model.xyz", code: 2, kind: "usage", words: &[".xyz", ".json"] },
    Wrong { line: "convert panel.h5 -o panel.h5 --force", code: 73, kind: "cannot_create", words: &["one of the inputs"] },
    Wrong { line: "simulate typo.toml -o new.h5", code: 65, kind: "bad_data", words: &["typo.toml", "line 2", "stop_hz"] },
    Wrong { line: "simulate panel.toml -o new.h5 --memory 1K", code: 65, kind: "bad_data", words: &["memory", "panel.toml"] },
    Wrong { line: "render truth.json typo.toml", code: 65, kind: "bad_data", words: &["typo.toml", "line"] },
    Wrong { line: "render panel.h5 scene.toml", code: 65, kind: "bad_data", words: &["panel.h5", "no model"] },
    Wrong { line: "evaluate truth.json --scene scene.toml --on panel.h5", code: 65, kind: "bad_data", words: &["truth.json", "weights"] },
    Wrong { line: "report panel.toml -o new.html", code: 65, kind: "bad_data", words: &["panel.toml", "model"] },
    Wrong { line: "info nowhere.uff", code: 66, kind: "no_input", words: &["nowhere.uff"] },
    Wrong { line: "demo -o no/such/demo", code: 73, kind: "cannot_create", words: &["no/such/demo"] },
];

fn prepared() -> Folder {
    let folder = Folder::with_panel();
    folder.run("convert panel.h5 -o panel.unv -q").exits(0);
    let text = folder.text("panel.unv");
    folder.write("truncated.unv", &text[..text.len() * 3 / 5]);
    let lines: Vec<&str> = text.lines().collect();
    let middle = lines.len() / 2;
    let mut damaged: Vec<String> = lines.iter().map(ToString::to_string).collect();
    damaged[middle].replace_range(0..7, "abcdefg");
    folder.write("letters.unv", damaged.join("\n"));
    folder.write("kindless.csv", "f,re,im\n10,1,0\n20,2,1\n30,1,0\n40,2,1\n");
    folder.write("old.json", "old");
    folder.write("typo.toml", "[frf]\nstop_hertz = 3\n");
    folder
}

#[test]
fn every_wrong_input_is_explained_and_leaves_nothing_behind() {
    let folder = prepared();
    let names = folder.names();
    for wrong in WRONG {
        let run = folder.run(wrong.line).exits(wrong.code);
        assert!(run.stderr.contains("error: ") && run.stdout.is_empty(), "{}: {}", wrong.line, run.stderr);
        for word in wrong.words {
            assert!(run.stderr.contains(word), "{}: no {word:?} in {}", wrong.line, run.stderr);
        }
        let json = folder.run(&format!("{} --json", wrong.line)).exits(wrong.code).json();
        let error = json["error"].as_object().unwrap();
        for key in ["code", "kind", "file", "dataset", "line", "field", "found", "expected", "help"] {
            assert!(error.contains_key(key), "{}: no key {key}", wrong.line);
        }
        assert_eq!(error["code"], wrong.code, "{}", wrong.line);
        assert_eq!(error["kind"], wrong.kind, "{}", wrong.line);
    }
    assert_eq!(folder.names(), names);
    assert_eq!(folder.text("old.json"), "old");
}

#[test]
fn a_damaged_file_says_where() {
    let error = prepared().run("fit letters.unv --json").exits(65).json()["error"].clone();
    assert_eq!(error["file"], "letters.unv");
    assert_eq!(error["dataset"], 58);
    assert!(error["line"].as_u64().unwrap() > 1000);
    assert!(error["found"].as_str().unwrap().contains("abcdefg"));
    assert!(error["expected"].is_string());
}

#[test]
fn help_and_version_are_no_errors_and_begin_with_examples() {
    let folder = Folder::new();
    assert!(folder.run("--version").exits(0).stdout.starts_with("chladni "));
    for command in ["demo", "info", "convert", "simulate", "fit", "render", "evaluate", "report", "completions", "man"] {
        let help = folder.run(&format!("{command} --help")).exits(0).stdout;
        assert!(help.starts_with("Examples:") && help.contains(&format!("chladni {command}")), "{command}: {help}");
    }
    assert!(folder.run("").exits(2).stderr.contains("Usage:"));
    assert_eq!(folder.run("--json").exits(2).json()["error"]["expected"], "a command");
    folder.run("man fit").exits(0);
    folder.run("man fix").exits(2);
    folder.run("completions zsh").exits(0);
}

#[cfg(unix)]
#[test]
fn a_full_disk_and_a_closed_pipe_on_stdout() {
    use std::process::{Command, Stdio};
    let folder = Folder::with_panel();
    let command = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        command.current_dir(folder.path()).args(["info", "panel.h5"]).stderr(Stdio::null());
        command
    };
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    assert_eq!(command().stdout(full).status().unwrap().code(), Some(74));
    let mut child = command().stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[cfg(unix)]
#[test]
fn an_interruption_leaves_nothing_half_written() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_chladni"))
        .current_dir(folder.path())
        .args(["demo", "--progress", "plain"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.by_ref().map_while(Result::ok).any(|line| line == "writing the FRFs"));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert!(lines.map_while(Result::ok).any(|line| line.contains("interrupted")));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let left = std::fs::read_dir(folder.path().join("chladni-demo")).unwrap();
    for entry in left {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(!name.starts_with('.'), "{name} was left behind");
    }
}
