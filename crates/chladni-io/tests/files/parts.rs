//! Files that are read part by part give what they give when they are read together.

use crate::uff::{binary_58, identifier, le64, HEADER_151, ID_LINES, MOBILITY_AXES, SI_164};
use chladni_frf::{Error, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_io::{read_frf, write_frf, Duplicates, FrfParts, ReadOptions};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use std::path::{Path, PathBuf};

/// Function types.
const TIME: i32 = 1;
const FRF: i32 = 4;
const COHERENCE: i32 = 6;

/// A text 58 of two values, the first of which is `value`.
fn function(kind: i32, response: u64, reference: u64, value: f64) -> String {
    let (ordinate, values) = match kind {
        FRF => (6, vec![value, -1.0, 1.0, 2.0]),
        _ => (4, vec![value, 0.5]),
    };
    let record_6 = format!(
        "{kind:5}{0:10}{0:5}{0:10} {1:10}{response:10}{2:4} {1:10}{reference:10}{2:4}",
        0, "NONE", 3
    );
    let record_7 =
        format!("{ordinate:10}         2         1  1.00000E+00  5.00000E-01  0.00000E+00");
    let numbers: String = values
        .iter()
        .map(|value| format!("{value:20.12E}"))
        .collect();
    let numbers = numbers.replace("E0", "E+00").replace("E-1", "E-01");
    format!("    -1\n    58\n{ID_LINES}{record_6}\n{record_7}\n{MOBILITY_AXES}{numbers}\n    -1\n")
}

/// Files with these texts, in a folder of their own.
fn files(texts: &[(&str, String)]) -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let paths = texts.iter().map(|(name, text)| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    });
    let paths = paths.collect();
    (folder, paths)
}

fn universal(functions: &[String]) -> String {
    [HEADER_151, SI_164].concat() + &functions.concat()
}

/// The measured pairs with values, coherence and variance, as text: NaN are equal there.
fn listed(sets: &[FrfSet]) -> Vec<String> {
    let of_set = |set: &FrfSet| {
        let missing = set.missing_pairs();
        let line = |(i, j): (usize, usize)| {
            let values: Vec<Complex64> = (0..set.frequency_hz.len())
                .map(|k| set.values.get(i, j, k))
                .collect();
            let row = ndarray::s![i, j, ..];
            let coherence = set.coherence.as_ref().map(|all| all.slice(row).to_vec());
            let coherence = coherence.filter(|row| row.iter().any(|value| !value.is_nan()));
            let variance = set.variance.as_ref().map(|all| all.slice(row).to_vec());
            let (response, reference) = (set.responses[i], set.references[j]);
            format!("{response} {reference} {values:?} {coherence:?} {variance:?}")
        };
        let measured = set.all_pairs().filter(|pair| !missing.contains(pair));
        measured.map(line).collect::<Vec<_>>()
    };
    let mut lines: Vec<String> = sets.iter().flat_map(of_set).collect();
    lines.sort();
    lines
}

/// The sets of all parts, as small as they can be.
fn in_parts(paths: &[PathBuf], options: &ReadOptions) -> Result<Vec<FrfSet>, Error> {
    let data = FrfParts::open(paths, options)?;
    let is_table = |path: &PathBuf| path.extension().is_some_and(|end| end == "csv");
    let most = if paths.iter().any(is_table) {
        10_000
    } else {
        1
    };
    let mut sets = Vec::new();
    for part in data.parts(most)? {
        sets.extend(data.read(&part, None, None)?.0);
    }
    Ok(sets)
}

/// Asserts that files give the same FRFs, or the same error, in parts as together. Returns the
/// number of parts, or the error in words.
fn assert_same(paths: &[PathBuf], options: &ReadOptions) -> Result<usize, String> {
    let together = read_frf(paths, options).map(|(set, ..)| listed(&[set]));
    let parts = in_parts(paths, options);
    let words = |error: &Error| error.to_string();
    assert_eq!(
        parts.as_ref().map(|sets| listed(sets)).map_err(words),
        together.as_ref().cloned().map_err(words)
    );
    parts.map(|sets| sets.len()).map_err(|error| words(&error))
}

#[test]
fn nodes_of_the_caller_must_fit_the_files_and_are_those_of_each_file() {
    let texts = [1, 2, 3].map(|k| {
        let functions = [function(FRF, 5, 1, k.into()), function(FRF, 6, 1, 0.5)];
        universal(&functions)
    });
    let [a, b, c] = texts;
    let (_folder, paths) = files(&[("a.uff", a), ("b.uff", b), ("c.uff", c)]);
    let with = |references: &[u64]| ReadOptions {
        references: references.to_vec(),
        ..ReadOptions::default()
    };
    assert_eq!(assert_same(&paths, &with(&[101, 102, 103])), Ok(6));
    for wrong in [[101, 102].as_slice(), &[101, 102, 103, 104]] {
        let error = assert_same(&paths, &with(wrong)).unwrap_err();
        assert!(error.contains("does not fit the count of files"), "{error}");
    }
    // one node cannot stand for the two responses of a file, though a part has one of them
    let responses = ReadOptions {
        responses: vec![7],
        ..with(&[101, 102, 103])
    };
    let error = assert_same(&paths, &responses).unwrap_err();
    assert!(error.contains("more than one response"), "{error}");
}

#[test]
fn responses_of_the_caller_are_those_of_each_file() {
    let text = |value| universal(&[function(FRF, 1, 101, value), function(FRF, 1, 102, value)]);
    let (_folder, paths) = files(&[("a.uff", text(1.0)), ("b.uff", text(2.0))]);
    let options = ReadOptions {
        responses: vec![11, 12],
        ..ReadOptions::default()
    };
    assert_eq!(assert_same(&paths, &options), Ok(4));
    let of_first_file = ReadOptions {
        responses: vec![11],
        ..ReadOptions::default()
    };
    assert_eq!(assert_same(&paths[..1], &of_first_file), Ok(2));
}

#[test]
fn one_node_cannot_stand_for_the_references_of_a_file_of_our_layout() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.h5");
    write_frf(&path, &with_coherence(), false).unwrap();
    let options = ReadOptions {
        responses: vec![7],
        ..ReadOptions::default()
    };
    let error = assert_same(&[path], &options).unwrap_err();
    assert!(error.contains("more than one response"), "{error}");
}

#[test]
fn coherence_is_read_with_its_frf_and_other_functions_are_left_out() {
    let frfs: Vec<String> = (1..=4).map(|k| function(FRF, k, 101, k as f64)).collect();
    let coherence: Vec<String> = (1..=4)
        .map(|k| function(COHERENCE, k, 101, 0.1 * k as f64))
        .collect();
    let records: Vec<String> = (1..=9).map(|k| function(TIME, k, 0, 1.0)).collect();
    let last = universal(&[frfs.clone(), coherence.clone(), records.clone()].concat());
    let first = universal(&[records.clone(), coherence.clone(), frfs.clone()].concat());
    let (_folder, paths) = files(&[("last.uff", last), ("first.uff", first)]);
    for path in &paths {
        let one = std::slice::from_ref(path);
        assert_eq!(assert_same(one, &ReadOptions::default()), Ok(4));
        let sets = in_parts(one, &ReadOptions::default()).unwrap();
        assert!(sets.iter().all(|set| set.coherence.is_some()));
    }
    // coherence in a file of its own is not silently lost
    let (_folder, apart) = files(&[
        ("frf.uff", universal(&frfs)),
        ("coherence.uff", universal(&coherence)),
    ]);
    let data = FrfParts::open(&apart, &ReadOptions::default()).unwrap();
    assert_eq!(data.parts(1).unwrap().len(), 4);
    let [finding] = data.findings() else {
        panic!("{:?}", data.findings());
    };
    assert_eq!(finding.code, "coherence-unmatched");
    assert!(
        finding.text.contains("4 coherence functions") && finding.text.contains("coherence.uff"),
        "{finding}"
    );
    // no FRF at all
    let (_folder, none) = files(&[("time.uff", universal(&records))]);
    let error = in_parts(&none, &ReadOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("no FRF in the input") && text.contains("9 other functions"),
        "{text}"
    );
    // a file that is not cut: no FRF in its part
    let (_folder, whole) = files(&[("two.uff", universal(&records) + SI_164)]);
    let data = FrfParts::open(&whole, &ReadOptions::default()).unwrap();
    let parts = data.parts(10_000).unwrap();
    assert_eq!(parts.len(), 1);
    assert!(data.read(&parts[0], None, None).unwrap().0.is_none());
}

#[test]
fn nodes_of_a_file_without_frfs_are_placed_in_every_part() {
    let mesh = "    -1\n  2411\n         7         0         0        11\n   \
                2.5000000000000000E-01   0.0000000000000000E+00   0.0000000000000000E+00\n    -1\n";
    let mesh = [HEADER_151, SI_164, mesh].concat();
    let frfs = [6, 7].map(|k| function(FRF, k, 101, 1.0));
    let (_folder, paths) = files(&[("mesh.unv", mesh), ("frf.uff", universal(&frfs))]);
    let placed = |set: &FrfSet| -> Vec<u64> {
        let nodes = set.geometry.nodes.iter();
        nodes.map(|node| node.label).collect()
    };
    let options = ReadOptions {
        references: vec![101, 102],
        ..ReadOptions::default()
    };
    let sets = in_parts(&paths, &options).unwrap();
    let labels: Vec<Vec<u64>> = sets.iter().map(placed).collect();
    assert_eq!(labels, [vec![], vec![7]]);
}

#[test]
fn damaged_functions_are_told_or_left_out_as_when_all_are_read() {
    let lenient = ReadOptions {
        lenient: true,
        ..ReadOptions::default()
    };
    let sound = [1, 2, 3].map(|k| function(FRF, k, 101, k as f64));
    let damages: [fn(String) -> String; 3] = [
        // the header; values at the end; the rest of the file
        |text| text.replace("         6         2", "         6       two"),
        |text| text.replace("  2.000000000000E+00\n", "\n"),
        |text| text[..text.len() - 30].to_owned(),
    ];
    for damage in damages {
        let damaged = damage(function(FRF, 4, 101, 4.0));
        let (_folder, paths) = files(&[("a.uff", universal(&sound) + &damaged)]);
        let error = assert_same(&paths, &ReadOptions::default()).unwrap_err();
        assert!(error.contains("line "), "{error}");
        assert_eq!(assert_same(&paths, &lenient), Ok(3));
    }
}

#[test]
fn the_byte_of_a_damaged_binary_function_is_that_of_the_file() {
    let record_7 = "         6         2         1  1.00000E+00  5.00000E-01  0.00000E+00";
    let payload = le64(&[1.0, 2.0, 3.0, 4.0]);
    let sound = binary_58(&identifier(1, 32), record_7, &payload, "    -1\n");
    let damaged = binary_58(&identifier(1, 4000), record_7, &payload[..17], "    -1\n");
    let without_units = |bytes: &[u8]| bytes[SI_164.len()..].to_vec();
    let time = function(TIME, 9, 0, 1.0).into_bytes();
    let bytes = [sound, time.repeat(40), without_units(&damaged)].concat();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.uff");
    std::fs::write(&path, bytes).unwrap();
    let byte = |error: Error| error.byte.unwrap();
    let together = read_frf(std::slice::from_ref(&path), &ReadOptions::default());
    let parts = in_parts(&[path], &ReadOptions::default());
    assert_eq!(byte(parts.unwrap_err()), byte(together.unwrap_err()));
}

#[test]
fn copies_of_an_frf_in_one_file_are_treated_as_the_caller_says() {
    let functions = [
        function(FRF, 1, 101, 1.0),
        function(FRF, 2, 101, 2.0),
        function(FRF, 3, 101, 3.0),
        function(FRF, 1, 101, 5.0),
    ];
    let (_folder, paths) = files(&[("a.uff", universal(&functions))]);
    for duplicates in [Duplicates::First, Duplicates::Last, Duplicates::Mean] {
        let options = ReadOptions {
            duplicates,
            ..ReadOptions::default()
        };
        assert_eq!(assert_same(&paths, &options), Ok(3));
    }
    let error = assert_same(&paths, &ReadOptions::default()).unwrap_err();
    assert!(error.contains("(1:+Z, 101:+Z) is there 2 times"), "{error}");
}

#[test]
fn tables_without_dofs_are_numbered_from_one_to_the_next() {
    let table = |value: i32| format!("# unit = m/s/N\nf,re,im\n10,{value},2\n20,3,4\n");
    let two = "# unit = m/s/N\nf,H1 re,H1 im,H2 re,H2 im\n10,1,2,3,4\n20,3,4,5,6\n".to_owned();
    let named = "# unit = m/s/N\nf,50:+Z:1:S re,50:+Z:1:S im\n10,1,2\n20,3,4\n".to_owned();
    let (_folder, paths) = files(&[
        ("a.csv", table(1)),
        ("b.csv", named),
        ("c.csv", two),
        ("d.csv", table(2)),
    ]);
    assert_eq!(assert_same(&paths, &ReadOptions::default()), Ok(4));
    // the last of two shares counts the tables of the other
    let data = FrfParts::open(&paths, &ReadOptions::default()).unwrap();
    let last = data.share(1, 2).unwrap();
    let parts = last.parts(10_000).unwrap();
    let (set, _) = last.read(&parts[1], None, None).unwrap();
    assert_eq!(set.unwrap().responses[0].to_string(), "4:+Z");
}

/// A set of three responses and one reference with coherence.
fn with_coherence() -> FrfSet {
    let dim = (3, 1, 4);
    FrfSet {
        frequency_hz: Array1::from_iter((1..=4).map(f64::from)),
        values: FrfValues::F64(Array3::from_shape_fn(dim, |(i, _, k)| {
            Complex64::new(i as f64, 1.0 + k as f64)
        })),
        responses: ["1:+Z", "2:+Z", "3:+Z"]
            .map(|dof| dof.parse().unwrap())
            .into(),
        references: vec!["101:+Z".parse().unwrap()],
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: Some(Array3::from_shape_fn(dim, |(i, _, k)| {
            0.125 * (i + k) as f32
        })),
        variance: None,
        estimation: None,
        geometry: Geometry::default(),
    }
}

#[test]
fn coherence_and_variance_of_our_layout_are_read_with_the_rows() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, set: &FrfSet| {
        let path = folder.path().join(name);
        write_frf(&path, set, false).unwrap();
        path
    };
    let coherent = with_coherence();
    let varied = FrfSet {
        variance: Some(Array3::from_shape_fn((3, 1, 4), |(i, _, k)| {
            1.0 + (i * 4 + k) as f64
        })),
        ..coherent.clone()
    };
    for (name, set) in [("coherence.h5", coherent), ("variance.h5", varied)] {
        let path = write(name, &set);
        let read: &Path = &path;
        assert_eq!(assert_same(&[read.into()], &ReadOptions::default()), Ok(3));
    }
}
