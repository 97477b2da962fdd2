//! Ctrl-C and termination: an interrupted run leaves neither half-written nor temporary files.

use crate::stdout::{is_printing, print_error};
use chladni_frf::{Error, ErrorKind};
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, Mutex};

/// Held while a file is being written.
static WRITING: Mutex<()> = Mutex::new(());

/// True once a file has exceeded the size that this process may write (SIGXFSZ).
static TOO_LARGE: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// Ends the process in order on Ctrl-C, on termination, when its terminal is closed, and when
/// its limit of time or of the size of files is reached.
///
/// A signal that is ignored already (Ctrl-C in a background job, the closed terminal under
/// `nohup`) stays ignored. A signal before the installation, or where that fails, ends the
/// process at once; the next run removes its temporary files.
#[cfg(unix)]
pub fn install(json: bool) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;
    let ignored = ignored_signals();
    let is_caught = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    if is_caught(&SIGXFSZ) {
        // writing then fails, and its error ends the run
        drop(signal_hook::flag::register(SIGXFSZ, TOO_LARGE.clone()));
    }
    let endings = [SIGHUP, SIGINT, SIGTERM, SIGXCPU];
    let Ok(mut signals) = Signals::new(endings.into_iter().filter(is_caught)) else {
        return;
    };
    watch(json, move || signals.forever().next().is_some());
}

/// The same for Ctrl-C, and for termination by a program of the same C library. No call waits
/// for these, so that a flag is polled.
#[cfg(not(unix))]
pub fn install(json: bool) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    /// Time between two polls, too short to be noticed.
    const POLL: std::time::Duration = std::time::Duration::from_millis(50);
    let ended = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        drop(signal_hook::flag::register(signal, ended.clone()));
    }
    watch(json, move || {
        while !ended.load(Ordering::Relaxed) {
            std::thread::sleep(POLL);
        }
        true
    });
}

/// Ends the process when `wait`, on a thread of its own, returns with a signal.
fn watch(json: bool, wait: impl FnOnce() -> bool + Send + 'static) {
    let work = move || {
        if wait() {
            end(json);
        }
    };
    drop(
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(work),
    );
}

/// The error of a run; an interruption where a file has grown too large.
pub fn as_interruption(error: Error) -> Error {
    if !TOO_LARGE.load(Ordering::Relaxed) {
        return error;
    }
    Error {
        kind: ErrorKind::Interrupted,
        ..error
    }
    .help("raise the limit on the size of files (ulimit -f); nothing half-written was left behind")
}

/// A bit for each signal that this process ignores, the lowest for signal 1. Known on Linux
/// only.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

fn end(json: bool) {
    // a file that is being written is finished first
    let _whole = WRITING.lock();
    let error = Error::new(
        ErrorKind::Interrupted,
        "interrupted; nothing half-written was left behind",
    );
    // stderr may be closed
    drop(writeln!(io::stderr(), "\nerror: {error}"));
    if json && !is_printing() {
        print_error(&error);
    }
    std::process::exit(ErrorKind::Interrupted.exit_code().into());
}

/// Runs `write`; an interruption waits until it has returned.
pub fn unbroken<T>(write: impl FnOnce() -> T) -> T {
    let _guard = WRITING.lock();
    write()
}
