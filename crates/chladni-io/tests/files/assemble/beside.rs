//! The content beside the FRFs: coherence, geometry, other functions, damaged datasets, sets.

use super::documents::{document, frf, function, merge};
use chladni_frf::{Error, Geometry, Node};
use chladni_io::{assemble, Contents, Document, FileFormat, Ordinate, ReadOptions};
use std::path::PathBuf;

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
