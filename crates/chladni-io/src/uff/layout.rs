//! Record 7 of dataset 58: the layout of the data.
//!
//! | case | type | spacing | line format | values per line |
//! |---|---|---|---|---|
//! | 1 | 2 real single | even | 6E13.5 | y ×6 |
//! | 2 | 2 | uneven | 6E13.5 | (x,y) ×3 |
//! | 3 | 5 complex single | even | 6E13.5 | (re,im) ×3 |
//! | 4 | 5 | uneven | 6E13.5 | (x,re,im) ×2 |
//! | 5 | 4 real double | even | 4E20.12 | y ×4 |
//! | 6 | 4 | uneven | 2(E13.5,E20.12) | (x,y) ×2 |
//! | 7 | 6 complex double | even | 4E20.12 | (re,im) ×2 |
//! | 8 | 6 | uneven | E13.5,2E20.12 | (x,re,im) ×1 |

use super::fields::{numbers, whole, Column, Record};
use super::step::Printed;
use chladni_frf::{Error, Finding, Result};

/// Layout of the data of one function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Layout {
    pub complex: bool,
    pub double: bool,
    pub even: bool,
    /// Declared number of abscissa values. It may be wrong, so memory is not allocated by it.
    pub count: u64,
}

impl Layout {
    /// Widths of the fields of a full line.
    pub(super) fn widths(self) -> &'static [usize] {
        match (self.double, self.complex, self.even) {
            (false, _, _) => &[13; 6],
            (true, _, true) => &[20; 4],
            (true, false, false) => &[13, 20, 13, 20],
            (true, true, false) => &[13, 20, 20],
        }
    }
    /// Numbers per ordinate value.
    pub(super) fn parts(self) -> usize {
        1 + usize::from(self.complex)
    }
    /// Numbers per point: those of the ordinate, and the abscissa value where it is uneven.
    pub(super) fn numbers_per_point(self) -> usize {
        self.parts() + usize::from(!self.even)
    }
    /// Ordinate type code.
    pub(super) fn code(self) -> i32 {
        match (self.complex, self.double) {
            (false, false) => 2,
            (false, true) => 4,
            (true, false) => 5,
            (true, true) => 6,
        }
    }
}

/// Record 7.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Record7 {
    pub layout: Layout,
    pub start: Printed,
    pub step: Printed,
    pub z: f64,
}

const COLUMNS: [Column; 6] = [
    ("record 7: ordinate type", 10),
    ("record 7: number of values", 10),
    ("record 7: spacing", 10),
    ("record 7: abscissa start", 13),
    ("record 7: abscissa step", 13),
    ("record 7: z value", 13),
];

impl Record7 {
    /// Reads record 7.
    ///
    /// # Errors
    /// A field that is no number, or a code that the definition does not have.
    pub(super) fn read(record: Record<'_>, warnings: &mut Vec<Finding>) -> Result<Self> {
        let mut splits = Vec::new();
        let [code, count, spacing, start, step, z] = numbers(record, COLUMNS, &mut splits)?;
        let unknown = |field: &str, found: f64, expected: &str| {
            Error::bad_data("unknown code")
                .at_line(record.line)
                .field(format!("record 7: {field}"))
                .found(found)
                .expected(expected)
        };
        let (complex, double) = match whole(record, COLUMNS[0].0, code)? {
            2 => (false, false),
            4 => (false, true),
            5 => (true, false),
            6 => (true, true),
            _ => {
                return Err(unknown(
                    "ordinate type",
                    code,
                    "2 real single, 4 real double, 5 complex single or 6 complex double",
                ))
            }
        };
        let even = match whole(record, COLUMNS[2].0, spacing)? {
            0 => false,
            1 => true,
            _ => return Err(unknown("spacing", spacing, "0 uneven or 1 even")),
        };
        let count = u64::try_from(whole(record, COLUMNS[1].0, count)?)
            .map_err(|_| unknown("number of values", count, "a number that is not negative"))?;
        let layout = Layout {
            complex,
            double,
            even,
            count,
        };
        let digits = |index: usize, value| {
            Printed::new(digits_of(record.text, index, !splits.is_empty()), value)
        };
        let record7 = Self {
            layout,
            start: digits(3, start),
            step: digits(4, step),
            z,
        };
        warnings.append(&mut splits);
        Ok(record7)
    }
}

/// The text of field `index` of record 7, cut in the same way as its number.
fn digits_of(text: &[u8], index: usize, between_blanks: bool) -> &[u8] {
    if between_blanks {
        return text
            .split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .nth(index)
            .unwrap_or_default();
    }
    let start: usize = COLUMNS[..index].iter().map(|column| column.1).sum();
    let end = (start + COLUMNS[index].1).min(text.len());
    text.get(start..end).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Record7> {
        Record7::read(
            Record {
                line: 9,
                text: text.as_bytes(),
            },
            &mut Vec::new(),
        )
    }

    #[test]
    fn record_7_is_cut_by_column() {
        let record =
            read("         6      1601         1  0.00000E+00  2.44141E+00  0.00000E+00").unwrap();
        assert_eq!(
            record.layout,
            Layout {
                complex: true,
                double: true,
                even: true,
                count: 1601
            }
        );
        assert_eq!((record.step.value, record.step.digits), (2.44141, 6));
    }

    #[test]
    fn codes_outside_the_definition_are_refused_with_their_field() {
        for (text, field) in [
            ("         3         1         1", "ordinate type"),
            ("         6         1         7", "spacing"),
            ("         6        -1         1", "number of values"),
            ("         6       1.5         1", "number of values"),
            ("       abc         1         1", "ordinate type"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(
                message.contains(field) && message.contains("line 9"),
                "{message}"
            );
        }
    }
}
