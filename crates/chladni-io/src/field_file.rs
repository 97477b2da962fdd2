//! The file of a measured field: `# key = value` lines, then rows
//! `response,re,im[,std]` or `response,magnitude[,std]`.
//!
//! Nothing is guessed: frequency and unit must stand in the file. A response that occurs
//! more than once is a repeat; the mean counts, and what repeats scatter says how sure it is.

use crate::limits::VELOCITY;
use crate::unit_label;
use chladni_frf::{Dof, Error, FieldPoint, MeasuredField, Result};
use chladni_text::read_text;
use num_complex::Complex64;
use std::path::Path;

const EXPECTED: &str = "a measured field, CSV";
const COLUMNS: &str = "response,re,im or response,re,im,std or response,magnitude or \
                       response,magnitude,std";

/// Reads the file of a measured field.
///
/// # Errors
/// As [`parse_field`], with the file's name; a file that cannot be read.
pub fn read_field(file: &Path) -> Result<MeasuredField> {
    parse_field(&read_text(file, EXPECTED)?).map_err(|error| error.file(file))
}

/// A measured field from its text.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] with line and field: no frequency, no unit, a unit
/// that is no velocity, other columns, a row that is none, no row.
pub fn parse_field(text: &str) -> Result<MeasuredField> {
    let mut remarks = Remarks::default();
    let mut columns: Option<Columns> = None;
    let mut rows: Vec<(Dof, Vec<Row>)> = Vec::new();
    for (number, line) in (1u64..).zip(text.lines().map(str::trim)) {
        if line.is_empty() {
            continue;
        }
        if let Some(remark) = line.strip_prefix('#') {
            remarks.take(remark, number)?;
            continue;
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(columns) = columns else {
            columns = Some(Columns::of(&cells).map_err(|error| error.at_line(number))?);
            continue;
        };
        let (dof, row) = columns.row(&cells).map_err(|error| error.at_line(number))?;
        match rows.iter_mut().find(|(known, _)| known.same_axis(dof)) {
            Some((known, repeats)) => {
                let turn = known.direction.sign() * dof.direction.sign();
                let value = if columns.complex {
                    row.value * turn
                } else {
                    row.value
                };
                repeats.push(Row { value, ..row });
            }
            None => rows.push((dof, vec![row])),
        }
    }
    let Some(columns) = columns.filter(|_| !rows.is_empty()) else {
        return Err(Error::bad_data("no value in the field")
            .found("no row")
            .expected(format!("a header {COLUMNS}, then a row for each response")));
    };
    let frequency_hz = remarks.frequency_hz.ok_or_else(|| {
        missing(
            "frequency_hz",
            "# frequency_hz = 300.0",
            "the drive frequency of the field",
        )
    })?;
    let unit = remarks
        .unit
        .ok_or_else(|| missing("unit", "# unit = m/s", "the unit of the velocities (peak)"))?;
    let points = rows
        .into_iter()
        .map(|(response, repeats)| mean(response, &repeats, unit))
        .collect();
    Ok(MeasuredField {
        frequency_hz,
        weights_sha256: remarks.weights_sha256,
        magnitudes_only: !columns.complex,
        points,
    })
}

fn missing(field: &str, line: &str, expected: &str) -> Error {
    Error::bad_data(format!("the field does not say its {field}"))
        .field(field)
        .found(format!("no line `# {field} = ...`"))
        .expected(expected)
        .help(format!("add the line `{line}` at the top of the file"))
}

/// The lines with `#`.
#[derive(Default)]
struct Remarks {
    frequency_hz: Option<f64>,
    /// Factor to m/s.
    unit: Option<f64>,
    weights_sha256: Option<String>,
}

impl Remarks {
    fn take(&mut self, remark: &str, line: u64) -> Result<()> {
        let Some((key, value)) = remark.split_once('=') else {
            return Ok(());
        };
        let (key, value) = (key.trim(), value.trim());
        let wrong = |expected: &str| {
            Error::bad_data("not understood")
                .at_line(line)
                .field(key)
                .found(value)
                .expected(expected)
        };
        match key {
            "frequency_hz" => {
                let hz = value
                    .parse()
                    .ok()
                    .filter(|hz: &f64| hz.is_finite() && *hz > 0.0);
                self.frequency_hz = Some(hz.ok_or_else(|| wrong("a frequency in Hz"))?);
            }
            "unit" => {
                // what follows in brackets is a remark
                let label = value.split([' ', '\t']).next().unwrap_or_default();
                let unit = unit_label::parse(label).filter(|unit| unit.powers == VELOCITY);
                let unit = unit.ok_or_else(|| wrong("a velocity: m/s, mm/s or um/s (peak)"))?;
                self.unit = Some(unit.factor);
            }
            "weights_sha256" => {
                let hexadecimal = value.len() == 64 && value.chars().all(|c| c.is_ascii_hexdigit());
                if !hexadecimal {
                    return Err(wrong("64 hexadecimal digits"));
                }
                self.weights_sha256 = Some(value.to_ascii_lowercase());
            }
            _ => {}
        }
        Ok(())
    }
}

/// Columns of the table.
#[derive(Clone, Copy)]
struct Columns {
    complex: bool,
    std: bool,
}

/// One measurement, in the unit of the file.
#[derive(Clone, Copy)]
struct Row {
    value: Complex64,
    std: Option<f64>,
}

impl Columns {
    fn of(header: &[&str]) -> Result<Self> {
        let (complex, std) = match header {
            ["response", "re", "im"] => (true, false),
            ["response", "re", "im", "std"] => (true, true),
            ["response", "magnitude"] => (false, false),
            ["response", "magnitude", "std"] => (false, true),
            _ => {
                return Err(Error::bad_data("not the columns of a measured field")
                    .field("header")
                    .found(header.join(","))
                    .expected(COLUMNS))
            }
        };
        Ok(Self { complex, std })
    }

    fn row(self, cells: &[&str]) -> Result<(Dof, Row)> {
        let values = if self.complex { 2 } else { 1 };
        let expected = 1 + values + usize::from(self.std);
        // a deviation that is left empty is not given
        if cells.len() != expected && !(self.std && cells.len() + 1 == expected) {
            return Err(Error::bad_data("another number of columns than the header")
                .found(format!("{} cells", cells.len()))
                .expected(format!("{expected} cells")));
        }
        let dof = cells[0].parse::<Dof>();
        let dof = dof.map_err(|message| Error::bad_word(&message, cells[0]).field("response"))?;
        let number = |name: &str, text: &str| {
            let number = text.parse::<f64>().ok().filter(|value| value.is_finite());
            number.ok_or_else(|| {
                Error::bad_data("no number")
                    .field(name)
                    .found(text)
                    .expected("a finite number")
            })
        };
        let not_negative = |name: &str, text: &str| match number(name, text)? {
            value if value >= 0.0 => Ok(value),
            _ => Err(Error::bad_data("below zero")
                .field(name)
                .found(text)
                .expected("a number of at least 0")),
        };
        let value = match self.complex {
            true => Complex64::new(number("re", cells[1])?, number("im", cells[2])?),
            false => Complex64::from(not_negative("magnitude", cells[1])?),
        };
        let std = match cells.get(1 + values) {
            Some(&text) if !text.is_empty() => Some(not_negative("std", text)?),
            _ => None,
        };
        Ok((dof, Row { value, std }))
    }
}

/// The mean of repeats and its standard deviation: that which the file states, else the
/// scatter of the repeats over √n.
fn mean(response: Dof, repeats: &[Row], unit: f64) -> FieldPoint {
    let count = repeats.len() as f64;
    let value = repeats.iter().map(|row| row.value).sum::<Complex64>() / count;
    let stated: Option<Vec<f64>> = repeats.iter().map(|row| row.std).collect();
    let std = match stated {
        Some(stated) => {
            Some((stated.iter().map(|std| std * std).sum::<f64>() / count).sqrt() / count.sqrt())
        }
        None if repeats.len() > 1 => {
            let square: f64 = repeats
                .iter()
                .map(|row| (row.value - value).norm_sqr())
                .sum();
            Some((square / (count - 1.0) / count).sqrt())
        }
        None => None,
    };
    FieldPoint {
        response,
        velocity_m_per_s: value * unit,
        std_m_per_s: std.map(|std| std * unit),
        repeats: repeats.len(),
    }
}

/// The text of the file of a measured field, in m/s.
pub fn field_csv(field: &MeasuredField) -> String {
    let mut text = format!("# frequency_hz = {}\n# unit = m/s\n", field.frequency_hz);
    if let Some(sha256) = &field.weights_sha256 {
        text += &format!("# weights_sha256 = {sha256}\n");
    }
    let with_std = field.points.iter().any(|point| point.std_m_per_s.is_some());
    let value = if field.magnitudes_only {
        "magnitude"
    } else {
        "re,im"
    };
    text += &format!("response,{value}{}\n", if with_std { ",std" } else { "" });
    for point in &field.points {
        let v = point.velocity_m_per_s;
        text += &match field.magnitudes_only {
            true => format!("{},{:e}", point.response, v.norm()),
            false => format!("{},{:e},{:e}", point.response, v.re, v.im),
        };
        text += &match point.std_m_per_s {
            Some(std) => format!(",{std:e}\n"),
            None if with_std => ",\n".into(),
            None => "\n".into(),
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# frequency_hz = 300\n# unit = mm/s (peak)\n";

    fn refused(text: &str) -> Error {
        parse_field(text).unwrap_err()
    }

    #[test]
    fn repeats_are_averaged_and_their_scatter_tells_how_sure_they_are() {
        let field = format!("{HEAD}response,re,im\n1:+Z,1,0\n2:+Z,0,3\n1:-Z,-3,0\n");
        let field = parse_field(&field).unwrap();
        assert_eq!(field.points.len(), 2);
        let [one, two] = field.points[..] else {
            panic!()
        };
        assert!((one.velocity_m_per_s - Complex64::new(2e-3, 0.0)).norm() < 1e-15);
        // values 1 and 3: variance 2, of the mean 1
        assert!((one.std_m_per_s.unwrap() - 1e-3).abs() < 1e-15 && one.repeats == 2);
        assert_eq!((two.std_m_per_s, two.repeats), (None, 1));
    }

    #[test]
    fn what_is_written_is_read() {
        for text in [
            "response,re,im,std\n1:+Z,0.5,-2,0.01\n7:-Z,1,1,\n",
            "response,magnitude\n1:+Z,0.5\n",
        ] {
            let sha256 = "ab".repeat(32);
            let text = format!("# weights_sha256 = {sha256}\n{HEAD}{text}");
            let field = parse_field(&text).unwrap();
            assert_eq!(field.weights_sha256.as_deref(), Some(sha256.as_str()));
            assert_eq!(parse_field(&field_csv(&field)).unwrap(), field);
        }
    }

    #[test]
    fn what_is_missing_or_wrong_is_named_with_its_line() {
        let row = "response,re,im\n1:+Z,1,0\n";
        let field = |error: Error| error.field.unwrap_or_default();
        assert_eq!(
            field(refused(&format!("# unit = m/s\n{row}"))),
            "frequency_hz"
        );
        assert_eq!(
            field(refused(&format!("# frequency_hz = 300\n{row}"))),
            "unit"
        );
        let wrong = refused(&format!("# frequency_hz = 300\n# unit = m\n{row}"));
        assert_eq!((wrong.line, wrong.found.as_deref()), (Some(2), Some("m")));
        assert_eq!(field(refused(&format!("{HEAD}node,x\n1,2\n"))), "header");
        for (row, name) in [
            ("x,1,0", "response"),
            ("1:+Z,nan,0", "re"),
            ("1:+Z,1,two", "im"),
        ] {
            let error = refused(&format!("{HEAD}response,re,im\n{row}\n"));
            assert_eq!((error.line, field(error)), (Some(4), name.into()), "{row}");
        }
        assert!(refused(&format!("{HEAD}response,re,im\n1:+Z,1\n"))
            .to_string()
            .contains("3 cells"));
        assert_eq!(
            field(refused(&format!("{HEAD}response,magnitude\n1:+Z,-1\n"))),
            "magnitude"
        );
        assert!(refused(HEAD).to_string().contains("no row"));
    }
}
