//! Inputs and outputs: outputs that are inputs, places that cannot be written, unusual names, and
//! limits of the system.

use crate::common::{Folder, SCENE};
use std::process::Command;

/// Runs a command that must be refused because an output is an input, with `--force` too; `kept`
/// is unchanged.
fn refused(folder: &Folder, line: &str, kept: &str) {
    let before = folder.read(kept);
    let names = folder.names();
    let run = folder.run(&format!("{line} --force --json --progress plain"));
    let error = run.exits(73).json()["error"].clone();
    let message = error["message"].as_str().unwrap();
    assert!(message.contains("one of the inputs"), "{line}: {error}");
    assert!(folder.read(kept) == before, "{line}");
    assert_eq!(folder.names(), names, "{line}");
}

#[test]
fn an_output_is_never_an_input_however_it_is_named() {
    let folder = Folder::with_panel();
    let link = |from: &str, to: &str| {
        std::fs::hard_link(folder.path().join(from), folder.path().join(to)).unwrap();
    };
    folder.write(
        "table.csv",
        "frequency_hz,velocity_m_per_s\n100,0.0002\n500,0.0002\n",
    );
    folder.write(
        "with-table.toml",
        format!("{SCENE}[threshold]\nprofile = \"table.csv\"\n"),
    );
    let render = "render truth.json";
    refused(
        &folder,
        &format!("{render} with-table.toml --wav table.csv"),
        "table.csv",
    );
    link("panel.h5", "measured.json");
    refused(
        &folder,
        &format!("{render} scene.toml --measured measured.json -o measured.json"),
        "measured.json",
    );
    refused(
        &folder,
        &format!("{render} scene.toml --measured panel.h5 -o measured.json"),
        "measured.json",
    );
    link("scene.toml", "scene.json");
    refused(
        &folder,
        &format!("{render} with-table.toml --also scene.toml -o scene.json"),
        "scene.json",
    );
    refused(
        &folder,
        "fit panel.h5 --scene scene.toml -o scene.json",
        "scene.json",
    );
    link("panel.toml", "panel.json");
    refused(
        &folder,
        "simulate panel.toml -o new.h5 --truth panel.json",
        "panel.json",
    );
    refused(
        &folder,
        "block residues panel.h5 --model truth.json -o truth.json",
        "truth.json",
    );
    link("panel.h5", "measured.html");
    refused(
        &folder,
        "report truth.json --measured panel.h5 -o measured.html",
        "measured.html",
    );
    link("panel.h5", "new.json.resume");
    refused(
        &folder,
        "fit panel.h5 -o new.json --memory 1M",
        "new.json.resume",
    );
}

#[test]
fn a_picture_is_not_drawn_over_an_input() {
    let folder = Folder::with_panel();
    folder.run("report truth.json --charts figures -q").exits(0);
    let figures = folder.path().join("figures");
    let mut names: Vec<_> = std::fs::read_dir(&figures)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    names.sort();
    std::fs::remove_file(&names[0]).unwrap();
    std::fs::hard_link(folder.path().join("truth.json"), &names[0]).unwrap();
    refused(&folder, "report truth.json --charts figures", "truth.json");
    assert_eq!(std::fs::read(&names[0]).unwrap(), folder.read("truth.json"));
}

#[test]
fn two_outputs_are_two_files() {
    let folder = Folder::with_panel();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    folder
        .run("simulate panel.toml -o a.h5 --truth sub/../a.h5")
        .exits(2);
    folder.run("simulate panel.toml -o a.h5 -q").exits(0);
    let [a, b] = ["a.h5", "b.h5"].map(|name| folder.path().join(name));
    std::fs::hard_link(a, b).unwrap();
    folder
        .run("simulate panel.toml -o a.h5 --truth b.h5 --force")
        .exits(2);
}

#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_is_found_before_the_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::with_panel();
    let locked = folder.path().join("locked");
    std::fs::create_dir(&locked).unwrap();
    let permit = |mode| std::fs::set_permissions(&locked, PermissionsExt::from_mode(mode)).unwrap();
    permit(0o555);
    // permissions do not bind an administrator, but no file can be made among the
    // system's own
    let binds = std::fs::write(locked.join("probe"), "").is_err();
    let place = if binds { "locked" } else { "/proc" };
    for line in [
        "fit panel.h5 -o PLACE/model.json",
        "render truth.json scene.toml -o PLACE/weights.json",
        "render truth.json scene.toml --wav PLACE/drive.wav",
        "simulate panel.toml -o new.h5 --truth PLACE/truth.json",
        "estimate panel.h5 -o PLACE/frf.h5",
        "block reduce panel.h5 -o PLACE/a.part",
        "report truth.json -o PLACE/report.html",
        "report truth.json --charts PLACE",
    ] {
        let line = line.replace("PLACE", place);
        let run = folder
            .run(&format!("{line} --json --progress plain"))
            .exits(73);
        let error = run.json()["error"].clone();
        assert_eq!(error["kind"], "cannot_create", "{line}: {error}");
        // no stage of the work has begun
        let stages: Vec<&str> = run
            .stderr
            .lines()
            .take_while(|line| !line.starts_with("error"))
            .collect();
        assert!(stages.is_empty(), "{line}: {stages:?}");
    }
    assert!(!folder.names().contains(&"new.h5".to_owned()));
    permit(0o755);
}

#[test]
fn control_characters_of_a_name_do_not_reach_the_terminal() {
    let folder = Folder::with_panel();
    let name = "\u{1b}[31mred\u{202e}.csv";
    let said = |line: &str, code: i32| {
        let run = folder.run(line).exits(code);
        let text = run.stdout + &run.stderr;
        let obeyed = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
        assert!(!text.contains(obeyed), "{line}: {text:?}");
        assert!(text.contains("\\u{1b}[31mred\\u{202e}"), "{line}: {text:?}");
    };
    said(&format!("info {name}"), 66);
    said(&format!("fit --band {name} panel.h5"), 2);
    folder
        .run(&format!("convert panel.h5 -o {name} -q"))
        .exits(0);
    said(&format!("info {name}"), 0);
    said(&format!("convert panel.h5 -o {name} --force"), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_is_read_where_the_system_starts_no_thread_beside() {
    let folder = Folder::with_panel();
    let read = |limits: &str| {
        let line = format!(
            "{limits} exec {} info panel.h5 --threads 1 --json",
            env!("CARGO_BIN_EXE_chladni")
        );
        let mut command = Command::new("sh");
        command.args(["-c", &line]).current_dir(folder.path());
        let output = command.output().unwrap();
        (output.status.code(), output.stdout)
    };
    // the stacks of the threads for signals and for computing fit into the memory allowed, that of
    // one more does not
    let limited = read("export RUST_MIN_STACK=1073741824; ulimit -v 2600000;");
    assert_eq!(limited.0, Some(0));
    assert!(limited == read(""));
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_the_system_refuses_are_no_bug() {
    let folder = Folder::with_panel();
    // the stack of one thread exceeds the memory allowed
    let line = format!(
        "export RUST_MIN_STACK=1073741824; ulimit -v 600000; \
         exec {} info panel.h5 --threads 8 --json",
        env!("CARGO_BIN_EXE_chladni")
    );
    let output = Command::new("sh")
        .args(["-c", &line])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let error = &answer["error"];
    assert_eq!(output.status.code(), Some(74), "{answer}");
    assert_eq!(
        (&error["field"], &error["found"]),
        (&"--threads".into(), &"8".into()),
        "{answer}"
    );
}
