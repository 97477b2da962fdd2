//! Work without the interpreter's lock, on threads that this process has.
//!
//! Threads do not survive a fork: a child inherits the pool of its parent without one of
//! them, and would wait for them for ever. A process other than the one that loaded the
//! package works in a pool of its own.

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::OnceLock;

/// The process that loaded the package: the common pool is its.
static HOME: AtomicU32 = AtomicU32::new(0);

/// The pool of the first child in a line of forks. No lock guards it, for a fork could
/// leave one locked.
static OF_CHILDREN: OnceLock<Box<Pool>> = OnceLock::new();

/// The threads of one child.
struct Pool {
    process: u32,
    threads: ThreadPool,
    /// That of a child of this child.
    next: OnceLock<Box<Self>>,
}

impl Pool {
    fn of(process: u32) -> PyResult<Box<Self>> {
        let threads = ThreadPoolBuilder::new().build().map_err(|error| {
            let message = format!("no threads for this child of a fork: {error}");
            PyOSError::new_err(message)
        })?;
        Ok(Box::new(Self {
            process,
            threads,
            next: OnceLock::new(),
        }))
    }
}

/// Notes that this process loads the package.
pub fn set_home() {
    HOME.store(process::id(), Ordering::Relaxed);
}

/// The threads that work runs on.
#[derive(Clone, Copy)]
pub struct Threads(Option<&'static ThreadPool>);

impl Threads {
    /// Those of this process: of the common pool, or of one of its own in a child of a
    /// fork, which is built at its first use and kept.
    pub fn of_process() -> PyResult<Self> {
        let process = process::id();
        if process == HOME.load(Ordering::Relaxed) {
            return Ok(Self(None));
        }
        let mut place = &OF_CHILDREN;
        loop {
            match place.get() {
                Some(pool) if pool.process == process => return Ok(Self(Some(&pool.threads))),
                Some(of_parent) => place = &of_parent.next,
                // another thread of this process may be faster: then its pool is taken
                None => drop(place.set(Pool::of(process)?)),
            }
        }
    }

    /// Runs `work` on them.
    pub fn run<T: Send>(self, work: impl FnOnce() -> T + Send) -> T {
        match self.0 {
            None => work(),
            Some(pool) => pool.install(work),
        }
    }
}

/// Runs `work` without the lock, on the threads of this process.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let threads = Threads::of_process()?;
    Ok(py.detach(|| threads.run(work)))
}
