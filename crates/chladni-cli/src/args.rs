//! The commands, and the options that all of them have.

use crate::{
    bench, block, convert, demo, estimate, evaluate, fit, info, play, render, report, select,
    shell, simulate, studio,
};
use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};

/// Modal identification of plates from measured FRFs, and vibration rendering with it
#[derive(Debug, Parser)]
#[command(name = "chladni", version, before_help = EXAMPLES)]
pub struct Cli {
    /// Options of all commands.
    #[command(flatten)]
    pub common: Common,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "Examples:
  chladni demo                                         the whole way on a simulated panel
  chladni info measurement.uff                         what is inside, and what is wrong with it
  chladni fit measurement.uff -o model.json            natural frequencies, damping and mode shapes
  chladni render model.json corner.toml -o weights.json
  chladni report model.json weights.json -o report.html
  chladni studio measurement.uff                       all of it, live, on a local page";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate, fit, render four scenes and report, on the built-in panel
    Demo(demo::Args),
    /// List what is inside files, and what is wrong with it
    Info(info::Args),
    /// Write measured data or a model in another format; several inputs are merged into
    /// one set
    Convert(convert::Args),
    /// Estimate FRFs and coherence from time records
    Estimate(estimate::Args),
    /// Simulate the FRFs of a virtual panel
    Simulate(simulate::Args),
    /// Identify modes from FRFs: natural frequencies, damping, shapes, with error bars
    Fit(fit::Args),
    /// Keep or drop modes of a model by hand, reproducibly
    Select(select::Args),
    /// Find actuator weights that move a panel here and keep it quiet there
    Render(render::Args),
    /// Turn weights into drive signals: bursts, fades, moving zones, and quiet ramps
    Play(play::Args),
    /// Judge given weights on other data: measured FRFs or another model
    Evaluate(evaluate::Args),
    /// Write models and weights as one HTML page
    Report(report::Args),
    /// The report, live: fit, draw scenes and render on a local page
    Studio(studio::Args),
    /// Measure speed and accuracy on cases whose truth is known
    #[command(subcommand)]
    Bench(bench::Bench),
    /// The same fit in pieces, for job arrays and clusters
    #[command(subcommand)]
    Block(block::Block),
    /// Print completions for a shell
    Completions(shell::CompletionsArgs),
    /// Print a manual page
    Man(shell::ManArgs),
}

/// Options of all commands.
#[derive(Debug, Args)]
#[command(next_help_heading = "Common options")]
pub struct Common {
    /// Print one JSON object on stdout, errors too
    #[arg(long, global = true)]
    pub json: bool,
    /// No warnings, no progress, no summary of what was written
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more: every dataset, rejected modes, time of each stage
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
    /// Threads to compute with; the result is the same for any number [default: all
    /// cores]
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Overwrite existing output files
    #[arg(long, global = true)]
    pub force: bool,
    /// Progress on stderr: a bar on a terminal only, a line per stage, or nothing
    #[arg(long, global = true, value_name = "HOW", value_enum, default_value_t = ProgressChoice::Auto)]
    pub progress: ProgressChoice,
}

/// How progress is shown. (Plain comments below: documented values would make every help
/// page three times as long.)
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ProgressChoice {
    // a bar where stderr is a terminal, nothing elsewhere
    Auto,
    // one line per stage
    Plain,
    // nothing
    None,
}
