//! The start and the end of every program.

use crate::args::Common;
use crate::console::Console;
use crate::outcome::{self, Outcome};
use crate::{interrupt, usage};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_text::door::KeptInputs;
use clap::Parser;
use std::process::ExitCode;

/// Parses the arguments, runs the command on the number of threads asked for, and prints its
/// result or its error. Returns the exit status.
///
/// * `common`: the common options of the parsed arguments
pub fn start<C: Parser>(
    common: impl Fn(&C) -> &Common,
    run: impl FnOnce(&C, &Console) -> Result<Outcome>,
) -> ExitCode {
    let json = usage::asks_for("--json");
    interrupt::install(json);
    // before parsing, since some options read a file
    let _kept = KeptInputs::of_run();
    let cli: C = match usage::parse() {
        Ok(cli) => cli,
        Err(answer) => return answer.report(&C::command(), json),
    };
    let common = common(&cli);
    let mut console = Console::new(common);
    // a command that hands its arguments on hands this one on, too; its own errors are JSON
    console.json |= json;
    let result = outcome::without_panic(|| {
        start_threads(common.threads)?;
        run(&cli, &console)
    });
    outcome::report(result.map_err(interrupt::as_interruption), &console)
}

/// Starts the threads to compute with; one for each core where no number is given.
fn start_threads(asked: Option<u16>) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(asked.unwrap_or(0).into());
    pool.build_global().map_err(|error| {
        let count = asked.map_or("one for each core".into(), |count| count.to_string());
        refused_threads(&error).field("--threads").found(count)
    })
}

/// The error where the system starts no more threads.
pub fn refused_threads(error: &dyn std::error::Error) -> Error {
    // the system's error behind that of the pool tells the reason
    let reason = error
        .source()
        .map_or_else(|| error.to_string(), ToString::to_string);
    Error::new(
        ErrorKind::Io,
        format!("the system starts no more threads: {reason}"),
    )
    .expected("a number that the limits on processes and memory allow")
    .help("give fewer with --threads, or raise the limits (ulimit -u, ulimit -v)")
}
