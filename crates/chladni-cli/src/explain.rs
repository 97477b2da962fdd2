//! A fit that cannot be made, as an error of the command line.

use chladni_frf::Error;
use chladni_rfp::{FitError, FitOptions};
use std::path::Path;

/// A fit that cannot be made, in words of the file and the command line.
pub fn explain(error: &FitError, options: &FitOptions, file: &Path) -> Error {
    error.told(options, |name| format!("--{name}")).file(file)
}
