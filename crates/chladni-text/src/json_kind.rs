//! Kinds of the JSON files of this program, by their key `format`.

use chladni_frf::MODEL_FORMAT;
use serde::Deserialize;

/// Names of the kinds by their `format`. Of the last three, JSON is the first line alone.
const KINDS: [(&str, &str); 8] = [
    (MODEL_FORMAT, "a model"),
    ("chladni.weights", "a weights file"),
    ("chladni.calibration", "a calibration file"),
    ("chladni.signal", "the sidecar of a signal"),
    ("chladni.comparison", "a comparison of models"),
    ("chladni.partial", "a partial of a fit in pieces"),
    ("chladni.poles", "poles of a fit in pieces"),
    ("chladni.resume", "the state of an interrupted fit"),
];

/// The part of a file that names its kind.
#[derive(Deserialize)]
struct Header {
    format: String,
}

/// The name of the kind of files with this `format`, as in "a model"; `None` for the files of
/// other programs.
pub fn json_kind(format: &str) -> Option<&'static str> {
    let kind = KINDS.iter().find(|(known, _)| *known == format);
    kind.map(|(_, name)| *name)
}

/// The `format` that a JSON text says of itself to have; `None` for other text.
pub fn json_format(text: &str) -> Option<String> {
    let header = serde_json::from_str::<Header>(text).ok()?;
    Some(header.format)
}
