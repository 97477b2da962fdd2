//! Significance of one more pole (theory.md, eq. 8).

use crate::poles::limits;

/// Fall of the sum of squares, in units of σ², that one more pole must bring: more than noise allows
/// in r columns, by the tail of χ² over all places that a pole may take.
pub(crate) fn threshold(columns: usize, lines: usize) -> f64 {
    let r = columns as f64;
    let looks = (limits::LOOKS_PER_LINE * lines as f64).ln();
    r + limits::SIGNIFICANCE * (2.0 * (r * looks).sqrt() + 2.0 * looks)
}
