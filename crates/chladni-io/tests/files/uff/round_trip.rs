//! Reading back of what was written.

use super::{options, read_with, text_58, ONES, SI_164, TWO_COMPLEX};
use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, Node, ReferenceUnit};
use chladni_io::uff::{write, Plan, WriteOptions};
use chladni_io::{Abscissa, Contents, Document, Ordinate, ReadOptions};
use ndarray::{Array1, Array3};
use num_complex::{Complex32, Complex64};

pub fn example_set(frequency_hz: Vec<f64>) -> FrfSet {
    let lines = frequency_hz.len();
    let value = |i: usize, j: usize, k: usize| {
        Complex64::new(
            1.0 / (1.0 + (i + k) as f64),
            -((j * lines + k) as f64).sqrt() * 1e-7,
        )
    };
    let mut values = Array3::from_shape_fn((2, 3, lines), |(i, j, k)| value(i, j, k));
    values
        .slice_mut(ndarray::s![1, 2, ..])
        .fill(Complex64::new(f64::NAN, f64::NAN));
    FrfSet {
        frequency_hz: Array1::from(frequency_hz),
        values: FrfValues::F64(values),
        responses: vec!["1:+Z".parse().unwrap(), "9999999999:-RX".parse().unwrap()],
        references: vec![
            "101:+Z".parse().unwrap(),
            "102:-X".parse().unwrap(),
            "103:S".parse().unwrap(),
        ],
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: Geometry {
            nodes: vec![Node {
                label: 1,
                xyz_m: [0.1, 1.0 / 3.0, -2e-9],
            }],
            ..Geometry::default()
        },
    }
}

fn round_trip(contents: &Contents, binary: bool) -> (Document, Vec<chladni_frf::Finding>) {
    let mut bytes = Vec::new();
    let warnings = write(
        &mut bytes,
        contents,
        WriteOptions {
            binary,
            ..WriteOptions::default()
        },
    )
    .unwrap();
    let document = read_with(&bytes, &options());
    assert_eq!(document.errors, []);
    assert_eq!(document.warnings, Vec::<chladni_frf::Finding>::new());
    (document, warnings)
}

fn even_axis() -> Vec<f64> {
    (0..301).map(|k| 5.0 + f64::from(k) * 2.44140625).collect()
}

#[test]
fn a_set_written_as_binary_reads_back_bit_for_bit() {
    for (axis, reference_unit) in [
        (even_axis(), ReferenceUnit::Newton),
        (
            (1..200).map(|k| f64::from(k).sqrt() * 10.1).collect(),
            ReferenceUnit::Volt,
        ),
    ] {
        for kind in [
            Some(FrfKind::Receptance),
            Some(FrfKind::Mobility),
            Some(FrfKind::Accelerance),
            None,
        ] {
            let set = FrfSet {
                kind,
                reference_unit,
                ..example_set(axis.clone())
            };
            let contents = Contents {
                frf: Some(set.clone()),
                ..Contents::default()
            };
            let (document, warnings) = round_trip(&contents, true);
            assert_eq!(warnings, Vec::<chladni_frf::Finding>::new());
            assert_eq!(document.geometry, set.geometry);
            assert_eq!(
                document.functions.len(),
                5,
                "one of six pairs was not measured"
            );
            for function in &document.functions {
                let i = set
                    .responses
                    .iter()
                    .position(|dof| *dof == function.response)
                    .unwrap();
                let j = set
                    .references
                    .iter()
                    .position(|dof| *dof == function.reference)
                    .unwrap();
                assert_eq!(
                    function.ordinate,
                    Ordinate::Complex64(set.values.frf(i, j).to_vec())
                );
                assert_eq!(function.abscissa.values(axis.len()), axis);
                assert_eq!((function.kind, function.scale_to_si), (kind, 1.0));
                if kind.is_some() {
                    assert_eq!(function.reference_unit, reference_unit);
                }
                assert_eq!(function.warnings, Vec::<chladni_frf::Finding>::new());
            }
        }
    }
}

#[test]
fn a_set_written_as_text_reads_back_to_the_printed_digits() {
    let set = example_set(even_axis());
    let contents = Contents {
        frf: Some(set.clone()),
        ..Contents::default()
    };
    let (document, warnings) = round_trip(&contents, false);
    assert!(warnings[0].contains("13 digits"), "{warnings:?}");
    assert_eq!(document.geometry, set.geometry, "2411 keeps 17 digits");
    for function in &document.functions {
        let i = set
            .responses
            .iter()
            .position(|dof| *dof == function.response)
            .unwrap();
        let j = set
            .references
            .iter()
            .position(|dof| *dof == function.reference)
            .unwrap();
        let Ordinate::Complex64(values) = &function.ordinate else {
            panic!()
        };
        for (read, written) in values.iter().zip(set.values.frf(i, j)) {
            assert!(
                (read.re - written.re).abs() <= 1e-12 * written.re.abs()
                    && (read.im - written.im).abs() <= 1e-12 * written.im.abs()
            );
        }
        assert_eq!(
            function.abscissa.values(values.len()),
            even_axis(),
            "df= in ID line 4 keeps the axis exact"
        );
        assert_eq!(function.warnings, Vec::<chladni_frf::Finding>::new());
    }
}

#[test]
fn numbers_that_do_not_fit_their_columns_are_refused() {
    let sound = read_with([SI_164, &text_58(TWO_COMPLEX, ONES)].concat(), &options())
        .functions
        .remove(0);
    type Spoil = fn(&mut chladni_io::Function);
    let spoils: [(Spoil, &str); 4] = [
        (
            |function| function.axes[1].exponents[0] = 999_999_999,
            "exponent",
        ),
        (|function| function.axes[2].quantity = i32::MIN, "quantity"),
        (|function| function.ids[1] = 1_000_000, "version"),
        (
            |function| function.function_type = -100_000,
            "function type",
        ),
    ];
    for (spoil, word) in spoils {
        let mut function = sound.clone();
        spoil(&mut function);
        let contents = Contents {
            functions: vec![function],
            ..Contents::default()
        };
        let error = Plan::new(&contents, WriteOptions::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(word) && error.contains("does not fit its columns"),
            "{error}"
        );
    }
}

#[test]
fn single_precision_and_coherence_round_trip() {
    let coherence = Array3::from_shape_fn((1, 1, 4), |(_, _, k)| 0.9 + 0.01 * k as f32);
    let set = FrfSet {
        frequency_hz: Array1::from(vec![0.1, 0.2, 0.4, 0.8]),
        values: FrfValues::F32(Array3::from_shape_fn((1, 1, 4), |(_, _, k)| {
            Complex32::new(0.1, k as f32)
        })),
        responses: vec!["1:+Z".parse().unwrap()],
        references: vec!["101:+Z".parse().unwrap()],
        coherence: Some(coherence.clone()),
        variance: None,
        ..example_set(vec![])
    };
    let contents = Contents {
        frf: Some(set.clone()),
        ..Contents::default()
    };
    let (document, _) = round_trip(&contents, true);
    assert_eq!(
        document
            .functions
            .iter()
            .map(|f| f.function_type)
            .collect::<Vec<_>>(),
        [4, 6]
    );
    assert_eq!(
        document.functions[0].abscissa,
        Abscissa::Uneven(vec![0.1, 0.2, 0.4, 0.8]),
        "widened, because f32 would round 0.1"
    );
    let Ordinate::Complex64(values) = &document.functions[0].ordinate else {
        panic!()
    };
    assert_eq!(values[2], Complex64::new(f64::from(0.1f32), 2.0));

    let even = Contents {
        frf: Some(FrfSet {
            frequency_hz: Array1::from(vec![1.0, 2.0, 3.0, 4.0]),
            ..set
        }),
        ..Contents::default()
    };
    let (document, _) = round_trip(&even, true);
    assert!(matches!(
        document.functions[0].ordinate,
        Ordinate::Complex32(_)
    ));
    assert_eq!(
        document.functions[1].ordinate,
        Ordinate::Real32(coherence.into_iter().collect())
    );
}

#[test]
fn id_line_5_says_how_a_set_was_estimated() {
    use chladni_frf::{BlockWindow, Estimation, Estimator, Forcing};
    let made = |estimator, window, averages| Estimation {
        estimator,
        window,
        forcing: (!Estimator::is_local(estimator)).then_some(Forcing::Transient),
        transform_s: 12.5,
        gate_s: 12.5,
        hop_s: 12.5 / 3.0,
        averages,
        lines_per_value: 13,
    };
    let window = BlockWindow::Exponential { rate_per_s: 0.25 };
    for (estimation, expected) in [
        (
            made(Estimator::Hv, window, [10, 20]),
            "hv win=exponential a=0.25/s hop=4.166667s T=12.5s n=10-20 force=transient",
        ),
        (
            made(Estimator::Lrm, BlockWindow::Rectangular, [1, 1]),
            "lrm lines=13 T=12.5s n=1",
        ),
    ] {
        let contents = Contents {
            frf: Some(FrfSet {
                estimation: Some(estimation),
                ..example_set(even_axis())
            }),
            ..Contents::default()
        };
        let (document, _) = round_trip(&contents, true);
        for function in &document.functions {
            assert_eq!(function.id_lines[4], expected);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("made.unv");
        chladni_io::write_frf(&path, contents.frf.as_ref().unwrap(), false).unwrap();
        let (set, ..) = chladni_io::read_frf(&[path], &chladni_io::ReadOptions::default()).unwrap();
        assert_eq!(
            set.estimation.map(|made| made.to_string()),
            Some(expected.into())
        );
    }
}

#[test]
fn masked_lines_stay_masked_in_binary_and_are_refused_as_text() {
    let mut set = example_set(even_axis());
    let FrfValues::F64(values) = &mut set.values else {
        unreachable!()
    };
    values[[0, 1, 7]] = Complex64::new(f64::NAN, f64::NAN);
    let contents = Contents {
        frf: Some(set),
        ..Contents::default()
    };
    let (document, _) = round_trip(&contents, true);
    let Ordinate::Complex64(values) = &document.functions[1].ordinate else {
        panic!()
    };
    assert!(values[7].re.is_nan() && values[8].is_finite());
    let error = Plan::new(&contents, WriteOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("1:+Z / 102:-X: value 8") && error.contains("binary"),
        "{error}"
    );
}

#[test]
fn any_function_of_a_file_is_written_in_si() {
    let units = SI_164.replacen("         1SI", "        10mm", 1).replacen(
        "1.00000000000000000D+00",
        "1.00000000000000000D+03",
        1,
    );
    let record_7 = "         4         4         1  0.00000E+00  1.95313E-05  0.00000E+00";
    let text = text_58(record_7, &format!("{}\n", "  2.000000000000E+00".repeat(4)))
        .replacen("    4         0    0", "    1         7    1", 1)
        .replace(
            "        18    0    0    0 Frequency            Hz ",
            "        17    0    0    0 Time                 s  ",
        )
        .replace(
            "        11    0    0    0 Velocity             m/s ",
            "        11    0    0    0 Velocity             mm/s",
        )
        .replace(
            "        13    0    0    0 Force                N ",
            "         0    0    0    0 NONE                 NONE",
        );
    let options = ReadOptions {
        snap_df: true,
        ..options()
    };
    let source = read_with([units, text].concat(), &options);
    assert_eq!(source.functions[0].scale_to_si, 1e-3);
    for binary in [false, true] {
        let (document, _) = round_trip(
            &Contents {
                functions: source.functions.clone(),
                ..Contents::default()
            },
            binary,
        );
        let function = &document.functions[0];
        assert_eq!(
            (function.function_type, function.ids, function.scale_to_si),
            (1, [7, 1, 0], 1.0)
        );
        assert_eq!(function.ordinate, Ordinate::Real64(vec![0.002; 4]));
        assert_eq!(
            (
                function.axes[1].unit.as_str(),
                function.axes[0].unit.as_str()
            ),
            ("m/s", "s")
        );
        assert_eq!(
            function.abscissa,
            Abscissa::Even {
                start: 0.0,
                step: 1.0 / 51200.0
            }
        );
    }
}

#[test]
fn the_same_contents_give_the_same_bytes() {
    let contents = Contents {
        frf: Some(example_set(even_axis())),
        ..Contents::default()
    };
    let [first, second] = [(); 2].map(|()| {
        let mut bytes = Vec::new();
        write(
            &mut bytes,
            &contents,
            WriteOptions {
                binary: true,
                ..WriteOptions::default()
            },
        )
        .unwrap();
        bytes
    });
    assert_eq!(first, second);
    assert!(first.starts_with(b"    -1\n   151\n"));
}

#[test]
fn a_node_number_of_eleven_digits_cannot_be_written() {
    let set = FrfSet {
        responses: vec!["1:+Z".parse().unwrap(), "12345678901:+Z".parse().unwrap()],
        ..example_set(even_axis())
    };
    let error = Plan::new(
        &Contents {
            frf: Some(set),
            ..Contents::default()
        },
        WriteOptions {
            binary: true,
            ..WriteOptions::default()
        },
    )
    .unwrap_err();
    assert!(error.to_string().contains("12345678901"));
}

/// Six digits of an uneven axis as text: lines that fall together are refused.
#[test]
fn an_uneven_axis_that_text_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let set = example_set(vec![5140.0, 5140.001, 5782.5]);
    let text = folder.path().join("a.unv");
    let error = chladni_io::write_frf(&text, &set, false).unwrap_err();
    let words = error.to_string();
    assert!(
        words.contains("six digits") && words.contains("5140.001"),
        "{words}"
    );
    assert!(!text.exists());
    chladni_io::write_frf(&folder.path().join("a.uff"), &set, false).unwrap();
}
