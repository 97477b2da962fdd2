//! Runs the real program in a folder of its own.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// A folder that is gone after the test.
pub struct Folder(TempDir);

/// Exit code and output of a run.
pub struct Run {
    code: i32,
    stdout: String,
    pub stderr: String,
}

impl Run {
    /// Exit code and output of a process that has ended.
    pub fn of(output: std::process::Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            code: output.status.code().unwrap(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// The one JSON object on stdout.
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("{error} in {:?}", self.stdout))
    }
    /// Checks the exit status.
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{:?} {:?}", self.stdout, self.stderr);
        self
    }
}

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Runs `chladni-bench` with words split at blanks.
    pub fn run(&self, line: &str) -> Run {
        let output = Command::new(env!("CARGO_BIN_EXE_chladni-bench"))
            .current_dir(self.path())
            .args(line.split_whitespace())
            .output()
            .unwrap();
        Run::of(output)
    }

    pub fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.path().join(name)).unwrap()
    }
}
