//! The committed panels say what their README says.

use chladni_plate::{simulate, Panel};
use std::path::{Path, PathBuf};

/// The default of `--memory`.
const MEMORY: u64 = 2 << 30;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../fixtures")
        .join(name)
}

#[test]
fn the_panel_file_writes_out_all_defaults() {
    assert_eq!(
        Panel::read(&fixture("panel.toml"), MEMORY).unwrap(),
        Panel::default()
    );
}

#[test]
fn the_second_panel_adds_its_driving_points_only() {
    let mut expected = Panel::default();
    expected.responses.at_references = true;
    let panel = Panel::read(&fixture("panel-driving-points.toml"), MEMORY).unwrap();
    assert_eq!(panel, expected);
    let simulation = simulate(&panel, None, None).unwrap();
    assert_eq!(simulation.frf.values.dim(), (111, 34, 1997));
    assert_eq!(
        (
            simulation.frf.frequency_hz[0],
            simulation.frf.frequency_hz[1996]
        ),
        (2.0, 1000.0)
    );
    assert_eq!(simulation.truth.in_band_modes().count(), 25);
    assert!(simulation.findings.is_empty());
}

#[test]
fn what_is_no_panel_is_refused_with_its_name() {
    let missing = Panel::read(Path::new("no-such-panel.toml"), MEMORY).unwrap_err();
    assert_eq!(missing.kind.exit_code(), 66);
    let readme = Panel::read(&fixture("README.md"), MEMORY).unwrap_err();
    assert_eq!(readme.kind.exit_code(), 65);
    assert!(
        readme.to_string().contains("README.md") && readme.to_string().contains("TOML"),
        "{readme}"
    );
    let small = Panel::read(&fixture("panel.toml"), 1 << 20).unwrap_err();
    assert!(small.to_string().contains("`memory`"), "{small}");
}
