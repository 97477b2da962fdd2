//! MATLAB and NumPy files: every class, order and packing; what we write reads back the
//! same.

use chladni_frf::{Error, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use chladni_io::{
    assemble, read_document, read_frf, write_frf, Contents, Document, PhaseUnit, ReadOptions,
};
use flate2::write::ZlibEncoder;
use ndarray::{Array1, Array3};
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;
use std::io::Write;
use std::path::Path;

const LINES: usize = 4;

/// A file in either byte order.
struct Mat {
    big: bool,
    bytes: Vec<u8>,
}

impl Mat {
    fn new(big: bool) -> Self {
        let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
        bytes.resize(124, b' ');
        bytes.extend(if big {
            [1, 0, b'M', b'I']
        } else {
            [0, 1, b'I', b'M']
        });
        Self { big, bytes }
    }
    fn word(&self, value: u32) -> [u8; 4] {
        if self.big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        }
    }
    fn element(&self, kind: u32, payload: &[u8]) -> Vec<u8> {
        // small elements keep type, size and data in eight bytes
        if (1..=4).contains(&payload.len()) {
            let mut small = self.word((payload.len() as u32) << 16 | kind).to_vec();
            small.extend(payload);
            small.resize(8, 0);
            return small;
        }
        let mut element = [self.word(kind), self.word(payload.len() as u32)].concat();
        element.extend(payload);
        element.resize(element.len().div_ceil(8) * 8, 0);
        element
    }
    /// An array of class `class` whose parts are stored as numbers of type `kind`.
    fn array(
        &self,
        name: &str,
        dimensions: &[u32],
        class: u32,
        kind: u32,
        parts: &[Vec<u8>],
    ) -> Vec<u8> {
        let complex = if parts.len() > 1 { 0x0800 } else { 0 };
        let mut content = self.element(6, &[self.word(class | complex), self.word(0)].concat());
        content.extend(
            self.element(
                5,
                &dimensions
                    .iter()
                    .flat_map(|&extent| self.word(extent))
                    .collect::<Vec<u8>>(),
            ),
        );
        content.extend(self.element(1, name.as_bytes()));
        parts
            .iter()
            .for_each(|part| content.extend(self.element(kind, part)));
        self.element(14, &content)
    }
    fn doubles(&self, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
        values
            .into_iter()
            .flat_map(|value| {
                if self.big {
                    value.to_be_bytes()
                } else {
                    value.to_le_bytes()
                }
            })
            .collect()
    }
    fn singles(&self, values: impl IntoIterator<Item = f32>) -> Vec<u8> {
        values
            .into_iter()
            .flat_map(|value| {
                if self.big {
                    value.to_be_bytes()
                } else {
                    value.to_le_bytes()
                }
            })
            .collect()
    }
    fn push(&mut self, element: &[u8], packed: bool) {
        if !packed {
            self.bytes.extend(element);
            return;
        }
        let mut encoder = ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(element).unwrap();
        let packed = encoder.finish().unwrap();
        self.bytes
            .extend([self.word(15), self.word(packed.len() as u32)].concat());
        self.bytes.extend(packed);
    }
}

fn value(response: usize, reference: usize, line: usize) -> Complex64 {
    Complex64::new(
        (100 * response + 10 * reference + line) as f64,
        -0.5 * line as f64,
    )
}

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
        for element in [&frf, &freq, &unit] {
            file.push(element, packed);
        }
        let (document, contents) = read(&file.bytes, "a.mat", &[]);
        assert_eq!(document.datasets.len(), 3);
        let set = contents.frf.unwrap();
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

fn set(values: FrfValues) -> FrfSet {
    let (responses, references, lines) = values.dim();
    FrfSet {
        frequency_hz: Array1::from_iter((0..lines).map(|k| 1.0 + 0.3 * k as f64)),
        values,
        responses: (1..=responses as u64)
            .map(|node| format!("{node}:-RX").parse().unwrap())
            .collect(),
        references: (9..9 + references as u64)
            .map(|node| format!("{node}:S").parse().unwrap())
            .collect(),
        kind: Some(FrfKind::Accelerance),
        reference_unit: ReferenceUnit::Volt,
        coherence: Some(Array3::from_shape_fn(
            (responses, references, lines),
            |(i, _, k)| 0.5 + 0.1 * i as f32 - 0.01 * k as f32,
        )),
        variance: None,
        estimation: None,
        geometry: Geometry::default(),
    }
}

fn through_npz(set: &FrfSet) -> FrfSet {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.npz");
    write_frf(&path, set, false).unwrap();
    let document = read_document(&path, &ReadOptions::default()).unwrap();
    assert_eq!(document.errors, []);
    assemble(vec![document], &ReadOptions::default())
        .unwrap()
        .frf
        .unwrap()
}

#[test]
fn single_precision_coherence_and_dofs_survive_numpy() {
    let single = set(FrfValues::F32(Array3::from_shape_fn(
        (2, 3, 5),
        |(i, j, k)| Complex32::new(0.1 * (i + j) as f32, k as f32),
    )));
    assert_eq!(through_npz(&single), single);
}

#[test]
fn our_own_archives_read_back_whatever_their_shape() {
    for shape in [
        (3, 2, 1),
        (1, 1, 1),
        (3, 1, 3),
        (2, 3, 2),
        (4, 4, 4),
        (1, 5, 5),
    ] {
        let values = Array3::from_shape_fn(shape, |(i, j, k)| value(i, j, k) + 1.0);
        let set = set(FrfValues::F64(values));
        assert_eq!(through_npz(&set), set, "{shape:?}");
    }
}

/// An archive as `numpy.savez` writes it; texts have at most eight characters.
struct Npz(Vec<(String, Vec<u8>)>);

impl Npz {
    fn add(mut self, name: &str, code: &str, shape: &[usize], data: Vec<u8>) -> Self {
        let extents: String = shape.iter().map(|extent| format!("{extent},")).collect();
        let head =
            format!("{{'descr': '{code}', 'fortran_order': False, 'shape': ({extents}), }}\n");
        let mut member = b"\x93NUMPY\x01\x00".to_vec();
        member.extend((head.len() as u16).to_le_bytes());
        member.extend(head.as_bytes());
        member.extend(data);
        self.0.push((format!("{name}.npy"), member));
        self
    }
    fn reals(self, name: &str, values: &[f64]) -> Self {
        let data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.add(name, "<f8", &[values.len()], data)
    }
    fn complex(self, name: &str, shape: &[usize], values: &[Complex64]) -> Self {
        let bytes = |v: &Complex64| [v.re.to_le_bytes(), v.im.to_le_bytes()].concat();
        let data = values.iter().flat_map(bytes).collect();
        self.add(name, "<c16", shape, data)
    }
    fn texts(self, name: &str, texts: &[&str]) -> Self {
        let padded = |text: &&str| {
            let mut bytes = text.as_bytes().to_vec();
            bytes.resize(24, 0);
            bytes
        };
        let data = texts.iter().flat_map(padded).collect();
        self.add(name, "|S24", &[texts.len()], data)
    }
    fn read(&self, options: &ReadOptions) -> Result<(FrfSet, Vec<String>), Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.npz");
        let mut archive = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        for (name, bytes) in &self.0 {
            archive
                .start_file(name.as_str(), zip::write::SimpleFileOptions::default())
                .unwrap();
            archive.write_all(bytes).unwrap();
        }
        archive.finish().unwrap();
        read_frf(&[path], options).map(|(set, _, warnings)| (set, crate::words(&warnings)))
    }
}

#[test]
fn lists_of_dofs_say_which_axis_is_which() {
    let values: Vec<Complex64> = (0..2)
        .flat_map(|j| (0..3).flat_map(move |i| (0..5).map(move |k| value(i, j, k))))
        .collect();
    let npz = Npz(Vec::new())
        .complex("frf", &[2, 3, 5], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0, 5.0])
        .texts("response", &["1:+Z", "2:+Z", "3:+Z"])
        .texts("reference", &["11:+Z", "12:+Z"]);
    let (set, warnings) = npz.read(&ReadOptions::default()).unwrap();
    assert_eq!(set.values.dim(), (3, 2, 5));
    assert_eq!(set.values.get(2, 1, 4), value(2, 1, 4));
    assert_eq!(set.references[1].to_string(), "12:+Z");
    assert!(
        !warnings.join("\n").contains("in the order"),
        "{warnings:?}"
    );

    let nameless = Npz(Vec::new())
        .complex("frf", &[2, 3, 5], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0, 5.0]);
    let (_, warnings) = nameless.read(&ReadOptions::default()).unwrap();
    let text = warnings.join("\n");
    assert!(text.contains("in the order response, reference"), "{text}");

    let wrong = Npz(Vec::new())
        .complex("frf", &[2, 3, 5], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0, 5.0])
        .texts("response", &["1:+Z", "2:+Z", "3:+Z", "4:+Z"]);
    let error = wrong.read(&ReadOptions::default()).unwrap_err().to_string();
    assert!(
        error.contains("4 response DOFs") && error.contains("[2, 3, 5]"),
        "{error}"
    );

    let named = Npz(Vec::new())
        .complex("frf", &[2, 2, 2], &values[..8])
        .reals("freq", &[1.0, 2.0])
        .texts("axes", &["line-reference-response"]);
    let (set, _) = named.read(&ReadOptions::default()).unwrap();
    assert_eq!(set.values.get(1, 0, 0), values[1]);
}

#[test]
fn infinities_are_errors_and_masked_where_asked() {
    let mut values = vec![Complex64::new(1.0, 2.0); 4];
    values[2].im = f64::INFINITY;
    let npz = Npz(Vec::new())
        .complex("frf", &[4], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0]);
    let error = npz.read(&ReadOptions::default()).unwrap_err().to_string();
    for words in ["/frf", "inf", "line 3", "`lenient`"] {
        assert!(error.contains(words), "{words}: {error}");
    }
    let lenient = ReadOptions {
        lenient: true,
        ..ReadOptions::default()
    };
    let (set, warnings) = npz.read(&lenient).unwrap();
    assert!(set.values.get(0, 0, 2).re.is_nan());
    assert!(warnings.join("\n").contains("masked"), "{warnings:?}");
}

#[test]
fn magnitudes_and_phases_say_their_unit_or_are_asked_for() {
    let polar = |phase: &str, phases: &[f64]| {
        Npz(Vec::new())
            .reals("mag", &[1.0, 2.0])
            .reals(phase, phases)
            .reals("freq", &[1.0, 2.0])
    };
    let degrees = polar("phase", &[0.0, 90.0]).read(&ReadOptions::default());
    assert!((degrees.unwrap().0.values.get(0, 0, 1).im - 2.0).abs() < 1e-12);
    let quarter = std::f64::consts::FRAC_PI_2;
    let radians = polar("phase_rad", &[0.0, quarter]).read(&ReadOptions::default());
    assert!((radians.unwrap().0.values.get(0, 0, 1).im - 2.0).abs() < 1e-12);
    let unsaid = polar("phase", &[0.0, quarter]);
    let error = unsaid
        .read(&ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("/phase") && error.contains("`phase_unit rad`"),
        "{error}"
    );
    let told = ReadOptions {
        phase_unit: Some(PhaseUnit::Radian),
        ..ReadOptions::default()
    };
    assert!((unsaid.read(&told).unwrap().0.values.get(0, 0, 1).im - 2.0).abs() < 1e-12);
    for name in ["mag_db", "mag"] {
        let decibels = Npz(Vec::new())
            .reals(name, &[-60.0, -40.0])
            .reals("phase", &[0.0, 90.0])
            .reals("freq", &[1.0, 2.0]);
        let error = decibels
            .read(&ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains("dB"), "{error}");
    }
    let complex = Npz(Vec::new())
        .complex("frf", &[2], &[Complex64::new(1.0, 2.0); 2])
        .reals("freq", &[1.0, 2.0])
        .texts("unit", &["dB"]);
    let error = complex
        .read(&ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("dB") && error.contains("/frf"), "{error}");
}

#[test]
fn frequencies_may_be_complex_and_stand_beside_the_frfs() {
    let frequencies = [1.0, 2.0, 3.0].map(Complex64::from);
    let frf = [value(0, 0, 1), value(0, 0, 2), value(0, 0, 3)];
    let apart = Npz(Vec::new())
        .complex("freq", &[3], &frequencies)
        .complex("H", &[3], &frf);
    let joined: Vec<Complex64> = frequencies
        .iter()
        .zip(&frf)
        .flat_map(|(f, h)| [*f, *h])
        .collect();
    let joined = Npz(Vec::new()).complex("FRF", &[3, 2], &joined);
    for npz in [apart, joined] {
        let (set, warnings) = npz.read(&ReadOptions::default()).unwrap();
        assert_eq!(set.frequency_hz.to_vec(), [1.0, 2.0, 3.0]);
        assert_eq!(set.values.frf(0, 0).to_vec(), frf);
        assert!(warnings.join("\n").contains("`map"), "{warnings:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_double_survives_numpy(values in prop::collection::vec(any::<f64>().prop_filter("finite", |v| v.is_finite()), 24)) {
        let values = Array3::from_shape_fn((2, 1, 6), |(i, _, k)| Complex64::new(values[12 * i + k], values[12 * i + 6 + k]));
        let set = set(FrfValues::F64(values));
        prop_assert_eq!(through_npz(&set), set);
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
