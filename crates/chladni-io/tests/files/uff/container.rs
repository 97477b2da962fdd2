//! Datasets in the file: unknown, damaged, cut short.

use super::{options, read_with, text_58, HEADER_151, ID_LINES, ONES, SI_164, TWO_COMPLEX};
use chladni_frf::Severity;
use chladni_io::uff::read;
use std::path::Path;

#[test]
fn unknown_datasets_are_listed_by_number_and_the_rest_is_read() {
    let text = [
        "    -1\n  1858\nanything\n    -1\n    -1\n   999\n         1         2\n    -1\n",
        SI_164,
    ]
    .concat();
    let document = read_with(text, &options());
    let names: Vec<_> = document
        .datasets
        .iter()
        .map(|d| (d.number, d.name.as_str()))
        .collect();
    assert_eq!(
        names,
        [
            (Some(1858), "unknown dataset 1858"),
            (Some(999), "unknown dataset 999"),
            (Some(164), "units")
        ]
    );
    assert_eq!(document.errors, []);
}

#[test]
fn a_dataset_whose_opening_line_is_damaged_is_missed_aloud() {
    let sound = text_58(TWO_COMPLEX, ONES);
    let damaged = sound.replacen("    -1", "   x-1", 1);
    for (text, severity) in [
        ([&damaged, SI_164].concat(), Severity::Caution),
        (["a title above\n", SI_164].concat(), Severity::Note),
    ] {
        let warnings = read_with(&text, &options()).warnings;
        let found = warnings.iter().find(|one| one.code == "not-read");
        assert_eq!(found.unwrap().severity, severity, "{warnings:?}");
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &text).unwrap();
        let listed = chladni_io::uff::scan(file.path(), &options()).unwrap();
        assert_eq!(listed.warnings, warnings, "in pieces as in one");
    }
}

#[test]
fn datasets_are_listed_with_the_lines_where_they_start() {
    let document = read_with([HEADER_151, SI_164].concat(), &options());
    let datasets: Vec<_> = document
        .datasets
        .iter()
        .map(|d| (d.number, d.line, d.name.as_str()))
        .collect();
    assert_eq!(
        datasets,
        [
            (Some(151), Some(1), "header"),
            (Some(164), Some(11), "units")
        ]
    );
    assert_eq!(document.checksum, None, "the caller fills it");
}

#[test]
fn a_file_cut_inside_a_text_function_says_so_and_keeps_the_sound_ones() {
    let sound = [SI_164, &text_58(TWO_COMPLEX, ONES)].concat();
    let cut = text_58(TWO_COMPLEX, ONES);
    for length in [cut.len() - 8, cut.len() - 60, 480, 200, 20] {
        let document = read_with([sound.as_str(), &cut[..length]].concat(), &options());
        assert_eq!(
            (document.functions.len(), document.errors.len()),
            (1, 1),
            "{length}"
        );
        assert_eq!(document.datasets.len(), 3);
        assert_eq!(document.errors[0].dataset, Some(58));
    }
}

#[test]
fn what_is_no_universal_file_is_refused() {
    for bytes in [
        &b""[..],
        b"hello",
        b"\x89HDF\r\n\x1a\n",
        b"1,2,3\n",
        b"    -1\n",
    ] {
        let error = read(bytes, Path::new("x.uff"), &options()).unwrap_err();
        assert!(error.file.is_some() && error.help.is_some());
    }
}

#[test]
fn a_damaged_units_dataset_does_not_make_si_of_what_it_scales() {
    let text = [
        SI_164.replacen("1.00000000000000000D+00", "0.00000000000000000D+00", 1),
        text_58(TWO_COMPLEX, ONES),
    ]
    .concat();
    let document = read_with(text, &options());
    assert_eq!((document.functions.len(), document.errors.len()), (0, 2));
}

#[test]
fn mode_shapes_are_listed_with_frequency_and_damping() {
    let text = format!(
        "    -1\n    55\n{ID_LINES}         1         3         2         8         \
                        5         3\n         2         6         1         1\n -3.00000E+00  \
                        4.00000E+00\n    -1\n"
    );
    let document = read_with(text, &options());
    assert_eq!(document.datasets[0].damping_ratio, Some(0.6));
    assert_eq!(
        document.datasets[0].frequency_hz,
        Some(5.0 / std::f64::consts::TAU)
    );
}
