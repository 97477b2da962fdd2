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
mod play;
mod progress;
mod render;
mod report;
mod scene_band;
mod select;
mod shell;
mod signal_files;
mod simulate;
mod streaming;
mod studio;
mod table;
mod time_table;
mod truth;
mod usage;

use args::{Cli, Command, Common};
use chladni_frf::{Error, ErrorKind, Result};
use clap::Parser;
use console::Console;
use outcome::Outcome;
use std::process::ExitCode;

fn main() -> ExitCode {
    let json = usage::asks_for_json(std::env::args_os());
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(answer) => return usage::report(&answer, json),
    };
    let console = Console::new(&cli.common);
    interrupt::install(json);
    let result = outcome::without_panic(|| run(&cli.command, &cli.common, &console));
    outcome::report(result, &console)
}

fn run(command: &Command, common: &Common, console: &Console) -> Result<Outcome> {
    if let Some(threads) = common.threads {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build_global();
        pool.map_err(|error| {
            Error::new(ErrorKind::Internal, error.to_string())
                .field("--threads")
                .found(threads)
        })?;
    }
    match command {
        Command::Demo(args) => demo::run(args, console),
        Command::Info(args) => info::run(args, console),
        Command::Convert(args) => convert::run(args, console),
        Command::Estimate(args) => estimate::run(args, console),
        Command::Simulate(args) => simulate::run(args, console),
        Command::Fit(args) => fit::run(args, console),
        Command::Select(args) => select::run(args, console),
        Command::Render(args) => render::run(args, console),
        Command::Play(args) => play::run(args, console),
        Command::Evaluate(args) => evaluate::run(args, console),
        Command::Report(args) => report::run(args, console),
        Command::Studio(args) => studio::run(args, console),
        Command::Bench(what) => bench::run(what, console),
        Command::Block(what) => block::run(what, console),
        Command::Completions(args) => Ok(shell::completions(args)),
        Command::Man(args) => shell::man(args),
    }
}
