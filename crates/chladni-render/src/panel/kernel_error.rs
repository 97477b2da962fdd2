//! Problems that the kernels of linear algebra refuse, told as a fault of model and
//! scene.

use chladni_frf::{Error, ErrorKind};
use chladni_linalg::LinalgError;

/// The error where a kernel refuses although model and scene are sound number by number:
/// they lie too far apart for arithmetic of sixteen digits. Sizes that do not fit are a
/// broken promise of our own.
pub(crate) fn unsolvable(error: LinalgError) -> Error {
    if let LinalgError::Shape { .. } | LinalgError::WrongShape { .. } = error {
        return Error::new(ErrorKind::Internal, error.to_string());
    }
    Error::bad_data("model and scene hold numbers that lie too far apart to compute with")
        .found(error)
        .expected("shapes, participations, standard deviations and limits of a real panel")
        .help(
            "look for a mode whose shape or standard deviation is out of all proportion, and \
             for absurd limits in the scene",
        )
}
