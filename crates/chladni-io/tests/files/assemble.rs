//! Many files into one set: single-reference surveys, duplicates, gaps, contradictions.
use chladni_frf::{
    Error, ErrorKind, FrfKind, FrfSet, FrfValues, Geometry, Node, ReferenceUnit, TimeSign,
};
use chladni_io::{
    assemble, Abscissa, Axis, Contents, Document, Duplicates, FileFormat, Function, Ordinate,
    ReadOptions,
};
use num_complex::{Complex32, Complex64};
use std::path::PathBuf;

fn function(function_type: i32, response: &str, reference: &str, ordinate: Ordinate) -> Function {
    Function {
        function_type,
        id_lines: Default::default(),
        ids: [0; 3],
        entity_names: Default::default(),
        response: response.parse().unwrap(),
        reference: reference.parse().unwrap(),
        abscissa: Abscissa::Even {
            start: 1.0,
            step: 0.5,
        },
        z: 0.0,
        axes: std::array::from_fn(|_| Axis::default()),
        ordinate,
        kind: Some(FrfKind::Mobility),
        reference_unit: ReferenceUnit::Newton,
        scale_to_si: 1.0,
        abscissa_to_si: 1.0,
        line: 12,
        warnings: Vec::new(),
    }
}

fn frf(response: &str, reference: &str, value: f64) -> Function {
    function(
        4,
        response,
        reference,
        Ordinate::Complex64(vec![Complex64::new(value, 1.0); 3]),
    )
}

fn document(name: &str, functions: Vec<Function>) -> Document {
    Document {
        file: PathBuf::from(name),
        format: FileFormat::Uff,
        sha256: "00".into(),
        geometry: Geometry::default(),
        datasets: Vec::new(),
        frf: None,
        functions,
        shapes: Vec::new(),
        errors: Vec::new(),
        warnings: Vec::new(),
    }
}

fn merge(documents: Vec<Document>, options: &ReadOptions) -> Result<(FrfSet, Vec<String>), Error> {
    assemble(documents, options)
        .map(|contents| (contents.frf.unwrap(), crate::words(&contents.warnings)))
}

fn names(dofs: &[chladni_frf::Dof]) -> Vec<String> {
    dofs.iter().map(ToString::to_string).collect()
}

#[test]
fn single_reference_files_make_one_set() {
    let documents = vec![
        document(
            "a.uff",
            vec![frf("1:+Z", "101:+Z", 1.0), frf("2:+Z", "101:+Z", 2.0)],
        ),
        document(
            "b.uff",
            vec![frf("1:+Z", "102:+Z", 3.0), frf("3:+Z", "102:+Z", 4.0)],
        ),
    ];
    let (set, warnings) = merge(documents, &ReadOptions::default()).unwrap();
    assert_eq!(
        (names(&set.responses), names(&set.references)),
        (
            vec!["1:+Z".into(), "2:+Z".into(), "3:+Z".into()],
            vec!["101:+Z".into(), "102:+Z".into()]
        )
    );
    assert_eq!(set.frequency_hz.to_vec(), [1.0, 1.5, 2.0]);
    assert_eq!(set.values.get(2, 1, 2), Complex64::new(4.0, 1.0));
    assert_eq!(set.missing_pairs(), [(1, 1), (2, 0)]);
    assert_eq!(
        warnings,
        ["2 of 6 pairs are missing (response, reference): (2:+Z, 102:+Z), (3:+Z, 101:+Z)"]
    );
}

#[test]
fn files_that_all_say_reference_one_need_the_override() {
    let documents = || {
        vec![
            document("a.uff", vec![frf("1:+Z", "1:+Z", 1.0)]),
            document("b.uff", vec![frf("1:+Z", "1:+Z", 3.0)]),
        ]
    };
    let error = merge(documents(), &ReadOptions::default()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("a.uff line 12 and b.uff line 12") && text.contains("`reference N`"),
        "{text}"
    );
    let options = ReadOptions {
        references: vec![101, 102],
        ..ReadOptions::default()
    };
    assert_eq!(
        names(&merge(documents(), &options).unwrap().0.references),
        ["101:+Z", "102:+Z"]
    );
    let options = ReadOptions {
        references: vec![101, 102, 103],
        ..ReadOptions::default()
    };
    assert_eq!(
        merge(documents(), &options).unwrap_err().kind,
        ErrorKind::Usage
    );
    let two = vec![document(
        "c.uff",
        vec![frf("1:+Z", "1:+Z", 1.0), frf("1:+Z", "2:+Z", 1.0)],
    )];
    let error = merge(
        two,
        &ReadOptions {
            references: vec![5],
            ..ReadOptions::default()
        },
    )
    .unwrap_err();
    assert!(error.to_string().contains("found 1, 2"), "{error}");
}

#[test]
fn duplicates_follow_the_rule() {
    let documents = || {
        vec![document(
            "a.uff",
            vec![frf("1:+Z", "9:+Z", 1.0), frf("1:+Z", "9:+Z", 4.0)],
        )]
    };
    for (duplicates, expected) in [
        (Duplicates::First, 1.0),
        (Duplicates::Last, 4.0),
        (Duplicates::Mean, 2.5),
    ] {
        let (set, warnings) = merge(
            documents(),
            &ReadOptions {
                duplicates,
                ..ReadOptions::default()
            },
        )
        .unwrap();
        assert_eq!(set.values.get(0, 0, 0).re, expected);
        assert!(warnings[0].contains("(1:+Z, 9:+Z)"), "{warnings:?}");
    }
}

#[test]
fn a_zero_pair_is_missing_and_makes_no_duplicate() {
    let zero = function(
        4,
        "1:+Z",
        "9:+Z",
        Ordinate::Complex64(vec![Complex64::new(0.0, 0.0); 3]),
    );
    let (set, _) = merge(
        vec![document(
            "a.uff",
            vec![zero.clone(), frf("1:+Z", "9:+Z", 4.0)],
        )],
        &ReadOptions::default(),
    )
    .unwrap();
    assert_eq!(set.values.get(0, 0, 0).re, 4.0);
    let (set, warnings) = merge(
        vec![document("a.uff", vec![zero, frf("2:+Z", "9:+Z", 4.0)])],
        &ReadOptions::default(),
    )
    .unwrap();
    assert!(set.values.get(0, 0, 0).re.is_nan());
    assert_eq!(
        warnings,
        ["1 pairs are exactly zero on every line and are treated as missing: (1:+Z, 9:+Z)"]
    );
}

#[test]
fn axes_agree_within_half_a_line_or_both_records_are_named() {
    let near = Function {
        abscissa: Abscissa::Uneven(vec![1.0, 1.51, 2.0]),
        line: 40,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let (set, warnings) = merge(
        vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0), near])],
        &ReadOptions::default(),
    )
    .unwrap();
    assert_eq!(set.frequency_hz[1], 1.5);
    assert!(
        warnings[0]
            .contains("differ by up to 0.020 of a line (a.uff line 40 against a.uff line 12)"),
        "{warnings:?}"
    );
    for abscissa in [
        Abscissa::Even {
            start: 1.3,
            step: 0.5,
        },
        Abscissa::Uneven(vec![1.0, 1.5]),
        Abscissa::Uneven(vec![1.0, f64::NAN, 2.0]),
    ] {
        let count = if let Abscissa::Uneven(values) = &abscissa {
            values.len()
        } else {
            3
        };
        let far = Function {
            abscissa,
            line: 40,
            ordinate: Ordinate::Complex64(vec![Complex64::new(1.0, 1.0); count]),
            ..frf("2:+Z", "9:+Z", 1.0)
        };
        let text = merge(
            vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0), far])],
            &ReadOptions::default(),
        )
        .unwrap_err()
        .to_string();
        assert!(
            text.contains("a.uff line 40")
                && text.contains("a.uff line 12")
                && text.contains("half a line"),
            "{text}"
        );
    }
}

#[test]
fn single_lines_must_be_the_same_and_a_falling_axis_is_named() {
    let one_line = |response: &str, f: f64| Function {
        abscissa: Abscissa::Uneven(vec![f]),
        ordinate: Ordinate::Complex64(vec![Complex64::new(1.0, 1.0)]),
        ..frf(response, "9:+Z", 1.0)
    };
    let pair = |f: f64| {
        vec![document(
            "a.uff",
            vec![one_line("1:+Z", 300.0), one_line("2:+Z", f)],
        )]
    };
    assert!(merge(pair(300.0), &ReadOptions::default()).is_ok());
    assert!(merge(pair(301.0), &ReadOptions::default())
        .unwrap_err()
        .to_string()
        .contains("one line at 301 Hz"));
    let falling = Function {
        abscissa: Abscissa::Even {
            start: 5.0,
            step: -1.0,
        },
        ..frf("1:+Z", "9:+Z", 1.0)
    };
    let text = merge(
        vec![document("a.uff", vec![falling])],
        &ReadOptions::default(),
    )
    .unwrap_err()
    .to_string();
    assert!(
        text.contains("a.uff line 12") && text.contains("3 lines 5..3 Hz"),
        "{text}"
    );
}

#[test]
fn kinds_and_reference_units_must_agree_unless_the_user_says_the_kind() {
    let other = Function {
        kind: None,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let documents = || {
        vec![
            document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0)]),
            document("b.uff", vec![other.clone()]),
        ]
    };
    let text = merge(documents(), &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("not said in b.uff") && text.contains("mobility as in a.uff"),
        "{text}"
    );
    let options = ReadOptions {
        frf_kind: Some(FrfKind::Receptance),
        ..ReadOptions::default()
    };
    let (set, warnings) = merge(documents(), &options).unwrap();
    assert_eq!(set.kind, Some(FrfKind::Receptance));
    assert_eq!(
        warnings,
        ["a.uff says mobility, you say receptance: taken as receptance"]
    );
    let unknown = vec![document("b.uff", vec![other.clone()])];
    assert_eq!(
        merge(unknown, &ReadOptions::default()).unwrap().0.kind,
        None
    );
    let volts = Function {
        reference_unit: ReferenceUnit::Volt,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let mixed = vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0), volts])];
    assert!(merge(mixed, &ReadOptions::default())
        .unwrap_err()
        .to_string()
        .contains("found V"));
}

#[test]
fn values_come_out_in_si_with_the_right_sign_and_precision() {
    let single = Function {
        scale_to_si: 1e-3,
        abscissa_to_si: 1000.0,
        ..function(
            4,
            "1:+Z",
            "9:+Z",
            Ordinate::Complex32(vec![Complex32::new(2.0, 3.0); 3]),
        )
    };
    let options = ReadOptions {
        time_sign: TimeSign::Minus,
        ..ReadOptions::default()
    };
    let (set, _) = merge(vec![document("a.uff", vec![single.clone()])], &options).unwrap();
    assert_eq!(set.frequency_hz[1], 1500.0);
    let FrfValues::F32(values) = &set.values else {
        panic!("single precision must stay")
    };
    assert_eq!(values[[0, 0, 0]], Complex32::new(0.002, -0.003));
    let double = Function {
        abscissa_to_si: 1000.0,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let (set, _) = merge(
        vec![document("a.uff", vec![single, double])],
        &ReadOptions::default(),
    )
    .unwrap();
    assert!(matches!(set.values, FrfValues::F64(_)));
    let real = function(
        4,
        "1:+Z",
        "9:+Z",
        Ordinate::Real64(vec![1.0, f64::INFINITY, 2.0]),
    );
    let (set, warnings) =
        merge(vec![document("a.uff", vec![real])], &ReadOptions::default()).unwrap();
    assert!(set.values.get(0, 0, 1).im.is_nan());
    let text = warnings.join("\n");
    assert!(
        text.contains("real values") && text.contains("1 values are not finite"),
        "{text}"
    );
}

#[test]
fn coherence_finds_its_frf_and_other_functions_go_along() {
    let coherence =
        |response: &str| function(6, response, "9:+Z", Ordinate::Real32(vec![0.5, 1.2, -0.5]));
    let time = function(1, "1:+Z", "0:S", Ordinate::Real64(vec![1.0]));
    let functions = vec![
        frf("1:+Z", "9:+Z", 1.0),
        coherence("1:+Z"),
        coherence("7:+Z"),
        time.clone(),
    ];
    let contents: Contents =
        assemble(vec![document("a.uff", functions)], &ReadOptions::default()).unwrap();
    let set = contents.frf.unwrap();
    let gamma = set.coherence.unwrap();
    assert_eq!(gamma[[0, 0, 0]], 0.5);
    assert!(gamma[[0, 0, 1]].is_nan() && gamma[[0, 0, 2]].is_nan());
    let text = crate::words(&contents.warnings).join("\n");
    assert!(
        text.contains("outside 0 to 1 on 2 lines") && text.contains("the first is (7:+Z, 9:+Z)"),
        "{text}"
    );
    assert_eq!(contents.functions, vec![time.clone(), coherence("7:+Z")]);
    let only_time = assemble(
        vec![document("a.uff", vec![time.clone()])],
        &ReadOptions::default(),
    )
    .unwrap();
    assert!(only_time.frf.is_none());
    assert_eq!(only_time.functions, vec![time]);
}

#[test]
fn geometry_is_merged_and_must_not_contradict_itself() {
    let with_nodes = |name: &str, response: &str, nodes: &[(u64, f64)]| Document {
        geometry: Geometry {
            nodes: nodes
                .iter()
                .map(|&(label, x)| Node {
                    label,
                    xyz_m: [x, 0.0, 0.0],
                })
                .collect(),
            lines: vec![vec![1, 2]],
            faces: vec![],
        },
        ..document(name, vec![frf(response, "9:+Z", 1.0)])
    };
    let documents = vec![
        with_nodes("a.uff", "1:+Z", &[(1, 0.1), (2, 0.2)]),
        with_nodes("b.uff", "5:+Z", &[(2, 0.2 + 1e-8), (3, 0.3)]),
    ];
    let (set, warnings) = merge(documents, &ReadOptions::default()).unwrap();
    assert_eq!(
        set.geometry
            .nodes
            .iter()
            .map(|node| node.label)
            .collect::<Vec<_>>(),
        [1, 2, 3]
    );
    assert_eq!(set.geometry.lines.len(), 1);
    assert_eq!(warnings, ["1 response nodes have no coordinates: 5"]);
    let documents = vec![
        with_nodes("a.uff", "1:+Z", &[(2, 0.2)]),
        with_nodes("b.uff", "5:+Z", &[(2, 0.3)]),
    ];
    let text = merge(documents, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("b.uff") && text.contains("node 2 stands at two places"),
        "{text}"
    );
}

#[test]
fn a_damaged_dataset_stops_the_reading_unless_lenient() {
    let damaged = || {
        let mut document = document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0)]);
        document
            .errors
            .push(Error::bad_data("cut short").dataset(58).at_line(99));
        document
            .warnings
            .push(chladni_frf::Finding::note("odd", "odd"));
        vec![document]
    };
    let error = merge(damaged(), &ReadOptions::default()).unwrap_err();
    assert_eq!(
        (error.line, error.file),
        (Some(99), Some(PathBuf::from("a.uff")))
    );
    let (_, warnings) = merge(
        damaged(),
        &ReadOptions {
            lenient: true,
            ..ReadOptions::default()
        },
    )
    .unwrap();
    assert!(
        warnings[0].starts_with("left out: a.uff: dataset 58: line 99: cut short"),
        "{warnings:?}"
    );
    assert_eq!(warnings[1], "a.uff: odd");
}

#[test]
fn sets_and_functions_merge() {
    let (set, _) = merge(
        vec![document(
            "a.uff",
            vec![frf("1:+Z", "101:+Z", 1.0), frf("2:+Z", "101:+Z", 2.0)],
        )],
        &ReadOptions::default(),
    )
    .unwrap();
    let hdf5 = Document {
        frf: Some(set.clone()),
        format: FileFormat::Hdf5,
        ..document("a.h5", Vec::new())
    };
    let (merged, warnings) = merge(
        vec![
            hdf5,
            document(
                "b.uff",
                vec![frf("1:+Z", "102:+Z", 3.0), frf("2:+Z", "102:+Z", 4.0)],
            ),
        ],
        &ReadOptions::default(),
    )
    .unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(merged.values.dim(), (2, 2, 3));
    assert_eq!(merged.values.get(1, 0, 0), set.values.get(1, 0, 0));
    assert_eq!(merged.values.get(1, 1, 0).re, 4.0);
}

#[test]
fn a_grid_that_is_nearly_empty_is_refused_before_it_is_allocated() {
    let many = |k: u64| Function {
        ordinate: Ordinate::Complex32(vec![Complex32::new(1.0, 1.0); 64]),
        ..frf(
            &format!("{}:+Z", k + 1),
            &format!("{}:+Z", 100_000 + k),
            1.0,
        )
    };
    let error = merge(
        vec![document("a.uff", (0..4000).map(many).collect())],
        &ReadOptions::default(),
    )
    .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("4000 FRFs for 4000 responses and 4000 references"),
        "{error}"
    );
}
