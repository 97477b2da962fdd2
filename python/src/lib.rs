//! Python bindings: what the command line does with time records, FRFs, models and
//! scenes, on NumPy arrays.
//!
//! `read` and `simulate` give an [`frf::FrfSet`], [`fit::fit`] a [`model::Model`] of it,
//! `render` a [`rendering::Rendering`] for a scene, and `evaluate` judges weights on
//! other data. [`pieces`] is the same fit for data larger than memory and for many
//! machines. Long work runs without the interpreter's lock.

mod arrays;
mod detached;
mod error;
mod findings;
mod fit;
mod frf;
mod frf_pickle;
mod memory;
mod model;
mod pieces;
mod playing;
mod progress;
mod rendering;
mod report;
mod signal;
mod simulation;

use pyo3::prelude::*;

/// The compiled half of the package `chladni`.
#[pymodule]
fn _chladni(module: &Bound<'_, PyModule>) -> PyResult<()> {
    detached::set_home();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add(
        "ChladniError",
        module.py().get_type::<error::ChladniError>(),
    )?;
    module.add_function(wrap_pyfunction!(error::refusal, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::float64, module)?)?;
    module.add_class::<frf::FrfSet>()?;
    module.add_class::<model::Model>()?;
    module.add_class::<rendering::Rendering>()?;
    module.add_class::<pieces::Partial>()?;
    module.add_class::<pieces::Poles>()?;
    module.add_function(wrap_pyfunction!(frf::read, module)?)?;
    module.add_function(wrap_pyfunction!(simulation::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    module.add_function(wrap_pyfunction!(model::load_model, module)?)?;
    module.add_function(wrap_pyfunction!(model::select, module)?)?;
    module.add_function(wrap_pyfunction!(model::compare, module)?)?;
    module.add_function(wrap_pyfunction!(signal::estimate, module)?)?;
    module.add_function(wrap_pyfunction!(signal::cmif, module)?)?;
    module.add_function(wrap_pyfunction!(signal::stabilization, module)?)?;
    module.add_function(wrap_pyfunction!(report::report, module)?)?;
    module.add_function(wrap_pyfunction!(pieces::reduce_block, module)?)?;
    module.add_function(wrap_pyfunction!(pieces::merge, module)?)?;
    module.add_function(wrap_pyfunction!(pieces::solve_poles, module)?)?;
    module.add_function(wrap_pyfunction!(pieces::residues_block, module)?)?;
    module.add_function(wrap_pyfunction!(rendering::render, module)?)?;
    module.add_class::<playing::Playing>()?;
    module.add_function(wrap_pyfunction!(playing::play, module)?)?;
    module.add_function(wrap_pyfunction!(rendering::correct, module)?)?;
    module.add_function(wrap_pyfunction!(rendering::evaluate, module)?)
}
