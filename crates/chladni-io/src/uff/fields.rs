//! Fields of fixed width: cut by columns, or at blanks where these do not parse. Adjacent
//! numbers may touch, so that cutting at blanks alone is not enough.

use super::number::{float, Fault};
use chladni_frf::{Error, Finding, Result};

/// One line of the file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record<'a> {
    /// Line in the file, counted from 1.
    pub line: u64,
    /// The line without its end.
    pub text: &'a [u8],
}

/// The extent of a field in its line: first byte, and one past the last.
type Span = (usize, usize);

/// Puts the spans of the columns of `widths` into `spans`. Returns the number of columns up to
/// the last that is not blank. `None` where the line was not written in these columns: a token
/// crosses a border without filling its column, or lies beyond the last column.
fn column_spans(text: &[u8], widths: &[usize], spans: &mut [Span]) -> Option<usize> {
    let length = text.trim_ascii_end().len();
    let mut start = 0;
    let mut filled = 0;
    for (k, (span, &width)) in spans.iter_mut().zip(widths).enumerate() {
        let end = (start + width).min(length);
        *span = (start.min(end), end);
        let field = &text[start.min(end)..end];
        if !field.trim_ascii().is_empty() {
            filled = k + 1;
            let touches = start > 0
                && !text[start - 1].is_ascii_whitespace()
                && !field[0].is_ascii_whitespace();
            if touches && (field.len() < width || field.iter().any(u8::is_ascii_whitespace)) {
                return None;
            }
        }
        start = end;
    }
    (start >= length).then_some(filled)
}

/// Puts the spans of the tokens between blanks into `spans`, also cut before a sign after a
/// complete exponent. Returns their number.
fn token_spans(text: &[u8], spans: &mut [Span]) -> usize {
    let mut count = 0;
    let mut push = |span: Span| {
        if let Some(slot) = spans.get_mut(count) {
            *slot = span;
        }
        count += 1;
    };
    let mut start: Option<usize> = None;
    let mut exponent = false;
    for (k, &c) in text.iter().enumerate() {
        let complete = exponent && matches!(c, b'+' | b'-') && text[k - 1].is_ascii_digit();
        if let Some(begin) = start.filter(|_| c.is_ascii_whitespace() || complete) {
            push((begin, k));
            start = None;
            exponent = false;
        }
        if !c.is_ascii_whitespace() {
            start.get_or_insert(k);
            exponent |= matches!(c, b'E' | b'e' | b'D' | b'd');
        }
    }
    if let Some(begin) = start {
        push((begin, text.len()));
    }
    count
}

/// The layout in which the numbers of a line were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FieldLayout {
    /// In columns; number of fields up to the last that is not blank.
    Columns(usize),
    /// Between blanks; number of fields.
    Blanks(usize),
}

/// A field that is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BadField {
    /// Index of the field in the line, from 0.
    pub index: usize,
    /// Its bytes in the line.
    pub span: Span,
    pub fault: Fault,
}

/// Most fields in a line of any dataset read here.
const MOST_FIELDS: usize = 12;

/// Puts the numbers of a line into `values`, one per width; missing ones at the end become 0.
pub(super) fn line_numbers(
    text: &[u8],
    widths: &[usize],
    values: &mut [f64],
) -> std::result::Result<FieldLayout, BadField> {
    let mut spans = [(0, 0); MOST_FIELDS];
    let columns = match column_spans(text, widths, &mut spans[..widths.len()]) {
        Some(filled) => match parse_spans(text, &spans[..filled], values) {
            Ok(()) => return Ok(FieldLayout::Columns(filled)),
            Err(bad) if bad.fault != Fault::NotANumber => return Err(bad),
            Err(bad) => bad,
        },
        None => BadField {
            index: 0,
            span: (0, text.trim_ascii_end().len()),
            fault: Fault::NotANumber,
        },
    };
    let count = token_spans(text, &mut spans);
    if count > values.len() {
        return Err(columns);
    }
    match parse_spans(text, &spans[..count], values) {
        Ok(()) => Ok(FieldLayout::Blanks(count)),
        Err(bad) => Err(bad),
    }
}

/// Number of fields in a line, with those that are no numbers.
pub(super) fn count_fields(text: &[u8], widths: &[usize]) -> usize {
    let mut spans = [(0, 0); MOST_FIELDS];
    let filled = column_spans(text, widths, &mut spans[..widths.len()]);
    let one_token_each = spans.iter().all(|&(start, end)| {
        !text[start..end]
            .trim_ascii()
            .iter()
            .any(u8::is_ascii_whitespace)
    });
    filled
        .filter(|_| one_token_each)
        .unwrap_or_else(|| token_spans(text, &mut spans))
}

/// Number of words between blanks.
pub(super) fn count_tokens(bytes: &[u8]) -> u64 {
    bytes
        .split(u8::is_ascii_whitespace)
        .filter(|token| !token.is_empty())
        .count() as u64
}

/// Puts the numbers of a line that [`line_numbers`] refuses into `values`, with NaN for every
/// field that is no number. Returns the number of these fields.
pub(super) fn masked_numbers(text: &[u8], widths: &[usize], values: &mut [f64]) -> usize {
    let mut spans = [(0, 0); MOST_FIELDS];
    if token_spans(text, &mut spans) != values.len() {
        column_spans(text, widths, &mut spans[..widths.len()]);
    }
    let mut bad = 0;
    for (value, &(start, end)) in values.iter_mut().zip(&spans) {
        let field = &text[start.min(text.len())..end.min(text.len())];
        *value = float(field)
            .ok()
            .filter(|_| !field.trim_ascii().is_empty())
            .unwrap_or(f64::NAN);
        bad += usize::from(value.is_nan());
    }
    bad
}

fn parse_spans(
    text: &[u8],
    spans: &[Span],
    values: &mut [f64],
) -> std::result::Result<(), BadField> {
    for (index, value) in values.iter_mut().enumerate() {
        *value = match spans.get(index) {
            Some(&span) => {
                float(&text[span.0..span.1]).map_err(|fault| BadField { index, span, fault })?
            }
            None => 0.0,
        };
    }
    Ok(())
}

/// A column of numbers: its name in messages, and its width.
pub(super) type Column = (&'static str, usize);

/// The numbers of a record of fixed columns.
///
/// # Errors
/// Bad data with line, field and columns.
pub(super) fn numbers<const N: usize>(
    record: Record<'_>,
    columns: [Column; N],
    warnings: &mut Vec<Finding>,
) -> Result<[f64; N]> {
    let mut values = [0.0; N];
    match line_numbers(record.text, &columns.map(|(_, width)| width), &mut values) {
        Ok(FieldLayout::Columns(_)) => Ok(values),
        Ok(FieldLayout::Blanks(_)) => {
            warn_split(record.line, warnings);
            Ok(values)
        }
        Err(bad) => Err(bad_field(
            record,
            columns.get(bad.index).map_or("", |c| c.0),
            bad,
        )),
    }
}

/// Warns, once per dataset, of a line that was not written in the columns of the format.
pub(super) fn warn_split(line: u64, warnings: &mut Vec<Finding>) {
    const WHAT: &str = "not in the format's columns, split on blanks (first such line)";
    if !warnings.iter().any(|warning| warning.text.ends_with(WHAT)) {
        warnings.push(Finding::note(
            "loosely-written",
            format!("line {line}: {WHAT}"),
        ));
    }
}

/// The error of a field that is no number.
pub(super) fn bad_field(record: Record<'_>, name: &str, bad: BadField) -> Error {
    let (start, end) = bad.span;
    Error::bad_data(bad.fault.message())
        .at_line(record.line)
        .field(format!(
            "{name}, columns {} to {}",
            start + 1,
            end.max(start + 1)
        ))
        .found(decode(record.text.get(start..end).unwrap_or_default()).trim())
        .expected("a finite decimal number")
        .help(
            "correct the file at that line; `lenient` masks values of a function that cannot be \
               read",
        )
}

/// A number that must be whole.
///
/// # Errors
/// Bad data with line and field.
pub(super) fn whole(record: Record<'_>, name: &str, value: f64) -> Result<i64> {
    const LARGEST: f64 = 9_007_199_254_740_992.0; // 2^53: above, f64 no longer counts in steps of 1
    if value.fract() == 0.0 && value.abs() <= LARGEST {
        return Ok(value as i64);
    }
    Err(Error::bad_data("a whole number must stand here")
        .at_line(record.line)
        .field(name)
        .found(value)
        .expected("an integer"))
}

/// Text in UTF-8, else Latin-1, which never fails.
pub(super) fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// A trimmed text field; `NONE` becomes empty.
pub(super) fn label(text: &str) -> String {
    let trimmed = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
    if trimmed.eq_ignore_ascii_case("none") {
        String::new()
    } else {
        trimmed.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(text: &str, widths: &[usize]) -> (FieldLayout, Vec<f64>) {
        let mut values = vec![0.0; widths.len()];
        let found = line_numbers(text.as_bytes(), widths, &mut values).unwrap();
        (found, values)
    }

    #[test]
    fn touching_numbers_are_cut_by_column() {
        assert_eq!(
            line("-1.23456E-101-2.34567E-101", &[13, 13]),
            (FieldLayout::Columns(2), vec![-1.23456e-101, -2.34567e-101])
        );
        assert_eq!(
            line("12345678901234567890", &[10, 10]),
            (FieldLayout::Columns(2), vec![1234567890.0, 1234567890.0])
        );
    }

    #[test]
    fn numbers_that_touch_outside_the_columns_are_cut_at_the_sign() {
        assert_eq!(
            line("-1.23456E+00-2.34567E-01", &[13, 13]),
            (FieldLayout::Blanks(2), vec![-1.23456, -0.234567])
        );
    }

    #[test]
    fn free_format_is_split_on_blanks() {
        assert_eq!(
            line("1.0 2.0 3.0", &[13, 13, 13]),
            (FieldLayout::Blanks(3), vec![1.0, 2.0, 3.0])
        );
        assert_eq!(
            line("1.234567890123456\t2.0", &[13, 13]),
            (FieldLayout::Blanks(2), vec![1.234567890123456, 2.0])
        );
    }

    #[test]
    fn a_blank_field_between_others_is_zero() {
        assert_eq!(
            line("  1.00000E+00               3.00000E+00", &[13, 13, 13]),
            (FieldLayout::Columns(3), vec![1.0, 0.0, 3.0])
        );
    }

    #[test]
    fn labels_are_trimmed_and_none_is_empty() {
        assert_eq!(label("None      "), "");
        assert_eq!(label(&decode(b" m/s\xb2 ")), "m/s²");
        assert_eq!(label(&decode("m/s²".as_bytes())), "m/s²");
    }
}
