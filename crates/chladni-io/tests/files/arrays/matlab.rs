//! MATLAB files: every class, order and packing.

use super::mat::Mat;
use super::sets::{set, value};
use chladni_frf::{FrfKind, FrfValues, ReferenceUnit};
use chladni_io::{assemble, read_document, read_frf, write_frf, Contents, Document, ReadOptions};
use ndarray::Array3;
use num_complex::{Complex32, Complex64};
use std::f64::consts::TAU;
use std::path::Path;

const LINES: usize = 4;

fn read(bytes: &[u8], name: &str, map: &[(&str, &str)]) -> (Document, Contents) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let map = map
        .iter()
        .map(|(key, path)| (key.to_string(), path.to_string()))
        .collect();
    let options = ReadOptions {
        map,
        ..ReadOptions::default()
    };
    let document = read_document(&path, &options).unwrap();
    assert_eq!(document.errors, []);
    (
        document.clone(),
        assemble(vec![document], &options).unwrap(),
    )
}

#[test]
fn matlab_arrays_are_read_in_every_order_and_packing() {
    for (big, packed, single) in [
        (false, false, false),
        (true, false, false),
        (false, true, false),
        (true, true, true),
        (false, false, true),
    ] {
        let mut file = Mat::new(big);
        // (response, reference, line) as MATLAB stores it: the first index runs fastest
        let order: Vec<(usize, usize, usize)> = (0..LINES)
            .flat_map(|k| (0..2).flat_map(move |j| (0..3).map(move |i| (i, j, k))))
            .collect();
        let all = || order.iter().map(|&(i, j, k)| value(i, j, k));
        let (class, kind, parts) = match single {
            true => (
                7,
                7,
                vec![
                    file.singles(all().map(|v| v.re as f32)),
                    file.singles(all().map(|v| v.im as f32)),
                ],
            ),
            false => (
                6,
                9,
                vec![
                    file.doubles(all().map(|v| v.re)),
                    file.doubles(all().map(|v| v.im)),
                ],
            ),
        };
        let frf = file.array("H", &[3, 2, LINES as u32], class, kind, &parts);
        // MATLAB stores whole numbers in as few bytes as they need
        let freq = file.array(
            "freq",
            &[1, LINES as u32],
            6,
            2,
            &[(1..=LINES as u8).collect()],
        );
        let unit = file.array("unit", &[1, 6], 4, 16, &[b"mm/s/V".to_vec()]);
        // a matrix of characters: a row for each text, column by column, filled with blanks
        let rows = ["4:+Z ", "17:-X", "2:+Y "];
        let columns = (0..5).flat_map(|k| rows.map(|row| row.as_bytes()[k]));
        let response = file.array("response", &[3, 5], 4, 16, &[columns.collect()]);
        for element in [&frf, &freq, &unit, &response] {
            file.push(element, packed);
        }
        let (document, contents) = read(&file.bytes, "a.mat", &[]);
        assert_eq!(document.datasets.len(), 4);
        let set = contents.frf.unwrap();
        let named: Vec<String> = set.responses.iter().map(|dof| dof.to_string()).collect();
        assert_eq!(named, rows.map(str::trim_end));
        assert_eq!(
            (set.values.dim(), set.kind, set.reference_unit),
            ((3, 2, LINES), Some(FrfKind::Mobility), ReferenceUnit::Volt)
        );
        assert_eq!(matches!(set.values, FrfValues::F32(_)), single);
        assert_eq!(set.frequency_hz.to_vec(), [1.0, 2.0, 3.0, 4.0]);
        for &(i, j, k) in &order {
            let (found, truth) = (set.values.get(i, j, k), 1e-3 * value(i, j, k));
            assert!(
                (found - truth).norm() <= if single { 1e-7 } else { 1e-15 } * truth.norm(),
                "{i} {j} {k}"
            );
        }
    }
}

#[test]
fn structs_and_cells_are_paths() {
    let mut file = Mat::new(false);
    let field = |file: &Mat, content: Vec<u8>, class: u32| {
        let head = [
            file.element(6, &[file.word(class), file.word(0)].concat()),
            file.element(5, &[file.word(1), file.word(1)].concat()),
            file.element(1, b"measured"),
        ];
        file.element(14, &[head.concat(), content].concat())
    };
    let axis = file.array(
        "",
        &[LINES as u32, 1],
        6,
        9,
        &[file.doubles((0..LINES).map(|k| 10.0 + k as f64))],
    );
    let frf = file.array(
        "",
        &[LINES as u32, 1],
        6,
        9,
        &[
            file.doubles((0..LINES).map(|k| k as f64)),
            file.doubles([0.5; LINES]),
        ],
    );
    let names = [
        file.element(5, &file.word(8)),
        file.element(1, b"f\0\0\0\0\0\0\0H\0\0\0\0\0\0\0"),
    ]
    .concat();
    let whole = field(&file, [names, axis.clone(), frf.clone()].concat(), 2);
    file.push(&whole, false);
    let (document, contents) = read(&file.bytes, "struct.mat", &[]);
    let listed: Vec<&str> = document
        .datasets
        .iter()
        .map(|info| info.name.as_str())
        .collect();
    assert_eq!(listed, ["/measured/H", "/measured/f"]);
    assert_eq!(
        contents.frf.unwrap().values.get(0, 0, 3),
        Complex64::new(3.0, 0.5)
    );

    let mut file = Mat::new(false);
    let whole = field(&file, [axis, frf].concat(), 1);
    file.push(&whole, true);
    let (_, contents) = read(
        &file.bytes,
        "cell.mat",
        &[("freq", "/measured/1"), ("frf", "/measured/2")],
    );
    assert_eq!(
        contents.frf.unwrap().frequency_hz.to_vec(),
        [10.0, 11.0, 12.0, 13.0]
    );
}

#[test]
fn a_unit_in_a_struct_and_one_of_joined_frequencies_are_used() {
    let mut file = Mat::new(false);
    let text = |file: &Mat, name: &str, text: &str| {
        let characters = [text.as_bytes().to_vec()];
        file.array(name, &[1, text.len() as u32], 4, 16, &characters)
    };
    // [w, H], column by column
    let re = [TAU, 2.0 * TAU, 3.0 * TAU, 5.0, 6.0, 7.0];
    let parts = [
        file.doubles(re),
        file.doubles([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]),
    ];
    let parts = [
        file.element(6, &[file.word(2), file.word(0)].concat()),
        file.element(5, &[file.word(1), file.word(1)].concat()),
        file.element(1, b"data"),
        file.element(5, &file.word(8)),
        file.element(1, b"H\0\0\0\0\0\0\0unit\0\0\0\0"),
        file.array("", &[3, 2], 6, 9, &parts),
        text(&file, "", "mm/s/N"),
    ];
    let whole = file.element(14, &parts.concat());
    file.push(&whole, false);
    let unit = text(&file, "frequency_unit", "rad/s");
    file.push(&unit, false);
    let (_, contents) = read(&file.bytes, "joined.mat", &[]);
    let set = contents.frf.unwrap();
    assert_eq!(set.kind, Some(FrfKind::Mobility));
    assert!((set.values.get(0, 0, 2) - 1e-3 * Complex64::new(7.0, 1.0)).norm() < 1e-15);
    assert!((set.frequency_hz[2] - 3.0).abs() < 1e-12);
    assert_eq!(contents.not_carried, [""; 0]);
}

#[test]
fn a_published_measurement_is_read() {
    let folder = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/vtb-case1"
    ));
    let Ok(bytes) = std::fs::read(folder.join("case1.mat")) else {
        crate::skipped("case1.mat is not beside this workspace");
        return;
    };
    let (_, contents) = read(
        &bytes,
        "case1.mat",
        &[("frf", "Hf_chan_2"), ("freq", "Freq_domain")],
    );
    let set = contents.frf.unwrap();
    assert_eq!(set.values.dim(), (1, 1, 1601));
    // the same numbers as a table, made by another program
    let table = std::fs::read_to_string(folder.join("case1_frf.csv")).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .filter_map(|row| {
            row.split(',')
                .map(|cell| cell.trim().parse().ok())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 1601);
    for (k, row) in rows.iter().enumerate() {
        assert!((set.frequency_hz[k] - row[0]).abs() <= 1e-6 * row[0]);
        let value = set.values.get(0, 0, k);
        assert!(
            (value.re - row[1]).abs() <= 1e-6 * value.norm()
                && (value.im - row[2]).abs() <= 1e-6 * value.norm(),
            "line {k}"
        );
    }
}

#[test]
fn matlab_files_are_written_as_they_are_read() {
    for shape in [(3, 2, 5), (3, 1, 1), (1, 1, 4), (2, 2, 2)] {
        let values = Array3::from_shape_fn(shape, |(i, j, k)| value(i, j, k) + 1.0);
        for values in [
            FrfValues::F32(values.mapv(|v| Complex32::new(v.re as f32, v.im as f32))),
            FrfValues::F64(values),
        ] {
            let set = set(values);
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("set.mat");
            write_frf(&path, &set, false).unwrap();
            let (back, ..) = read_frf(&[path], &ReadOptions::default()).unwrap();
            assert_eq!(back, set, "{shape:?}");
        }
    }
}
