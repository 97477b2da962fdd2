//! HDF5 files of others: MATLAB's complex numbers and axis order, home-made layouts,
//! `--map`, ambiguity.
use chladni_frf::{ErrorKind, FrfKind, FrfSet, ReferenceUnit};
use chladni_io::{read_contents, read_document, read_frf, ReadOptions};
use hdf5_pure::{AttrValue, CompoundTypeBuilder, FileBuilder};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::path::PathBuf;

const LINES: u64 = 5;

fn value(i: u64, j: u64, k: u64) -> (f64, f64) {
    (1.0 + i as f64 + 10.0 * j as f64, -0.5 - k as f64)
}

fn frequencies() -> Vec<f64> {
    (0..LINES).map(|k| 10.0 + 2.5 * k as f64).collect()
}

/// Values of 3 responses and 2 references, in the order in which the indices are nested.
fn nested(order: [char; 3]) -> Vec<(f64, f64)> {
    let extent = |axis| match axis {
        'i' => 3,
        'j' => 2,
        _ => LINES,
    };
    let mut values = Vec::new();
    for a in 0..extent(order[0]) {
        for b in 0..extent(order[1]) {
            for c in 0..extent(order[2]) {
                let at = |axis| [a, b, c][order.iter().position(|&found| found == axis).unwrap()];
                values.push(value(at('i'), at('j'), at('k')));
            }
        }
    }
    values
}

/// h5py's compound {r, i}.
fn r_i(builder: &mut hdf5_pure::DatasetBuilder, values: &[(f64, f64)], shape: &[u64]) {
    let datatype = CompoundTypeBuilder::new()
        .f64_field("r")
        .f64_field("i")
        .build()
        .unwrap();
    let bytes = values
        .iter()
        .flat_map(|(re, im)| [re.to_le_bytes(), im.to_le_bytes()])
        .flatten()
        .collect();
    builder
        .with_compound_data(datatype, bytes, values.len() as u64)
        .with_shape(shape);
}

fn saved(builder: FileBuilder) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("foreign.h5");
    builder.write(&path).unwrap();
    (folder, path)
}

fn read(builder: FileBuilder, map: &[(&str, &str)]) -> chladni_frf::Result<(FrfSet, Vec<String>)> {
    let (_folder, path) = saved(builder);
    let map = map
        .iter()
        .map(|&(key, path)| (key.to_owned(), path.to_owned()))
        .collect();
    read_frf(
        &[path],
        &ReadOptions {
            map,
            ..ReadOptions::default()
        },
    )
    .map(|(set, _, warnings)| (set, crate::words(&warnings)))
}

#[track_caller]
fn assert_values(set: &FrfSet) {
    assert_eq!(set.values.dim(), (3, 2, LINES as usize));
    for (i, j, k) in [(0, 0, 0), (2, 0, 1), (1, 1, 4)] {
        let (re, im) = value(i, j, k);
        assert_eq!(
            set.values.get(i as usize, j as usize, k as usize),
            Complex64::new(re, im),
            "{i} {j} {k}"
        );
    }
    assert_eq!(set.frequency_hz.to_vec(), frequencies());
}

#[test]
fn matlab_writes_real_and_imag_and_reverses_the_axes() {
    let mut file = FileBuilder::new();
    file.with_userblock(512);
    // MATLAB's (lines, outputs, inputs) stands in the file as (inputs, outputs, lines),
    // and is called as MATLAB does
    let class = || AttrValue::AsciiString("double".into());
    file.create_dataset("frf")
        .with_complex64_data(&nested(['j', 'i', 'k']))
        .with_shape(&[2, 3, LINES])
        .set_attr("MATLAB_class", class());
    file.create_dataset("f")
        .with_f64_data(&frequencies())
        .with_shape(&[1, LINES])
        .set_attr("MATLAB_class", class());
    let (set, warnings) = read(file, &[]).unwrap();
    assert_values(&set);
    assert_eq!(set.kind, None);
    let text = warnings.join("\n");
    for words in [
        "took /frf (5 x 3 x 2) as the FRFs",
        "taken as SI",
        "numbered 1:+Z ... 3:+Z",
        "numbered 1:S ... 2:S",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn units_names_and_kind_beside_the_array_are_used() {
    let mut file = FileBuilder::new();
    let mut group = file.create_group("data");
    let values = nested(['i', 'j', 'k']);
    let dataset = group.create_dataset("H");
    r_i(dataset, &values, &[3, 2, LINES]);
    dataset.set_attr("unit", AttrValue::String("mm/s/V".into()));
    let khz: Vec<f64> = frequencies().iter().map(|f| f / 1000.0).collect();
    group
        .create_dataset("Freq")
        .with_f64_data(&khz)
        .set_attr("unit", AttrValue::String("kHz".into()));
    group
        .create_dataset("response")
        .with_vlen_strings(&["7:+Z", "8:-X", "9Y"]);
    group.create_dataset("reference").with_i32_data(&[101, 102]);
    let group = group.finish();
    file.add_group(group);
    let (set, warnings) = read(file, &[]).unwrap();
    assert_eq!(
        (set.kind, set.reference_unit),
        (Some(FrfKind::Mobility), ReferenceUnit::Volt)
    );
    assert!((set.values.get(2, 1, 3).re - 1e-3 * value(2, 1, 3).0).abs() < 1e-15);
    assert!((set.frequency_hz[1] - 12.5).abs() < 1e-12);
    assert_eq!(
        set.responses
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>(),
        ["7:+Z", "8:-X", "9:+Y"]
    );
    assert_eq!(set.references[1].to_string(), "102:S");
    assert!(
        warnings
            .join("\n")
            .contains("node numbers without a direction"),
        "{warnings:?}"
    );
}

#[test]
fn units_of_the_root_and_of_groups_hold_for_the_arrays_in_them() {
    let text = |text: &str| AttrValue::String(text.into());
    let file = |set: &dyn Fn(&mut FileBuilder, &mut hdf5_pure::GroupBuilder)| {
        let mut file = FileBuilder::new();
        let mut group = file.create_group("data");
        r_i(
            group.create_dataset("H"),
            &nested(['j', 'i', 'k']),
            &[2, 3, LINES],
        );
        let turned: Vec<f64> = frequencies().iter().map(|f| f * TAU).collect();
        group
            .create_dataset("freq")
            .with_f64_data(&turned)
            .set_attr("Units", text("rad/s"));
        group
            .create_dataset("response")
            .with_f64_data(&[7.0, 8.0, 9.0]);
        set(&mut file, &mut group);
        let group = group.finish();
        file.add_group(group);
        file
    };
    for at_root in [true, false] {
        let (set, warnings) = read(
            file(&|file, group| {
                if at_root {
                    file.set_attr("unit", text("mm/s/N"));
                } else {
                    group.set_attr("Unit", text("mm/s/N"));
                }
            }),
            &[],
        )
        .unwrap();
        assert_eq!(set.kind, Some(FrfKind::Mobility));
        assert!((set.values.get(2, 1, 3).re - 1e-3 * value(2, 1, 3).0).abs() < 1e-15);
        assert!((set.frequency_hz[1] - 12.5).abs() < 1e-12);
        assert_eq!(set.responses[2].to_string(), "9:+Z");
        assert!(!warnings.join("\n").contains("taken as SI"), "{warnings:?}");
    }
    let contradicted = file(&|file, _| {
        file.set_attr("unit", text("mm/N"));
        file.set_attr("frf_kind", text("mobility"));
    });
    let error = read(contradicted, &[]).unwrap_err().to_string();
    assert!(error.contains("mobility with unit mm/N"), "{error}");
}

#[test]
fn labels_of_dimensions_tell_the_axes() {
    let file = |labels: &[&str]| {
        let mut file = FileBuilder::new();
        let dataset = file.create_dataset("H");
        r_i(dataset, &nested(['j', 'i', 'k']), &[2, 3, LINES]);
        let labels = labels.iter().map(|label| (*label).to_owned()).collect();
        dataset.set_attr("DIMENSION_LABELS", AttrValue::VarLenStringArray(labels));
        file.create_dataset("freq").with_f64_data(&frequencies());
        file
    };
    for labels in [["reference", "response", "line"], ["input", "", ""]] {
        let (set, warnings) = read(file(&labels), &[]).unwrap();
        assert_values(&set);
        assert!(
            !warnings.join("\n").contains("in the order"),
            "{warnings:?}"
        );
    }
    let error = read(file(&["line", "response", "reference"]), &[]).unwrap_err();
    assert!(
        error.to_string().contains("DIMENSION_LABELS of /H"),
        "{error}"
    );
    // names of somebody's own say nothing
    let (set, _) = read(file(&["a", "b", "c"]), &[]).unwrap();
    assert_eq!(set.values.dim(), (2, 3, LINES as usize));
}

#[test]
fn characters_of_matlab_are_texts() {
    let mut file = FileBuilder::new();
    let class = |class: &str| AttrValue::AsciiString(class.into());
    let mut characters = |name: &str, rows: &[&str]| {
        // column by column, as all arrays of MATLAB
        let width = rows[0].len();
        let codes: Vec<u16> = (0..width)
            .flat_map(|k| rows.iter().map(move |row| row.as_bytes()[k].into()))
            .collect();
        file.create_dataset(name)
            .with_u16_data(&codes)
            .with_shape(&[width as u64, rows.len() as u64])
            .set_attr("MATLAB_class", class("char"));
    };
    characters("unit", &["mm/s/V"]);
    characters("response", &["7:+Z ", "18:-X", "9:+Y "]);
    file.create_dataset("frf")
        .with_complex64_data(&nested(['j', 'i', 'k']))
        .with_shape(&[2, 3, LINES])
        .set_attr("MATLAB_class", class("double"));
    file.create_dataset("f")
        .with_f64_data(&frequencies())
        .with_shape(&[1, LINES])
        .set_attr("MATLAB_class", class("double"));
    let (set, _) = read(file, &[]).unwrap();
    assert_eq!(
        (set.kind, set.reference_unit),
        (Some(FrfKind::Mobility), ReferenceUnit::Volt)
    );
    assert_eq!(set.values.dim(), (3, 2, LINES as usize));
    assert_eq!(set.responses[1].to_string(), "18:-X");
}

#[test]
fn two_real_arrays_make_one_complex() {
    for (names, polar) in [(["re", "im"], false), (["Mag", "Phase"], true)] {
        let mut file = FileBuilder::new();
        let values = nested(['i', 'j', 'k']);
        let part = |second: bool| -> Vec<f64> {
            let of = |&(re, im): &(f64, f64)| match (polar, second) {
                (false, false) => re,
                (false, true) => im,
                (true, false) => re.hypot(im),
                (true, true) => im.atan2(re).to_degrees(),
            };
            values.iter().map(of).collect()
        };
        file.create_dataset(names[0])
            .with_f64_data(&part(false))
            .with_shape(&[3, 2, LINES]);
        file.create_dataset(names[1])
            .with_f64_data(&part(true))
            .with_shape(&[3, 2, LINES]);
        file.create_dataset("x").with_f64_data(&frequencies());
        let (set, _) = read(file, &[]).unwrap();
        let (re, im) = value(2, 1, 3);
        assert!((set.values.get(2, 1, 3) - Complex64::new(re, im)).norm() < 1e-12);
    }
}

fn two_candidates() -> FileBuilder {
    let mut file = FileBuilder::new();
    r_i(
        file.create_dataset("H1"),
        &nested(['k', 'i', 'j']),
        &[LINES, 3, 2],
    );
    r_i(
        file.create_dataset("H2"),
        &nested(['i', 'j', 'k']),
        &[3, 2, LINES],
    );
    file.create_dataset("freq").with_f64_data(&frequencies());
    file
}

#[test]
fn ambiguity_lists_the_candidates_and_a_map_decides() {
    let (_folder, path) = saved(two_candidates());
    let document = read_document(&path, &ReadOptions::default()).unwrap();
    assert_eq!(document.datasets.len(), 3, "info lists them all the same");
    let text = document.errors[0].to_string();
    for words in [
        "/H1 (5 x 3 x 2)",
        "/H2 (3 x 2 x 5)",
        "/freq (5)",
        "`map frf=PATH,freq=PATH`",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let (set, warnings) = read(two_candidates(), &[("frf", "H1"), ("freq", "/freq")]).unwrap();
    assert_values(&set);
    assert!(
        warnings
            .join("\n")
            .contains("in the order response, reference"),
        "{warnings:?}"
    );
    assert_values(&read(two_candidates(), &[("frf", "/H2")]).unwrap().0);
    for (map, kind, words) in [
        (
            &[("frf", "H9")][..],
            ErrorKind::BadData,
            "the file has /H1, /H2, /freq",
        ),
        (&[("array", "H1")], ErrorKind::Usage, "found array"),
        (&[("re", "H1")], ErrorKind::Usage, "re and im"),
        (
            &[("frf", "H2"), ("axes", "response-line")],
            ErrorKind::Usage,
            "response-line for shape [3, 2, 5]",
        ),
        (&[("frf", "freq")], ErrorKind::BadData, "complex numbers"),
    ] {
        let error = read(two_candidates(), map).unwrap_err();
        assert_eq!(error.kind, kind, "{error}");
        assert!(error.to_string().contains(words), "{words}: {error}");
    }
}

#[test]
fn axes_of_equal_length_need_names() {
    let square = || {
        let mut file = FileBuilder::new();
        let values: Vec<(f64, f64)> = (0..4).map(|n| (n as f64, 1.0)).collect();
        r_i(file.create_dataset("H"), &values, &[2, 2]);
        file.create_dataset("f").with_f64_data(&[1.0, 2.0]);
        file
    };
    let text = read(square(), &[]).unwrap_err().to_string();
    assert!(
        text.contains("2 axes are as long as the frequency axis (2)")
            && text.contains("axes=response-reference-line"),
        "{text}"
    );
    let first = |axes| {
        read(square(), &[("frf", "H"), ("freq", "f"), ("axes", axes)])
            .unwrap()
            .0
            .values
            .get(0, 0, 1)
            .re
    };
    assert_eq!(
        (first("responses-lines"), first("line-response")),
        (1.0, 2.0)
    );
}

#[test]
fn an_array_of_four_axes_is_refused() {
    let mut file = FileBuilder::new();
    r_i(
        file.create_dataset("H"),
        &nested(['i', 'j', 'k']),
        &[1, 3, 2, LINES],
    );
    file.create_dataset("f").with_f64_data(&frequencies());
    let text = read(file, &[("frf", "H"), ("freq", "f")])
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("at most three axes") && text.contains("[1, 3, 2, 5]"),
        "{text}"
    );
}

#[test]
fn a_file_without_frfs_says_so() {
    let mut file = FileBuilder::new();
    file.create_dataset("numbers").with_f64_data(&[1.0, 2.0]);
    let text = read(file, &[]).unwrap_err().to_string();
    assert!(
        text.contains("no FRF in the input") && text.contains("`map"),
        "{text}"
    );
}

#[test]
fn a_dataset_that_claims_more_than_the_file_holds_is_refused() {
    let mut file = FileBuilder::new();
    r_i(
        file.create_dataset("H"),
        &nested(['i', 'j', 'k']),
        &[3, 2, LINES],
    );
    file.create_dataset("f").with_f64_data(&frequencies());
    let (_folder, path) = saved(file);
    let mut bytes = std::fs::read(&path).unwrap();
    let shape: Vec<u8> = [3_u64, 2, LINES]
        .iter()
        .flat_map(|extent| extent.to_le_bytes())
        .collect();
    let at = bytes
        .windows(shape.len())
        .position(|window| window == shape)
        .unwrap();
    bytes[at + 5] = 0x7f;
    std::fs::write(&path, bytes).unwrap();
    let error = read_frf(&[path], &ReadOptions::default()).unwrap_err();
    assert_eq!(error.kind, ErrorKind::BadData);
}

#[test]
fn chunks_and_filters_that_straddle_the_windows_change_no_value() {
    let (rows, lines) = (37_u64, 9001_u64);
    let values: Vec<(f64, f64)> = (0..rows * lines)
        .map(|k| (k as f64, -0.5 * (k % 7) as f64))
        .collect();
    let mut file = FileBuilder::new();
    let dataset = file.create_dataset("H");
    r_i(dataset, &values, &[rows, lines]);
    dataset.with_chunks(&[5, 1000]).with_deflate(1);
    file.create_dataset("freq")
        .with_f64_data(&(0..lines).map(|k| k as f64).collect::<Vec<_>>())
        .with_shape(&[lines]);
    let (set, _) = read(file, &[]).unwrap();
    assert_eq!(set.values.dim(), (rows as usize, 1, lines as usize));
    for (k, &(re, im)) in values.iter().enumerate() {
        let (i, line) = (k / lines as usize, k % lines as usize);
        assert_eq!(
            set.values.get(i, 0, line),
            Complex64::new(re, im),
            "{i} {line}"
        );
    }
}

#[test]
fn arrays_that_are_no_part_of_the_frfs_are_named_as_left_behind() {
    let mut file = FileBuilder::new();
    r_i(
        file.create_dataset("H"),
        &nested(['i', 'j', 'k']),
        &[3, 2, LINES],
    );
    file.create_dataset("freq")
        .with_f64_data(&frequencies())
        .with_shape(&[LINES]);
    file.create_dataset("temperature")
        .with_f64_data(&[20.5])
        .with_shape(&[1]);
    let (_folder, path) = saved(file);
    let contents = read_contents(&[path], &ReadOptions::default()).unwrap();
    let [left] = contents.not_carried.as_slice() else {
        panic!("{:?}", contents.not_carried)
    };
    assert!(
        left.ends_with("foreign.h5: not carried over: /temperature"),
        "{left}"
    );
}
