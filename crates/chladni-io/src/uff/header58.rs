//! The header of dataset 58: records 1 to 11.
//!
//! | record | format | fields |
//! |---|---|---|
//! | 1–5 | 80A1 | ID lines |
//! | 6 | 2(I5,I10),2(1X,10A1,I10,I4) | function type, id; version, load case; response entity, node, direction; reference the same |
//! | 7 | 3I10,3E13.5 | see `layout` |
//! | 8–11 | I10,3I5,2(1X,20A1) | abscissa, numerator, denominator, z axis: quantity, exponents, label, unit |

use super::container::ends_in_header;
use super::fields::{bad_field, decode, label, line_numbers, warn_split, whole, BadField, Record};
use super::layout::Record7;
use super::lines::{Lines, HEADER_RECORDS};
use super::number::{float, Fault};
use crate::Axis;
use chladni_frf::{Direction, Dof, Error, Finding, Result};

/// Records 1 to 11.
#[derive(Debug, Clone)]
pub(super) struct Header {
    pub function_type: i32,
    pub id_lines: [String; 5],
    pub ids: [i64; 3],
    pub entity_names: [String; 2],
    pub response: Dof,
    pub reference: Dof,
    pub record7: Record7,
    pub axes: [Axis; 4],
}

impl Header {
    /// Reads records 1 to 11. Returns with them the lines that follow.
    ///
    /// # Errors
    /// A missing record or a field that cannot be read.
    pub(super) fn read<'a>(
        mut lines: Lines<'a>,
        warnings: &mut Vec<Finding>,
    ) -> Result<(Self, Lines<'a>)> {
        let mut records = [Record {
            line: lines.line,
            text: b"".as_slice(),
        }; HEADER_RECORDS];
        for (k, record) in records.iter_mut().enumerate() {
            *record = lines
                .next()
                .ok_or_else(|| ends_in_header(lines.line, k, HEADER_RECORDS))?;
        }
        let id_lines = [0, 1, 2, 3, 4].map(|k: usize| label(&decode(records[k].text)));
        let record6 = Record6::read(records[5], warnings)?;
        let record7 = Record7::read(records[6], warnings)?;
        let mut axes: [Axis; 4] = Default::default();
        for (axis, &record) in axes.iter_mut().zip(&records[7..]) {
            *axis = read_axis(record, warnings)?;
        }
        let [function_type, id, version, load_case] = record6.codes;
        let function_type = i32::try_from(function_type).map_err(|_| {
            Error::bad_data("unknown function type")
                .at_line(records[5].line)
                .field("record 6: function type")
                .found(function_type)
                .expected("a code of the definition, 0 to 27")
        })?;
        let [response, reference] = record6.dofs;
        let header = Self {
            function_type,
            id_lines,
            ids: [id, version, load_case],
            entity_names: record6.entity_names,
            response,
            reference,
            record7,
            axes,
        };
        Ok((header, lines))
    }
}

/// Number that some programs write where there is no reference node.
const NO_REFERENCE: i64 = -1;

/// Record 6.
struct Record6 {
    codes: [i64; 4],
    entity_names: [String; 2],
    dofs: [Dof; 2],
}

const RECORD_6_NUMBERS: [(&str, usize, usize); 8] = [
    ("function type", 0, 5),
    ("function id", 5, 15),
    ("version", 15, 20),
    ("load case", 20, 30),
    ("response node", 41, 51),
    ("response direction", 51, 55),
    ("reference node", 66, 76),
    ("reference direction", 76, 80),
];
const RECORD_6_NAMES: [(usize, usize); 2] = [(31, 41), (56, 66)];

/// The numbers of record 6 in the order of [`RECORD_6_NUMBERS`], and the entity names.
type Fields6 = ([f64; 8], [String; 2]);

impl Record6 {
    fn read(record: Record<'_>, warnings: &mut Vec<Finding>) -> Result<Self> {
        // columns count characters; some programs pad by bytes, and a name in UTF-8 shifts
        // the columns
        let by_character: Vec<char> = decode(record.text).chars().collect();
        let by_byte: Vec<char> = record.text.iter().map(|&b| char::from(b)).collect();
        let first = Self::cut(&by_character);
        let cut = first
            .as_ref()
            .ok()
            .cloned()
            .or_else(|| Self::cut(&by_byte).ok())
            .or_else(|| {
                let split = Self::split_on_blanks(&by_character)?;
                warn_split(record.line, warnings);
                Some(split)
            });
        let Some((numbers, entity_names)) = cut else {
            let (name, span) = first.err().unwrap_or(("function type", (0, 5)));
            return Err(bad_field(
                record,
                &format!("record 6: {name}"),
                BadField {
                    index: 0,
                    span,
                    fault: Fault::NotANumber,
                },
            ));
        };
        let integer = |k: usize| {
            whole(
                record,
                &format!("record 6: {}", RECORD_6_NUMBERS[k].0),
                numbers[k],
            )
        };
        let mut dofs = [Dof::new(0, Direction::SCALAR); 2];
        for (k, dof) in dofs.iter_mut().enumerate() {
            let (node, code) = (integer(4 + 2 * k)?, integer(5 + 2 * k)?);
            if k == 1 && node == NO_REFERENCE {
                continue; // node 0, as other programs write it
            }
            let refuse = |field: usize, found: i64, expected: &str| {
                Error::bad_data("no such degree of freedom")
                    .at_line(record.line)
                    .field(format!("record 6: {}", RECORD_6_NUMBERS[field].0))
                    .found(found)
                    .expected(expected)
            };
            let node = u64::try_from(node)
                .map_err(|_| refuse(4 + 2 * k, node, "a node number that is not negative"))?;
            let direction = Direction::from_code(code)
                .ok_or_else(|| refuse(5 + 2 * k, code, "a direction code from -6 to 6"))?;
            *dof = Dof::new(node, direction);
        }
        Ok(Self {
            codes: [integer(0)?, integer(1)?, integer(2)?, integer(3)?],
            entity_names,
            dofs,
        })
    }

    /// The numbers and names by column, or the first field that is no number.
    fn cut(line: &[char]) -> std::result::Result<Fields6, (&'static str, (usize, usize))> {
        let is_blank = |column: usize| line.get(column).is_none_or(|c| c.is_whitespace());
        let mut numbers = [0.0; 8];
        for (number, &(name, start, end)) in numbers.iter_mut().zip(&RECORD_6_NUMBERS) {
            let field: String = text_at(line, start, end);
            let touches = start > 0 && !is_blank(start - 1) && !is_blank(start);
            let full = (start..end).all(|column| !is_blank(column));
            let spills = matches!(end, 30 | 55) && !is_blank(end) && !is_blank(end - 1);
            let value = float(field.as_bytes())
                .ok()
                .filter(|_| (!touches || full) && !spills);
            *number = value.ok_or((name, (start, end)))?;
        }
        Ok((
            numbers,
            RECORD_6_NAMES.map(|(start, end)| label(&text_at(line, start, end))),
        ))
    }

    /// Ten words with both entity names, or eight numbers without.
    fn split_on_blanks(line: &[char]) -> Option<Fields6> {
        let text: String = line.iter().collect();
        let words: Vec<&str> = text.split_whitespace().collect();
        let (numeric, names): (&[usize], [&str; 2]) = match words.len() {
            10 => (&[0, 1, 2, 3, 5, 6, 8, 9], [words[4], words[7]]),
            8 => (&[0, 1, 2, 3, 4, 5, 6, 7], ["", ""]),
            _ => return None,
        };
        let mut numbers = [0.0; 8];
        for (number, &k) in numbers.iter_mut().zip(numeric) {
            *number = float(words[k].as_bytes()).ok()?;
        }
        Some((numbers, names.map(label)))
    }
}

fn text_at(line: &[char], start: usize, end: usize) -> String {
    line.get(start.min(line.len())..end.min(line.len()))
        .unwrap_or_default()
        .iter()
        .collect()
}

/// Records 8 to 11: I10,3I5,2(1X,20A1).
fn read_axis(record: Record<'_>, warnings: &mut Vec<Finding>) -> Result<Axis> {
    const NAMES: [&str; 4] = [
        "quantity code",
        "length exponent",
        "force exponent",
        "temperature exponent",
    ];
    let mut codes = [0.0; 4];
    let numeric = &record.text[..record.text.len().min(25)];
    let by_column = line_numbers(numeric, &[10, 5, 5, 5], &mut codes);
    let line: Vec<char> = match decode(record.text).chars().collect::<Vec<_>>() {
        // where a file pads labels in UTF-8 by bytes, column 47 is not blank in the wrong cut
        shifted
            if shifted.get(46).is_some_and(|c| !c.is_whitespace())
                && record.text.get(46).is_some_and(u8::is_ascii_whitespace) =>
        {
            return axis(
                record,
                codes,
                label(&decode(&record.text[26..46])),
                label(&decode(&record.text[47..])),
            );
        }
        line => line,
    };
    if let Err(bad) = by_column {
        let words: Vec<String> = line
            .iter()
            .collect::<String>()
            .split_whitespace()
            .map(String::from)
            .collect();
        for (k, code) in codes.iter_mut().enumerate() {
            let word = words.get(k).map_or("", String::as_str);
            *code = float(word.as_bytes())
                .map_err(|_| bad_field(record, &axis_field(NAMES[bad.index.min(3)]), bad))?;
        }
        warn_split(record.line, warnings);
        let labels = words.get(4..).unwrap_or_default();
        let (unit, name) = labels
            .split_last()
            .map_or((String::new(), String::new()), |(unit, name)| {
                (label(unit), label(&name.join(" ")))
            });
        return axis(record, codes, name, unit);
    }
    axis(
        record,
        codes,
        label(&text_at(&line, 26, 46)),
        label(&text_at(&line, 47, usize::MAX)),
    )
}

fn axis_field(name: &str) -> String {
    format!("axis record: {name}")
}

fn axis(record: Record<'_>, codes: [f64; 4], label: String, unit: String) -> Result<Axis> {
    let mut integers = [0; 4];
    for (integer, code) in integers.iter_mut().zip(codes) {
        let field = axis_field("quantity code or exponent");
        let number = whole(record, &field, code)?;
        *integer = i32::try_from(number).map_err(|_| {
            Error::bad_data("the code is too large")
                .at_line(record.line)
                .field(field)
                .found(number)
                .expected("a code of the definition")
        })?;
    }
    let [quantity, exponents @ ..] = integers;
    Ok(Axis {
        quantity,
        exponents,
        label,
        unit,
    })
}

/// The DOF that an entity name carries: `1+Z`, `comp:12:-X`, `Mic 01.0Scalar`.
pub(super) fn entity_dof(name: &str) -> Option<Dof> {
    if let Some(dof) = name.parse::<Dof>().ok().filter(|dof| dof.node > 0) {
        return Some(dof);
    }
    let numbered = name.trim_start_matches(|c: char| !c.is_ascii_digit());
    let digits = numbered.bytes().take_while(u8::is_ascii_digit).count();
    let (node, rest) = numbered.split_at(digits);
    let rest = match rest.strip_prefix('.') {
        Some(decimals) => decimals.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => rest,
    }
    .trim_matches(|c: char| c.is_whitespace() || c == ':');
    let node = node.parse().ok().filter(|&node| node > 0)?;
    let scalar = !rest.is_empty() && "scalar".starts_with(&rest.to_ascii_lowercase());
    let direction = if scalar {
        Some(Direction::SCALAR)
    } else {
        rest.parse().ok().filter(|_| !rest.is_empty())
    };
    Some(Dof::new(node, direction?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(text: &[u8]) -> Record<'_> {
        Record { line: 8, text }
    }

    #[test]
    fn record_6_is_cut_by_column_with_negative_directions() {
        let text =
            b"    4         0    0         0   NewModel         1  -3   NewModel9999999999   4";
        let read = Record6::read(record(text), &mut Vec::new()).unwrap();
        assert_eq!(
            read.dofs.map(|dof| dof.to_string()),
            ["1:-Z", "9999999999:+RX"]
        );
        assert_eq!(read.entity_names, ["NewModel", "NewModel"]);
    }

    #[test]
    fn record_6_in_free_format_is_split_on_blanks() {
        let mut warnings = Vec::new();
        let read = Record6::read(record(b"4 0 1 0 NONE 12 3 plate 7 -1"), &mut warnings).unwrap();
        assert_eq!(read.dofs.map(|dof| dof.to_string()), ["12:+Z", "7:-X"]);
        assert_eq!(
            (read.codes, read.entity_names),
            ([4, 0, 1, 0], [String::new(), "plate".to_string()])
        );
        assert_eq!(warnings.len(), 1);
    }

    #[test]
    fn a_reference_of_minus_one_is_none() {
        let text =
            b"    1         0    0         0   NewModel         1   3       NONE        -1   0";
        let read = Record6::read(record(text), &mut Vec::new()).unwrap();
        assert_eq!(read.dofs.map(|dof| dof.to_string()), ["1:+Z", "0:S"]);
        let response =
            b"    1         0    0         0   NewModel        -1   3       NONE         1   3";
        assert!(Record6::read(record(response), &mut Vec::new()).is_err());
    }

    #[test]
    fn names_that_are_not_ascii_do_not_shift_the_columns() {
        let line = |name: &str, pad: usize| {
            format!(
                "    4         0    0         0 {name}{:pad$}         5   3 {:10}         6   3",
                "", "NONE"
            )
        };
        for text in [line("Geh\u{e4}use", 3), line("Geh\u{e4}use", 2)] {
            let read = Record6::read(record(text.as_bytes()), &mut Vec::new()).unwrap();
            assert_eq!(
                read.dofs.map(|dof| dof.to_string()),
                ["5:+Z", "6:+Z"],
                "{text}"
            );
        }
    }

    #[test]
    fn a_direction_outside_the_codes_is_refused_with_its_field() {
        let text =
            b"    4         0    0         0   NewModel         1   9   NewModel        21   1";
        let message = Record6::read(record(text), &mut Vec::new())
            .err()
            .unwrap()
            .to_string();
        assert!(
            message.contains("line 8") && message.contains("response direction"),
            "{message}"
        );
    }

    #[test]
    fn dofs_are_found_in_entity_names() {
        for (name, printed) in [
            ("1+Z", "1:+Z"),
            ("plate:12:-X", "12:-X"),
            ("Mic 01.0Scalar", "1:S"),
            ("Mic 01.0Sc", "1:S"),
            ("P7:-RY", "7:-RY"),
        ] {
            assert_eq!(
                entity_dof(name).map(|dof| dof.to_string()).as_deref(),
                Some(printed),
                "{name}"
            );
        }
        for name in ["", "NONE", "plate", "Mic 1", "0+Z", "Mic 01.0Left"] {
            assert_eq!(entity_dof(name), None, "{name}");
        }
    }

    #[test]
    fn an_axis_record_is_read_in_latin_1_and_utf_8() {
        let latin = b"        12    0    0    0 Beschleunigung       m/s\xb2                ";
        let utf = "        12    0    0    0 Beschleunigung       m/s²                ";
        for text in [latin.as_slice(), utf.as_bytes()] {
            let axis = read_axis(record(text), &mut Vec::new()).unwrap();
            assert_eq!(
                (axis.quantity, axis.label.as_str(), axis.unit.as_str()),
                (12, "Beschleunigung", "m/s²")
            );
        }
        let padded_by_bytes = format!("        12    0    0    0 {}{:12} m/s", "Öffnung", "");
        let padded_by_characters = format!("        12    0    0    0 {:20} m/s", "Öffnung");
        for text in [padded_by_bytes, padded_by_characters] {
            assert_eq!(
                read_axis(record(text.as_bytes()), &mut Vec::new())
                    .unwrap()
                    .unit,
                "m/s",
                "{text:?}"
            );
        }
    }
}
