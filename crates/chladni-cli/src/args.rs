//! The commands.

use crate::{
    bench, block, compare, convert, correct, demo, estimate, evaluate, fit, info, play, render,
    report, select, shell, simulate, studio,
};
use chladni_console::Common;
use clap::{Parser, Subcommand};

/// Modal identification of plates from measured FRFs, and vibration rendering with it
#[derive(Debug, Parser)]
#[command(name = "chladni", version, before_help = EXAMPLES, after_help = PIPES)]
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

const PIPES: &str = "Input files may be pipes; one of them may be -, the standard input. -o - is the standard output: JSON, CSV or HTML,
and binary universal files of FRFs. CHLADNI_FRF_KIND and CHLADNI_THREADS stand for --frf-kind and --threads.
COMMAND -h: its own options; COMMAND --help: all of them.
Documentation: https://docs.rs/chladni-cli; what a finding means: docs/troubleshooting.md";

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
    /// Pair the modes of two models, or follow them through many: MAC, shifts, what is missing
    Compare(compare::Args),
    /// Find actuator weights that move a panel here and keep it quiet there
    Render(render::Args),
    /// Turn weights into drive signals: bursts, fades, moving zones, and quiet ramps
    Play(play::Args),
    /// Judge given weights on other data: measured FRFs, another model, or a measured field
    Evaluate(evaluate::Args),
    /// Correct weights by the fields that were measured under them
    Correct(correct::Args),
    /// Write models and weights as one HTML page
    Report(report::Args),
    /// The report, live: fit, draw scenes and render on a local page
    Studio(studio::Args),
    /// Measure speed and accuracy on cases whose truth is known
    #[command(disable_help_flag = true)]
    Bench(bench::Args),
    /// The same fit in pieces, for job arrays and clusters
    #[command(subcommand)]
    Block(block::Block),
    /// Print completions for a shell
    Completions(shell::CompletionsArgs),
    /// Print a manual page
    Man(shell::ManArgs),
}
