//! `chladni bench`: runs the program `chladni-bench`, which is installed beside `chladni`.

use chladni_console::Outcome;
use chladni_frf::{Error, ErrorKind, Result};
use std::ffi::OsString;
use std::io;
use std::process::Command;

/// The program that measures.
const PROGRAM: &str = "chladni-bench";

/// Arguments of `bench`: those of the program.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Verb and options of `chladni-bench`
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "ARGUMENTS"
    )]
    arguments: Vec<OsString>,
}

/// Runs `chladni-bench` with all arguments but the word `bench`, and ends with its exit code.
///
/// # Errors
/// [`ErrorKind::NoInput`] where the program is not installed.
pub fn run(_: &Args) -> Result<Outcome> {
    let mut arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    if let Some(word) = arguments.iter().position(|argument| argument == "bench") {
        arguments.remove(word);
    }
    let beside = std::env::current_exe()
        .ok()
        .map(|program| program.with_file_name(PROGRAM))
        .map(|path| path.with_extension(std::env::consts::EXE_EXTENSION))
        .filter(|path| path.is_file());
    let mut command = Command::new(beside.unwrap_or_else(|| PROGRAM.into()));
    Err(refused(&run_in_place(command.args(&arguments))))
}

/// Replaces this process by the program, so that signals and exit code are the program's.
#[cfg(unix)]
fn run_in_place(command: &mut Command) -> io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Runs the program and ends with its exit code.
#[cfg(not(unix))]
fn run_in_place(command: &mut Command) -> io::Error {
    match command.status() {
        Ok(status) => std::process::exit(
            status
                .code()
                .unwrap_or_else(|| ErrorKind::Interrupted.exit_code().into()),
        ),
        Err(error) => error,
    }
}

fn refused(error: &io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::NotFound => Error::new(ErrorKind::NoInput, "the benches are not installed")
            .file(PROGRAM)
            .found("no such program beside chladni or in PATH")
            .expected("the program chladni-bench")
            .help("in a checkout of Chladni: cargo install --path benches"),
        _ => Error::new(ErrorKind::Io, format!("cannot run the benches: {error}")).file(PROGRAM),
    }
}
