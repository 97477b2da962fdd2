//! The scene file: defaults, and what is said about every mistake.

use chladni_frf::ErrorKind;
use chladni_render::{Scene, Threshold, ZoneLayout};
use std::path::Path;

const MINIMAL: &str = "frequency_hz = 300\n[zones]\ngrid = [2, 2]\nhot = [1]\n";

fn parse(text: &str) -> Result<Scene, chladni_frf::Error> {
    Scene::parse(text, Path::new("no/such/folder"))
}

#[test]
fn what_a_scene_leaves_out_has_its_default() {
    let scene = parse(MINIMAL).unwrap();
    assert_eq!((scene.threshold, scene.limen_db), (Threshold::Paper, 2.0));
    assert_eq!(
        (scene.zones.area_m, scene.zones.transition_m),
        (None, 0.010)
    );
    assert_eq!(
        (
            scene.actuators.only,
            scene.actuators.max_force_n,
            scene.actuators.max_voltage_v
        ),
        (None, None, None)
    );
}

#[test]
fn the_scene_of_the_contract_is_read_key_by_key() {
    let text = r#"
frequency_hz = 300.0
[threshold]
profile = "press-flat"
limen_db = 3
[zones]
grid = [3, 2]
hot = [1, 4]
area_m = [0.034, 0.025, 0.234, 0.145]
cells_m = [0.0, 0.0, 0.268, 0.170]
transition_m = 0.02
[actuators]
use = ["101:+Z", "102Z"]
max_force_n = 0.05
"#;
    let scene = parse(text).unwrap();
    assert_eq!(
        (scene.threshold.clone(), scene.limen_db),
        (Threshold::PressFlat, 3.0)
    );
    let ZoneLayout::Grid { grid, hot, cells_m } = &scene.zones.layout else {
        panic!("a grid")
    };
    assert_eq!(
        (*grid, hot.as_slice(), *cells_m),
        ([3, 2], &[1, 4][..], Some([0.0, 0.0, 0.268, 0.170]))
    );
    assert_eq!(
        scene.actuators.only.as_ref().unwrap()[1].to_string(),
        "102:+Z"
    );
    assert_eq!(scene.actuators.max_force_n, Some(0.05));
    let limits = scene.limits().unwrap();
    assert!((20.0 * (limits.hot_m_per_s / limits.cold_m_per_s).log10() - 6.0).abs() < 1e-12);
}

#[test]
fn the_limits_of_the_seed_paper_are_2_db_on_either_side_of_0_2_mm_per_s() {
    let limits = parse(MINIMAL).unwrap().limits().unwrap();
    assert!(
        (limits.hot_m_per_s - 0.252e-3).abs() < 0.5e-6
            && (limits.cold_m_per_s - 0.159e-3).abs() < 0.5e-6
    );
}

#[test]
fn the_committed_scene_can_be_read() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/scene-corner.toml");
    let scene = Scene::read(&file).unwrap();
    assert_eq!(
        (scene.name().as_str(), scene.frequency_hz),
        ("scene-corner.toml", 300.0)
    );
}

/// Replaces the first occurrence of `old`, which must be there.
fn with(old: &str, new: &str) -> String {
    assert!(MINIMAL.contains(old));
    MINIMAL.replacen(old, new, 1)
}

#[test]
fn every_mistake_is_named_with_its_line_and_what_belongs_there() {
    let cases = [
        (with("hot", "hott"), 4, "zones.hott", "did you mean `hot`"),
        (
            with("frequency_hz", "frequency"),
            1,
            "frequency",
            "did you mean `frequency_hz`",
        ),
        (
            with("[zones]", "max_force_n = 1\n[zones]"),
            2,
            "max_force_n",
            "belongs into [actuators]",
        ),
        (
            with("[zones]", "[zones]\nlimen_db = 2"),
            3,
            "zones.limen_db",
            "belongs into [threshold]",
        ),
        (
            with("300", "\"300\""),
            1,
            "frequency_hz",
            "a number between -1e15 and 1e15",
        ),
        (
            with("300", "nan"),
            1,
            "frequency_hz",
            "a number between -1e15 and 1e15",
        ),
        (with("300", "0"), 1, "frequency_hz", "greater than 0"),
        (
            with("300", "[330.0, 330.001]"),
            1,
            "frequency_hz",
            "330 and 330.001 Hz beat",
        ),
        (
            with("[zones]", "points_m = [[0, 0]]\n[zones]"),
            2,
            "points_m",
            "belongs under [[zones.polygon]]",
        ),
        (
            format!("{MINIMAL}[drift]\nfrequency_relative = 5\n"),
            6,
            "drift.frequency_relative",
            "a part from 0 to 1",
        ),
        (
            with("frequency_hz = 300\n", ""),
            1,
            "frequency_hz",
            "drive frequency in Hz",
        ),
        (with("[1]", "[5]"), 4, "zones.hot[1]", "from 1 to 4"),
        (with("[1]", "[1, 0]"), 4, "zones.hot[2]", "from 1 to 4"),
        (with("[1]", "[]"), 4, "zones.hot", "no cell is hot"),
        (
            with("hot = [1]\n", ""),
            2,
            "zones.hot",
            "a list of hot cells",
        ),
        (with("[2, 2]", "[2]"), 3, "zones.grid", "[columns, rows]"),
        (
            with("[2, 2]", "[2, 2.5]"),
            3,
            "zones.grid[2]",
            "a whole number",
        ),
        (
            with("[2, 2]", "[4000000000, 4000000000]"),
            3,
            "zones.grid",
            "too many cells",
        ),
        (
            with("grid = [2, 2]", "grid = [2, 2]\narea_m = [1, 0, 0, 1]"),
            4,
            "zones.area_m",
            "an empty rectangle",
        ),
        (
            with("grid = [2, 2]", "grid = [2, 2]\narea_m = [0, 0, 1]"),
            4,
            "zones.area_m",
            "wrong number of entries",
        ),
        (
            with("grid = [2, 2]", "grid = [2, 2]\ntransition_m = -0.01"),
            4,
            "zones.transition_m",
            "must not be negative",
        ),
        (
            format!("{MINIMAL}[threshold]\nprofile = \"clasic\"\n"),
            6,
            "threshold.profile",
            "did you mean `classic`",
        ),
        (
            format!("{MINIMAL}[threshold]\nprofile = \"nofile.csv\"\n"),
            6,
            "threshold.profile",
            "no such file",
        ),
        (
            format!("{MINIMAL}[actuators]\nuse = \"some\"\n"),
            6,
            "actuators.use",
            "\"all\" or a list",
        ),
        (
            format!("{MINIMAL}[actuators]\nuse = [\"101\"]\n"),
            6,
            "actuators.use[1]",
            "no DOF",
        ),
        (
            format!("{MINIMAL}[actuators]\nuse = []\n"),
            6,
            "actuators.use",
            "no actuator is left",
        ),
        (
            format!("{MINIMAL}[actuators]\nmax_force_n = 0\n"),
            6,
            "actuators.max_force_n",
            "greater than zero",
        ),
        (
            format!("{MINIMAL}[[zones.polygon]]\nkind = \"hot\"\npoints_m = []\n"),
            5,
            "zones.polygon",
            "either a grid or polygons",
        ),
    ];
    for (text, line, field, message) in cases {
        let error = parse(&text).expect_err(&text);
        let shown = error.to_string();
        assert_eq!(error.kind, ErrorKind::BadData, "{shown}");
        assert!(shown.contains(message), "`{message}` is not in: {shown}");
        assert_eq!(
            (error.line, error.field.as_deref()),
            (Some(line), Some(field)),
            "{shown}"
        );
    }
}

#[test]
fn mistakes_in_polygons_are_named() {
    let polygon = |kind: &str, points: &str| {
        format!(
            "frequency_hz = 300\n[zones]\n[[zones.polygon]]\nkind = \"{kind}\"\npoints_m = \
                 {points}\n"
        )
    };
    for (text, line, message) in [
        (
            polygon("warm", "[[0, 0], [1, 0], [0, 1]]"),
            4,
            "\"hot\", \"cold\" or \"ignore\"",
        ),
        (
            polygon("cold", "[[0, 0], [1, 0], [0, 1]]"),
            3,
            "no polygon is hot",
        ),
        (
            polygon("hot", "[[0, 0], [1, 1], [2, 2]]"),
            5,
            "an empty polygon",
        ),
        (polygon("hot", "[[0, 0], [1, 0]]"), 5, "an empty polygon"),
        (
            polygon("hot", "[[0, 0], [1, 1], [1, 0], [0, 1]]"),
            5,
            "a polygon whose sides cross",
        ),
        (
            polygon("hot", "[[0, 0], [1, 0], [0]]"),
            5,
            "[x, y] in metres",
        ),
        (
            polygon("hot", "[[0, 0], [1, 0], [0, inf]]"),
            5,
            "a number between -1e15 and 1e15",
        ),
        (
            polygon("hot", "[[0, 0], [1, 0], [0, 1]]").replace("[zones]", "[zones]\nhot = [1]"),
            3,
            "this scene has polygons",
        ),
        (
            polygon("hot", "[[0, 0], [1, 0], [0, 1]]\nkinds = 1"),
            6,
            "did you mean `kind`",
        ),
    ] {
        let error = parse(&text).expect_err(&text);
        assert!(
            error.to_string().contains(message),
            "`{message}` is not in: {error}"
        );
        assert_eq!(error.line, Some(line), "{error}");
    }
}

#[test]
fn broken_toml_is_reported_with_its_line() {
    let error = parse("frequency_hz = 300\n[zones\n").unwrap_err();
    assert_eq!(error.line, Some(2), "{error}");
    assert!(error.message.contains("no TOML"));
}

#[test]
fn a_missing_scene_is_no_input() {
    let error = Scene::read(Path::new("no/such/scene.toml")).unwrap_err();
    assert_eq!(error.kind, ErrorKind::NoInput);
    assert!(error.to_string().contains("scene.toml"));
}

#[test]
fn a_frequency_without_a_threshold_is_refused_when_limits_are_asked_for() {
    let scene = parse(&format!(
        "{}[threshold]\nprofile = \"classic\"\n",
        with("300", "1000")
    ))
    .unwrap();
    assert!(scene
        .limits()
        .unwrap_err()
        .to_string()
        .contains("no threshold known"));
}

#[test]
fn drift_levels_and_effort_are_read() {
    let text = "frequency_hz = 300\n[zones]\n[[zones.polygon]]\nkind = \"hot\"\nlevel_db = 3\npoints_m = [[0,0],[0.1,0],[0.1,0.1]]\n\
                [actuators]\nmax_effort = 0.02\n[drift]\nfrequency_relative = 2e-3\ndrive_relative = 0.01\n";
    let scene = chladni_render::Scene::parse(text, std::path::Path::new("")).unwrap();
    let drift = scene.drift.unwrap();
    assert_eq!(
        (
            drift.frequency_relative,
            drift.drive_relative,
            drift.loss_factor_relative
        ),
        (2e-3, Some(0.01), 0.1)
    );
    assert_eq!(scene.actuators.max_effort, Some(0.02));
    let unnamed = text.replacen("drive_relative = 0.01\n", "", 1);
    let scene = chladni_render::Scene::parse(&unnamed, std::path::Path::new("")).unwrap();
    assert_eq!(scene.drift.unwrap().drive_relative, None);
    for (old, new, message) in [
        ("drive_relative", "drive_relativ", "drive_relative"),
        ("= 0.01", "= -1", "0"),
        (
            "\"hot\"\nlevel_db = 3",
            "\"cold\"\nlevel_db = 3",
            "only hot polygons have a level",
        ),
    ] {
        let error =
            chladni_render::Scene::parse(&text.replacen(old, new, 1), std::path::Path::new(""))
                .unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }
}
