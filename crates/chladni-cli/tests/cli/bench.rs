//! `bench` hands on to the program `chladni-bench` beside it.

use crate::common::Folder;
use std::path::Path;
use std::process::{Command, Output};

/// Runs a copy of the program in a folder that PATH does not name.
fn alone(folder: &Path, line: &str) -> Output {
    let copy = folder.join("chladni");
    if !copy.exists() {
        std::fs::copy(env!("CARGO_BIN_EXE_chladni"), &copy).unwrap();
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
}

#[cfg(unix)]
#[test]
fn arguments_and_exit_code_are_handed_on() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let program = folder.path().join("chladni-bench");
    std::fs::write(&program, "#!/bin/sh\necho \"$@\"\nexit 73\n").unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let run = alone(folder.path(), "--json bench accuracy -o bench --help");
    assert_eq!(run.status.code(), Some(73));
    assert_eq!(run.stdout, b"--json accuracy -o bench --help\n");
}

#[test]
fn wild_has_a_row_for_each_structure_and_exports_one_that_can_be_fitted() {
    let folder = Folder::new();
    let line = "bench wild -o out --quick --seed 3 --seeds 3 --export --json";
    let json = folder.run(line).exits(0).json();
    assert_eq!(json["seeds"], 3);
    let internal = &json["criteria"][0];
    assert_eq!(
        (internal["name"].as_str(), internal["count"].as_u64()),
        (Some("internal errors"), Some(0))
    );
    let csv = folder.text("out/wild.csv");
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    assert_eq!(
        lines.next().unwrap(),
        "seed,law,kind,modes,references,responses,snr_db,complexity,found,spurious,spurious_sure,\
         announced,damping,undecidable,chi2_per_dof,frequency_within_95,time_s"
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    let seed = rows[0][0];
    let model = folder.run(&format!("fit out/wild-{seed}.h5 -o model.json -q"));
    assert!([0, 1].contains(&model.code), "{}", model.stderr);
    let truth = folder.text(&format!("out/wild-{seed}.json"));
    assert!(
        truth.contains(rows[0][1]),
        "the law of the row is that of the truth"
    );
}
