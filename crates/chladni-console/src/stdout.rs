//! The content of stdout: the result, or the error object of the contract.

use chladni_frf::{Error, ErrorKind, Result};
use serde_json::json;
use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// The name of the standard output.
const STANDARD_OUTPUT: &str = "-";
/// Set once stdout is the place of a result file.
static CLAIMED: AtomicBool = AtomicBool::new(false);

/// Set once stdout is in use for the result.
static PRINTING: AtomicBool = AtomicBool::new(false);

/// True once stdout belongs to the result.
pub fn is_printing() -> bool {
    PRINTING.load(Ordering::SeqCst)
}

/// True where a result is to be written to stdout.
pub fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == STANDARD_OUTPUT
}

/// Takes stdout for the content of a result file; false where another one has it.
pub fn claim() -> bool {
    !CLAIMED.swap(true, Ordering::SeqCst)
}

/// True once stdout is the place of a result file, and no text belongs there.
pub fn is_claimed() -> bool {
    CLAIMED.load(Ordering::SeqCst)
}

/// Prints the error object of the contract: all keys always.
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
    // the error is on stderr already; a closed stdout changes nothing
    drop(print_line(&object.to_string()));
}

/// Prints text that ends with a line feed.
pub fn print_line(text: &str) -> Result<()> {
    to_stdout(&format!("{text}\n"))
}

/// Writes text to stdout.
pub fn to_stdout(text: &str) -> Result<()> {
    bytes_to_stdout(text.as_bytes())
}

/// Writes to stdout; a reader that has seen enough (`| head`) is no error.
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
