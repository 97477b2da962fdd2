//! Inputs that people name and write. Every file is opened by one [`door`]; scenes, panels,
//! selections and thresholds are read key by key, so that an error names the line, the key,
//! what stood there and what belongs there.
//!
//! A part of Chladni for its other crates: what is public here may change with any version.

pub mod door;
mod file;
mod json;
mod json_kind;
mod limits;
mod spool;
#[doc(hidden)]
pub mod toml_reader;
mod words;

pub use file::{file_name, read_text};
pub use json::{json_error, json_error_in};
pub use json_kind::{json_format, json_kind};
pub use words::{line_of_byte, parser_complaint, toml_complaint};
