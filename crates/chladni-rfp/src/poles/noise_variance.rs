//! Noise variance of one value from the sum of squares that a linear fit leaves.

/// Noise variance of one value of (lines, columns), each column fitted with so many `unknowns`.
///
/// * `sse`: sum of squares left
/// * `floor`: variance below which the rest is rounding
pub(crate) fn noise_variance(
    sse: f64,
    (lines, columns): (usize, usize),
    unknowns: usize,
    floor: f64,
) -> f64 {
    let freedom = lines.saturating_sub(unknowns).max(1) * columns;
    (sse / freedom as f64).max(floor)
}
