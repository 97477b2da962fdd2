//! Thousands of damaged files: seeds with a few random changes must never make a reader
//! panic, hang, or allocate by a wrong count. Sums that overflow panic here (overflow checks
//! are on).
//!
//! In the normal suite each target runs for about a second. `CHLADNI_FUZZ_SECONDS=1200
//! cargo test --release -p chladni-io --test mutation -- --nocapture uff_text` runs one
//! for long.

mod engine;
mod targets;

use chladni_frf::{FrfSet, FrfValues, Geometry, Node, ReferenceUnit};
use chladni_io::write_frf;
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use std::path::{Path, PathBuf};
use targets::{any_file, any_file_or_model, selection, universal};

fn set() -> FrfSet {
    FrfSet {
        frequency_hz: Array1::from_iter((1..=6).map(|k| 0.5 * f64::from(k))),
        values: FrfValues::F64(Array3::from_shape_fn((2, 1, 6), |(i, _, k)| {
            Complex64::new(0.1 * k as f64, 1.0 / (1 + i) as f64)
        })),
        responses: vec!["1:+Z".parse().unwrap(), "2:-Z".parse().unwrap()],
        references: vec!["101:+Z".parse().unwrap()],
        kind: Some(chladni_frf::FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: Some(Array3::from_elem((2, 1, 6), 0.9)),
        variance: None,
        estimation: None,
        geometry: Geometry {
            nodes: [1, 2, 101]
                .map(|label| Node {
                    label,
                    xyz_m: [0.1 * label as f64, 0.0, 0.0],
                })
                .to_vec(),
            lines: vec![vec![1, 2, 101]],
            faces: vec![vec![1, 2, 101]],
        },
    }
}

/// Sound files of one format, and the damaged ones of the corpus in folders that begin
/// like this.
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
    for folder in std::fs::read_dir(corpus)
        .unwrap()
        .flatten()
        .map(|entry| entry.path())
    {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        if folder.is_dir() && folders.iter().any(|prefix| name.starts_with(prefix)) {
            files.extend(
                std::fs::read_dir(folder)
                    .unwrap()
                    .flatten()
                    .map(|entry| entry.path()),
            );
        }
    }
    files.sort();
    // sound files as often as all damaged ones together; archives that unfold to much
    // only cost time
    let damaged: Vec<Vec<u8>> = files
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .filter(|bytes| bytes.len() < 16_384)
        .collect();
    let sound = seeds.clone();
    while !sound.is_empty() && seeds.len() < damaged.len() {
        seeds.extend(sound.iter().cloned());
    }
    seeds.extend(damaged);
    seeds
}

/// Runs a target on the thread of its test alone: handing work to others takes longer
/// than most readers need.
fn run_files(name: &str, extension: &str, seeds: &[Vec<u8>], target: impl Fn(&Path, &[u8])) {
    let _alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build()
        .unwrap();
    engine::run_files(name, extension, seeds, target);
}

#[test]
fn uff_text() {
    run_files(
        "uff_text",
        "unv",
        &seeds(&["unv", "uf"], &["uff"]),
        universal,
    );
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
    run_files("hdf5", "h5", &seeds(&["h5"], &["h5"]), any_file_or_model);
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
    run_files(
        "model_and_weights_json",
        "json",
        &seeds(&[], &["model", "weights", "base"]),
        any_file_or_model,
    );
}

#[test]
fn selection_toml() {
    run_files(
        "selection_toml",
        "toml",
        &seeds(&[], &["selection"]),
        selection,
    );
}
