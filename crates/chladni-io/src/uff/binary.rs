//! Binary dataset 58 (`58b`): its identifier line, and where its payload lies.
//!
//! Identifier: I6 = 58, A1 = `b`, I6 byte order (1 little, 2 big), I6 float format (1 DEC
//! VMS, 2 IEEE 754, 3 IBM 370), I12 count of text lines that follow, I12 count of bytes
//! after them, then four zeros.
//!
//! The length of the payload comes from record 7, not from the identifier: common writers
//! state it wrongly. A length counts as right when it lands on a closing `-1` line.

use super::fields::{numbers, whole, Record};
use super::layout::{Layout, Record7};
use super::lines::{is_marker, Lines, HEADER_RECORDS};
use chladni_frf::{Error, Finding, Result};
use std::borrow::Cow;

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
        let columns = [
            ("byte order", 6),
            ("float format", 6),
            ("count of header lines", 12),
            ("count of bytes", 12),
            ("unused 1", 6),
            ("unused 2", 6),
            ("unused 3", 12),
            ("unused 4", 12),
        ];
        let [order, format, lines, bytes, ..] = numbers(fields, columns, warnings)?;
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

/// The data of a binary 58, and how they are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Payload<'a> {
    /// A whole number of points.
    pub bytes: &'a [u8],
    /// Offset in the file.
    pub byte: u64,
    pub form: Form,
    pub big_endian: bool,
}

/// Sizes of the floats of one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Form {
    /// Bytes of the abscissa value: 0 (even), 4 or 8.
    pub x_bytes: usize,
    /// Bytes of one part of the ordinate value: 4 or 8.
    pub y_bytes: usize,
    /// Parts of the ordinate value: 1 or 2.
    pub parts: usize,
}

impl Form {
    /// Bytes of one point.
    pub(super) fn point_bytes(self) -> usize {
        self.x_bytes + self.parts * self.y_bytes
    }
    /// Bytes of `count` points, where that many lie within `available`.
    fn bytes(self, count: u64, available: u64) -> Option<u64> {
        count
            .checked_mul(self.point_bytes() as u64)
            .filter(|&bytes| bytes <= available)
    }
}

/// Forms that record 7 allows. For uneven doubles the definition has a single abscissa,
/// common writers a double one.
fn allowed(layout: Layout) -> Vec<Form> {
    let parts = layout.parts();
    match (layout.double, layout.even) {
        (double, true) => vec![Form {
            x_bytes: 0,
            y_bytes: if double { 8 } else { 4 },
            parts,
        }],
        (false, false) => vec![Form {
            x_bytes: 4,
            y_bytes: 4,
            parts,
        }],
        (true, false) => vec![
            Form {
                x_bytes: 8,
                y_bytes: 8,
                parts,
            },
            Form {
                x_bytes: 4,
                y_bytes: 8,
                parts,
            },
        ],
    }
}

/// Forms of writers that state one precision and write the other.
fn contradicting(layout: Layout) -> Vec<Form> {
    allowed(Layout {
        double: !layout.double,
        ..layout
    })
}

/// Requirement on what stands behind a payload, for its length to be believed.
#[derive(Clone, Copy, PartialEq)]
enum Landing {
    /// A closing marker, then an opening one or the end of the file.
    Strict,
    /// A closing marker.
    Loose,
    /// Nothing: the file ends with the payload.
    FileEnd,
}

/// The file from the beginning of a payload on.
pub(super) trait Rest {
    /// Bytes to the end of the file.
    fn length(&self) -> u64;
    /// The bytes from `offset` on: at least the lines that follow a payload.
    fn behind(&self, offset: u64) -> Cow<'_, [u8]>;
}

impl Rest for &[u8] {
    fn length(&self) -> u64 {
        self.len() as u64
    }
    fn behind(&self, offset: u64) -> Cow<'_, [u8]> {
        Cow::Borrowed(
            usize::try_from(offset)
                .ok()
                .and_then(|offset| self.get(offset..))
                .unwrap_or_default(),
        )
    }
}

/// One past the closing marker behind `length` bytes of payload, where one stands there.
fn lands(file: &impl Rest, length: u64, landing: Landing) -> Option<u64> {
    let rest = file.behind(length);
    // Writers put LF or CRLF between payload and marker, against the rule.
    let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
    let mut lines = Lines {
        bytes: &rest[blanks..],
        line: 0,
    };
    if landing == Landing::FileEnd {
        return (length + blanks as u64 == file.length()).then_some(file.length());
    }
    lines.next().filter(|record| is_marker(record.text))?;
    let end = length + (rest.len() - lines.bytes.len()) as u64;
    let next = lines.find(|record| !record.text.trim_ascii().is_empty());
    (landing == Landing::Loose || next.is_none_or(|record| is_marker(record.text))).then_some(end)
}

/// A payload whose length lands: its form, its bytes, and one past the closing marker.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landed {
    pub form: Form,
    pub length: u64,
    pub end: u64,
}

/// Everything that is known about where a payload may end.
struct Search<'a, R> {
    rest: &'a R,
    layout: Layout,
    /// Bytes stated by the identifier line.
    declared: u64,
}

impl<R: Rest> Search<'_, R> {
    /// The first of `forms` whose length lands; the declared length is tried first.
    fn any_of(&self, forms: &[Form], landings: &[Landing]) -> Option<Landed> {
        let mut sized: Vec<(Form, u64)> = forms
            .iter()
            .filter_map(|&form| Some((form, form.bytes(self.layout.count, self.rest.length())?)))
            .collect();
        sized.sort_by_key(|&(_, length)| length != self.declared);
        landings.iter().find_map(|&landing| {
            sized.iter().find_map(|&(form, length)| {
                Some(Landed {
                    form,
                    length,
                    end: lands(self.rest, length, landing)?,
                })
            })
        })
    }

    /// The declared length, where it lands: then record 7 states the wrong number of
    /// values.
    fn declared_length(&self) -> Option<Landed> {
        let length = self.declared;
        let end = lands(self.rest, length, Landing::Loose)?;
        let form = allowed(self.layout)
            .into_iter()
            .find(|form| length > 0 && length.is_multiple_of(form.point_bytes() as u64))?;
        Some(Landed { form, length, end })
    }

    /// No length lands anywhere.
    fn nowhere(&self) -> String {
        let smallest = allowed(self.layout)
            .iter()
            .map(|form| form.point_bytes())
            .min()
            .unwrap_or(1);
        let (count, left) = (self.layout.count, self.rest.length());
        let needed = count.saturating_mul(smallest as u64);
        if needed > left {
            format!(
                "{count} values declared ({needed} bytes), {} present at most ({left} bytes \
                     left in the file)",
                left / smallest as u64
            )
        } else {
            format!(
                "{count} values declared ({needed} bytes), {} bytes by the identifier line; \
                     neither ends on a -1 line",
                self.declared
            )
        }
    }
}

/// Finds where the payload at the beginning of `rest`, which lies at `byte` in the file,
/// ends.
///
/// # Errors
/// No length lands on a closing marker, or the one that does contradicts record 7.
pub(super) fn locate(
    rest: &impl Rest,
    byte: u64,
    identifier: Identifier,
    record7: Record<'_>,
    lenient: bool,
    warnings: &mut Vec<Finding>,
) -> Result<Landed> {
    let layout = Record7::read(record7, &mut Vec::new())?.layout;
    let search = Search {
        rest,
        layout,
        declared: identifier.declared_bytes,
    };
    let wrong = |message: &str, field: &str| {
        Error::bad_data(message)
            .at_line(record7.line)
            .at_byte(byte)
            .field(field)
    };
    const COUNT: &str = "record 7: number of values";

    if let Some(at) = search.any_of(&allowed(layout), &[Landing::Strict, Landing::Loose]) {
        let (declared, length) = (search.declared, at.length);
        if declared != length {
            warnings.push(Finding::note(
                "loosely-written",
                format!(
                    "the identifier line states {declared} bytes of data, the header \
                               {length}; {length} are there and are read"
                ),
            ));
        }
        return Ok(at);
    }
    if let Some(at) = search.any_of(&contradicting(layout), &[Landing::Strict, Landing::Loose]) {
        let precision = |is_double: bool| if is_double { "double" } else { "single" };
        let [said, written] = [layout.double, at.form.y_bytes == 8].map(precision);
        if !lenient {
            let message = format!(
                "the header says {said} precision, but the data are written in {written} precision"
            );
            let found = format!(
                "{} and {} bytes of data for {} values",
                layout.code(),
                at.length,
                layout.count
            );
            return Err(wrong(&message, "record 7: ordinate type")
                .found(found)
                .expected(format!("data in {said} precision"))
                .help("read it with `lenient`, which takes the data as they are written"));
        }
        let words = format!(
            "the header says {said} precision, the data are in {written} precision and read so"
        );
        warnings.push(Finding::caution("loosely-written", words));
        return Ok(at);
    }
    if let Some(at) = search.declared_length() {
        let (declared, present) = (layout.count, at.length / at.form.point_bytes() as u64);
        if !lenient {
            return Err(
                wrong("the declared number of values and the data disagree", COUNT)
                    .found(format!("{declared} declared, {present} present"))
                    .expected("equal numbers")
                    .help("export the file again, or read what is there with `lenient`"),
            );
        }
        let words = format!(
            "the header declares {declared} values, the data hold {present}; these are read"
        );
        warnings.push(Finding::caution("values-missing", words));
        return Ok(at);
    }
    if let Some(at) = search
        .any_of(&allowed(layout), &[Landing::FileEnd])
        .filter(|_| lenient)
    {
        warnings.push(Finding::note(
            "loosely-written",
            "the file ends behind the data, without a closing -1 line",
        ));
        return Ok(at);
    }
    Err(
        wrong("the binary data do not end where their length says", COUNT)
            .found(search.nowhere())
            .expected("data of the declared length, then a line with -1")
            .help(
                "the file is cut short or was changed by a text transfer; copy it again in binary \
               mode",
            ),
    )
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

    #[test]
    fn a_payload_lands_on_a_marker_behind_any_line_end() {
        for rest in ["    -1", "    -1\n", "\n    -1\n    -1\n", "\r\n    -1\r\n"] {
            let bytes = [&[7; 16], rest.as_bytes()].concat();
            assert!(
                lands(&bytes.as_slice(), 16, Landing::Strict).is_some(),
                "{rest:?}"
            );
            assert_eq!(lands(&bytes.as_slice(), 8, Landing::Loose), None);
        }
        let bytes = [&[7; 16], &b"    -1\nrubbish"[..]].concat();
        assert_eq!(lands(&bytes.as_slice(), 16, Landing::Strict), None);
        assert_eq!(lands(&bytes.as_slice(), 16, Landing::Loose), Some(23));
        assert_eq!(lands(&bytes.as_slice(), 1000, Landing::Loose), None);
    }
}
