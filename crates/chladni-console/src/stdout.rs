//! Stdout: the result, or the error object.

use chladni_frf::{Error, ErrorKind, Result};
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// The name of the standard output.
const STANDARD_OUTPUT: &str = "-";
/// Set once stdout takes the content of a result file.
static CLAIMED: AtomicBool = AtomicBool::new(false);
/// Set once something is printed.
static PRINTING: AtomicBool = AtomicBool::new(false);

/// True once something is printed.
pub fn is_printing() -> bool {
    PRINTING.load(Ordering::SeqCst)
}

/// True for the path `-`.
pub fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == STANDARD_OUTPUT
}

/// Claims stdout for the content of a result file; false where another one has it.
pub fn claim() -> bool {
    !CLAIMED.swap(true, Ordering::SeqCst)
}

/// True once stdout takes the content of a result file, so that no text may be printed.
pub fn is_claimed() -> bool {
    CLAIMED.load(Ordering::SeqCst)
}

/// Prints the error object, which always has all keys.
pub fn print_error(error: &Error) {
    let object = json!({"error": {
        "code": error.kind.exit_code(),
        "kind": error.kind.as_str(),
        "message": error.message,
        "file": error.file.as_ref().map(|file| file.display().to_string()),
        "dataset": error.dataset,
        "line": error.line,
        "byte": error.byte,
        "field": error.field,
        "found": error.found,
        "expected": error.expected,
        "help": error.help,
    }});
    // the error is on stderr already, so a closed stdout does not matter
    drop(print_line(&object.to_string()));
}

/// Prints text and a line feed.
pub fn print_line(text: &str) -> Result<()> {
    to_stdout(&format!("{text}\n"))
}

/// Writes text to stdout.
pub fn to_stdout(text: &str) -> Result<()> {
    bytes_to_stdout(text.as_bytes())
}

/// Writes to stdout; a pipe that its reader has closed (`| head`) is no error.
pub fn bytes_to_stdout(bytes: &[u8]) -> Result<()> {
    PRINTING.store(true, Ordering::SeqCst);
    let mut stdout = io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Error::new(
            ErrorKind::Io,
            format!("cannot write to stdout: {error}"),
        )
        .file("stdout")
        .help("free some space or write elsewhere")),
        _ => Ok(()),
    }
}
