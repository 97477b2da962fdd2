//! The identifier line of a binary dataset 58.
//!
//! I6 = 58, A1 = `b`, I6 byte order (1 little, 2 big), I6 float format (1 DEC VMS, 2 IEEE
//! 754, 3 IBM 370), I12 count of text lines that follow, I12 count of bytes after them,
//! then four zeros.

use super::fields::{numbers, whole, Column, Record};
use super::lines::HEADER_RECORDS;
use chladni_frf::{Error, Finding, Result};

/// Fields behind the letter `b`, and their widths.
const COLUMNS: [Column; 8] = [
    ("byte order", 6),
    ("float format", 6),
    ("count of header lines", 12),
    ("count of bytes", 12),
    ("unused 1", 6),
    ("unused 2", 6),
    ("unused 3", 12),
    ("unused 4", 12),
];

/// The identifier line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Identifier {
    pub big_endian: bool,
    pub header_lines: usize,
    /// Bytes of payload that the line states; 0 where it states none.
    pub declared_bytes: u64,
}

impl Identifier {
    /// Reads the number line of a binary dataset.
    ///
    /// # Errors
    /// An unknown byte order, or floats that are not IEEE 754.
    pub(super) fn read(record: Record<'_>, warnings: &mut Vec<Finding>) -> Result<Self> {
        let after_b = record
            .text
            .iter()
            .position(|b| matches!(b, b'b' | b'B'))
            .map_or(record.text.len(), |k| k + 1);
        let fields = Record {
            text: &record.text[after_b..],
            ..record
        };
        let [order, format, lines, bytes, ..] = numbers(fields, COLUMNS, warnings)?;
        let refuse = |field: &str, found: f64, expected: &str| {
            Error::bad_data("this binary form cannot be read")
                .at_line(record.line)
                .field(field)
                .found(found)
                .expected(expected)
                .help("export the file again as text, or as IEEE binary")
        };
        let big_endian = match whole(record, "byte order", order)? {
            1 => false,
            2 => true,
            _ => {
                return Err(refuse(
                    "byte order",
                    order,
                    "1 little endian or 2 big endian",
                ))
            }
        };
        match whole(record, "float format", format)? {
            2 => {}
            1 => return Err(refuse("float format", format, "2 IEEE 754; 1 is DEC VMS")),
            3 => return Err(refuse("float format", format, "2 IEEE 754; 3 is IBM 370")),
            _ => return Err(refuse("float format", format, "2 IEEE 754")),
        }
        let header_lines = match whole(record, "count of header lines", lines)? {
            more if (HEADER_RECORDS as i64..100).contains(&more) => more as usize,
            other => {
                warnings.push(Finding::note(
                    "loosely-written",
                    format!(
                        "line {}: the identifier states {other} header lines; \
                                       {HEADER_RECORDS} are read",
                        record.line
                    ),
                ));
                HEADER_RECORDS
            }
        };
        let declared_bytes = u64::try_from(whole(record, "count of bytes", bytes)?).unwrap_or(0);
        Ok(Self {
            big_endian,
            header_lines,
            declared_bytes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identifier(text: &str) -> Result<Identifier> {
        Identifier::read(
            Record {
                line: 2,
                text: text.as_bytes(),
            },
            &mut Vec::new(),
        )
    }

    #[test]
    fn the_identifier_line_is_cut_by_column() {
        let read = identifier(
            "    58b     1     2          11        1600     0     0           0           0",
        )
        .unwrap();
        assert_eq!(
            read,
            Identifier {
                big_endian: false,
                header_lines: 11,
                declared_bytes: 1600
            }
        );
        assert!(
            identifier("    58b     2     2          11")
                .unwrap()
                .big_endian
        );
    }

    #[test]
    fn dec_and_ibm_floats_are_refused_by_name() {
        for (text, name) in [
            ("    58b     1     1          11", "DEC VMS"),
            ("    58b     2     3          11", "IBM 370"),
        ] {
            assert!(identifier(text).unwrap_err().to_string().contains(name));
        }
        assert!(identifier("    58b     0     2          11")
            .unwrap_err()
            .to_string()
            .contains("byte order"));
    }
}
