//! Runs the real binary in a folder of its own.

#![allow(dead_code)] // every test file uses its own part

pub mod browser;
mod run;
pub mod studio;

pub use run::Run;

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// A small panel: 24 responses, 10 references, a handful of modes.
pub const PANEL: &str = "[responses]\ngrid = [6, 4]\nspacing_m = 0.035\n[references]\nedge_count = [3, 2]\nspacing_m = 0.06\n\
                         [frf]\nstart_hz = 20.0\nstop_hz = 400.0\nstep_hz = 1.0\n";
/// The corner at the origin is felt, the rest is quiet.
pub const SCENE: &str =
    "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, \
     0.170]\ntransition_m = 0.02\n";

/// A folder that is gone after the test.
pub struct Folder(pub TempDir);

/// Tells that a test is skipped. The line bypasses the test harness, which would hide it.
pub fn skipped(what: &str) {
    use std::io::Write;
    drop(writeln!(std::io::stderr(), "skipped: {what}"));
}

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A folder with `panel.toml`, `scene.toml` and `panel.h5`.
    pub fn with_panel() -> Self {
        let folder = Self::new();
        folder.write("panel.toml", PANEL);
        folder.write("scene.toml", SCENE);
        folder
            .run("simulate panel.toml -o panel.h5 --truth truth.json -q")
            .exits(0);
        folder
    }

    /// A folder with `panel.h5` of the glass panel with driving points at few lines, and
    /// its truth as `model.json`.
    pub fn with_glass() -> Self {
        let folder = Self::new();
        folder.write(
            "panel.toml",
            "[responses]\nat_references = true\n[frf]\nstart_hz = 100\nstop_hz = 1000\nstep_hz = 10\n",
        );
        folder
            .run("simulate panel.toml -o panel.h5 --truth model.json -q")
            .exits(0);
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Runs `chladni` with words split at blanks.
    pub fn run(&self, line: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chladni"));
        let output = command
            .current_dir(self.path())
            .args(line.split_whitespace())
            .output()
            .unwrap();
        Run::of(output)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path().join(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path().join(name)).unwrap()
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// Names of all files, hidden ones too.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// Natural frequencies of the modes in the band, Hz, of a model as JSON.
pub fn in_band_hz(model: &Value) -> Vec<f64> {
    let modes = model["modes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|mode| mode["in_band"] == true);
    modes
        .map(|mode| mode["frequency_hz"].as_f64().unwrap())
        .collect()
}
