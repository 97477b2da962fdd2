//! FRFs of a virtual panel, with the model behind them.

use crate::detached::detached;
use crate::error::raised;
use crate::frf::FrfSet;
use crate::model::Model;
use chladni_plate::Panel;
use pyo3::prelude::*;
use std::path::PathBuf;

/// FRFs of a virtual panel and the model behind them.
///
/// Parameters
/// ----------
/// panel : path
///     Panel file (TOML).
/// snr_db : float, optional
///     Noise level, dB, in place of the panel's.
/// seed : int, optional
///     Seed of the noise in place of the panel's.
/// memory_bytes : int
///     What needs more is refused at once.
///
/// Returns
/// -------
/// FrfSet, Model
#[pyfunction]
#[pyo3(signature = (panel, *, snr_db=None, seed=None, memory_bytes=2 << 30))]
pub fn simulate(
    py: Python<'_>,
    panel: PathBuf,
    snr_db: Option<f64>,
    seed: Option<u64>,
    memory_bytes: u64,
) -> PyResult<(FrfSet, Model)> {
    let simulated = detached(py, || {
        chladni_plate::simulate(&Panel::read(&panel, memory_bytes)?, seed, snr_db)
    })?;
    let simulation = simulated.map_err(|error| {
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
