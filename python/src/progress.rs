//! Long work without the interpreter's lock, which tells of its stages and may be stopped.

use crate::detached::Threads;
use chladni_rfp::CancelToken;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Time between two looks for signals (Ctrl-C): too short to be felt, too long to cost
/// anything.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Runs `work` without the lock. It is given a function that hands the name of each stage
/// to `callback`, and a request to stop, which the first error of the callback and a
/// signal such as Ctrl-C make. That error is raised once the work has ended.
pub fn telling<T: Send>(
    py: Python<'_>,
    callback: Option<&Py<PyAny>>,
    work: impl FnOnce(&(dyn Fn(&str) + Sync), &CancelToken) -> T + Send,
) -> PyResult<T> {
    let stop = CancelToken::new();
    let failed: Mutex<Option<PyErr>> = Mutex::new(None);
    let note = |outcome: PyResult<()>| {
        if let Err(error) = outcome {
            let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
            failed.get_or_insert(error);
            stop.cancel();
        }
    };
    let tell = |stage: &str| {
        if let Some(callback) = callback.filter(|_| !stop.is_cancelled()) {
            note(Python::attach(|py| {
                callback.call1(py, (stage,)).map(|_| ())
            }));
        }
    };
    let threads = Threads::of_process()?;
    let done = py.detach(|| -> PyResult<T> {
        let work = || threads.run(|| work(&tell, &stop));
        // a callback works on a thread of the pool, which must not wait for the others
        if rayon::current_thread_index().is_some() {
            return Ok(work());
        }
        watched(work, || {
            if !stop.is_cancelled() {
                note(Python::attach(|py| py.check_signals()));
            }
        })
    })?;
    let failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.map_or(Ok(done), Err)
}

/// Runs `work` on a thread of its own, and `look` on this one again and again until it has
/// ended: Python hands signals to its main thread alone. An `OSError` where the system starts
/// no thread.
fn watched<T: Send>(work: impl FnOnce() -> T + Send, look: impl Fn()) -> PyResult<T> {
    let (ended, end) = channel::<()>();
    thread::scope(|scope| {
        let started = thread::Builder::new().spawn_scoped(scope, move || {
            let _ended = ended; // gone when the work has ended, even by a panic
            work()
        });
        let worker = started.map_err(|error| {
            PyOSError::new_err(format!(
                "the system starts no more threads: {error}; end other programs, or allow this \
                 one more memory or threads (ulimit)"
            ))
        })?;
        while end.recv_timeout(SIGNALS_EVERY) == Err(RecvTimeoutError::Timeout) {
            look();
        }
        Ok(worker.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })
}
