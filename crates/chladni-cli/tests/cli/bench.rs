//! `bench` runs the program `chladni-bench` beside it.

use crate::common::Folder;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

/// Waits until a new program can run. A process that another test starts while the file is
/// written holds it open for a moment.
fn wait_until_runnable(program: &Path) {
    let busy = || match Command::new(program).arg("--version").output() {
        Err(error) => error.kind() == ErrorKind::ExecutableFileBusy,
        Ok(_) => false,
    };
    while busy() {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Runs a copy of the program in a folder that PATH does not name.
fn alone(folder: &Path, line: &str) -> Output {
    let copy = folder.join("chladni");
    if !copy.exists() {
        std::fs::copy(env!("CARGO_BIN_EXE_chladni"), &copy).unwrap();
        wait_until_runnable(&copy);
    }
    Command::new(copy)
        .args(line.split(' '))
        .env("PATH", "/nowhere")
        .output()
        .unwrap()
}

#[test]
fn without_the_program_it_says_how_to_install_it() {
    let folder = Folder::new();
    let run = alone(folder.path(), "bench accuracy -o out");
    let said = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(66), "{said}");
    assert!(said.contains("cargo install --path benches"), "{said}");
    for line in [
        "bench --json",
        "--json bench accuracy",
        "bench accuracy --json",
    ] {
        let run = alone(folder.path(), line);
        assert_eq!(run.status.code(), Some(66), "{line}");
        let json: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
        assert!(json["error"].is_object(), "{line}: {json}");
    }
}

#[cfg(unix)]
#[test]
fn arguments_and_exit_code_are_handed_on() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let program = folder.path().join("chladni-bench");
    std::fs::write(&program, "#!/bin/sh\necho \"$@\"\nexit 73\n").unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    wait_until_runnable(&program);
    let run = alone(folder.path(), "--json bench accuracy -o bench --help");
    assert_eq!(run.status.code(), Some(73));
    assert_eq!(run.stdout, b"--json accuracy -o bench --help\n");
}
