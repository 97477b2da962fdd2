//! Options of a universal file that is written.

/// Settings of writing a universal file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WriteOptions {
    /// Binary 58 (IEEE 754, little endian): exact, and much smaller and faster than text.
    pub binary: bool,
    /// Datasets 15 and 55 (six digits) in place of 2411 and 2414, for old programs.
    pub old_datasets: bool,
}
