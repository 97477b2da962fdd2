//! Text files and their names.

use crate::door::{read_bytes, size_of, KeptInputs};
use crate::limits::TEXT_MOST;
use chladni_frf::{Error, Result};
use std::path::Path;

fn text_bytes(path: &Path, expected: &str) -> Result<Vec<u8>> {
    let _kept = KeptInputs::new();
    let bytes = size_of(path)?;
    if bytes > TEXT_MOST {
        return Err(Error::bad_data("too large for a text")
            .file(path)
            .found(format!("{bytes} bytes"))
            .expected(format!("{expected}, of at most {} MiB", TEXT_MOST >> 20))
            .help("check that the right file is named"));
    }
    read_bytes(path)
}

/// The text of a UTF-8 file without its byte-order mark; `expected` says what it should
/// be: "a scene, TOML".
///
/// # Errors
/// Those of reading; [`chladni_frf::ErrorKind::BadData`] with the first byte that is no UTF-8.
pub fn read_text(path: &Path, expected: &str) -> Result<String> {
    let bytes = text_bytes(path, expected)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let found = if error.as_bytes().contains(&0) {
            "a binary file".into()
        } else {
            format!("byte {:#04x}", error.as_bytes()[at])
        };
        let error = Error::bad_data("the file is no UTF-8 text")
            .file(path)
            .at_byte(at as u64)
            .found(found)
            .expected(expected);
        error.help("check that the right file is named; save text with special characters as UTF-8")
    })?;
    Ok(text
        .strip_prefix('\u{feff}')
        .map(str::to_owned)
        .unwrap_or(text))
}

/// Last part of a path; empty where there is none.
pub fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}
