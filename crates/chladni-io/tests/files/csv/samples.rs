//! Measured files.

use super::reading::{c, read};
use chladni_frf::FrfKind;
use chladni_io::{read_document, read_frf, ReadOptions};
use std::path::PathBuf;

/// A measured file that stands beside the project.
fn sample(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    if path.exists() {
        return Some(path);
    }
    crate::skipped(&format!("no sample {name}"));
    None
}

#[test]
fn a_measured_frf_with_coherence() {
    let Some(path) = sample("vtb-case1/case1_frf.csv") else {
        return;
    };
    let (set, _, warnings) =
        read_frf(std::slice::from_ref(&path), &ReadOptions::default()).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(
        (set.frequency_hz.len(), set.frequency_hz[1600]),
        (1601, 500.0)
    );
    assert_eq!(set.values.get(0, 0, 1), c(-64.2635574, -37.0582924));
    let coherence = set.coherence.unwrap();
    assert!(coherence[[0, 0, 0]].is_nan() && (coherence[[0, 0, 1]] - 0.704_286_34).abs() < 1e-7);
    let text = warnings.join("\n");
    assert!(text.contains("0 Hz is outside"), "{text}");
    assert_eq!(
        read_document(&path, &ReadOptions::default())
            .unwrap()
            .datasets[0]
            .values,
        Some(1601)
    );
}

#[test]
fn lists_of_python_complex_numbers_are_refused_and_readable_as_columns() {
    let Some(path) = sample("pyuff-measured-beam-txt/meas_point_1.txt") else {
        return;
    };
    let error = read_frf(std::slice::from_ref(&path), &ReadOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("without a frequency axis"),
        "{error}"
    );
    let mut table = String::from("# frf_kind = accelerance\n# unit = m/s^2/N\nf,re,im\n");
    for (k, line) in std::fs::read_to_string(path).unwrap().lines().enumerate() {
        let inner = line.trim().trim_start_matches('(').trim_end_matches("j)");
        let cut = (1..inner.len())
            .rev()
            .find(|&at| "+-".contains(&inner[at..=at]) && !"eE".contains(&inner[at - 1..at]))
            .unwrap();
        table += &format!("{k},{},{}\n", &inner[..cut], &inner[cut..]);
    }
    let (set, _) = read(table).unwrap();
    assert_eq!(
        (set.frequency_hz.len(), set.kind),
        (1001, Some(FrfKind::Accelerance))
    );
    assert_eq!(
        set.values.get(0, 0, 0),
        c(-0.0774752256830106, 2.6838208936737454e-08)
    );
}
