//! Fast parsing of the common forms of printed numbers, which take most of the time of
//! reading a text file.

/// The powers of ten that a double holds exactly.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];
/// Integers up to this are exact in a double.
const EXACT_INTEGER: u64 = 1 << 53;

/// A number as writers print it, `-1.234567890123E-05`, where one rounding gives the
/// nearest double: the digits are an exact integer and the power of ten is exact (W.
/// Clinger, PLDI 1990). `None` for all other texts. Twice as fast as the general parser.
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
    let exponent = two_digit_exponent(digits.get(at..)?.try_into().ok()?)?;
    (at > 1).then(|| scaled(negative, mantissa, exponent - decimals.unwrap_or(0)))?
}

/// A field of `W` columns as `E13.5`, `E20.12` and C's `%20.11e` print it:
/// right-justified, one digit, the point in column `POINT` (from 0), decimals to the
/// exponent. `None` for everything else; three times as fast as [`short_decimal`],
/// because the digits are read eight at a time.
pub(super) fn right_justified<const W: usize, const POINT: usize>(field: &[u8; W]) -> Option<f64> {
    let negative = match &field[..POINT - 1] {
        [blank @ .., sign @ (b' ' | b'-' | b'+')] if blank.iter().all(|&c| c == b' ') => {
            *sign == b'-'
        }
        _ => return None,
    };
    let exponent = two_digit_exponent(field[W - 4..].try_into().ok()?)?;
    let decimals = &field[POINT + 1..W - 4];
    // first the digit before the point and all decimals but the last eight, padded with
    // zeros in front; then these eight
    let (first, last) = decimals.split_at(decimals.len().saturating_sub(8));
    let mut high = [b'0'; 8];
    let mut low = [b'0'; 8];
    high[7 - first.len()] = field[POINT - 1];
    high[8 - first.len()..].copy_from_slice(first);
    low[8 - last.len()..].copy_from_slice(last);
    let below = const {
        10_u64.pow(if W - 5 - POINT < 8 {
            (W - 5 - POINT) as u32
        } else {
            8
        })
    };
    let mantissa = eight_digits(high)? * below + eight_digits(low)?;
    (field[POINT] == b'.').then(|| scaled(negative, mantissa, exponent - decimals.len() as i32))?
}

/// The value of eight decimal digits (after D. Lemire, "Quickly parsing eight digits",
/// 2018).
fn eight_digits(digits: [u8; 8]) -> Option<u64> {
    let values = u64::from_le_bytes(digits) ^ 0x3030_3030_3030_3030;
    if (values | values.wrapping_add(0x7676_7676_7676_7676)) & 0x8080_8080_8080_8080 != 0 {
        return None;
    }
    const PAIRS: u64 = 0x0000_00ff_0000_00ff;
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8);
    let high = (pairs & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
    let low = (pairs >> 16 & PAIRS).wrapping_mul(1 + (10_000 << 32));
    Some(high.wrapping_add(low) >> 32)
}

/// The exponent in `E-05`, with any letter that Fortran uses.
fn two_digit_exponent(text: [u8; 4]) -> Option<i32> {
    let [b'E' | b'D' | b'e' | b'd', sign @ (b'+' | b'-'), tens @ b'0'..=b'9', ones @ b'0'..=b'9'] =
        text
    else {
        return None;
    };
    let exponent = i32::from(tens - b'0') * 10 + i32::from(ones - b'0');
    Some(if sign == b'-' { -exponent } else { exponent })
}

/// ±`mantissa`·10^`exponent`, where both are exact.
fn scaled(negative: bool, mantissa: u64, exponent: i32) -> Option<f64> {
    let power = EXACT_POWERS
        .get(exponent.unsigned_abs() as usize)
        .filter(|_| mantissa <= EXACT_INTEGER)?;
    let value = if exponent < 0 {
        mantissa as f64 / power
    } else {
        mantissa as f64 * power
    };
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_way_gives_the_nearest_double_as_the_general_one_does() {
        for text in [
            "1.234567890123E-05",
            "-9.999999999999E+12",
            "0.00000E+00",
            "-0.00000E+00",
            "+1.5E+00",
            "7.E-03",
            "1.1D-02",
        ] {
            let general: f64 = text.replace('D', "E").parse().unwrap();
            assert_eq!(
                short_decimal(text.as_bytes()).unwrap().to_bits(),
                general.to_bits(),
                "{text}"
            );
        }
        for text in [
            "",
            "E+01",
            ".E+01",
            "1.5",
            "1.5E1",
            "1.5E+1",
            "1..5E+01",
            "1.5E+123",
            "1.5E-40",
            "1234567890123456789012E+00",
            "1.5E+0x",
        ] {
            assert_eq!(short_decimal(text.as_bytes()), None, "{text}");
        }
    }

    fn field<const W: usize, const POINT: usize>(text: &str) -> Option<f64> {
        right_justified::<W, POINT>(text.as_bytes().try_into().unwrap())
    }

    #[test]
    fn fields_of_the_usual_forms_give_the_nearest_double() {
        let mut state = 1_u64;
        for k in 0..20_000 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let value = (state as i64) as f64 * 10_f64.powi(k % 24 - 30);
            for (text, read) in [
                (
                    format!("{:>20}", c_exponent(&format!("{value:.12e}"))),
                    field::<20, 3> as fn(&str) -> Option<f64>,
                ),
                (
                    format!("{:>20}", c_exponent(&format!("{value:.11e}"))),
                    field::<20, 4>,
                ),
                (
                    format!("{:>13}", c_exponent(&format!("{value:.5e}"))),
                    field::<13, 3>,
                ),
            ] {
                if let Some(read) = read(&text) {
                    assert_eq!(
                        read.to_bits(),
                        text.trim().parse::<f64>().unwrap().to_bits(),
                        "{text}"
                    );
                } else {
                    assert!(
                        value.abs() < 1e-9,
                        "{text}: only far from 1 the general way is needed"
                    );
                }
            }
        }
    }

    /// Rust's `1.5e-7` as C's `1.5e-07`.
    fn c_exponent(text: &str) -> String {
        let (mantissa, exponent) = text.split_once('e').unwrap();
        format!("{mantissa}e{:+03}", exponent.parse::<i32>().unwrap())
    }

    #[test]
    fn fields_of_another_form_are_left_to_the_general_way() {
        for text in [
            "  1.23456E+0x",
            "  1.23456+001",
            "  1,23456E+00",
            "  1.2345 E+00",
            "   .23456E+00",
            " 11.23456E+00",
            "-x1.23456E+00",
            "x-1.23456E+00",
            "  1.234567E+0",
            "             ",
            "*************",
            "  1.2345/E+00",
            "  1.2345:E+00",
            "   1.2345E+00",
            "- 1.23456E+00",
        ] {
            assert_eq!(field::<13, 3>(text), None, "{text}");
        }
        assert_eq!(field::<13, 3>(" -1.23456D+02"), Some(-123.456));
        assert_eq!(field::<13, 3>(" +1.23456d-02"), Some(0.0123456));
        assert_eq!(field::<13, 3>("  0.00000E+00").map(f64::to_bits), Some(0));
    }
}
