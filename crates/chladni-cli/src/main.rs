//! The command line of Chladni: arguments, progress, messages, exit codes. One file per
//! command; no arithmetic here.

// the error carries file, line, field and advice; it is built once, where a run ends

mod args;
mod asked_model;
mod bench;
mod block;
mod console;
mod convert;
mod curves;
mod demo;
mod estimate;
mod evaluate;
mod fit;
mod indices;
mod info;
mod input;
mod interrupt;
mod memory;
mod oddities;
mod outcome;
mod output;
mod progress;
mod render;
mod report;
mod scene_band;
mod select;
mod shell;
mod simulate;
mod streaming;
mod studio;
mod table;
mod truth;
mod usage;

use args::{Command, Common};
use chladni_frf::io::KeptInputs;
use chladni_frf::{Error, ErrorKind, Result};
use console::Console;
use outcome::Outcome;
use std::process::ExitCode;

fn main() -> ExitCode {
    let json = usage::asks_for_json(std::env::args_os());
    interrupt::install(json);
    let cli = match usage::parse() {
        Ok(cli) => cli,
        Err(answer) => return answer.report(json),
    };
    let _kept = KeptInputs::of_run();
    let console = Console::new(&cli.common);
    let result = outcome::without_panic(|| run(&cli.command, &cli.common, &console));
    outcome::report(result, &console)
}

/// Starts the threads to compute with, as many as there are cores where no number is
/// asked for.
fn start_threads(asked: Option<u16>) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(asked.unwrap_or(0).into());
    pool.build_global().map_err(|error| {
        let count = asked.map_or("one for each core".into(), |count| count.to_string());
        refused_threads(&error).field("--threads").found(count)
    })
}

/// The error for threads that the system does not start.
fn refused_threads(error: &dyn std::error::Error) -> Error {
    // the words of the pool say nothing, those of the system behind them do
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

fn run(command: &Command, common: &Common, console: &Console) -> Result<Outcome> {
    start_threads(common.threads)?;
    match command {
        Command::Demo(args) => demo::run(args, console),
        Command::Info(args) => info::run(args, console),
        Command::Convert(args) => convert::run(args, console),
        Command::Estimate(args) => estimate::run(args, console),
        Command::Simulate(args) => simulate::run(args, console),
        Command::Fit(args) => fit::run(args, console),
        Command::Select(args) => select::run(args, console),
        Command::Render(args) => render::run(args, console),
        Command::Evaluate(args) => evaluate::run(args, console),
        Command::Report(args) => report::run(args, console),
        Command::Studio(args) => studio::run(args, console),
        Command::Bench(what) => bench::run(what, console),
        Command::Block(what) => block::run(what, console),
        Command::Completions(args) => Ok(shell::completions(args)),
        Command::Man(args) => shell::man(args),
    }
}
