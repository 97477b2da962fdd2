//! Binary dataset 58 (`58b`): the extent of its payload.
//!
//! The length of the payload follows from record 7, not from the identifier, which common
//! writers state wrongly. A length is right when it lands on a closing `-1` line.

use super::fields::Record;
use super::identifier::Identifier;
use super::layout::{Layout, Record7};
use super::lines::{is_marker, Lines};
use chladni_frf::{Error, Finding, Result};
use std::borrow::Cow;

/// The data of a binary 58, and the form in which they are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Payload<'a> {
    /// The bytes of a whole number of points.
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
    /// Bytes of `count` points; `None` where they exceed `available`.
    fn bytes(self, count: u64, available: u64) -> Option<u64> {
        count
            .checked_mul(self.point_bytes() as u64)
            .filter(|&bytes| bytes <= available)
    }
}

/// Forms that record 7 allows. For uneven doubles, the definition has an abscissa in single
/// precision, and common writers one in double precision.
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

/// Forms of writers that state one precision and write in the other.
fn contradicting(layout: Layout) -> Vec<Form> {
    allowed(Layout {
        double: !layout.double,
        ..layout
    })
}

/// Requirement on the bytes after a payload, for its length to count as right.
#[derive(Clone, Copy, PartialEq)]
enum Landing {
    /// A closing marker, then an opening one or the end of the file.
    Strict,
    /// A closing marker.
    Loose,
    /// Nothing: the file ends with the payload.
    FileEnd,
}

/// The rest of a file, from the beginning of a payload on.
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

/// Offset of the end of the closing marker after `length` bytes of payload, where there is one.
fn lands(file: &impl Rest, length: u64, landing: Landing) -> Option<u64> {
    let rest = file.behind(length);
    // against the definition, writers put LF or CRLF between payload and marker
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

/// A payload whose length lands: its form, its bytes, and the end of the closing marker.
#[derive(Debug, Clone, Copy)]
pub(super) struct Landed {
    pub form: Form,
    pub length: u64,
    pub end: u64,
}

/// All information about the end of a payload.
struct Search<'a, R> {
    rest: &'a R,
    /// Offset of `rest` in the file.
    byte: u64,
    layout: Layout,
    /// Line of record 7.
    line: u64,
    /// Bytes that the identifier line declares.
    declared: u64,
    lenient: bool,
}

const COUNT: &str = "record 7: number of values";

impl<R: Rest> Search<'_, R> {
    /// The first of `forms` whose length lands; a form of the declared length is preferred.
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

    /// The payload of the declared length, where it lands; then the number of values in record
    /// 7 is wrong.
    fn declared_length(&self) -> Option<Landed> {
        let length = self.declared;
        let end = lands(self.rest, length, Landing::Loose)?;
        let form = allowed(self.layout)
            .into_iter()
            .find(|form| length > 0 && length.is_multiple_of(form.point_bytes() as u64))?;
        Some(Landed { form, length, end })
    }

    fn wrong(&self, message: &str, field: &str) -> Error {
        Error::bad_data(message)
            .at_line(self.line)
            .at_byte(self.byte)
            .field(field)
    }

    /// The payload by record 7.
    fn as_stated(&self, warnings: &mut Vec<Finding>) -> Option<Landed> {
        let forms = allowed(self.layout);
        let at = self.any_of(&forms, &[Landing::Strict, Landing::Loose])?;
        let (declared, length) = (self.declared, at.length);
        if declared != length {
            let words = format!(
                "the identifier line states {declared} bytes of data, the header {length}; \
                 {length} are there and are read"
            );
            warnings.push(Finding::note("loosely-written", words));
        }
        Some(at)
    }

    /// The payload in the precision that record 7 does not state; an error unless `lenient`.
    fn in_other_precision(&self, warnings: &mut Vec<Finding>) -> Result<Option<Landed>> {
        let layout = self.layout;
        let forms = contradicting(layout);
        let Some(at) = self.any_of(&forms, &[Landing::Strict, Landing::Loose]) else {
            return Ok(None);
        };
        let precision = |is_double: bool| if is_double { "double" } else { "single" };
        let [said, written] = [layout.double, at.form.y_bytes == 8].map(precision);
        if !self.lenient {
            let message = format!(
                "the header says {said} precision, but the data are written in {written} precision"
            );
            let found = format!(
                "{} and {} bytes of data for {} values",
                layout.code(),
                at.length,
                layout.count
            );
            return Err(self
                .wrong(&message, "record 7: ordinate type")
                .found(found)
                .expected(format!("data in {said} precision"))
                .help("read it with `lenient`, which takes the data as they are written"));
        }
        let words = format!(
            "the header says {said} precision, the data are in {written} precision and read so"
        );
        warnings.push(Finding::caution("loosely-written", words));
        Ok(Some(at))
    }

    /// The payload of the declared length; unless `lenient`, an error about the number of
    /// values.
    fn with_other_count(&self, warnings: &mut Vec<Finding>) -> Result<Option<Landed>> {
        let Some(at) = self.declared_length() else {
            return Ok(None);
        };
        let declared = self.layout.count;
        let present = at.length / at.form.point_bytes() as u64;
        if !self.lenient {
            return Err(self
                .wrong("the declared number of values and the data disagree", COUNT)
                .found(format!("{declared} declared, {present} present"))
                .expected("equal numbers")
                .help("export the file again, or read what is there with `lenient`"));
        }
        let words = format!(
            "the header declares {declared} values, the data hold {present}; these are read"
        );
        warnings.push(Finding::caution("values-missing", words));
        Ok(Some(at))
    }

    /// The payload up to the end of the file; an error unless `lenient`.
    fn at_file_end(&self, warnings: &mut Vec<Finding>) -> Result<Landed> {
        let forms = allowed(self.layout);
        let found = self.any_of(&forms, &[Landing::FileEnd]);
        let at = found.filter(|_| self.lenient).ok_or_else(|| {
            self.wrong("the binary data do not end where their length says", COUNT)
                .found(self.nowhere())
                .expected("data of the declared length, then a line with -1")
                .help(
                    "the file is cut short or was changed by a text transfer; copy it again in \
                     binary mode",
                )
        })?;
        warnings.push(Finding::note(
            "loosely-written",
            "the file ends behind the data, without a closing -1 line",
        ));
        Ok(at)
    }

    /// Words for a payload of which no length lands.
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

/// Finds the end of the payload at the beginning of `rest`, which is at `byte` in the file.
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
    let search = Search {
        rest,
        byte,
        layout: Record7::read(record7, &mut Vec::new())?.layout,
        line: record7.line,
        declared: identifier.declared_bytes,
        lenient,
    };
    if let Some(at) = search.as_stated(warnings) {
        return Ok(at);
    }
    if let Some(at) = search.in_other_precision(warnings)? {
        return Ok(at);
    }
    if let Some(at) = search.with_other_count(warnings)? {
        return Ok(at);
    }
    search.at_file_end(warnings)
}

#[cfg(test)]
mod tests {
    use super::*;

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
