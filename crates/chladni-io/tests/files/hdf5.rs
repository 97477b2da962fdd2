//! HDF5 through the public door: round trips, damaged files, files of others.
use chladni_frf::{
    BlockWindow, ErrorKind, Estimation, Estimator, Forcing, FrfKind, FrfSet, FrfValues, Geometry,
    Node, ReferenceUnit, TimeSign,
};
use chladni_io::{
    checksum_of, read_contents, read_document, read_frf, write_contents, write_frf, Abscissa, Axis,
    Contents, FrfParts, Function, Ordinate, ReadOptions,
};
use ndarray::{Array1, Array3};
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn set(responses: usize, references: usize, lines: usize) -> FrfSet {
    let value = |(i, j, k): (usize, usize, usize)| {
        Complex64::new(1.0 + i as f64 + 0.1 * j as f64, -(k as f64) / 3.0)
    };
    FrfSet {
        frequency_hz: Array1::from_iter((0..lines).map(|k| 10.0 + k as f64 / 3.0)),
        values: FrfValues::F64(Array3::from_shape_fn((responses, references, lines), value)),
        responses: (1..=responses)
            .map(|node| format!("{node}:+Z").parse().unwrap())
            .collect(),
        references: (1..=references)
            .map(|node| format!("{}:-Z", 100 + node).parse().unwrap())
            .collect(),
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Volt,
        coherence: Some(Array3::from_elem((responses, references, lines), 0.75)),
        variance: Some(Array3::from_shape_fn(
            (responses, references, lines),
            |(i, j, k)| 1e-6 * (1 + i + j + k) as f64,
        )),
        estimation: Some(Estimation {
            estimator: Estimator::H1,
            window: BlockWindow::Exponential { rate_per_s: 0.1 },
            forcing: Some(Forcing::Burst { part: 0.5 }),
            transform_s: 2.0,
            gate_s: 1.5,
            hop_s: 1.0 / 3.0,
            averages: [3, 30],
            lines_per_value: 1,
        }),
        geometry: Geometry {
            nodes: vec![
                Node {
                    label: 1,
                    xyz_m: [0.1, 0.2, 0.3],
                },
                Node {
                    label: u64::MAX,
                    xyz_m: [1e-9, -0.5, 7.0],
                },
            ],
            lines: vec![vec![1, u64::MAX], vec![], vec![1]],
            faces: vec![vec![1, 1, 1]],
        },
    }
}

/// Equal with NaN at equal places.
fn assert_same(a: &FrfSet, b: &FrfSet) {
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

fn folder_with(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn read_one(path: &Path, options: &ReadOptions) -> chladni_frf::Result<(FrfSet, Vec<String>)> {
    let (set, sources, warnings) = read_frf(&[path.to_path_buf()], options)?;
    assert_eq!(sources[0].checksum.digits().len(), 64);
    Ok((set, crate::words(&warnings)))
}

#[test]
fn files_that_are_merged_keep_the_variance_of_each_pair_and_their_mean_has_less() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a.h5", "b.h5"].map(|name| folder.path().join(name));
    files
        .iter()
        .for_each(|file| drop(write_frf(file, &set(2, 1, 4), false).unwrap()));
    let options = ReadOptions {
        duplicates: chladni_io::Duplicates::Mean,
        ..ReadOptions::default()
    };
    let (mean, ..) = read_frf(&files, &options).unwrap();
    let variance = mean.variance.as_ref().unwrap();
    assert!(
        (variance[[1, 0, 2]] - 0.5e-6 * 4.0).abs() < 1e-18,
        "two measurements: half the variance"
    );
    let table = folder.path().join("out.csv");
    let lost = write_contents(
        &table,
        &Contents {
            frf: Some(mean),
            ..Contents::default()
        },
        false,
    )
    .unwrap();
    assert!(
        lost.iter().any(|warning| warning.contains("no variances")),
        "{lost:?}"
    );
    let made = lost
        .iter()
        .find(|w| w.contains("how the FRFs were estimated"));
    assert!(made.is_some(), "{lost:?}");
}

#[test]
fn a_set_returns_as_it_was_written_and_twice_the_same_bytes() {
    let (folder, path) = folder_with("set.h5");
    let set = set(3, 2, 5);
    assert_eq!(
        write_frf(&path, &set, false).unwrap(),
        Vec::<chladni_frf::Finding>::new()
    );
    let (back, warnings) = read_one(&path, &ReadOptions::default()).unwrap();
    assert_same(&back, &set);
    assert_eq!(
        warnings,
        ["1 response nodes have no coordinates: 2, 3".replace('1', "2")]
    );
    let again = folder.path().join("again.hdf5");
    write_frf(&again, &set, false).unwrap();
    assert_eq!(
        std::fs::read(&path).unwrap(),
        std::fs::read(&again).unwrap()
    );
}

#[test]
fn a_file_that_is_cut_off_is_refused_however_little_is_missing() {
    let (folder, path) = folder_with("whole.h5");
    write_frf(&path, &set(2, 2, 40), false).unwrap();
    let whole = std::fs::read(&path).unwrap();
    for left in [whole.len() - 1, 2 * whole.len() / 3] {
        let cut = folder.path().join("cut.h5");
        std::fs::write(&cut, &whole[..left]).unwrap();
        let error = read_frf(&[cut], &ReadOptions::default()).unwrap_err();
        assert_eq!(error.kind, ErrorKind::BadData);
        assert!(error.to_string().contains("cut"), "{error}");
    }
}

#[test]
fn files_that_are_merged_say_how_they_were_made_where_they_agree() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["a.h5", "b.h5"].map(|name| folder.path().join(name));
    let first = set(2, 1, 4);
    let made = first.estimation.unwrap();
    let more = Estimation {
        averages: [40, 50],
        ..made
    };
    let other = Estimation { hop_s: 0.5, ..made };
    for (second, expected) in [
        (
            Some(more),
            Some(Estimation {
                averages: [3, 50],
                ..made
            }),
        ),
        (Some(other), None),
        (None, None),
    ] {
        let mut set = set(2, 1, 4);
        set.references = vec!["200:+Z".parse().unwrap()];
        set.estimation = second;
        write_frf(&files[0], &first, true).unwrap();
        write_frf(&files[1], &set, true).unwrap();
        let (merged, ..) = read_frf(&files, &ReadOptions::default()).unwrap();
        assert_eq!(merged.estimation, expected);
    }
}

#[test]
fn parts_hold_the_values_of_their_rows_whatever_memory_they_are_read_into() {
    // more than the bytes that are read at a time, and fewer rows in the last part
    let double = set(41, 2, 500);
    let single = FrfSet {
        values: FrfValues::F32(Array3::from_shape_fn((41, 2, 500), |(i, j, k)| {
            Complex32::new((i + j) as f32 + 0.1, k as f32)
        })),
        ..double.clone()
    };
    for set in [double, single] {
        let (_folder, path) = folder_with("set.h5");
        write_frf(&path, &set, false).unwrap();
        let data = FrfParts::open(std::slice::from_ref(&path), &ReadOptions::default()).unwrap();
        let parts = data.parts(300_000).unwrap();
        assert!(parts.len() > 1, "{}", parts.len());
        let of_other_kinds = [
            FrfValues::F64(Array3::zeros((1, 1, 7))),
            FrfValues::F32(Array3::zeros((50, 2, 500))),
        ]
        .map(Some);
        for mut spare in of_other_kinds.into_iter().chain([None]) {
            let mut first = 0;
            let checksums = data.checksums(std::slice::from_ref(&path));
            for (number, part) in parts.iter().enumerate() {
                let turn = checksums
                    .as_ref()
                    .map(|checksums| data.turn(checksums, number, part));
                let frf = data.read(part, turn, spare.take()).unwrap().0.unwrap();
                assert_eq!(
                    frf.responses,
                    set.responses[first..first + frf.responses.len()]
                );
                for (i, j) in frf.all_pairs() {
                    assert!(
                        (0..500)
                            .all(|k| frf.values.get(i, j, k) == set.values.get(first + i, j, k)),
                        "{i} {j}"
                    );
                }
                first += frf.responses.len();
                spare = Some(frf.values);
            }
            assert_eq!(first, 41);
            if let Some(checksums) = &checksums {
                assert_eq!(
                    checksums.sources().unwrap()[0].checksum,
                    checksum_of(&path).unwrap()
                );
            }
            assert_eq!(
                checksums.is_some(),
                !cfg!(feature = "system"),
                "no library hands over bytes of a file"
            );
        }
    }
}

#[test]
fn a_time_sign_that_cannot_be_read_is_refused_whole_and_in_parts() {
    let source = "../../fixtures/malformed/h5-attributes/time-sign.h5";
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(source);
    let mut bytes = std::fs::read(source).unwrap();
    let name = b"time_sign\0";
    let at = bytes.windows(name.len()).position(|found| found == name);
    // the type after the name, which is padded to 16 bytes: a field of bits, no text
    bytes[at.unwrap() + 16] = 0x14;
    let (_folder, path) = folder_with("damaged.h5");
    std::fs::write(&path, &bytes).unwrap();
    let whole = read_one(&path, &ReadOptions::default()).unwrap_err();
    let parts = FrfParts::open(std::slice::from_ref(&path), &ReadOptions::default());
    for error in [whole, parts.err().unwrap()] {
        assert_eq!(error.kind, ErrorKind::BadData);
        let text = error.to_string();
        assert!(
            text.contains("time_sign of /") && !text.contains("`time_sign`"),
            "{text}"
        );
    }
}

#[test]
fn single_precision_stays_single_and_missing_pairs_stay_missing() {
    let (_folder, path) = folder_with("single.h5");
    let mut set = set(2, 2, 4);
    let mut values = Array3::from_shape_fn((2, 2, 4), |(i, j, k)| {
        Complex32::new(0.1 + i as f32, j as f32 - k as f32)
    });
    values
        .slice_mut(ndarray::s![1, 0, ..])
        .fill(Complex32::new(f32::NAN, f32::NAN));
    values[[0, 1, 2]] = Complex32::new(f32::NAN, f32::NAN);
    set.values = FrfValues::F32(values);
    set.kind = None;
    write_frf(&path, &set, false).unwrap();
    let (back, warnings) = read_one(&path, &ReadOptions::default()).unwrap();
    assert_same(&back, &set);
    let text = warnings.join("\n");
    assert!(
        text.contains("(2:+Z, 101:-Z)") && text.contains("1 lines are NaN in the file: masked"),
        "{text}"
    );
}

#[test]
fn other_functions_and_geometry_travel_without_frfs() {
    let (_folder, path) = folder_with("time.h5");
    let function = |ordinate, abscissa| Function {
        function_type: 1,
        id_lines: ["Vib  Geschwindigkeit", "µ", "", "", "last"].map(String::from),
        ids: [1, -2, 3],
        entity_names: ["NONE".into(), "x".into()],
        response: "12:-Y".parse().unwrap(),
        reference: "0:S".parse().unwrap(),
        abscissa,
        z: 0.5,
        axes: std::array::from_fn(|k| Axis {
            quantity: k as i32,
            exponents: [1, -1, 0],
            label: "t".into(),
            unit: "s".into(),
        }),
        ordinate,
        kind: None,
        reference_unit: ReferenceUnit::Newton,
        scale_to_si: 1e-3,
        abscissa_to_si: 1.0,
        line: 0,
        warnings: Vec::new(),
    };
    let even = Abscissa::Even {
        start: 0.0,
        step: 1.0 / 3.0,
    };
    let functions = vec![
        function(Ordinate::Real32(vec![1.0, f32::MIN_POSITIVE]), even.clone()),
        function(
            Ordinate::Real64(vec![1e-300, -2.0, 3.0]),
            Abscissa::Uneven(vec![0.0, 0.1, 0.35]),
        ),
        function(
            Ordinate::Complex32(vec![Complex32::new(1.0, 2.0)]),
            even.clone(),
        ),
        function(Ordinate::Complex64(vec![Complex64::new(1.0, 2.0)]), even),
    ];
    let contents = Contents {
        functions: functions.clone(),
        other_geometry: set(1, 1, 1).geometry,
        ..Contents::default()
    };
    write_contents(&path, &contents, false).unwrap();
    let back = read_contents(std::slice::from_ref(&path), &ReadOptions::default()).unwrap();
    assert_eq!(back.functions, functions);
    assert_eq!(back.geometry(), contents.geometry());
    assert!(back.frf.is_none());
    let error = read_one(&path, &ReadOptions::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("4 other functions, the first a time"),
        "{error}"
    );
}

#[test]
fn the_user_overrules_kind_time_sign_and_reference() {
    let (_folder, path) = folder_with("set.h5");
    let mut set = set(2, 1, 3);
    set.geometry = Geometry::default();
    write_frf(&path, &set, false).unwrap();
    let options = ReadOptions {
        frf_kind: Some(FrfKind::Accelerance),
        time_sign: TimeSign::Minus,
        references: vec![7],
        ..ReadOptions::default()
    };
    let (back, warnings) = read_one(&path, &options).unwrap();
    assert_eq!(back.kind, Some(FrfKind::Accelerance));
    assert_eq!(back.references[0].to_string(), "7:-Z");
    assert_eq!(back.values.get(1, 0, 2), set.values.get(1, 0, 2).conj());
    let text = warnings.join("\n");
    assert!(
        text.contains("says mobility, you say accelerance") && text.contains("you say -"),
        "{text}"
    );
}

#[test]
fn pairs_of_zeros_are_missing_and_reported() {
    let (_folder, path) = folder_with("set.h5");
    let mut set = set(2, 1, 3);
    set.geometry = Geometry::default();
    if let FrfValues::F64(values) = &mut set.values {
        values
            .slice_mut(ndarray::s![0, 0, ..])
            .fill(Complex64::new(0.0, 0.0));
    }
    write_frf(&path, &set, false).unwrap();
    let (back, warnings) = read_one(&path, &ReadOptions::default()).unwrap();
    assert_eq!(back.missing_pairs(), [(0, 0)]);
    assert!(
        warnings[0].contains("exactly zero") && warnings[0].contains("(1:+Z, 101:-Z)"),
        "{warnings:?}"
    );
}

#[test]
fn sets_without_lines_or_with_a_dof_twice_are_refused_with_help() {
    let mut twice = set(2, 1, 3);
    twice.responses[1] = twice.responses[0];
    for (set, words) in [
        (twice, "correct it in the program"),
        (set(2, 1, 0), "found 0 lines"),
    ] {
        let (_folder, path) = folder_with("set.h5");
        write_frf(&path, &set, false).unwrap();
        let error = read_one(&path, &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn damaged_files_are_refused_and_never_panic() {
    let (folder, path) = folder_with("set.h5");
    write_frf(&path, &set(2, 2, 4), false).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let cut = folder.path().join("cut.h5");
    for length in (8..bytes.len()).step_by(97) {
        std::fs::write(&cut, &bytes[..length]).unwrap();
        if let Err(error) = read_one(&cut, &ReadOptions::default()) {
            assert_eq!(error.kind, ErrorKind::BadData, "{error}");
        }
    }
    if cfg!(feature = "system") {
        crate::skipped("the C library does not survive every damaged file");
        return;
    }
    for at in (8..bytes.len()).step_by(61) {
        let mut changed = bytes.clone();
        changed[at] ^= 0xff;
        std::fs::write(&cut, &changed).unwrap();
        let _ = read_document(&cut, &ReadOptions::default());
    }
}

#[test]
fn another_version_is_refused() {
    let (_folder, path) = folder_with("set.h5");
    write_frf(&path, &set(1, 1, 2), false).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    // the attribute `version` is the only place with this name followed by an 8-byte 1
    let name = bytes
        .windows(8)
        .position(|window| window == b"version\0")
        .unwrap();
    let one = bytes[name..]
        .windows(8)
        .position(|window| window == 1_u64.to_le_bytes())
        .unwrap();
    bytes[name + one] = 9;
    std::fs::write(&path, &bytes).unwrap();
    let error = read_one(&path, &ReadOptions::default()).unwrap_err();
    // the checksum of the header may speak first
    assert_eq!(error.kind, ErrorKind::BadData);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn any_set_survives_the_round_trip(
        responses in 1_usize..4, references in 1_usize..4, lines in 1_usize..6,
        seed in prop::collection::vec(-1e300_f64..1e300, 96), first in 0.0_f64..1e4, with_coherence: bool,
    ) {
        let (_folder, path) = folder_with("any.h5");
        let mut set = set(responses, references, lines);
        set.geometry = Geometry::default();
        set.frequency_hz = Array1::from_iter((0..lines).map(|k| first + k as f64 * 0.3));
        set.values = FrfValues::F64(Array3::from_shape_fn((responses, references, lines), |(i, j, k)| {
            let at = (i * references + j) * lines + k;
            Complex64::new(seed[at % 96], seed[(at + 48) % 96])
        }));
        if !with_coherence {
            set.coherence = None;
            set.variance = None;
        }
        write_frf(&path, &set, false).unwrap();
        let (back, _) = read_one(&path, &ReadOptions::default()).unwrap();
        assert_same(&back, &set);
    }
}

#[test]
fn large_arrays_are_read_window_by_window_and_whole() {
    let value =
        |(i, j, k): (usize, usize, usize)| Complex64::new(1.0 + i as f64, (j * 10_000 + k) as f64);
    let large = FrfSet {
        coherence: None,
        values: FrfValues::F64(Array3::from_shape_fn((23, 3, 9001), value)),
        ..set(23, 3, 9001)
    };
    let (_folder, path) = folder_with("large.h5");
    write_frf(&path, &large, false).unwrap();
    let (back, _) = read_one(&path, &ReadOptions::default()).unwrap();
    assert_same(&back, &large);
}
