//! Runs the real program in a folder of its own.

#[path = "../../../crates/chladni-cli/tests/cli/common/run.rs"]
mod run;

pub use run::Run;

use assert_cmd::Command;
use std::path::Path;
use tempfile::TempDir;

/// A folder that is gone after the test.
pub struct Folder(TempDir);

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
