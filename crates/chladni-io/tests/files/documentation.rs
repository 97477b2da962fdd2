//! The examples of docs/formats.md are read as the page says.
use chladni_frf::FrfKind;
use chladni_io::{read_frf, ReadOptions};
use num_complex::Complex64;

const PAGE: &str = include_str!("../../../../docs/formats.md");

/// Blocks of one language, in the order of the page.
fn blocks(language: &str) -> Vec<&'static str> {
    let fence = format!("```{language}\n");
    PAGE.split(fence.as_str())
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap())
        .collect()
}

#[test]
fn both_table_layouts_hold_the_same_frfs() {
    let folder = tempfile::tempdir().unwrap();
    // the page's other tables are no FRFs
    let mut tables = blocks("csv");
    tables.retain(|table| table.contains("frf_kind"));
    assert_eq!(tables.len(), 2);
    for (name, table) in ["long.csv", "wide.csv"].iter().zip(tables) {
        let path = folder.path().join(name);
        std::fs::write(&path, table).unwrap();
        let (set, _, warnings) = read_frf(&[path], &ReadOptions::default()).unwrap();
        let warnings = crate::words(&warnings);
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        assert_eq!(set.kind, Some(FrfKind::Mobility), "{name}");
        assert_eq!(set.frequency_hz.to_vec(), [10.0, 10.5], "{name}");
        let names =
            |dofs: &[chladni_frf::Dof]| dofs.iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(
            (names(&set.responses), names(&set.references)),
            (vec!["1:+Z".into(), "2:+Z".into()], vec!["101:+Z".into()]),
            "{name}"
        );
        for (at, expected) in [
            ((0, 0, 0), Complex64::new(0.0012, -0.0003)),
            ((1, 0, 1), Complex64::new(-0.0008, 0.0002)),
        ] {
            let found = set.values.get(at.0, at.1, at.2);
            assert!(
                (found - expected).norm() < 1e-15,
                "{name}: {found} at {at:?}"
            );
        }
    }
}
