//! Reading a JSON file of one kind, and the error where it is of another.

use chladni_frf::{Error, Result};
use chladni_text::{json_error_in, json_format, json_kind};
use serde::de::DeserializeOwned;

/// `format` of the files of this crate.
pub(crate) const WEIGHTS: &str = "chladni.weights";
pub(crate) const CALIBRATION: &str = "chladni.calibration";
pub(crate) const SIGNAL: &str = "chladni.signal";

/// The file that a JSON `text` holds.
///
/// * `wrong`: what another text is not, as in "not a weights file"
/// * `again`: what to give in its place
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] with the line: no JSON, a missing field; a text that says of
/// itself to be of another known kind is called by that.
pub(crate) fn parse_as<T: DeserializeOwned>(
    text: &str,
    (format, version): (&str, u32),
    wrong: &str,
    again: &str,
) -> Result<T> {
    serde_json::from_str(text).map_err(|error| {
        other_kind(text, format, version)
            .unwrap_or_else(|| json_error_in(text, wrong, &error))
            .help(again)
    })
}

/// The error of a JSON `text` that says of itself to be of another known kind than `format`.
fn other_kind(text: &str, format: &str, version: u32) -> Option<Error> {
    let found = json_format(text)?;
    let (is, wanted) = (json_kind(&found)?, json_kind(format)?);
    (found != format).then(|| {
        Error::bad_data(format!("{is}, not {wanted}"))
            .field("format")
            .found(&found)
            .expected(format!("{format} version {version}"))
    })
}
