//! The file that an error about a model names.

use chladni_frf::Error;
use std::path::Path;

/// The error with the file of the model where it is about responses, which are those of the
/// model; another error as it is.
pub fn blame_model(error: Error, model: &Path) -> Error {
    match error.field.as_deref() {
        Some("responses") => error.file(model),
        _ => error,
    }
}
