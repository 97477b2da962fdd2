//! Long work without the interpreter's lock, which tells of its stages.

use pyo3::prelude::*;
use std::cell::RefCell;

/// Runs `work` without the lock. It is given a function that hands the name of each stage to `callback`; the first error of the callback is
/// raised in the end.
pub fn telling<T: Send>(py: Python<'_>, callback: Option<Py<PyAny>>, work: impl FnOnce(&dyn Fn(&str)) -> T + Send) -> PyResult<T> {
    let (done, failed) = py.detach(|| {
        let failed: RefCell<Option<PyErr>> = RefCell::new(None);
        let tell = |stage: &str| {
            let Some(callback) = &callback else { return };
            if failed.borrow().is_none() {
                if let Err(error) = Python::attach(|py| callback.call1(py, (stage,))) {
                    *failed.borrow_mut() = Some(error);
                }
            }
        };
        (work(&tell), failed.into_inner())
    });
    failed.map_or(Ok(done), Err)
}
