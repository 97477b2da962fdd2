//! A JSON file of another kind than the one that is read.

use chladni_frf::{Error, MODEL_FORMAT};
use serde::Deserialize;

/// `format` of the files of this crate.
pub(crate) const WEIGHTS: &str = "chladni.weights";
pub(crate) const CALIBRATION: &str = "chladni.calibration";
pub(crate) const SIGNAL: &str = "chladni.signal";

/// Kinds of files by their `format`.
const KINDS: [(&str, &str); 4] = [
    (MODEL_FORMAT, "a model"),
    (WEIGHTS, "a weights file"),
    (CALIBRATION, "a calibration file"),
    (SIGNAL, "the sidecar of a signal"),
];

/// The part of a file that names its kind.
#[derive(Deserialize)]
struct Header {
    format: String,
}

/// The error of a JSON `text` that says of itself to be of another known kind than `format`.
pub(crate) fn other_kind(text: &str, format: &str, version: u32) -> Option<Error> {
    let found = serde_json::from_str::<Header>(text).ok()?.format;
    let name = |format: &str| {
        KINDS
            .iter()
            .find(|kind| kind.0 == format)
            .map(|kind| kind.1)
    };
    let (is, wanted) = (name(&found)?, name(format)?);
    (found != format).then(|| {
        Error::bad_data(format!("{is}, not {wanted}"))
            .field("format")
            .found(&found)
            .expected(format!("{format} version {version}"))
    })
}
