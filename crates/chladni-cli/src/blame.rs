//! The file that an error names, where several were read.

use chladni_frf::Error;
use chladni_render::Scene;
use std::path::Path;

/// The error with the file of the model where it is about responses or modes, which are those of
/// the model; another error as it is.
pub fn blame_model(error: Error, model: &Path) -> Error {
    match error.field.as_deref() {
        Some("responses" | "modes") => error.file(model),
        _ => error,
    }
}

/// The error with the file that it is about, of those that a measured field is judged with: the
/// field, the weights that played, the model, else the scene.
pub fn blame_field(
    error: Error,
    (field, weights): (&Path, &Path),
    model: &Path,
    scene: &Scene,
) -> Error {
    match error.field.as_deref() {
        Some("weights" | "weights.frequency_hz" | "weights.unit") => error.file(weights),
        Some("weights_sha256" | "field" | "response" | "unit" | "velocity" | "gains") => {
            error.file(field)
        }
        _ => scene.blame(blame_model(error, model)),
    }
}
