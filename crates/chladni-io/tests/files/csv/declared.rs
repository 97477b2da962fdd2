//! DOFs and sample rates that the files do not state.

use super::reading::{c, read, read_with};
use chladni_frf::Severity;
use chladni_io::{read_document, read_frf, DeclaredDofs, ReadOptions};
use std::path::PathBuf;

/// Files of one FRF each in a folder of their own, in this order.
fn written(texts: &[&str]) -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let path = |(k, text): (usize, &&str)| {
        let path = folder.path().join(format!("p{}.csv", k + 1));
        std::fs::write(&path, text).unwrap();
        path
    };
    let paths = texts.iter().enumerate().map(path).collect();
    (folder, paths)
}

const ONE: &str = "f,re,im\n1,2,3\n2,4,5\n";

#[test]
fn a_file_without_dofs_names_its_assumption_and_no_driving_point() {
    let (set, warnings) = read("f,re,im\n1,2,3\n2,2,3\n").unwrap();
    assert_eq!(
        (set.responses[0].to_string(), set.references[0].to_string()),
        ("1:+Z".into(), "1:S".into())
    );
    assert!(!set.responses[0].same_axis(set.references[0]));
    let text = warnings.join("\n");
    assert!(
        text.contains("taken as 1:+Z") && text.contains("taken as 1:S; say it with `reference N`"),
        "{text}"
    );
    let options = ReadOptions {
        references: vec![21],
        ..ReadOptions::default()
    };
    assert_eq!(
        read_with("f,re,im\n1,2,3\n2,2,3\n", &options)
            .unwrap()
            .0
            .references[0]
            .to_string(),
        "21:+Z"
    );
    let (set, _) = read("# response = 5:-X\n# reference = 8:+Y\nf,re,im\n1,2,3\n2,2,3\n").unwrap();
    assert_eq!(
        (set.responses[0].to_string(), set.references[0].to_string()),
        ("5:-X".into(), "8:+Y".into())
    );
}

#[test]
fn remarks_of_other_dofs_than_the_columns_are_not_used_with_a_word() {
    let text = "# response = 1:+Z\n# reference = 2:+Z\nf,5:+Z/6:+Z re,5:+Z/6:+Z im\n1,1,2\n2,1,3\n";
    let (set, warnings) = read(text).unwrap();
    assert_eq!(set.responses[0].to_string(), "5:+Z");
    let said = warnings.join("\n");
    for words in [
        "line 1: the remark response says 1:+Z, the table 5:+Z",
        "line 2: the remark reference says 2:+Z, the table 6:+Z",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let same = text.replace("1:+Z\n", "5:+Z\n").replace("= 2:+Z", "= 6:+Z");
    let said = read(same).unwrap().1.join("\n");
    assert!(!said.contains("remark"), "{said}");
}

#[test]
fn files_of_one_frf_are_numbered_in_natural_order() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("point_1.csv", 1), ("point_2.csv", 2), ("point_10.csv", 10)] {
        std::fs::write(
            folder.path().join(name),
            format!("f,re,im\n1,{value},0\n2,{value},1\n"),
        )
        .unwrap();
    }
    let expected = [1.0, 2.0, 10.0];
    for input in [
        folder.path().to_path_buf(),
        folder.path().join("point_*.csv"),
    ] {
        let (set, sources, _) = read_frf(&[input], &ReadOptions::default()).unwrap();
        assert_eq!(
            (0..3)
                .map(|i| set.values.get(i, 0, 0).re)
                .collect::<Vec<_>>(),
            expected
        );
        assert_eq!(set.responses[2].to_string(), "3:+Z");
        assert_eq!(sources.len(), 3);
    }
}

#[test]
fn a_file_given_twice_and_a_copy_under_another_name_are_told() {
    let (_folder, paths) = written(&[ONE, "f,re,im\n1,2,3\n2,4,6\n", ONE]);
    let told = |paths: &[PathBuf]| {
        let (set, _, findings) = read_frf(paths, &ReadOptions::default()).unwrap();
        let mut findings = findings.into_iter();
        let of_copies = findings.find(|finding| finding.code == "same-files");
        (set.responses.len(), of_copies)
    };
    assert_eq!(told(&paths[..2]), (2, None));
    for (other, words) in [(0, "p1.csv of p1.csv"), (2, "p3.csv of p1.csv")] {
        let (responses, finding) = told(&[paths[0].clone(), paths[other].clone()]);
        let finding = finding.unwrap();
        assert!(finding.contains(words), "{finding}");
        assert!(finding.contains("leave copies out"), "{finding}");
        assert_eq!((responses, finding.severity), (2, Severity::Caution));
    }
}

#[test]
fn a_roving_hammer_is_declared_by_response_and_references() {
    let (_folder, paths) = written(&[ONE; 3]);
    let options = ReadOptions {
        responses: vec![5],
        references: vec![1, 2, 5],
        ..ReadOptions::default()
    };
    let (set, _, warnings) = read_frf(&paths, &options).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(set.values.dim(), (1, 3, 2));
    assert_eq!(set.responses[0].to_string(), "5:+Z");
    assert_eq!(set.references[2].to_string(), "5:+Z");
    assert!(
        !warnings.join("\n").contains("response DOF"),
        "{warnings:?}"
    );
}

#[test]
fn a_guessed_response_is_no_driving_point() {
    let (_folder, paths) = written(&[ONE; 3]);
    let options = ReadOptions {
        references: vec![1, 2, 3],
        ..ReadOptions::default()
    };
    let (set, ..) = read_frf(&paths, &options).unwrap();
    for response in &set.responses {
        assert!(set
            .references
            .iter()
            .all(|reference| !response.same_axis(*reference)));
    }
}

#[test]
fn a_list_declares_the_dofs_of_every_frf() {
    let wide = "f,re1,im1,re2,im2\n1,2,3,4,5\n2,2,3,4,5\n";
    let (_folder, paths) = written(&[wide, ONE]);
    let with = |list: &str| ReadOptions {
        dofs: DeclaredDofs::parse(list).unwrap(),
        ..ReadOptions::default()
    };
    let (set, _, warnings) = read_frf(&paths, &with("5Z,101Z\n5Z,102Z\n5Z,103Z\n")).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(set.values.dim(), (1, 3, 2));
    assert_eq!(set.values.get(0, 1, 0), c(4.0, 5.0));
    assert_eq!(set.references[2].to_string(), "103:+Z");
    assert!(!warnings.join("\n").contains("DOF"), "{warnings:?}");
    let by_file = "file,response,reference\np2.csv,7X,9Z\np1.csv,5Z,9Z\np1.csv,6Z,9Z\n";
    let (set, ..) = read_frf(&paths, &with(by_file)).unwrap();
    assert_eq!(set.responses[2].to_string(), "7:+X");
    for list in [
        "5Z,101Z\n",
        "5Z,101Z\n5Z,102Z\n5Z,103Z\n5Z,104Z\n",
        "p9.csv,1Z,2Z\n",
    ] {
        let error = read_frf(&paths, &with(list)).unwrap_err().to_string();
        assert!(error.contains("dofs"), "{error}");
    }
}

#[test]
fn hammer_records_need_no_time_column_and_units_may_stand_in_names() {
    let text = "force_N,acc_m_s2,Velocity (mm/s),weight\n1,2,3000,4\n5,6,7000,8\n";
    let (_folder, paths) = written(&[text]);
    let options = ReadOptions {
        sample_rate_hz: Some(48_000.0),
        ..ReadOptions::default()
    };
    let document = read_document(&paths[0], &options).unwrap();
    let channels: Vec<_> = document
        .functions
        .iter()
        .map(|function| {
            (
                function.response.to_string(),
                function.axes[1].unit.clone(),
                function.scale_to_si,
            )
        })
        .collect();
    let expected = [
        ("1:S", "N", 1.0),
        ("2:S", "m/s2", 1.0),
        ("3:S", "mm/s", 1e-3),
        ("4:S", "", 1.0),
    ];
    assert_eq!(channels.len(), expected.len());
    for ((dof, unit, scale), expected) in channels.iter().zip(expected) {
        assert_eq!((dof.as_str(), unit.as_str(), *scale), expected);
    }
    let warnings = crate::words(&document.warnings).join("\n");
    assert!(
        warnings.contains("column 4: no unit") && !warnings.contains("column 3"),
        "{warnings}"
    );
    // without the rate nobody takes the force for a frequency
    let error = read_document(&paths[0], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("`sample_rate HZ`"), "{error}");
}
