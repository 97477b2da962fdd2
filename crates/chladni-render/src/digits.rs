//! Numbers in sentences.

use crate::tolerances::PLAIN;

/// A frequency in Hz, with six significant digits and without trailing zeros.
pub(crate) fn hertz(frequency_hz: f64) -> String {
    rounded::<6>(frequency_hz)
}

/// A value with `DIGITS` significant digits, without trailing zeros; very small and very large
/// ones with an exponent.
pub(crate) fn rounded<const DIGITS: usize>(value: f64) -> String {
    let decimals = DIGITS.saturating_sub(1);
    let rounded = format!("{value:.decimals$e}").parse::<f64>();
    let rounded = rounded.unwrap_or(value);
    let is_short = rounded == 0.0 || !rounded.is_finite() || PLAIN.contains(&rounded.abs());
    match is_short {
        true => rounded.to_string(),
        false => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_leaves_the_digits_that_a_reader_wants() {
        assert_eq!(hertz(143.438_000_000_000_02), "143.438");
        assert_eq!(hertz(300.0), "300");
        assert_eq!(rounded::<4>(0.000_257_577_803_498_042_83), "0.0002576");
        assert_eq!(rounded::<4>(f64::INFINITY), "inf");
        assert_eq!(hertz(0.0), "0");
        assert_eq!(hertz(-2e15), "-2e15");
        assert_eq!(hertz(1.234_567_8e-300), "1.23457e-300");
    }
}
