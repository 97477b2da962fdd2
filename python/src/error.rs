//! One exception with the fields of the error contract.

use chladni_frf::{Error, ErrorKind};
use chladni_io::extension_of;
use chladni_rfp::pieces::PieceError;
use chladni_rfp::{FitError, FitOptions};
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::Path;

create_exception!(
    chladni,
    ChladniError,
    PyValueError,
    "What was found, what was expected and what to do, in the attributes code, kind, file, dataset, line, byte, field, found, expected and help \
     (None where they do not apply)."
);

/// The exception of an error about files, options or data.
pub fn raised(py: Python<'_>, error: &Error) -> PyErr {
    let exception = ChladniError::new_err(error.to_string());
    let value = exception.value(py);
    let file = error.file.as_ref().map(|file| file.display().to_string());
    let set = || -> PyResult<()> {
        value.setattr("code", error.kind.exit_code())?;
        value.setattr("kind", error.kind.as_str())?;
        value.setattr("file", file)?;
        value.setattr("dataset", error.dataset)?;
        value.setattr("line", error.line)?;
        value.setattr("byte", error.byte)?;
        value.setattr("field", error.field.as_deref())?;
        value.setattr("found", error.found.as_deref())?;
        value.setattr("expected", error.expected.as_deref())?;
        value.setattr("help", error.help.as_deref())
    };
    match set() {
        Ok(()) => exception,
        Err(other) => other,
    }
}

/// The exception of an option that its parser refused.
pub fn wrong_option(py: Python<'_>, field: &str, error: Error) -> PyErr {
    let kind = ErrorKind::Usage;
    raised(py, &Error { kind, ..error }.field(field))
}

/// The exception of an argument that the Python half refuses, for it to raise.
#[pyfunction]
pub fn refusal(
    py: Python<'_>,
    field: &str,
    message: &str,
    found: &str,
    expected: &str,
) -> Py<PyAny> {
    let error = Error::new(ErrorKind::Usage, message).field(field);
    let refused = raised(py, &error.found(found).expected(expected));
    refused.into_value(py).into_any()
}

/// The exception of a word that an option does not know: "`x` is no ...; write ...".
pub fn wrong_word(py: Python<'_>, field: &str, found: &str, message: &str) -> PyErr {
    wrong_option(py, field, Error::bad_word(message, found))
}

/// The exception of a path whose extension is none of `expected`.
pub fn wrong_extension(py: Python<'_>, path: &Path, expected: &str) -> PyErr {
    let found = match extension_of(path) {
        none if none.is_empty() => "no extension".into(),
        extension => format!(".{extension}"),
    };
    let message = "the extension of the path names no format that can be written";
    let error = Error::new(ErrorKind::Usage, message).file(path);
    wrong_option(py, "path", error.found(found).expected(expected))
}

/// The exception of a fit that cannot be made.
pub fn unfitted(py: Python<'_>, error: &FitError, options: &FitOptions) -> PyErr {
    let keyword = |name: &str| if name == "frf-kind" { "kind" } else { name }.to_owned();
    raised(py, &error.told(options, keyword))
}

/// The exception of a piece that cannot be made, merged or solved.
pub fn unpieced(py: Python<'_>, error: &PieceError, options: &FitOptions) -> PyErr {
    match error {
        PieceError::Fit(error) => unfitted(py, error, options),
        PieceError::Data(error) => raised(py, error),
    }
}
