//! The common case of a printed number, fast: most of the time that a text file takes goes into its numbers.

/// The largest power of ten that a double holds exactly, and all below it.
const EXACT_POWERS: [f64; 23] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22];
/// Integers up to this are exact in a double.
const EXACT_INTEGER: u64 = 1 << 53;

/// A number as writers print it, `-1.234567890123E-05`, where one rounding gives the nearest double: the digits are an exact
/// integer and the power of ten is exact (W. Clinger, PLDI 1990). `None` for everything else; twice as fast as the general way.
pub(super) fn short_decimal(text: &[u8]) -> Option<f64> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        all => (false, all),
    };
    let mut mantissa = 0_u64;
    let mut decimals: Option<i32> = None;
    let mut at = 0;
    while let Some(&c) = digits.get(at) {
        match c {
            b'0'..=b'9' if at < 18 => {
                mantissa = mantissa * 10 + u64::from(c - b'0');
                decimals = decimals.map(|count| count + 1);
            }
            b'.' if decimals.is_none() => decimals = Some(0),
            _ => break,
        }
        at += 1;
    }
    let [b'E' | b'D', sign @ (b'+' | b'-'), exponent @ ..] = &digits[at..] else { return None };
    let (tens @ b'0'..=b'9', ones @ b'0'..=b'9') = (match exponent {
        [tens, ones] => (tens, ones),
        _ => return None,
    }) else {
        return None;
    };
    let exponent = i32::from(tens - b'0') * 10 + i32::from(ones - b'0');
    let exponent = if *sign == b'-' { -exponent } else { exponent } - decimals.unwrap_or(0);
    let power = EXACT_POWERS.get(exponent.unsigned_abs() as usize).filter(|_| mantissa <= EXACT_INTEGER && at > 1)?;
    let value = if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_way_gives_the_nearest_double_as_the_general_one_does() {
        for text in ["1.234567890123E-05", "-9.999999999999E+12", "0.00000E+00", "-0.00000E+00", "+1.5E+00", "7.E-03", "1.1D-02"] {
            let general: f64 = text.replace('D', "E").parse().unwrap();
            assert_eq!(short_decimal(text.as_bytes()).unwrap().to_bits(), general.to_bits(), "{text}");
        }
        for text in
            ["", "E+01", ".E+01", "1.5", "1.5E1", "1.5E+1", "1..5E+01", "1.5E+123", "1.5E-40", "1234567890123456789012E+00", "1.5E+0x"]
        {
            assert_eq!(short_decimal(text.as_bytes()), None, "{text}");
        }
    }
}
