//! Text files and their names.

use chladni_frf::{Error, Result};
use std::fs;
use std::path::Path;

/// The text of a UTF-8 file without its byte-order mark; `expected` says what it should
/// be: "a scene, TOML".
///
/// # Errors
/// Those of reading; [`chladni_frf::ErrorKind::BadData`] with the first byte that is no UTF-8.
pub fn read_text(path: &Path, expected: &str) -> Result<String> {
    let bytes = fs::read(path).map_err(|error| Error::from_read(&error, path))?;
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
