//! Nothing is allocated on a header's word: reading takes at most 8 × the file + 16 MiB, sound or damaged.
//!
//! Packed files (MATLAB 7, NPZ) are measured by what they hold; what they may unfold to is limited in the readers.

use chladni_frf::io::{assemble, read_document, write_frf, ReadOptions};
use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use peak_alloc::PeakAlloc;
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const TIMES: usize = 8;
const ROOM: usize = 16 << 20;

/// Bytes that reading and merging `path` takes at most.
fn peak_of(path: &Path, lenient: bool) -> usize {
    let options = ReadOptions { lenient, ..ReadOptions::default() };
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    if let Ok(document) = read_document(path, &options) {
        let _ = assemble(vec![document], &options);
    }
    ALLOCATOR.peak_usage().saturating_sub(before)
}

fn check(path: &Path, packed_into: usize) {
    let bytes = std::fs::metadata(path).unwrap().len() as usize * packed_into;
    for lenient in [false, true] {
        let peak = peak_of(path, lenient);
        assert!(peak <= TIMES * bytes + ROOM, "{}: {peak} bytes for a file of {bytes}", path.display());
    }
}

// one test: the allocator counts for the whole process
#[test]
fn reading_takes_at_most_eight_times_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let (responses, references, lines) = (20, 4, 4000);
    let set = FrfSet {
        frequency_hz: Array1::from_iter((1..=lines).map(|k| 0.25 * k as f64)),
        values: FrfValues::F64(Array3::from_shape_fn((responses, references, lines), |(i, j, k)| {
            Complex64::new((i * 31 + j * 7 + k) as f64 * 0.123, -0.001 * k as f64)
        })),
        responses: (1..=responses as u64).map(|node| format!("{node}:+Z").parse().unwrap()).collect(),
        references: (101..101 + references as u64).map(|node| format!("{node}:+Z").parse().unwrap()).collect(),
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: None,
        variance: None,
        geometry: Geometry::default(),
    };
    for extension in ["uff", "unv", "h5", "csv", "npz"] {
        let path = folder.path().join(format!("large.{extension}"));
        write_frf(&path, &set, true).unwrap();
        let bytes = std::fs::metadata(&path).unwrap().len() as usize;
        let peak = peak_of(&path, false);
        println!("{extension}: {bytes} bytes, peak {:.2} times that", peak as f64 / bytes as f64);
        // large enough that the fixed room does not hide a factor
        assert!(peak <= TIMES * bytes, "{extension}: {peak} bytes for a file of {bytes}");
    }
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/malformed");
    let mut count = 0;
    for class in std::fs::read_dir(corpus).unwrap().flatten().filter(|entry| entry.path().is_dir()) {
        let files: Vec<PathBuf> = std::fs::read_dir(class.path()).unwrap().flatten().map(|entry| entry.path()).collect();
        for file in files {
            // the readers' limit of what packed data may unfold to
            let packed_into = if file.file_stem().is_some_and(|stem| stem == "bomb") { 128 } else { 1 };
            check(&file, packed_into);
            count += 1;
        }
    }
    assert!(count >= 200, "{count} files of the corpus");
}
