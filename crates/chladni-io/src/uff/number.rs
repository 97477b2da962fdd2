//! One number, as Fortran prints it: exponents with `E`, `e`, `D`, `d` or no letter at
//! all (`1.234-101`), a blank field is 0, stars are an overflow.

use super::decimal::{right_justified, short_decimal};

/// The reason why a field is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// `*****`: the writer's field was too narrow.
    Stars,
    /// NaN, Inf, or too large.
    NotFinite,
    /// Anything else.
    NotANumber,
}

impl Fault {
    pub(super) fn message(self) -> &'static str {
        match self {
            Self::Stars => "the number did not fit its field when the file was written",
            Self::NotFinite => "the number is not finite",
            Self::NotANumber => "text instead of a number",
        }
    }
}

/// A number as Fortran prints and reads it; a blank field is 0.
pub(super) fn float(field: &[u8]) -> std::result::Result<f64, Fault> {
    let text = field.trim_ascii();
    if text.is_empty() {
        return Ok(0.0);
    }
    if let Some(value) = short_decimal(text) {
        return Ok(value);
    }
    let parse = |bytes: &[u8]| {
        std::str::from_utf8(bytes)
            .ok()
            .and_then(|t| t.parse::<f64>().ok())
    };
    let value = match parse(text) {
        Some(value) => value,
        None if text.iter().all(|&c| c == b'*') => return Err(Fault::Stars),
        None => {
            let mut buffer = [0; 48];
            with_exponent_letter(text, &mut buffer)
                .and_then(parse)
                .ok_or(Fault::NotANumber)?
        }
    };
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Fault::NotFinite)
    }
}

/// The number in a field of 13 or 20 columns, in one of the usual forms of dataset 58. `None`
/// for a field that needs the general parser: blank, damaged, touching its neighbour, or cut
/// by the end of its line.
pub(super) fn usual_float(field: &[u8]) -> Option<f64> {
    // Fortran leaves one column for the sign; %13.4e and %20.11e of C leave one more
    let usual = match (field.len(), field.get(3)) {
        (13, Some(b'.')) => right_justified::<13, 3>(field.try_into().ok()?),
        (13, _) => right_justified::<13, 4>(field.try_into().ok()?),
        (20, Some(b'.')) => right_justified::<20, 3>(field.try_into().ok()?),
        (20, _) => right_justified::<20, 4>(field.try_into().ok()?),
        _ => None,
    };
    usual.or_else(|| {
        let alone = field.first() == Some(&b' ') || !field.iter().any(u8::is_ascii_whitespace);
        let in_one_line = !field.contains(&b'\n') && !field.trim_ascii().is_empty();
        float(field).ok().filter(|_| alone && in_one_line)
    })
}

/// `1.2D+03` and `1.2+03` as `1.2E+03`, in `buffer`; `None` where it does not fit.
fn with_exponent_letter<'b>(text: &[u8], buffer: &'b mut [u8; 48]) -> Option<&'b [u8]> {
    let mut length = 0;
    let mut previous = b' ';
    let mut push = |c: u8| {
        *buffer.get_mut(length)? = c;
        length += 1;
        Some(())
    };
    for &c in text {
        if matches!(c, b'+' | b'-') && (previous.is_ascii_digit() || previous == b'.') {
            push(b'E')?;
        }
        push(if matches!(c, b'D' | b'd') { b'E' } else { c })?;
        previous = c;
    }
    buffer.get(..length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fortran_exponent_is_read() {
        for (text, value) in [
            ("  1.5E+01", 15.0),
            ("1.5e1", 15.0),
            ("1.5D+01", 15.0),
            ("-1.5d-01", -0.15),
            ("1.234-101", 1.234e-101),
            ("-1.234+101", -1.234e101),
            ("1.+2", 100.0),
            ("+7", 7.0),
            ("   ", 0.0),
        ] {
            assert_eq!(float(text.as_bytes()), Ok(value), "{text}");
        }
    }

    #[test]
    fn stars_and_what_is_not_finite_are_faults() {
        for (text, fault) in [
            ("*****", Fault::Stars),
            ("NaN", Fault::NotFinite),
            ("-Inf", Fault::NotFinite),
            ("1E999", Fault::NotFinite),
            ("abc", Fault::NotANumber),
            ("1 2", Fault::NotANumber),
            ("--1", Fault::NotANumber),
        ] {
            assert_eq!(float(text.as_bytes()), Err(fault), "{text}");
        }
    }
}
