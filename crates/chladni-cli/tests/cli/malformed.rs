//! The corpus of damaged files (`fixtures/malformed`): each is refused with its message,
//! and every message carries file, place, what was found and what was expected.
//! `scripts/make_malformed.py` writes the files and the list.

use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Least numbers of files and of classes.
const FILES: usize = 200;
const CLASSES: usize = 25;
/// Time after which a reader counts as hanging, on a busy machine too.
const SLOWEST: Duration = Duration::from_secs(10);

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/malformed")
}

/// Faults of the answer to one file.
fn complaints(case: &Value, folder: &Path) -> Vec<String> {
    let name = case["file"].as_str().unwrap();
    let file = corpus().join(name);
    let model = corpus().join("base/model.json");
    let (inputs, extension) = match case["command"].as_str().unwrap() {
        "render" | "select" => (vec![model, file], Some("json")),
        "info" => (vec![file], None),
        _ => (vec![file], Some("h5")),
    };
    let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
    command
        .args(["--json", case["command"].as_str().unwrap()])
        .args(&inputs);
    if let Some(extension) = extension {
        command
            .arg("-o")
            .arg(folder.join(format!("out.{extension}")));
    }
    let started = Instant::now();
    let output = command.output().unwrap();
    let mut wrong = Vec::new();
    if started.elapsed() > SLOWEST {
        wrong.push(format!("took {:?}", started.elapsed()));
    }
    let stdout = String::from_utf8_lossy(&output.stdout);
    if output.status.code() != Some(65) {
        wrong.push(format!("exit {:?}, stdout {stdout}", output.status.code()));
        return wrong;
    }
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    let error = &answer["error"];
    let text = |key: &str| match &error[key] {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    };
    for key in ["file", "found", "expected"] {
        if text(key).is_empty() {
            wrong.push(format!("no `{key}`"));
        }
    }
    if ["line", "byte", "field", "dataset"]
        .iter()
        .all(|key| text(key).is_empty())
    {
        wrong.push("no place".into());
    }
    for key in ["message", "field", "found", "expected", "dataset"] {
        let said = match &case[key] {
            Value::String(said) => said.clone(),
            Value::Null => continue,
            other => other.to_string(),
        };
        if !text(key).contains(&said) {
            wrong.push(format!("`{key}` does not say `{said}`: {}", text(key)));
        }
    }
    wrong
}

#[test]
fn every_damaged_file_is_refused_with_its_message() {
    let list = std::fs::read_to_string(corpus().join("cases.json")).unwrap();
    let cases: Vec<Value> = serde_json::from_str(&list).unwrap();
    let classes: BTreeSet<&str> = cases
        .iter()
        .map(|case| case["file"].as_str().unwrap().split('/').next().unwrap())
        .collect();
    assert!(
        cases.len() >= FILES && classes.len() >= CLASSES,
        "{} files in {} classes",
        cases.len(),
        classes.len()
    );
    let folder = tempfile::tempdir().unwrap();
    let mut failed = Vec::new();
    for case in &cases {
        // the C library has its own words for errors
        if cfg!(feature = "system") && case["file"].as_str().unwrap().starts_with("h5-cut") {
            continue;
        }
        let wrong = complaints(case, folder.path());
        if !wrong.is_empty() {
            failed.push(format!("{}: {}", case["file"], wrong.join("; ")));
        }
    }
    assert!(
        failed.is_empty(),
        "{} of {}:\n{}",
        failed.len(),
        cases.len(),
        failed.join("\n")
    );
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing was written"
    );
}
