//! Constants that decide something, under the file that uses them: meaning, unit, origin.

// file.rs

/// Most bytes of a file that is read as one text: a model of 10⁵ responses and 100 modes
/// has 6·10⁸.
pub(crate) const TEXT_MOST: u64 = 1 << 30;

// spool.rs

/// Most bytes that a pipe may give: what is kept of it takes room on the disk of temporary
/// files, which an endless pipe would fill.
pub(crate) const SPOOL_MOST: u64 = 4 << 30;
/// Bytes of a pipe read at a time.
pub(crate) const BLOCK: usize = 1 << 16;

// toml_reader.rs

/// Largest number that is taken, in any unit: far above what is told of panels and scenes,
/// and its square is still a number.
pub(crate) const LARGEST: f64 = 1e15;
