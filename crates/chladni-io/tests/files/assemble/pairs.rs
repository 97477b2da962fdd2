//! The pairs of a set: single-reference surveys, duplicates, gaps.

use super::documents::{document, frf, function, merge, names};
use chladni_frf::{ErrorKind, FrfSet, FrfValues, Severity};
use chladni_io::{assemble, Document, Duplicates, Function, Ordinate, ReadOptions};
use ndarray::Array3;
use num_complex::{Complex32, Complex64};

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

/// A file that names its DOFs, and a copy under another name.
fn copies() -> Vec<Document> {
    let file = |name: &str| document(name, vec![frf("1:+Z", "9:+Z", 1.0)]);
    let original = file("a.uff");
    let copy = Document {
        checksum: original.checksum.clone(),
        ..file("b.uff")
    };
    vec![original, copy]
}

#[test]
fn copies_of_which_one_is_kept_are_a_note() {
    let told = |duplicates: Duplicates, references: Vec<u64>| {
        let options = ReadOptions {
            duplicates,
            references,
            ..ReadOptions::default()
        };
        let findings = assemble(copies(), &options).unwrap().warnings;
        let mut findings = findings.into_iter();
        let finding = findings.find(|finding| finding.code == "same-files");
        finding.unwrap()
    };
    for duplicates in [Duplicates::First, Duplicates::Last] {
        let finding = told(duplicates, Vec::new());
        assert_eq!(finding.severity, Severity::Note, "{finding}");
        assert!(finding.contains("b.uff of a.uff"), "{finding}");
        assert!(
            finding.contains("one FRF of each pair is kept"),
            "{finding}"
        );
    }
    // a mean of copies has error bars of two measurements
    let mean = told(Duplicates::Mean, Vec::new());
    assert_eq!(mean.severity, Severity::Caution, "{mean}");
    // of other DOFs both are kept, whatever is said about pairs
    let apart = told(Duplicates::First, vec![9, 10]);
    assert_eq!(apart.severity, Severity::Caution, "{apart}");
    assert!(apart.contains("two measurements"), "{apart}");
}

#[test]
fn copies_of_a_set_without_responses_are_told() {
    let one = vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0)])];
    let (set, _) = merge(one, &ReadOptions::default()).unwrap();
    let empty = FrfSet {
        values: FrfValues::F64(Array3::zeros((0, 1, 3))),
        responses: Vec::new(),
        ..set
    };
    let sets = copies().into_iter().map(|copy| Document {
        frf: Some(empty.clone()),
        functions: Vec::new(),
        ..copy
    });
    let contents = assemble(sets.collect(), &ReadOptions::default()).unwrap();
    assert!(contents.frf.is_none());
    let findings = contents.warnings;
    let told = findings.iter().find(|finding| finding.code == "same-files");
    let told = told.unwrap();
    assert_eq!(told.severity, Severity::Note);
    assert!(told.text.ends_with("b.uff of a.uff"), "{told}");
}

#[test]
fn a_pair_of_two_copies_is_refused_with_that_word() {
    let refused = |documents: Vec<Document>| {
        let error = merge(documents, &ReadOptions::default()).unwrap_err();
        (error.message.clone(), error.to_string())
    };
    let (message, text) = refused(copies());
    assert!(
        message.ends_with("2 times, and the two files are copies of each other"),
        "{text}"
    );
    assert!(
        text.contains("a.uff line 12 and b.uff line 12") && text.contains("only one of these two"),
        "{text}"
    );
    // another measurement of the pair, before both
    let mut three = vec![document("c.uff", vec![frf("1:+Z", "9:+Z", 2.0)])];
    three.extend(copies());
    let (message, text) = refused(three);
    assert!(
        message.ends_with("3 times, and two of the files are copies of each other"),
        "{text}"
    );
    assert!(text.contains("found a.uff line 12 and b.uff"), "{text}");
    let mut others = copies();
    others.truncate(1);
    others.push(document("c.uff", vec![frf("1:+Z", "9:+Z", 2.0)]));
    let (message, text) = refused(others);
    assert!(message.ends_with("2 times"), "{text}");
    assert!(!text.contains("only one"), "{text}");
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
