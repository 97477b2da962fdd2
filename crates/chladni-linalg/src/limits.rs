//! Constants that decide something, under the file that uses them: meaning, unit, origin.

// blocked.rs

/// Columns of a block, about: fewer, and packing the left side again for each block costs
/// more than the threads bring.
pub(crate) const LEAST: usize = 24;
/// Most blocks.
pub(crate) const MOST: usize = 64;
/// Blocks of rows of a tall QR.
pub(crate) const ROW_BLOCKS: usize = 4;
/// Multiplications below which one thread is faster than many.
pub(crate) const SMALL: usize = 1 << 16;
