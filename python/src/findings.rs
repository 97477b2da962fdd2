//! Findings on their way to Python: as the JSON of a list, which `findings` reads.

use chladni_frf::Finding;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Code, severity, modes, DOFs, values, text and help of each.
pub fn findings_json(findings: &[Finding]) -> PyResult<String> {
    serde_json::to_string(findings).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// The sentences of cautions and faults.
pub fn sentences(findings: &[Finding]) -> Vec<String> {
    chladni_frf::warnings(findings)
}
