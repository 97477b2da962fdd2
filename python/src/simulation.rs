//! FRFs of a virtual panel, with the model behind them.

use crate::error::raised;
use crate::frf::FrfSet;
use crate::model::Model;
use chladni_plate::Panel;
use pyo3::prelude::*;
use std::path::PathBuf;

/// FRFs of a virtual panel and the model behind them, from a panel file (TOML).
#[pyfunction]
#[pyo3(signature = (panel, *, snr_db=None, seed=None, memory_bytes=2 << 30))]
pub fn simulate(
    py: Python<'_>,
    panel: PathBuf,
    snr_db: Option<f64>,
    seed: Option<u64>,
    memory_bytes: u64,
) -> PyResult<(FrfSet, Model)> {
    let simulation = py
        .detach(|| chladni_plate::simulate(&Panel::read(&panel, memory_bytes)?, seed, snr_db))
        .map_err(|error| {
            raised(
                py,
                &if error.file.is_none() {
                    error.file(&panel)
                } else {
                    error
                },
            )
        })?;
    Ok((
        FrfSet {
            set: simulation.frf,
            findings: simulation.findings,
        },
        Model::new(simulation.truth),
    ))
}
