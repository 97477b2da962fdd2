//! Counts in headers do not decide allocations: reading takes at most 8 × the file + 16 MiB,
//! whether it is damaged or not. The list of a universal file that does not fit into memory
//! takes less than 1 MiB.
//!
//! Packed files (MATLAB 7, NPZ) are measured by what they hold; what they may unfold to
//! is limited in the readers.

use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_io::{assemble, list_document, read_document, uff, write_frf, ReadOptions};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use peak_alloc::PeakAlloc;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const TIMES: usize = 8;
const ROOM: usize = 16 << 20;

/// Room for the list of a file whose values are passed over.
const ROOM_FOR_LIST: usize = 1 << 20;

/// A binary function of `count` complex doubles, all of them a hole in the file, and a
/// header behind it.
fn write_sparse(path: &Path, count: u64) {
    let bytes = count * 16;
    let before = format!(
        "    -1\n    58b     1     2          11{bytes:>12}     0     0           0           \
         0\n{}    4         0    0         0 NONE               7   3 NONE             101   \
         3\n         6{count:>10}         1  1.00000E+00  5.00000E-01  0.00000E+00\n        18    \
         0    0    0 Frequency            Hz\n        11    0    0    0 Velocity             \
         m/s\n        13    0    0    0 Force                N\n         0    0    0    0 \
         NONE                 NONE\n",
        "NONE\n".repeat(5)
    );
    let mut file = std::fs::File::create(path).unwrap();
    file.write_all(before.as_bytes()).unwrap();
    file.seek(SeekFrom::Start(before.len() as u64 + bytes))
        .unwrap();
    file.write_all(b"    -1\n    -1\n   151\nNONE\n    -1\n")
        .unwrap();
}

fn lists_within_little_memory(folder: &Path) {
    for (name, size) in [("large.uff", 4 << 20), ("large.unv", 12 << 20)] {
        let path = folder.join(name);
        assert!(
            std::fs::metadata(&path).unwrap().len() > size,
            "{name}: large enough to tell"
        );
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let scanned = uff::scan(&path, &ReadOptions::default()).unwrap();
        let peak = ALLOCATOR.peak_usage() - before;
        assert!(peak < ROOM_FOR_LIST, "{name}: {peak} bytes");
        let read = read_document(&path, &ReadOptions::default()).unwrap();
        assert_eq!(
            (scanned.datasets.len(), scanned.errors),
            (read.datasets.len(), vec![])
        );
        for (listed, read) in scanned.datasets.iter().zip(&read.datasets) {
            assert_eq!(
                (listed.number, &listed.response, listed.values),
                (read.number, &read.response, read.values)
            );
            assert!(listed.line.is_none() || listed.line == read.line, "{name}");
        }
    }
    // larger than the memory of any machine that runs this test
    let path = folder.join("sparse.uff");
    write_sparse(&path, 1 << 33);
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let started = std::time::Instant::now();
    let listed = list_document(&path, &ReadOptions::default()).unwrap();
    let (peak, elapsed) = (ALLOCATOR.peak_usage() - before, started.elapsed());
    println!("128 GiB: listed in {elapsed:.1?} with {peak} bytes");
    assert!(peak < ROOM_FOR_LIST && elapsed.as_secs() < 5);
    assert_eq!(
        listed
            .datasets
            .iter()
            .map(|info| info.number)
            .collect::<Vec<_>>(),
        [Some(58), Some(151)]
    );
    assert_eq!(
        (listed.datasets[0].values, listed.datasets[0].frf_kind),
        (Some(1 << 33), Some(FrfKind::Mobility))
    );
    assert!(
        listed.errors.is_empty()
            && listed
                .warnings
                .iter()
                .any(|warning| warning.contains("headers")),
        "{:?}",
        listed.warnings
    );
}

/// Bytes that reading and merging `path` takes at most.
fn peak_of(path: &Path, lenient: bool) -> usize {
    let options = ReadOptions {
        lenient,
        ..ReadOptions::default()
    };
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
        assert!(
            peak <= TIMES * bytes + ROOM,
            "{}: {peak} bytes for a file of {bytes}",
            path.display()
        );
    }
}

// one test: the allocator counts for the whole process
#[test]
fn reading_takes_at_most_eight_times_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let (responses, references, lines) = (20, 4, 4000);
    let set = FrfSet {
        frequency_hz: Array1::from_iter((1..=lines).map(|k| 0.25 * k as f64)),
        values: FrfValues::F64(Array3::from_shape_fn(
            (responses, references, lines),
            |(i, j, k)| Complex64::new((i * 31 + j * 7 + k) as f64 * 0.123, -0.001 * k as f64),
        )),
        responses: (1..=responses as u64)
            .map(|node| format!("{node}:+Z").parse().unwrap())
            .collect(),
        references: (101..101 + references as u64)
            .map(|node| format!("{node}:+Z").parse().unwrap())
            .collect(),
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: Geometry::default(),
    };
    for extension in ["uff", "unv", "h5", "csv", "npz"] {
        let path = folder.path().join(format!("large.{extension}"));
        write_frf(&path, &set, true).unwrap();
        let bytes = std::fs::metadata(&path).unwrap().len() as usize;
        let peak = peak_of(&path, false);
        println!(
            "{extension}: {bytes} bytes, peak {:.2} times that",
            peak as f64 / bytes as f64
        );
        // large enough that the fixed room does not hide a factor
        assert!(
            peak <= TIMES * bytes,
            "{extension}: {peak} bytes for a file of {bytes}"
        );
    }
    lists_within_little_memory(folder.path());
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/malformed");
    let mut count = 0;
    for class in std::fs::read_dir(corpus)
        .unwrap()
        .flatten()
        .filter(|entry| entry.path().is_dir())
    {
        let files: Vec<PathBuf> = std::fs::read_dir(class.path())
            .unwrap()
            .flatten()
            .map(|entry| entry.path())
            .collect();
        for file in files {
            // the readers' limit of what packed data may unfold to
            let packed_into = if file.file_stem().is_some_and(|stem| stem == "bomb") {
                128
            } else {
                1
            };
            check(&file, packed_into);
            count += 1;
        }
    }
    assert!(count >= 200, "{count} files of the corpus");
}
