//! Whole numbers on the command line, each within its range.

use chladni_frf::{Error, ErrorKind, Result};
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// `text` as a whole number within `range`.
///
/// * `of`: its unit, as in " of Hz"; empty where it has none
/// * `wrong`: what another text is not, as in "no port"
///
/// # Errors
/// [`ErrorKind::Usage`] that says `wrong` and the range.
pub fn whole_number<T>(text: &str, range: RangeInclusive<T>, of: &str, wrong: &str) -> Result<T>
where
    T: FromStr + PartialOrd + Display,
{
    let number = text
        .parse::<T>()
        .ok()
        .filter(|number| range.contains(number));
    number.ok_or_else(|| {
        let expected = in_range(range.start(), range.end(), of);
        Error::new(ErrorKind::Usage, wrong).expected(expected)
    })
}

/// The whole numbers of a range, in words.
pub(crate) fn in_range(low: impl Display, high: impl Display, of: &str) -> String {
    format!("a whole number{of} from {low} to {high}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_out_of_its_range_is_told_the_range_with_its_unit() {
        let rate = |text: &str| whole_number(text, 1..=u32::MAX, " of Hz", "no sampling rate");
        assert_eq!(rate("4294967295"), Ok(u32::MAX));
        for text in ["0", "4294967296", "-5", "44100.5", "48k", ""] {
            let error = rate(text).unwrap_err();
            assert_eq!(error.message, "no sampling rate");
            let expected = error.expected.as_deref();
            assert_eq!(
                expected,
                Some("a whole number of Hz from 1 to 4294967295"),
                "{text}"
            );
        }
        let threads = whole_number("1025", 1..=1024_u16, "", "no such number of threads");
        let expected = threads.unwrap_err().expected;
        assert_eq!(expected.as_deref(), Some("a whole number from 1 to 1024"));
    }
}
