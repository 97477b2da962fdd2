//! What every fuzz target does with its bytes.

use chladni_frf::io::{assemble, read_document, read_model, uff, write_contents, ReadOptions};
use chladni_frf::{ErrorKind, Selection};
use std::io::Write;
use std::path::Path;

/// Reads bytes as a file, strictly and leniently. Where they could be read, universal files that are written of them must be read
/// again without an error.
pub fn file(data: &[u8], extension: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("input.{extension}"));
    std::fs::File::create(&path).unwrap().write_all(data).unwrap();
    for lenient in [false, true] {
        let options = ReadOptions { lenient, snap_df: lenient, ..ReadOptions::default() };
        let _ = uff::scan(&path, &options);
        let Ok(document) = read_document(&path, &options) else { continue };
        let Ok(contents) = assemble(vec![document], &options) else { continue };
        for binary in [true, false] {
            let written = uff::WriteOptions { binary, old_datasets: false };
            let mut bytes = Vec::new();
            if uff::write(&mut bytes, &contents, written).is_ok() {
                let again = uff::read(&bytes, Path::new("again.uff"), &ReadOptions::default()).unwrap();
                assert_eq!(again.errors, [], "what was written is read");
            }
        }
        if let Err(error) = write_contents(&folder.path().join("again.h5"), &contents, true) {
            assert_ne!(error.kind, ErrorKind::Internal, "{error}");
        }
    }
    let _ = read_model(&path);
}

/// Reads text as a scene, a panel and a selection.
pub fn toml_inputs(data: &[u8]) {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(data).unwrap();
    let _ = chladni_render::Scene::read(file.path());
    let _ = chladni_plate::Panel::read(file.path(), 1 << 28);
    let _ = Selection::read(file.path());
}
