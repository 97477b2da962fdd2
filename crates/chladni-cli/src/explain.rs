//! A fit that cannot be made, as an error of the command line.

use chladni_frf::Error;
use chladni_rfp::{FitError, FitOptions};
use std::path::Path;

/// The error of a fit that cannot be made, with its file; settings are named as options.
pub fn explain(error: &FitError, options: &FitOptions, file: &Path) -> Error {
    error.told(options, |name| format!("--{name}")).file(file)
}
