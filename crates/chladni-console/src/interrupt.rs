//! Ctrl-C and termination: an interrupted run leaves no half-written file and no
//! temporary one.

use crate::stdout::{is_printing, print_error};
use chladni_frf::{Error, ErrorKind};
use std::io::{self, Write};
use std::sync::Mutex;

/// Held while a file is being written beside its place.
static WRITING: Mutex<()> = Mutex::new(());

/// Ends the process in order on Ctrl-C, on termination, when its terminal is closed and
/// when its time is used up.
///
/// A signal that is ignored already (Ctrl-C in a background job, the closed terminal
/// under `nohup`) stays ignored. One that comes before this is installed, or where it
/// cannot be, ends the process at once: what it leaves is removed by the next run.
#[cfg(unix)]
pub fn install(json: bool) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;
    let ignored = ignored_signals();
    let is_heard = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
    if is_heard(&SIGXFSZ) {
        // a file has grown beyond what is allowed: the writing fails with its own error
        drop(signal_hook::flag::register(SIGXFSZ, Default::default()));
    }
    let endings = [SIGHUP, SIGINT, SIGTERM, SIGXCPU];
    let Ok(mut signals) = Signals::new(endings.into_iter().filter(is_heard)) else {
        return;
    };
    let wait = move || {
        if signals.forever().next().is_some() {
            end(json);
        }
    };
    drop(
        std::thread::Builder::new()
            .name("signals".into())
            .spawn(wait),
    );
}

/// Elsewhere the system ends the process, and the next run removes what it leaves.
#[cfg(not(unix))]
pub fn install(_json: bool) {}

/// A bit for each signal that this process ignores, the lowest for signal 1; only Linux
/// tells.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

#[cfg(unix)]
fn end(json: bool) {
    // a file in the making is finished first: it takes moments, and leaves nothing behind
    let _whole = WRITING.lock();
    let error = Error::new(
        ErrorKind::Interrupted,
        "interrupted; nothing half-written was left behind",
    );
    // nobody may listen any more
    drop(writeln!(io::stderr(), "\nerror: {error}"));
    if json && !is_printing() {
        print_error(&error);
    }
    std::process::exit(ErrorKind::Interrupted.exit_code().into());
}

/// Runs `write` to its end even where an interruption comes between.
pub fn unbroken<T>(write: impl FnOnce() -> T) -> T {
    let _guard = WRITING.lock();
    write()
}
