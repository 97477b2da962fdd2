//! The content of stdout: the result, or the error object of the contract.

use chladni_frf::{Error, ErrorKind, Result};
use serde_json::json;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set once stdout is in use for the result.
static PRINTING: AtomicBool = AtomicBool::new(false);

/// True once stdout belongs to the result.
pub fn is_printing() -> bool {
    PRINTING.load(Ordering::SeqCst)
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

/// Writes to stdout; a reader that has seen enough (`| head`) is no error.
pub fn to_stdout(text: &str) -> Result<()> {
    PRINTING.store(true, Ordering::SeqCst);
    let mut stdout = io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Error::new(
            ErrorKind::Io,
            format!("cannot write to stdout: {error}"),
        )
        .file("stdout")
        .help("free some space or write elsewhere")),
        _ => Ok(()),
    }
}
