//! Exact steps of even axes: dataset 58 prints start and step with six digits.
//!
//! 2.44140625 Hz is stored as 2.44141, which puts line 6399 off by 0.024 Hz: enough to
//! bias the damping of a sharp mode. But the steps of real instruments are not arbitrary: a
//! step is a sampling rate over a power of two, or one over a whole number of seconds. If
//! exactly one such number prints as the digits of the file, it is the candidate.

/// A printed number and its precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Printed {
    pub value: f64,
    /// Half a unit of the last printed digit.
    pub half_unit: f64,
    /// Significant digits up to the last that is not 0.
    pub digits_used: usize,
    /// Significant digits printed.
    pub digits: usize,
}

impl Printed {
    /// Reads the digits of `text`, whose value is known to be `value`.
    pub(super) fn new(text: &[u8], value: f64) -> Self {
        let mantissa = text
            .trim_ascii()
            .strip_prefix(b"-")
            .unwrap_or(text.trim_ascii());
        let length = mantissa
            .iter()
            .position(|c| !(c.is_ascii_digit() || *c == b'.'))
            .unwrap_or(mantissa.len());
        let mantissa = &mantissa[..length];
        let significant: Vec<u8> = mantissa
            .iter()
            .copied()
            .filter(u8::is_ascii_digit)
            .skip_while(|&c| c == b'0')
            .take(40)
            .collect();
        let digits = significant.len();
        let digits_used = significant
            .iter()
            .rposition(|&c| c != b'0')
            .map_or(0, |k| k + 1);
        let leading = if value == 0.0 {
            0.0
        } else {
            value.abs().log10().floor()
        };
        let half_unit = if digits == 0 {
            0.0
        } else {
            0.5 * 10f64.powf(leading - (digits as f64 - 1.0))
        };
        Self {
            value,
            half_unit,
            digits_used,
            digits,
        }
    }

    /// True where `exact` prints as these digits.
    pub(super) fn agrees(&self, exact: f64) -> bool {
        (exact - self.value).abs() <= self.half_unit * (1.0 + ROUNDING)
    }

    /// The exact step that the digits may stand for; `None` where it equals their value.
    pub(super) fn candidate(&self) -> Option<f64> {
        let written_out = self.digits_used + 2 <= self.digits || self.digits >= EXACT_DIGITS;
        if written_out {
            return None; // 1.250000 means 1.25
        }
        candidate(self.value, self.half_unit).filter(|&exact| exact != self.value)
    }
}

/// Slack for the rounding of decimal fractions, relative to half a unit of the last
/// digit.
const ROUNDING: f64 = 1e-6;
/// Digits from which an axis is exact enough: at line 10⁶ the error is below 10⁻⁴ of a line.
const EXACT_DIGITS: usize = 10;
/// Longest record in whole seconds, T, for a step of 1/T. With ten times more, one number in
/// twenty would match by chance.
const LONGEST_RECORD_S: f64 = 1000.0;
/// Factors of sampling rates beside powers of two and five: 44.1 kHz has 441, 48 kHz has
/// 3; the others are multiples m·f_s/2^k. Every entry adds a probability of about 10⁻⁴ of a
/// match by chance.
const RATE_FACTORS: [f64; 9] = [1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 13.0, 15.0, 441.0];
/// Largest power of five in a sampling rate: 10⁸ samples per second.
const LARGEST_POWER_OF_FIVE: i32 = 8;

/// The exact number within `half_unit` of `value` that a sampling rate or a record length
/// explains.
///
/// f_s·m/2^k with f_s = 2^a·5^b·m, its inverse (time steps), or 1/T.
pub(super) fn candidate(value: f64, half_unit: f64) -> Option<f64> {
    if !(value.is_finite() && value > 0.0 && half_unit > 0.0 && half_unit < value) {
        return None;
    }
    let fits = |exact: f64| (exact - value).abs() <= half_unit * (1.0 + ROUNDING);
    let seconds = (1.0 / value).round();
    if (1.0..=LONGEST_RECORD_S).contains(&seconds) && fits(1.0 / seconds) {
        return Some(1.0 / seconds);
    }
    for five in 0..=LARGEST_POWER_OF_FIVE {
        for factor in RATE_FACTORS {
            let odd = factor * 5f64.powi(five);
            for rate in [odd, 1.0 / odd] {
                let exact = rate * 2f64.powi((value / rate).log2().round() as i32);
                if fits(exact) {
                    return Some(exact);
                }
            }
        }
    }
    None
}

/// The exact even axis (start, step) of abscissa values printed with six digits; `None` where
/// the values are not even, or exact already.
pub(super) fn even_behind(values: &[f64], tagged_step: Option<f64>) -> Option<(f64, f64)> {
    let (&first, &last) = (values.first()?, values.last()?);
    let intervals = values.len().checked_sub(1).filter(|&n| n >= 2)? as f64;
    let open = half_unit_of_six_digits(first.abs().max(last.abs()));
    let mean = (last - first) / intervals;
    let step = tagged_step.or_else(|| candidate(mean, 2.0 * open / intervals))?;
    let start = multiple_near(first, step, half_unit_of_six_digits(first));
    let mut exact = true;
    for (k, &value) in values.iter().enumerate() {
        let difference = (start + step * k as f64 - value).abs();
        // a bound below half a unit of any six digits spares most values the logarithm
        let surely_within = difference <= 0.5e-6 * value.abs();
        if !surely_within && difference > half_unit_of_six_digits(value) * (1.0 + ROUNDING) {
            return None;
        }
        exact &= difference <= step.abs() * ROUNDING;
    }
    (!exact).then_some((start, step))
}

/// The multiple of `step` that prints as `start`, else `start` itself.
pub(super) fn multiple_near(start: f64, step: f64, half_unit: f64) -> f64 {
    let multiple = (start / step).round() * step;
    if multiple.is_finite() && (multiple - start).abs() <= half_unit * (1.0 + ROUNDING) {
        multiple
    } else {
        start
    }
}

fn half_unit_of_six_digits(value: f64) -> f64 {
    if value == 0.0 {
        0.0
    } else {
        0.5 * 10f64.powf(value.abs().log10().floor() - 5.0)
    }
}

/// The number after `key` in an ID line: `df=2.44140625`.
pub(super) fn tagged(id_line: &str, key: &str) -> Option<f64> {
    let word = id_line
        .split_whitespace()
        .find_map(|word| word.strip_prefix(key))?;
    word.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(text: &str) -> Printed {
        Printed::new(text.as_bytes(), text.trim().parse().unwrap())
    }

    #[test]
    fn steps_of_instruments_are_recognised_behind_six_digits() {
        for (text, exact) in [
            ("  2.44141E+00", 2.44140625),
            ("  3.33333E-01", 1.0 / 3.0),
            ("  1.95313E-05", 1.0 / 51200.0),
            ("  2.26757E-05", 1.0 / 44100.0),
            ("  1.46484E+00", 1.46484375),      // 48000 / 32768
            ("  1.34583E+00", 1.3458251953125), // 44100 / 32768
            ("  3.90625E-02", 0.0390625),
        ] {
            let printed = printed(text);
            assert!(printed.agrees(exact), "{text}");
            assert_eq!(
                printed.candidate().unwrap_or(printed.value),
                exact,
                "{text}"
            );
        }
    }

    #[test]
    fn steps_that_are_exact_as_printed_have_no_candidate() {
        for text in [
            "1.00000E-01",
            "5.00000E-01",
            "3.12500E-01",
            "1.00000E+00",
            "1.23000E+00",
            "0.0",
            "1.234567890123E+00",
        ] {
            assert_eq!(printed(text).candidate(), None, "{text}");
        }
    }

    #[test]
    fn arbitrary_steps_have_no_candidate() {
        let by_chance = (0..1000)
            .filter(|k| {
                printed(&format!("{:.5e}", 1.0 + f64::from(*k) * 0.0089137))
                    .candidate()
                    .is_some()
            })
            .count();
        assert!(by_chance <= 5, "{by_chance} of 1000");
    }

    #[test]
    fn an_uneven_axis_of_printed_multiples_is_recognised() {
        let exact: Vec<f64> = (0..6400).map(|k| 2.44140625 * f64::from(k)).collect();
        let printed: Vec<f64> = exact
            .iter()
            .map(|x| format!("{x:.5e}").parse().unwrap())
            .collect();
        assert_eq!(even_behind(&printed, None), Some((0.0, 2.44140625)));
        assert_eq!(even_behind(&exact, None), None, "already exact");
        let uneven: Vec<f64> = (0..100).map(|k| f64::from(k * k)).collect();
        assert_eq!(even_behind(&uneven, None), None);
    }

    #[test]
    fn tags_are_found_in_id_lines() {
        assert_eq!(tagged("run 3 df=0.1 start=5", "df="), Some(0.1));
        assert_eq!(tagged("df=abc", "df="), None);
        assert_eq!(tagged("NONE", "df="), None);
    }
}
