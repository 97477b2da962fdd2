//! Text of a table: encoding, lines, comments, delimiter, decimal sign, numbers.

use crate::limits::LINES_TRIED;
use chladni_frf::{Error, Result};
use std::borrow::Cow;

/// The text of a file: UTF-8, UTF-16 with its mark, else Latin-1, which never fails.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some(rest) = bytes.strip_prefix(b"\xef\xbb\xbf") {
        return decode(rest);
    }
    for (mark, big) in [(b"\xff\xfe", false), (b"\xfe\xff", true)] {
        if let Some(rest) = bytes.strip_prefix(mark) {
            let unit = |pair: &[u8]| {
                if big {
                    u16::from_be_bytes([pair[0], pair[1]])
                } else {
                    u16::from_le_bytes([pair[0], pair[1]])
                }
            };
            let units: Vec<u16> = rest.chunks_exact(2).map(unit).collect();
            return String::from_utf16_lossy(&units).into();
        }
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes
            .iter()
            .map(|&byte| char::from(byte))
            .collect::<String>()
            .into(),
    }
}

/// A line that is not blank, with its number counted from 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) number: u64,
    pub(super) text: &'a str,
    /// True for a comment, whose sign is cut off: it may be the header, but no row.
    pub(super) is_comment: bool,
}

/// The rule that cuts a table into cells, and the decimal point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    /// `None`: runs of blanks.
    pub(super) delimiter: Option<char>,
    pub(super) decimal_comma: bool,
}

/// All dialects; where several fit equally, the first is taken.
const DIALECTS: [Dialect; 7] = [
    Dialect {
        delimiter: Some('\t'),
        decimal_comma: false,
    },
    Dialect {
        delimiter: Some(';'),
        decimal_comma: false,
    },
    Dialect {
        delimiter: Some(','),
        decimal_comma: false,
    },
    Dialect {
        delimiter: None,
        decimal_comma: false,
    },
    Dialect {
        delimiter: Some('\t'),
        decimal_comma: true,
    },
    Dialect {
        delimiter: Some(';'),
        decimal_comma: true,
    },
    Dialect {
        delimiter: None,
        decimal_comma: true,
    },
];
/// Commas as delimiter and decimal sign: such a table is refused.
const COMMAS: Dialect = Dialect {
    delimiter: Some(','),
    decimal_comma: true,
};

impl Dialect {
    /// The dialect in which most lines are rows of numbers; `None` where no line is.
    pub(super) fn detect(lines: &[Line<'_>]) -> Option<Self> {
        let rows = |dialect: &Dialect| dialect.rows_among(lines);
        let mut best = None;
        for dialect in DIALECTS {
            let count = rows(&dialect);
            if count > best.map_or(0, |(found, _)| found) {
                best = Some((count, dialect));
            }
        }
        best.map(|(_, dialect)| dialect)
    }

    fn rows_among(self, lines: &[Line<'_>]) -> usize {
        lines
            .iter()
            .filter(|line| !line.is_comment)
            .take(LINES_TRIED)
            .filter(|line| self.is_row(line.text))
            .count()
    }

    /// True where lines are rows of numbers only if commas are both decimal sign and delimiter.
    pub(super) fn commas_everywhere(lines: &[Line<'_>]) -> bool {
        COMMAS.rows_among(lines) > 0
    }

    /// True where some dialect finds two rows of numbers or more; one alone may be a date in a
    /// letter.
    pub(super) fn any_finds_rows(lines: &[Line<'_>]) -> bool {
        DIALECTS
            .iter()
            .chain([&COMMAS])
            .any(|dialect| dialect.rows_among(lines) > 1)
    }

    /// True where a line is a row of numbers in some dialect.
    pub(super) fn any_finds_row(line: &str) -> bool {
        DIALECTS
            .iter()
            .chain([&COMMAS])
            .any(|dialect| dialect.is_row(line))
    }

    /// Every dialect, this one first: the header may have another dialect than the numbers.
    pub(super) fn and_others(self) -> impl Iterator<Item = Self> {
        std::iter::once(self).chain(
            DIALECTS
                .into_iter()
                .filter(move |other| !other.decimal_comma && other.delimiter != self.delimiter),
        )
    }

    /// Cells of a line, trimmed, quotes removed.
    pub(super) fn cells<'a>(self, line: &'a str) -> Vec<Cow<'a, str>> {
        let Some(delimiter) = self.delimiter else {
            return line.split_whitespace().map(unquoted).collect();
        };
        let mut cells = Vec::new();
        let (mut start, mut quoted) = (0, false);
        for (at, c) in line.char_indices() {
            if c == '"' {
                quoted = !quoted;
            } else if c == delimiter && !quoted {
                cells.push(unquoted(&line[start..at]));
                start = at + c.len_utf8();
            }
        }
        cells.push(unquoted(&line[start..]));
        cells
    }

    /// True where the first cell and at least one other are numbers, and the rest are numbers
    /// or empty.
    pub(super) fn is_row(self, line: &str) -> bool {
        let cells = self.cells(line);
        let values = cells
            .iter()
            .filter(|cell| matches!(self.number(cell), Cell::Value(_)))
            .count();
        let clean = cells
            .iter()
            .all(|cell| !matches!(self.number(cell), Cell::Text));
        values >= 2 && clean && matches!(self.number(&cells[0]), Cell::Value(_))
    }

    /// True for a damaged row of a table of `columns` columns: it begins with a number, or holds
    /// nothing but numbers and gaps.
    pub(super) fn is_damaged_row(self, line: &str, columns: usize) -> bool {
        let cells = self.cells(line);
        let number = |cell: &Cow<'_, str>| self.number(cell);
        cells.len() == columns
            && (matches!(number(&cells[0]), Cell::Value(_))
                || (cells.iter().all(|cell| number(cell) != Cell::Text)
                    && cells
                        .iter()
                        .any(|cell| matches!(number(cell), Cell::Value(_)))))
    }

    /// The content of a cell.
    pub(super) fn number(self, cell: &str) -> Cell {
        let cell = cell.trim();
        let start = cell.trim_start_matches(['+', '-']);
        if cell.is_empty() || is_gap(start) {
            return Cell::Empty;
        }
        if !start.starts_with(|c: char| {
            c.is_ascii_digit() || c == '.' || (self.decimal_comma && c == ',')
        }) {
            return if start.to_ascii_lowercase().starts_with("inf") || start.starts_with('*') {
                Cell::Overflow
            } else {
                Cell::Text
            };
        }
        if start.to_ascii_lowercase().starts_with("1.#inf") {
            return Cell::Overflow;
        }
        // with decimal commas, a point separates thousands, or the dialect is wrong
        if self.decimal_comma && (cell.contains('.') || cell.ends_with(',')) {
            return Cell::Text;
        }
        let plain: Cow<'_, str> = if self.decimal_comma && cell.contains(',') {
            cell.replacen(',', ".", 1).into()
        } else {
            cell.into()
        };
        // Fortran writes 1.5D+03
        let parsed = plain
            .parse()
            .or_else(|_| plain.replace(['D', 'd'], "e").parse::<f64>());
        match parsed {
            Ok(value) if value.is_finite() => Cell::Value(value),
            Ok(_) => Cell::Overflow,
            Err(_) => Cell::Text,
        }
    }
}

/// True for a text (without sign) that programs write in place of a number.
fn is_gap(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let not_a_number = lower.strip_prefix("nan").is_some_and(|rest| {
        rest.is_empty() || rest.starts_with('(') // `nan(ind)` of the C library
    });
    not_a_number
        || ["na", "n/a", "null", "1.#qnan", "1.#snan", "1.#ind"]
            .iter()
            .any(|gap| lower == *gap)
}

/// True for a text like a number with separators of thousands: `1,000.5`, `1.000`, `1 000`,
/// `1'000`.
pub(super) fn has_thousands(cell: &str) -> bool {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let cell = cell.trim().trim_start_matches(['+', '-']);
    let separator = cell.chars().nth(digits(cell));
    let Some(separator) = separator.filter(|c| c.is_whitespace() || ",.'’".contains(*c)) else {
        return false;
    };
    let mut groups = cell.split(separator);
    let first = groups.next().map_or(0, str::len);
    let last = groups.next_back().unwrap_or_default();
    let is_end = match last.get(3..).map(str::as_bytes) {
        Some([]) => true,
        Some([sign, decimals @ ..]) => {
            b".,".contains(sign) && decimals.iter().all(u8::is_ascii_digit)
        }
        None => false,
    };
    (1..=3).contains(&first)
        && digits(last) == 3
        && is_end
        && groups.all(|group| group.len() == 3 && digits(group) == 3)
}

/// Content of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    Value(f64),
    /// Empty or NaN: not measured.
    Empty,
    /// Infinite, too large, or asterisks.
    Overflow,
    Text,
}

fn unquoted(cell: &str) -> Cow<'_, str> {
    let cell = cell.trim();
    match cell
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'))
    {
        Some(inner) if inner.contains("\"\"") => inner.replace("\"\"", "\"").into(),
        Some(inner) => inner.trim().into(),
        None => cell.into(),
    }
}

/// The error of rows with a decimal point in some cells and a comma in others, if there are any.
pub(super) fn both_signs(lines: &[Line<'_>]) -> Option<Error> {
    let begins_as_number = |cell: &str| {
        let cell = cell.trim_start_matches(['+', '-']);
        cell.starts_with(|c: char| c.is_ascii_digit())
            && cell
                .chars()
                .all(|c| c.is_ascii_digit() || ".,eE+-".contains(c))
    };
    let is_row = |line: &&Line<'_>| {
        let mut dialects = DIALECTS.iter().filter(|dialect| dialect.decimal_comma);
        !line.is_comment
            && line.text.contains('.')
            && line.text.contains(',')
            && dialects.any(|dialect| {
                let cells = dialect.cells(line.text);
                cells.len() > 1 && cells.iter().all(|cell| begins_as_number(cell))
            })
    };
    let line = lines.iter().take(LINES_TRIED).find(is_row)?;
    Some(
        Error::bad_data("a point and a comma among the digits of one row")
            .at_line(line.number)
            .found(line.text.trim())
            .expected("one decimal sign in all numbers, and no separators of thousands")
            .help("export the numbers again with one decimal sign, point or comma"),
    )
}

/// Refuses rows of more cells than names, up to twice as many: decimal commas were taken for
/// delimiters.
pub(super) fn refuse_decimal_comma(
    first: &Line<'_>,
    header: &[Line<'_>],
    dialect: Dialect,
    filled: usize,
) -> Result<()> {
    let Some(last) = header.last().filter(|_| dialect.delimiter == Some(',')) else {
        return Ok(());
    };
    let names = dialect.cells(last.text).len();
    if names >= 2 && names < filled && filled <= 2 * names {
        return Err(both_commas(
            Error::bad_data("more columns than names; do the numbers have a decimal comma?")
                .at_line(first.number)
                .found(format!(
                    "{filled} columns under {names} names: {}",
                    first.text.trim()
                )),
        ));
    }
    Ok(())
}

/// The error of a table with `,` as both decimal sign and delimiter.
pub(super) fn both_commas(error: Error) -> Error {
    error
        .expected("a decimal point, or another delimiter")
        .help(
            "a decimal comma together with `,` as delimiter cannot be read: export with `;` or \
               tabs between the columns",
        )
}

#[cfg(test)]
mod tests {
    use super::super::remarks::lines_and_remarks;
    use super::*;

    fn dialect_of(text: &str) -> Option<Dialect> {
        Dialect::detect(&lines_and_remarks(text).0)
    }

    #[test]
    fn delimiter_and_decimal_sign_are_found() {
        for (text, delimiter, decimal_comma) in [
            ("f,re,im\n1,2,3\n", Some(','), false),
            ("f;re;im\n1;2;3\n", Some(';'), false),
            ("f;re;im\n1,5;2,25;-3,5e-3\n2;1;1\n", Some(';'), true),
            ("f\tre\tim\n1\t2\t3\n", Some('\t'), false),
            ("1,5 2,5 3,5\n", None, true),
            ("  1.0   2.0  -3e5\n", None, false),
            ("1.0, 2.0, 3.0\n", Some(','), false),
            ("1.5D+03 2 3\n", None, false),
        ] {
            assert_eq!(
                dialect_of(text),
                Some(Dialect {
                    delimiter,
                    decimal_comma
                }),
                "{text}"
            );
        }
        assert_eq!(dialect_of("no numbers here\n"), None);
    }

    #[test]
    fn quotes_protect_delimiters() {
        let dialect = Dialect {
            delimiter: Some(','),
            decimal_comma: false,
        };
        assert_eq!(
            dialect.cells("\"a, b\",c,\"say \"\"d\"\"\","),
            ["a, b", "c", "say \"d\"", ""]
        );
    }

    #[test]
    fn cells_that_are_no_finite_numbers() {
        let dialect = Dialect {
            delimiter: Some(';'),
            decimal_comma: true,
        };
        assert_eq!(dialect.number("1,5"), Cell::Value(1.5));
        assert_eq!(dialect.number("1.234,5"), Cell::Text);
        assert_eq!(dialect.number("1.5"), Cell::Text);
        for gap in [
            "NaN", "-nan", "nan(ind)", "NA", "n/a", "null", "-1.#IND", "",
        ] {
            assert_eq!(dialect.number(gap), Cell::Empty, "{gap}");
        }
        assert_eq!(dialect.number("-inf"), Cell::Overflow);
        assert_eq!(dialect.number("1e999"), Cell::Overflow);
        assert_eq!(dialect.number("*****"), Cell::Overflow);
    }

    #[test]
    fn separators_of_thousands_are_known() {
        for cell in ["1,000.00", "-1.000,5", "12 345", "1'234'567.8", "1.000"] {
            assert!(has_thousands(cell), "{cell}");
        }
        for cell in [
            "", "x", "1,00", "1.0005", "1000,000", "1,5", "1,000x", "1.000e3", "é",
        ] {
            assert!(!has_thousands(cell), "{cell}");
        }
    }

    #[test]
    fn latin_1_and_utf_16_are_read() {
        assert_eq!(decode(b"m/s\xb2"), "m/s²");
        assert_eq!(decode(b"\xff\xfef\0,\0"), "f,");
        assert_eq!(decode(b"\xef\xbb\xbff"), "f");
    }
}
