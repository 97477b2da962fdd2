//! Shapes, trace lines and elements: what is read is written again, and what other
//! programs wrote is read right.

use super::{options, read_with, SI_164};
use chladni_frf::{Geometry, Node};
use chladni_io::uff::{write, WriteOptions};
use chladni_io::{Analysis, Contents, Document, Shape, ShapeForm, ShapeNumbers};
use ndarray::Array2;
use num_complex::Complex64;

fn sample(name: &str) -> Option<Vec<u8>> {
    let folder = std::path::Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/pyuff-uff-samples"
    ));
    let bytes = std::fs::read(folder.join(name)).ok();
    if bytes.is_none() {
        crate::skipped(&format!("{name} is not beside this workspace"));
    }
    bytes
}

fn geometry() -> Geometry {
    let node = |label: u64| Node {
        label,
        xyz_m: [0.1 * label as f64, -1.0 / label as f64, 0.0],
    };
    Geometry {
        nodes: (1..=300).map(node).collect(),
        lines: vec![vec![1, 2, 3], vec![7, 8], (1..=250).collect()],
        faces: vec![vec![1, 2, 3], vec![4, 5, 6, 7]],
    }
}

/// A shape of which six digits hold everything.
fn shape(form: ShapeForm, analysis: Analysis, complex: bool, components: usize) -> Shape {
    let numbers = ShapeNumbers {
        load_case: 1,
        number: 4,
        ..ShapeNumbers::default()
    };
    let numbers = match analysis {
        Analysis::NormalMode => ShapeNumbers {
            frequency_hz: 54.35,
            modal_mass: 0.25,
            viscous: 0.005,
            hysteretic: 0.01,
            ..numbers
        },
        Analysis::FrequencyResponse => ShapeNumbers {
            frequency_hz: 300.0,
            ..numbers
        },
        Analysis::Transient => ShapeNumbers {
            time_s: 1.25e-3,
            ..numbers
        },
        _ if analysis.is_complex_mode() => ShapeNumbers {
            eigenvalue: Complex64::new(-1.5, 300.25),
            modal_a: Complex64::new(2.0, -3.0),
            modal_b: Complex64::new(-1e-7, 1e12),
            ..numbers
        },
        _ => ShapeNumbers {
            number: 0,
            ..numbers
        },
    };
    Shape {
        form,
        name: if form == ShapeForm::Analysis2414 {
            "Mode 4".into()
        } else {
            String::new()
        },
        id_lines: [
            "shape".into(),
            String::new(),
            "no date".into(),
            String::new(),
            String::new(),
        ],
        model_type: 1,
        analysis,
        characteristic: if components == 6 { 3 } else { 2 },
        quantity: 8,
        reference: (form == ShapeForm::AtNodes55).then(|| "101:-Z".parse().unwrap()),
        numbers,
        complex,
        nodes: vec![3, 1, 9_999_999_999],
        values: Array2::from_shape_fn((3, components), |(i, j)| {
            Complex64::new(
                0.25 * i as f64 - 1.5 * j as f64,
                if complex { 1e-12 * (i + j) as f64 } else { 0.0 },
            )
        }),
        scale_to_si: 1.0,
        line: 0,
        warnings: Vec::new(),
    }
}

fn written(contents: &Contents, options: WriteOptions) -> Document {
    let mut bytes = Vec::new();
    write(&mut bytes, contents, options).unwrap();
    let document = read_with(&bytes, &super::options());
    assert_eq!(document.errors, []);
    document
}

#[test]
fn shapes_of_every_analysis_survive_both_datasets() {
    for form in [ShapeForm::AtNodes55, ShapeForm::Analysis2414] {
        for analysis in (0..=7).map(Analysis::from_code) {
            for (complex, components) in [(false, 3), (true, 3), (false, 6), (true, 6), (true, 1)] {
                let original = shape(form, analysis, complex, components);
                let contents = Contents {
                    shapes: vec![original.clone()],
                    ..Contents::default()
                };
                let mut document = written(&contents, WriteOptions::default());
                let mut read = document.shapes.remove(0);
                // ID line 5 of dataset 55 holds the reference
                read.id_lines[4].clear();
                read.line = 0;
                assert_eq!(read, original);
            }
        }
    }
}

#[test]
fn geometry_survives_and_the_old_datasets_keep_six_digits() {
    let contents = Contents {
        other_geometry: geometry(),
        shapes: vec![shape(
            ShapeForm::Analysis2414,
            Analysis::NormalMode,
            false,
            3,
        )],
        ..Contents::default()
    };
    let document = written(
        &contents,
        WriteOptions {
            binary: true,
            ..WriteOptions::default()
        },
    );
    assert_eq!(document.geometry.nodes, geometry().nodes, "2411 is exact");
    assert_eq!(document.geometry, geometry());
    let old = written(
        &contents,
        WriteOptions {
            old_datasets: true,
            ..WriteOptions::default()
        },
    );
    let numbers: Vec<u32> = old.datasets.iter().filter_map(|info| info.number).collect();
    assert_eq!(numbers, [151, 164, 15, 82, 82, 82, 2412, 55]);
    for (a, b) in old.geometry.nodes.iter().zip(&geometry().nodes) {
        assert!(a
            .xyz_m
            .iter()
            .zip(b.xyz_m)
            .all(|(a, b)| (a - b).abs() <= 5e-6 * b.abs()));
    }
    assert_eq!(old.shapes[0].form, ShapeForm::AtNodes55);
}

#[test]
fn a_line_longer_than_the_format_allows_is_cut_and_shares_a_node() {
    let long = Geometry {
        lines: vec![(1..=300).collect()],
        ..geometry()
    };
    let document = written(
        &Contents {
            other_geometry: long,
            ..Contents::default()
        },
        WriteOptions::default(),
    );
    let [first, second, face @ ..] = document.geometry.lines.as_slice() else {
        panic!("two parts")
    };
    assert_eq!(
        (first.len(), second[0], *second.last().unwrap(), face.len()),
        (250, 250, 300, 0)
    );
}

#[test]
fn mode_shapes_keep_their_own_scaling_and_fields_are_turned_into_metres() {
    let mm = SI_164.replace("         1SI", "         5mm").replacen(
        "  1.00000000000000000D+00  1.0",
        "  1.00000000000000000D+03  1.0",
        1,
    );
    for (analysis, scale, warned) in [(2, 1.0, 1), (5, 1e-3, 0)] {
        let reals = if analysis == 2 { 4 } else { 1 };
        let head = format!(
            "    -1\n    55\n{}         1{analysis:10}         2         8         2         3\n",
            super::ID_LINES
        );
        let numbers = format!(
            "         2{reals:10}         1         1\n  1.00000E+01  \
                               0.00000E+00  0.00000E+00  0.00000E+00\n"
        );
        let document = read_with(
            format!("{mm}{head}{numbers}         1\n  1.0  2.0  3.0\n    -1\n"),
            &options(),
        );
        assert_eq!(document.errors, []);
        let shape = &document.shapes[0];
        assert_eq!(shape.scale_to_si, scale);
        let own_scaling = shape
            .warnings
            .iter()
            .filter(|warning| warning.contains("scaling of its own"))
            .count();
        assert_eq!(own_scaling, warned);
    }
}

#[test]
fn shapes_and_meshes_of_other_programs_are_read() {
    let Some(bytes) = sample("uff55_translation.uff") else {
        return;
    };
    let document = read_with(bytes, &options());
    assert_eq!((document.shapes.len(), document.errors.len()), (3, 0));
    let shape = &document.shapes[1];
    assert_eq!(
        (
            shape.nodes.as_slice(),
            shape.frequency_hz(),
            shape.numbers.number
        ),
        ([1, 2, 3, 4].as_slice(), Some(12.0), 2)
    );
    assert_eq!(shape.values[[3, 0]], Complex64::from(1.98289));

    let document = read_with(sample("heat_engine_housing.uff").unwrap(), &options());
    assert_eq!(document.errors, []);
    // four tetrahedra of four faces each, four triangles
    assert_eq!(
        (
            document.geometry.faces.len(),
            document.geometry.faces[16].as_slice()
        ),
        (20, [1, 2, 4].as_slice())
    );
    let shape = &document.shapes[0];
    assert_eq!(
        (
            shape.name.as_str(),
            shape.values.dim(),
            shape.values[[6, 0]].re
        ),
        ("Temperature", (10, 1), 24.9976)
    );

    let document = read_with(sample("mesh_test_uff2412_mixed.uff").unwrap(), &options());
    assert_eq!(
        (document.errors.len(), document.warnings.len()),
        (0, 1),
        "only that units are missing: {:?}",
        document.warnings
    );
    assert_eq!(
        document.geometry.faces,
        [
            vec![3, 4, 5, 6],
            vec![3, 4, 11],
            vec![4, 5, 11],
            vec![5, 6, 11],
            vec![3, 6, 11]
        ]
    );
}
