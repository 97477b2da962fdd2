//! Damaged files by the thousand: seeds with a few random changes must never make a reader panic, hang, or take a count on
//! trust. Sums that wrap are panics here (overflow checks are on).
//!
//! In the normal suite each target runs for about a second. `CHLADNI_FUZZ_SECONDS=1200 cargo test --release -p chladni-frf --test
//! mutation -- --nocapture uff_text` runs one for long.

mod engine;

use chladni_frf::io::{assemble, read_document, read_model, uff, write_frf, write_json, Contents, Document, ReadOptions};
use chladni_frf::{ErrorKind, FrfSet, FrfValues, Geometry, Node, ReferenceUnit, Selection};
use engine::run_files;
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use std::path::{Path, PathBuf};

fn set() -> FrfSet {
    FrfSet {
        frequency_hz: Array1::from_iter((1..=6).map(|k| 0.5 * f64::from(k))),
        values: FrfValues::F64(Array3::from_shape_fn((2, 1, 6), |(i, _, k)| Complex64::new(0.1 * k as f64, 1.0 / (1 + i) as f64))),
        responses: vec!["1:+Z".parse().unwrap(), "2:-Z".parse().unwrap()],
        references: vec!["101:+Z".parse().unwrap()],
        kind: Some(chladni_frf::FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: Some(Array3::from_elem((2, 1, 6), 0.9)),
        variance: None,
        geometry: Geometry {
            nodes: [1, 2, 101].map(|label| Node { label, xyz_m: [0.1 * label as f64, 0.0, 0.0] }).to_vec(),
            lines: vec![vec![1, 2, 101]],
            faces: vec![vec![1, 2, 101]],
        },
    }
}

/// Sound files of one format, and the damaged ones of the corpus in folders that begin like this.
fn seeds(extensions: &[&str], folders: &[&str]) -> Vec<Vec<u8>> {
    let temporary = tempfile::tempdir().unwrap();
    let mut seeds = Vec::new();
    for extension in extensions {
        let path = temporary.path().join(format!("seed.{extension}"));
        write_frf(&path, &set(), true).unwrap();
        seeds.push(std::fs::read(path).unwrap());
    }
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/malformed");
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in std::fs::read_dir(corpus).unwrap().flatten().map(|entry| entry.path()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        if folder.is_dir() && folders.iter().any(|prefix| name.starts_with(prefix)) {
            files.extend(std::fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path()));
        }
    }
    files.sort();
    // sound files as often as all damaged ones together; archives that unfold to much only cost time
    let damaged: Vec<Vec<u8>> = files.iter().map(|file| std::fs::read(file).unwrap()).filter(|bytes| bytes.len() < 16_384).collect();
    let sound = seeds.clone();
    while !sound.is_empty() && seeds.len() < damaged.len() {
        seeds.extend(sound.iter().cloned());
    }
    seeds.extend(damaged);
    seeds
}

/// The count that record 7 declares is the count that was read, whatever else is wrong with the file.
fn declared_is_read(bytes: &[u8], document: &Document) {
    let lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
    for function in &document.functions {
        // marker, number, five ID lines, record 6, record 7; blank lines may stand before the number
        let Some(number) = (function.line as usize..lines.len()).find(|&k| !lines[k].trim_ascii().is_empty()) else { continue };
        let Some(record) = lines.get(number + 7).filter(|_| lines[number].trim_ascii().starts_with(b"58")) else { continue };
        let count = |field: &[u8]| std::str::from_utf8(field).ok().and_then(|text| text.trim().parse::<usize>().ok());
        // by column, or between blanks where a change has moved the columns
        let by_column = record.get(10..20).and_then(count);
        let by_blanks = record.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).nth(1).and_then(count);
        if let (Some(by_column), Some(by_blanks)) = (by_column, by_blanks) {
            let read = function.ordinate.len();
            assert!(by_column == read || by_blanks == read, "declared {by_column} or {by_blanks}, read {read}, line {}", function.line);
        }
    }
}

/// The list of a file whose values are passed over is that of the file; it finds no fault where there is none.
fn listed_is_read(scanned: &Document, read: &Document) {
    if read.errors.is_empty() {
        let listed = |document: &Document| document.datasets.iter().map(|info| (info.number, info.values, info.nodes)).collect::<Vec<_>>();
        assert_eq!(scanned.errors, []);
        assert_eq!(listed(scanned), listed(read));
        assert_eq!(scanned.geometry, read.geometry);
    }
}

fn universal(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    let scanned = uff::scan(path, &ReadOptions::default());
    if let Ok(document) = uff::read(bytes, path, &ReadOptions::default()) {
        declared_is_read(bytes, &document);
        listed_is_read(scanned.as_ref().unwrap(), &document);
        let functions = document.functions;
        let contents = Contents { functions, shapes: document.shapes, other_geometry: document.geometry, ..Contents::default() };
        for binary in [true, false] {
            let mut again = Vec::new();
            if uff::write(&mut again, &contents, uff::WriteOptions { binary, old_datasets: false }).is_ok() {
                let read = uff::read(&again, path, &ReadOptions::default()).unwrap();
                assert_eq!(read.errors, [], "what was written is read");
                assert_eq!((read.functions.len(), read.shapes.len()), (contents.functions.len(), contents.shapes.len()));
            }
        }
    }
    let lenient = ReadOptions { lenient: true, snap_df: true, ..ReadOptions::default() };
    let _ = uff::read(bytes, path, &lenient);
    let _ = uff::scan(path, &lenient);
}

/// Reads bytes as any file, merges them, and writes what came of it.
fn any_file(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
    for lenient in [false, true] {
        let options = ReadOptions { lenient, ..ReadOptions::default() };
        let Ok(document) = read_document(path, &options) else { continue };
        for error in &document.errors {
            assert!(!error.message.is_empty());
        }
        if let Ok(contents) = assemble(vec![document], &options) {
            let mut again = Vec::new();
            if let Err(error) = uff::write(&mut again, &contents, uff::WriteOptions { binary: true, old_datasets: false }) {
                assert_ne!(error.kind, ErrorKind::Internal, "{error}");
            }
        }
    }
}

#[test]
fn uff_text() {
    run_files("uff_text", "unv", &seeds(&["unv", "uf"], &["uff"]), universal);
}

#[test]
fn uff_binary() {
    run_files("uff_binary", "uff", &seeds(&["uff"], &["58b"]), universal);
}

#[test]
fn csv() {
    run_files("csv", "csv", &seeds(&["csv"], &["csv"]), any_file);
}

// the C library crashes on such files (docs/architecture.md)
#[cfg(not(feature = "system"))]
#[test]
fn hdf5() {
    run_files("hdf5", "h5", &seeds(&["h5"], &["h5"]), |path, bytes| {
        any_file(path, bytes);
        let _ = read_model(path);
    });
}

#[test]
fn matlab() {
    run_files("matlab", "mat", &seeds(&[], &["mat"]), any_file);
}

#[test]
fn numpy() {
    run_files("numpy", "npz", &seeds(&["npz"], &["npy", "npz"]), any_file);
}

#[test]
fn wav() {
    run_files("wav", "wav", &seeds(&[], &["wav"]), any_file);
}

#[test]
fn model_and_weights_json() {
    run_files("model_and_weights_json", "json", &seeds(&[], &["model", "weights", "base"]), |path, bytes| {
        any_file(path, bytes);
        if let Ok(model) = read_model(path) {
            let mut again = Vec::new();
            write_json(&mut again, &model).unwrap();
            std::fs::write(path, again).unwrap();
            assert_eq!(read_model(path).unwrap(), model, "what was written is read");
        }
    });
}

#[test]
fn selection_toml() {
    run_files("selection_toml", "toml", &seeds(&[], &["selection"]), |path, bytes| {
        std::fs::write(path, bytes).unwrap();
        let _ = Selection::read(path);
    });
}
