//! The options that all commands have.

use crate::limits::MOST_THREADS;
use crate::numbers::whole_number;
use chladni_frf::Result;
use clap::{ArgAction, Args, ValueEnum};

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
    /// No colours; NO_COLOR in the environment says the same
    #[arg(long, global = true)]
    pub no_color: bool,
    /// Threads to compute with; the result is the same for any number [default: all
    /// cores]
    #[arg(long, global = true, value_name = "N", env = "CHLADNI_THREADS", hide_env_values = true, allow_negative_numbers = true, value_parser = parse_threads)]
    pub threads: Option<u16>,
    /// Overwrite existing output files
    #[arg(long, global = true)]
    pub force: bool,
    /// Progress on stderr: a bar on a terminal only, a line per stage, or nothing
    #[arg(long, global = true, value_name = "HOW", value_enum, default_value_t = ProgressChoice::Auto)]
    pub progress: ProgressChoice,
}

/// `--threads` as a number.
fn parse_threads(text: &str) -> Result<u16> {
    whole_number(text, 1..=MOST_THREADS, "", "no such number of threads")
        .map_err(|error| error.help("leave --threads out to compute with all cores"))
}

/// Display of progress. (Plain comments below: documented values would make every help
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
