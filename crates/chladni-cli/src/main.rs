//! The command line of Chladni: arguments, progress, messages, exit codes. One file per
//! command; no arithmetic here.

mod args;
mod asked_model;
mod bench;
mod blame;
mod block;
mod compare;
mod convert;
mod correct;
mod curves;
mod demo;
mod estimate;
mod evaluate;
mod explain;
mod extent;
mod field_words;
mod fit;
mod in_time;
mod indices;
mod info;
mod limits;
mod plan;
mod play;
mod render;
mod report;
mod scanned;
mod scene_band;
mod select;
mod shell;
mod signal_files;
mod simulate;
mod streaming;
mod studio;
mod time_table;
mod truth;

use args::{Cli, Command};
use chladni_console::{start, Console, Outcome};
use chladni_frf::Result;
use clap::CommandFactory;
use std::process::ExitCode;

fn main() -> ExitCode {
    start(
        |cli: &Cli| &cli.common,
        |cli, console| run(&cli.command, console),
    )
}

fn run(command: &Command, console: &Console) -> Result<Outcome> {
    match command {
        Command::Demo(args) => demo::run(args, console),
        Command::Info(args) => info::run(args, console),
        Command::Convert(args) => convert::run(args, console),
        Command::Estimate(args) => estimate::run(args, console),
        Command::Simulate(args) => simulate::run(args, console),
        Command::Fit(args) => fit::run(args, console),
        Command::Select(args) => select::run(args, console),
        Command::Compare(args) => compare::run(args, console),
        Command::Render(args) => render::run(args, console),
        Command::Play(args) => play::run(args, console),
        Command::Evaluate(args) => evaluate::run(args, console),
        Command::Correct(args) => correct::run(args, console),
        Command::Report(args) => report::run(args, console),
        Command::Studio(args) => studio::run(args, console),
        Command::Bench(args) => bench::run(args),
        Command::Block(what) => block::run(what, console),
        Command::Completions(args) => Ok(shell::completions(args, Cli::command())),
        Command::Man(args) => shell::man(args, Cli::command()),
    }
}
