//! Findings on their way to Python: as the JSON of a list, which `findings` reads.

use chladni_frf::Finding;
use pyo3::exceptions::{PyRuntimeError, PyUserWarning};
use pyo3::prelude::*;
use std::ffi::CString;

/// Code, severity, modes, DOFs, values, text and help of each.
pub fn findings_json(findings: &[Finding]) -> PyResult<String> {
    serde_json::to_string(findings).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// The sentences of cautions and faults.
pub fn sentences(findings: &[Finding]) -> Vec<String> {
    chladni_frf::warnings(findings)
}

/// Says a finding as a warning of Python: for results that hold no findings.
pub fn warn(py: Python<'_>, finding: &Finding) -> PyResult<()> {
    let words = CString::new(finding.to_string())?;
    // the caller of the Python half
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &words, 2)
}
