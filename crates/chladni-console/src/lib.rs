//! The common part of the programs of Chladni: options, messages, progress, refusal of outputs
//! before the work, and exit codes.
//!
//! It serves only these programs; its public items may change with any version.

mod args;
mod console;
pub mod input;
mod interrupt;
mod limits;
pub mod memory;
pub mod next_step;
mod numbers;
pub mod oddities;
mod outcome;
pub mod output;
mod progress;
pub mod quoting;
pub mod settings;
mod start;
mod stdout;
pub mod table;
mod telling;
mod usage;

pub use args::Common;
pub use console::Console;
pub use interrupt::unbroken;
pub use numbers::whole_number;
pub use outcome::Outcome;
pub use start::{refused_threads, start};
pub use stdout::{bytes_to_stdout, is_standard_output, print_line};
