//! Long work without the interpreter's lock, which tells of its stages.

use pyo3::prelude::*;
use std::sync::Mutex;

/// Runs `work` without the lock. It is given a function that hands the name of each stage
/// to `callback`; the first error of the callback is raised in the end.
pub fn telling<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&(dyn Fn(&str) + Sync)) -> T + Send,
) -> PyResult<T> {
    let (done, failed) = py.detach(|| {
        let failed: Mutex<Option<PyErr>> = Mutex::new(None);
        let tell = |stage: &str| {
            let Some(callback) = &callback else { return };
            let mut failed = failed.lock().expect("nothing panics while it is held");
            if failed.is_none() {
                *failed = Python::attach(|py| callback.call1(py, (stage,))).err();
            }
        };
        (
            work(&tell),
            failed
                .into_inner()
                .expect("nothing panics while it is held"),
        )
    });
    failed.map_or(Ok(done), Err)
}
