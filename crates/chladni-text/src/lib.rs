//! Text that people write, scenes, panels, selections and thresholds: read key by key, so
//! that every error names the line, the key, what stood there and what belongs there.

mod file;
mod json;
pub mod toml_reader;
mod words;

pub use file::{file_name, read_text};
pub use json::json_error;
pub use words::{line_of_byte, parser_complaint, toml_complaint};
