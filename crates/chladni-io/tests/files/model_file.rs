//! Model files: both formats return every field; what is wrong is named.
use chladni_frf::{
    Checksum, ComplexMatrix, ComplexVector, Damping, ErrorKind, Finding, FrfKind, ModalModel, Mode,
    Node, Quality, Reason, Reasons, ReferenceUnit, ResidualTerm, ResidualTerms, Scaling, Source,
    Trust, MODEL_FORMAT,
};
use chladni_io::{read_document, read_model, write_model, FileFormat, ReadOptions};
use ndarray::Array2;
use num_complex::Complex64;
use std::path::Path;

fn vector(values: &[(f64, f64)]) -> ComplexVector {
    ComplexVector(
        values
            .iter()
            .map(|&(re, im)| Complex64::new(re, im))
            .collect(),
    )
}

fn mode(frequency_hz: f64, trust: Trust) -> Mode {
    Mode {
        frequency_hz,
        frequency_std_hz: 1e-4,
        loss_factor: 0.01,
        loss_factor_std: 1e-5,
        damping_ratio: 0.005,
        in_band: trust == Trust::Sure,
        trust,
        reasons: if trust == Trust::Sure {
            Reasons::default()
        } else {
            Reasons(vec![
                Reason::new("one-frf-alone", "only in one FRF").detail("20 dB"),
                Reason::new("quoted", "a \"quoted\"\nline"),
            ])
        },
        mpc: 0.999,
        shape: vector(&[(0.1, -1e-300), (1.0 / 3.0, 2.0), (0.0, 0.0)]),
        shape_std: vec![1e-4, 0.0, 5.0],
        scale_std: (trust == Trust::Sure).then_some(0.01),
        participation: vector(&[(0.1, 0.0), (-4.0, 1e22)]),
    }
}

fn model() -> ModalModel {
    let matrix = |seed: f64| {
        ComplexMatrix(Array2::from_shape_fn((3, 2), |(i, j)| {
            Complex64::new(seed + i as f64, j as f64 / 7.0)
        }))
    };
    ModalModel {
        format: MODEL_FORMAT.into(),
        version: 1,
        created_by: chladni_frf::CREATED_BY.into(),
        source: [
            ("Platte µ.h5", Checksum::Sha256("ab".repeat(32))),
            ("beyond 1 GiB.h5", Checksum::Blake3("cd".repeat(32))),
        ]
        .map(|(file, checksum)| Source {
            file: file.into(),
            checksum,
        })
        .to_vec(),
        options: serde_json::json!({"band": [10.0, 700.0], "modes": "auto"})
            .as_object()
            .unwrap()
            .clone(),
        frf_kind: FrfKind::Mobility,
        reference_unit: ReferenceUnit::Volt,
        band_hz: [10.0, 700.0],
        damping: Damping::Viscous,
        scaling: Scaling::Unscaled,
        responses: ["1:+Z", "2:-Z", "3:S"]
            .map(|dof| dof.parse().unwrap())
            .to_vec(),
        references: ["101:+Z", "18446744073709551615:RX"]
            .map(|dof| dof.parse().unwrap())
            .to_vec(),
        nodes: vec![Node {
            label: 1,
            xyz_m: [0.034, 0.025, 0.0],
        }],
        lines: vec![vec![1, 1]],
        faces: vec![vec![1, 1, 1], vec![1, 1, 1, 1]],
        method: "auto".into(),
        modes: vec![
            mode(54.4, Trust::Sure),
            mode(54.4, Trust::Weak),
            mode(900.0, Trust::Rejected),
        ],
        residual_terms: ResidualTerms {
            omega_scale_rad_per_s: 4398.2,
            terms: vec![
                ResidualTerm {
                    power: -2,
                    matrix: matrix(0.5),
                },
                ResidualTerm {
                    power: 4,
                    matrix: matrix(-0.5),
                },
            ],
        },
        quality: Quality {
            relative_error: 0.01,
            chi2_per_dof: 1.0,
            trusted: false,
            findings: vec![Finding::caution("look", "look").help("look")],
            path: Some("lean".into()),
        },
    }
}

fn empty_model() -> ModalModel {
    ModalModel {
        source: vec![],
        options: serde_json::Map::new(),
        nodes: vec![],
        modes: vec![],
        residual_terms: ResidualTerms {
            omega_scale_rad_per_s: 0.0,
            terms: vec![],
        },
        quality: Quality {
            relative_error: 1.0,
            chi2_per_dof: 2.0,
            trusted: true,
            findings: vec![],
            path: None,
        },
        ..model()
    }
}

fn round_trip(model: &ModalModel, path: &Path) -> ModalModel {
    write_model(path, model, true).unwrap();
    read_model(path).unwrap()
}

#[test]
fn every_field_returns_from_both_formats_and_the_bytes_repeat() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["model.json", "model.h5", "model.HDF5"] {
        let path = folder.path().join(name);
        for model in [model(), empty_model()] {
            assert_eq!(round_trip(&model, &path), model, "{name}");
            let first = std::fs::read(&path).unwrap();
            write_model(&path, &model, true).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), first, "{name}");
        }
    }
    let document =
        read_document(&folder.path().join("model.json"), &ReadOptions::default()).unwrap();
    assert_eq!(
        (document.format, document.datasets.len()),
        (FileFormat::Model, 0)
    );
}

#[test]
fn at_some_dofs_a_model_says_what_it_says_there() {
    for damping in [Damping::Viscous, Damping::Structural] {
        let whole = ModalModel { damping, ..model() };
        let part = whole.at_dofs(&[2, 0], &[1]);
        assert_eq!(
            (part.responses[1], part.references[0]),
            (whole.responses[0], whole.references[1])
        );
        let (of_whole, of_part) = (
            whole.frf_matrix(FrfKind::Mobility, 60.0),
            part.frf_matrix(FrfKind::Mobility, 60.0),
        );
        assert_eq!(
            of_part,
            ndarray::array![[of_whole[[2, 1]]], [of_whole[[0, 1]]]]
        );
    }
}

#[test]
fn info_lists_the_modes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    write_model(&path, &model(), false).unwrap();
    let document = read_document(&path, &ReadOptions::default()).unwrap();
    assert_eq!(document.datasets.len(), 3);
    assert_eq!(
        (
            document.datasets[0].frequency_hz,
            document.datasets[0].damping_ratio
        ),
        (Some(54.4), Some(0.005))
    );
    assert_eq!(
        document.datasets[1].warnings[0].text,
        "only in one FRF (20 dB)"
    );
    assert_eq!(document.checksum.unwrap().digits().len(), 64);
}

/// The error of a model file in which `from` stands as `to`, and the line of that change
/// as errors name it.
#[track_caller]
fn refusal(from: &str, to: &str) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.json");
    write_model(&path, &model(), false).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from} in {text}");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let error = read_model(&path).unwrap_err();
    assert_eq!(error.kind, ErrorKind::BadData, "{error}");
    let line = text[..text.find(from).unwrap()].lines().count();
    (error.to_string(), format!("line {line}:"))
}

#[test]
fn what_is_wrong_is_named_with_line_or_field() {
    for (from, to, words) in [
        (
            "\"version\": 1",
            "\"version\": 2",
            &["version", "found 2", "expected 1"][..],
        ),
        (
            "\"damping\": \"viscous\"",
            "\"damping\": \"sticky\"",
            &["LINE", "unknown variant", "found sticky", "structural"],
        ),
        ("\"method\": \"auto\",", "", &["method: ", "missing field"]),
        (
            "\"responses\": [\"1:+Z\"",
            "\"responses\": [\"one\"",
            &["line", "no DOF"],
        ),
        (
            "\"responses\": [\"1:+Z\"",
            "\"responses\": [\"2:-Z\"",
            &["responses", "occurs twice", "2:-Z"],
        ),
        (
            "\"responses\": [\"1:+Z\", ",
            "\"responses\": [",
            &["modes[0].shape", "found 3", "expected 2"],
        ),
        (
            "\"shape_std\": [0.0001, ",
            "\"shape_std\": [",
            &["modes[0].shape_std", "found 2"],
        ),
        (
            "\"frequency_hz\": 54.4",
            "\"frequency_hz\": null",
            &["LINE", "invalid type", "found null", "expected a number"],
        ),
        (
            "\"frequency_hz\": 54.4",
            "\"frequency_hz\": 1e999",
            &["LINE", "out of range"],
        ),
        (
            "\"band_hz\": [10.0",
            "\"band_hz\": [1000.0",
            &["band_hz", "ends before it begins"],
        ),
        (
            "\"frf_kind\"",
            "\"frf_kind\" \"",
            &["LINE", "begins like JSON"],
        ),
        (
            "\"re\": [[0.5, 0.5], ",
            "\"re\": [[0.5], ",
            &["rectangular"],
        ),
    ] {
        let (message, line) = refusal(from, to);
        for word in words {
            assert!(
                message.contains(&word.replace("LINE", &line)),
                "{word}: {message}"
            );
        }
    }
}

#[test]
fn other_files_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text, words) in [
        (
            "weights.json",
            "{\"format\": \"chladni.weights\"}",
            "weights, not a model",
        ),
        ("frf.csv", "f,re,im\n1,2,3\n", "fit a model first"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert!(read_model(&path).unwrap_err().to_string().contains(words));
    }
    let error = write_model(&folder.path().join("model.xml"), &model(), false).unwrap_err();
    assert_eq!(
        (error.kind, error.expected.as_deref()),
        (ErrorKind::Usage, Some(".json, .h5, .hdf5, .mat or .csv"))
    );
    let mut broken = model();
    broken.modes[1].loss_factor = f64::NAN;
    let error = write_model(&folder.path().join("model.json"), &broken, false).unwrap_err();
    assert_eq!(
        (error.kind, error.field.as_deref()),
        (ErrorKind::Internal, Some("modes[1].loss_factor"))
    );
    let mut told_twice = model();
    told_twice.modes[0].damping_ratio = 0.3;
    let error = write_model(&folder.path().join("model.json"), &told_twice, false).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("expected 0.005, half of its loss_factor of 0.01"),
        "{error}"
    );
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        2,
        "nothing half-written"
    );
}
