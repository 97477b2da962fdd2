//! The end of a run: the result on stdout or the error, and the exit status.

use crate::console::{for_terminal, Console};
use crate::next_step::error_with_commands;
use crate::settings::error_with_options;
use crate::stdout::{is_claimed, print_error, print_line, to_stdout};
use chladni_frf::{Error, ErrorKind, Result};
use serde_json::{json, Value};
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Exit status of a result that was written but is in doubt.
const DOUBTED: u8 = 1;

/// The outcome of a command.
pub struct Outcome {
    /// One JSON object, printed with `--json`.
    pub json: Value,
    /// Text for people, printed without `--json`.
    pub text: String,
    /// The file of the result. With `--quiet` the text of a result in a file is not printed.
    pub output: Option<PathBuf>,
    /// The reason that the result cannot be trusted (exit 1).
    pub doubt: Option<String>,
    /// The command that is proposed next.
    pub next: Option<String>,
}

impl Outcome {
    /// A result whose only place is stdout.
    pub fn shown(json: Value, text: String) -> Self {
        Self {
            json,
            text,
            output: None,
            doubt: None,
            next: None,
        }
    }

    /// A result that was written to `output`.
    pub fn written(output: &Path, json: Value, text: String) -> Self {
        Self {
            json,
            text,
            output: Some(output.to_path_buf()),
            doubt: None,
            next: None,
        }
    }

    /// The same with a doubt.
    pub fn doubted(self, doubt: Option<String>) -> Self {
        Self { doubt, ..self }
    }

    /// The same with the next command.
    pub fn next(self, next: impl Into<String>) -> Self {
        Self {
            next: Some(next.into()),
            ..self
        }
    }
}

/// Runs `work`; a panic becomes an internal error with its place in the source.
pub fn without_panic(work: impl FnOnce() -> Result<Outcome>) -> Result<Outcome> {
    let place = std::sync::Arc::new(std::sync::Mutex::new(String::new()));
    let seen = place.clone();
    panic::set_hook(Box::new(move |info| {
        if let (Ok(mut seen), Some(location)) = (seen.lock(), info.location()) {
            *seen = format!("{}:{}", location.file(), location.line());
        }
    }));
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    drop(panic::take_hook());
    result.unwrap_or_else(|payload| {
        let message = payload
            .downcast_ref::<String>()
            .cloned()
            .or_else(|| payload.downcast_ref::<&str>().map(ToString::to_string));
        let place = place.lock().map(|place| place.clone()).unwrap_or_default();
        Err(Error::new(
            ErrorKind::Internal,
            format!("internal error: {}", message.unwrap_or_default()),
        )
        .found(place))
    })
}

/// Prints the result, the findings and the next step, or the error. Returns the exit status.
pub fn report(result: Result<Outcome>, console: &Console) -> ExitCode {
    console.finish();
    let printed = result.and_then(|outcome| {
        print(&outcome, console)?;
        Ok(outcome)
    });
    console.tell();
    if let Ok(Outcome {
        next: Some(next), ..
    }) = &printed
    {
        if !console.json && !is_claimed() {
            console.note(&format!("Next: {next}"));
        }
    }
    match printed {
        Ok(Outcome { doubt: None, .. }) => ExitCode::SUCCESS,
        Ok(Outcome {
            doubt: Some(doubt), ..
        }) => {
            console.error(&doubt);
            ExitCode::from(DOUBTED)
        }
        Err(error) => {
            let error = error_with_options(error_with_commands(with_advice(error)));
            console.error(&error.to_string());
            if console.json {
                print_error(&error);
            }
            ExitCode::from(error.kind.exit_code())
        }
    }
}

fn print(outcome: &Outcome, console: &Console) -> Result<()> {
    if console.json {
        return print_line(&with_findings(&outcome.json, console).to_string());
    }
    match &outcome.output {
        _ if is_claimed() => Ok(()),
        Some(_) if console.quiet => Ok(()),
        _ => to_stdout(&for_terminal(&outcome.text)),
    }
}

/// The result with `findings` and `warnings`, where it holds none of its own.
fn with_findings(result: &Value, console: &Console) -> Value {
    let mut result = result.clone();
    if let Value::Object(fields) = &mut result {
        fields
            .entry("findings")
            .or_insert_with(|| json!(console.findings()));
        fields
            .entry("warnings")
            .or_insert_with(|| json!(console.warnings()));
    }
    result
}

fn with_advice(error: Error) -> Error {
    match (error.kind, &error.help) {
        (ErrorKind::Internal, None) => error.help(
            "this is a bug of chladni, not of your data: please report it with the \
                        command and the input",
        ),
        _ => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_internal_error_with_its_place() {
        let error = without_panic(|| panic!("broken promise {}", 7))
            .err()
            .unwrap();
        assert_eq!(error.kind.exit_code(), 70);
        assert!(error.message.contains("broken promise 7"), "{error}");
        assert!(error.found.unwrap().contains("outcome.rs"));
    }
}
