//! One way to start and to end for every program.

use crate::args::Common;
use crate::console::Console;
use crate::outcome::{self, Outcome};
use crate::{interrupt, usage};
use chladni_frf::{Error, ErrorKind, Result};
use clap::Parser;
use std::process::ExitCode;

/// Parses the arguments, runs the command on as many threads as asked for, and prints its
/// result or its error; the exit status is that of the contract.
///
/// * `common`: the options of all commands among the parsed ones
pub fn start<C: Parser>(
    common: impl Fn(&C) -> &Common,
    run: impl FnOnce(&C, &Console) -> Result<Outcome>,
) -> ExitCode {
    let json = usage::asks_for_json(std::env::args_os());
    let cli = match C::try_parse() {
        Ok(cli) => cli,
        Err(answer) => return usage::report(&answer, &C::command(), json),
    };
    let common = common(&cli);
    let console = Console::new(common);
    interrupt::install(json);
    let result = outcome::without_panic(|| {
        set_threads(common.threads)?;
        run(&cli, &console)
    });
    outcome::report(result, &console)
}

fn set_threads(threads: Option<u16>) -> Result<()> {
    let Some(threads) = threads else {
        return Ok(());
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.into())
        .build_global();
    pool.map_err(|error| {
        Error::new(ErrorKind::Internal, error.to_string())
            .field("--threads")
            .found(threads)
    })
}
