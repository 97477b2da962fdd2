//! The part of the data that chance lets one more pole explain.

use crate::poles::limits;

/// Rise of the sum of squares, in units of σ², that one more pole over r columns must
/// bring: the tail of χ² with K looks.
pub(crate) fn threshold(columns: usize, lines: usize) -> f64 {
    let r = columns as f64;
    let looks = (limits::LOOKS_PER_LINE * lines as f64).ln();
    r + limits::SIGNIFICANCE * (2.0 * (r * looks).sqrt() + 2.0 * looks)
}
