//! Checks of a scene, of its threshold table and of a model with any bytes; shared by the
//! seeded mutations and by the targets that coverage guides (`fuzz/`).

use chladni_frf::{ComplexVector, Error, ErrorKind, ModalModel, Node};
use chladni_io::read_model;
use chladni_render::{render, MethodChoice, RenderOptions, Scene, Threshold, ThresholdTable};
use num_complex::Complex64;
use std::path::Path;
use std::sync::LazyLock;

/// Between a scene and its table.
pub const SEPARATOR: &[u8] = b"\n---\n";
/// Name of the table, in the scene and as a file.
pub const TABLE: &str = "table.csv";
/// Methods with kernels of their own, quick enough to be asked a million times.
const METHODS: [&str; 3] = ["fast", "modal", "tikhonov"];

/// One mode on four responses, 100 mm apart, with two actuators.
pub static SMALL: LazyLock<ModalModel> = LazyLock::new(|| {
    let text = include_str!("../../../../fixtures/malformed/base/model.json");
    let mut model: ModalModel = serde_json::from_str(text).unwrap();
    model.responses = [1, 2, 3, 4]
        .map(|node| format!("{node}:+Z").parse().unwrap())
        .to_vec();
    model.references = ["101:+Z", "102:+Z"]
        .map(|dof| dof.parse().unwrap())
        .to_vec();
    model.nodes = [(1, 0.0, 0.0), (2, 0.1, 0.0), (3, 0.0, 0.1), (4, 0.1, 0.1)]
        .map(|(label, x, y)| Node {
            label,
            xyz_m: [x, y, 0.0],
        })
        .to_vec();
    let vector =
        |values: &[f64]| ComplexVector(values.iter().map(|&re| Complex64::new(re, 0.0)).collect());
    let mode = &mut model.modes[0];
    mode.shape = vector(&[1.0, -0.5, 0.3, 0.2]);
    mode.shape_std = vec![0.01; 4];
    mode.participation = vector(&[0.2, -0.1]);
    let mut other = mode.clone();
    other.frequency_hz = 80.0;
    other.shape = vector(&[0.2, 0.9, -0.6, 0.1]);
    other.participation = vector(&[0.1, 0.3]);
    model.modes.push(other);
    model
});

/// Whatever is wrong is said, and is not a bug.
pub fn is_said(error: &Error) {
    assert!(
        !matches!(error.kind, ErrorKind::Internal),
        "a bug of ours: {error}"
    );
    assert!(!error.message.is_empty());
}

/// Renders a scene on a small panel: weights, or a complaint.
pub fn rendered(model: &ModalModel, scene: &Scene, method: &str) {
    let options = RenderOptions {
        method: method.parse::<MethodChoice>().unwrap(),
        ..RenderOptions::default()
    };
    match render(model, scene, &options) {
        Ok(rendering) => assert!(rendering
            .weights
            .weights
            .iter()
            .all(|weight| weight.re.is_finite() && weight.im.is_finite())),
        Err(error) => is_said(&error),
    }
}

/// A scene and a table, between them [`SEPARATOR`]: alone with the table and beside it as a
/// file the scene is the same, and it is rendered or refused.
pub fn scene_and_table(path: &Path, bytes: &[u8]) {
    let at = bytes
        .windows(SEPARATOR.len())
        .position(|part| part == SEPARATOR);
    let (scene, table) = match at {
        Some(at) => (&bytes[..at], &bytes[at + SEPARATOR.len()..]),
        None => (bytes, &b""[..]),
    };
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    alone_and_beside(path, &text(scene), &text(table));
}

/// The same of texts; a file is written beside `path`.
pub fn alone_and_beside(path: &Path, scene: &str, table: &str) {
    let folder = path.parent().unwrap();
    std::fs::write(folder.join(TABLE), table).unwrap();
    let table = ThresholdTable::parse(table, Path::new(TABLE));
    if let Err(error) = &table {
        is_said(error);
    }
    let table = table.ok();
    match Scene::parse_alone(scene, table.as_slice()) {
        Err(error) => is_said(&error),
        Ok(alone) => {
            let mut beside = Scene::parse(scene, folder).unwrap();
            if let Threshold::Table(table) = &mut beside.threshold {
                table.file = TABLE.into();
            }
            assert_eq!(alone, beside);
            if let Threshold::Table(known) = &alone.threshold {
                assert_eq!(Some(known), table.as_ref());
            }
            for method in METHODS {
                rendered(&SMALL, &alone, method);
            }
        }
    }
}

/// Bytes as a model: refused, or rendered.
pub fn model(path: &Path, bytes: &[u8]) {
    /// The place of the first response is hot.
    const SCENE: &str = "frequency_hz = 60.0\n[zones]\ngrid = [2, 1]\nhot = [1]\n\
                         cells_m = [-0.05, -0.05, 0.15, 0.15]\ntransition_m = 0.0\n";
    std::fs::write(path, bytes).unwrap();
    match read_model(path) {
        Err(error) => is_said(&error),
        Ok(model) => {
            let scene = Scene::parse_alone(SCENE, &[]).unwrap();
            for method in METHODS {
                rendered(&model, &scene, method);
            }
        }
    }
}
