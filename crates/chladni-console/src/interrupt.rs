//! Ctrl-C and termination: an interrupted run leaves no half-written file and no
//! temporary one.

use crate::outcome::print_error;
use chladni_frf::{Error, ErrorKind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Mutex;

/// Held while a file is being written beside its place.
static WRITING: Mutex<()> = Mutex::new(());
/// Set once stdout is in use for the result.
static PRINTING: AtomicBool = AtomicBool::new(false);

/// Ends the process on Ctrl-C and on termination.
///
/// Signals that are ignored already (background jobs, `nohup`) stay ignored, hence `try_`
/// and no error.
pub fn install(json: bool) {
    let _ = ctrlc::try_set_handler(move || {
        // a file in the making is finished first: it takes moments, and leaves nothing
        // behind
        let _whole = WRITING.lock();
        let error = Error::new(
            ErrorKind::Interrupted,
            "interrupted; nothing half-written was left behind",
        );
        eprintln!("\nerror: {error}");
        if json && !PRINTING.load(Ordering::SeqCst) {
            print_error(&error);
        }
        std::process::exit(ErrorKind::Interrupted.exit_code().into());
    });
}

/// Runs `write` to its end even where an interruption comes between.
pub fn unbroken<T>(write: impl FnOnce() -> T) -> T {
    let _guard = WRITING.lock();
    write()
}

/// From now on stdout belongs to the result.
pub fn printing() {
    PRINTING.store(true, Ordering::SeqCst);
}
