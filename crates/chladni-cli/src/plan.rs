//! `--dry-run`: the inputs, the memory and the outputs of a command.

use chladni_console::memory::in_mebibytes;
use chladni_console::table::counted;
use chladni_console::Outcome;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Work that is described instead of done.
pub struct Plan<'a> {
    /// Files to read.
    pub files: &'a [PathBuf],
    /// Approximate bytes of the FRFs in memory.
    pub frf_bytes: u64,
    /// Parts that the files are read in; `None` where they are held whole.
    pub parts: Option<usize>,
    /// Bytes that the run may take.
    pub memory: u64,
    /// Files to write.
    pub outputs: Vec<&'a Path>,
}

impl Plan<'_> {
    /// The plan as a result.
    pub fn outcome(&self) -> Outcome {
        let names = |paths: &mut dyn Iterator<Item = &Path>| -> Vec<String> {
            paths.map(|path| path.display().to_string()).collect()
        };
        let files = names(&mut self.files.iter().map(PathBuf::as_path));
        let outputs = names(&mut self.outputs.iter().copied());
        let manner = match self.parts {
            Some(parts) => format!("in {}", counted(parts, "part")),
            None => "whole".into(),
        };
        let written = match outputs.as_slice() {
            [] => "nothing".into(),
            some => some.join(", "),
        };
        let text = format!(
            "{} to read, {}: FRFs of {} in memory, {} allowed\nto be written: {written}\n\
             Nothing was done (--dry-run).\n",
            counted(files.len(), "file"),
            manner,
            in_mebibytes(self.frf_bytes),
            in_mebibytes(self.memory),
        );
        let json = json!({
            "dry_run": true,
            "files": files,
            "frf_bytes": self.frf_bytes,
            "parts": self.parts,
            "memory_bytes": self.memory,
            "outputs": outputs,
        });
        Outcome::shown(json, text)
    }
}
