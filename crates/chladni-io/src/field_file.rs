//! The file of a measured field: `# key = value` lines, then rows
//! `response,re,im[,std]` or `response,magnitude[,std]`.
//!
//! Nothing is guessed: the file must state frequency and unit. A response that occurs more
//! than once was repeated: its value is the mean, and the scatter gives its standard
//! deviation.

mod peak;
mod remarks;

use crate::csv::numbered_lines;
use crate::limits::{DRIFT_OF_LEVEL, FASTEST_M_PER_S, REPEATS_APART, STILL_M_PER_S};
use chladni_frf::{Dof, Error, FieldPoint, MeasuredField, Result};
use chladni_text::read_text;
use num_complex::Complex64;
use remarks::Remarks;
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

/// Reads a measured field from its text.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] with line and field: no frequency; no unit, two units,
/// or one that is no velocity or not of peak values; other columns; a damaged row; a velocity
/// above the speed of light; repeats too far apart; no row; no response that moves.
pub fn parse_field(text: &str) -> Result<MeasuredField> {
    let remarks = Remarks::of(text)?;
    let to_m_per_s = remarks.unit.as_ref().map_or(1.0, |unit| unit.value);
    let mut columns: Option<Columns> = None;
    let mut rows: Vec<(Dof, Vec<Row>)> = Vec::new();
    for (number, line) in numbered_lines(text) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(columns) = columns else {
            columns = Some(Columns::of(&cells).map_err(|error| error.at_line(number))?);
            continue;
        };
        let row = columns.row(&cells, to_m_per_s);
        let (dof, row) = row.map_err(|error| error.at_line(number))?;
        match rows.iter_mut().find(|(known, _)| known.same_axis(dof)) {
            Some((known, repeats)) => {
                let turn = known.direction.sign() * dof.direction.sign();
                let value = if columns.complex {
                    row.value * turn
                } else {
                    row.value
                };
                let row = Row { value, ..row };
                check_repeat(dof, &repeats[0], &row).map_err(|error| error.at_line(number))?;
                repeats.push(row);
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
    let points: Vec<FieldPoint> = rows
        .into_iter()
        .map(|(response, repeats)| mean(response, &repeats, unit.value))
        .collect();
    let moves = |point: &FieldPoint| point.velocity_m_per_s.norm() > STILL_M_PER_S;
    if !points.iter().any(moves) {
        return Err(nothing_moves(points.len(), columns));
    }
    Ok(MeasuredField {
        frequency_hz: frequency_hz.value,
        weights_sha256: remarks.weights_sha256.map(|sha256| sha256.value),
        magnitudes_only: !columns.complex,
        points,
    })
}

/// The error of a field in which every value is zero.
fn nothing_moves(responses: usize, columns: Columns) -> Error {
    let field = if columns.complex {
        "re,im"
    } else {
        "magnitude"
    };
    Error::bad_data("every value of the field is zero: nothing was measured")
        .field(field)
        .found(format!(
            "{responses} responses, none above {STILL_M_PER_S:e} m/s"
        ))
        .expected("at least one response that moves")
        .help("see whether laser and amplifiers were on, and measure the field again")
}

fn missing(field: &str, line: &str, expected: &str) -> Error {
    Error::bad_data(format!("the field does not say its {field}"))
        .field(field)
        .found(format!("no line `# {field} = ...`"))
        .expected(expected)
        .help(format!("add the line `{line}` at the top of the file"))
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

    /// A row of numbers that `to_m_per_s` turns into peak velocities.
    fn row(self, cells: &[&str], to_m_per_s: f64) -> Result<(Dof, Row)> {
        let values = if self.complex { 2 } else { 1 };
        let expected = 1 + values + usize::from(self.std);
        // an empty cell for the standard deviation counts as absent
        if cells.len() != expected && !(self.std && cells.len() + 1 == expected) {
            return Err(Error::bad_data("another number of columns than the header")
                .found(format!("{} cells", cells.len()))
                .expected(format!("{expected} cells")));
        }
        let dof = cells[0].parse::<Dof>();
        let dof = dof.map_err(|message| Error::bad_word(&message, cells[0]).field("response"))?;
        let number = |name: &str, text: &str| {
            let wrong = |message: &str| Error::bad_data(message).field(name).found(text);
            let number = text.parse::<f64>().ok().filter(|value| value.is_finite());
            let number = number.ok_or_else(|| wrong("no number").expected("a finite number"))?;
            if (number * to_m_per_s).abs() > FASTEST_M_PER_S {
                return Err(wrong("no speed that a vibration can have")
                    .expected(format!(
                        "at most {FASTEST_M_PER_S:e} m/s, the speed of light"
                    ))
                    .help("correct the unit, or leave out a response that was not measured"));
            }
            Ok(number)
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

/// Refuses a value too far from the first of its response to be a repeat of it.
fn check_repeat(response: Dof, first: &Row, row: &Row) -> Result<()> {
    let (Some(one), Some(other)) = (first.std, row.std) else {
        return Ok(());
    };
    let (apart, bar) = ((row.value - first.value).norm(), one.hypot(other));
    // between passes a level may drift by more than the noise
    let drift = DRIFT_OF_LEVEL * first.value.norm().max(row.value.norm());
    if bar == 0.0 || apart <= drift.max(REPEATS_APART * bar) {
        return Ok(());
    }
    Err(
        Error::bad_data("a response occurs twice, with values too far apart for repeats")
            .field("response")
            .found(format!(
                "{response}, {:.0} standard deviations from its first value",
                apart / bar
            ))
            .expected(format!("at most {REPEATS_APART} standard deviations"))
            .help("correct the name of one of both rows, or state the deviations as they are"),
    )
}

/// The mean of repeats and its standard deviation: by those that the file states, else by the
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
    fn values_too_far_apart_for_repeats_are_refused() {
        let of = |second: &str| format!("{HEAD}response,re,im,std\n1:+Z,1,0,0.01\n{second}\n");
        let error = refused(&of("1:+Z,1.5,0,0.01"));
        assert_eq!(
            (error.line, error.field.as_deref()),
            (Some(5), Some("response"))
        );
        assert!(error.to_string().contains("35 standard"), "{error}");
        for near in ["1:+Z,1.05,0,0.01", "1:-Z,-1.05,0,0.001", "1:+Z,1.5,0,0.1"] {
            assert_eq!(parse_field(&of(near)).unwrap().points[0].repeats, 2);
        }
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
    fn lines_end_as_in_every_table() {
        let text = format!("{HEAD}response,re,im\n1:+Z,0.5,-2\n\n7:-Z,1,1\n");
        let field = parse_field(&text).unwrap();
        for end in ["\r\n", "\r"] {
            assert_eq!(
                parse_field(&text.replace('\n', end)).unwrap(),
                field,
                "{end:?}"
            );
            let wrong = text.replace("7:-Z,1", "7:-Z,x").replace('\n', end);
            assert_eq!(refused(&wrong).line, Some(6), "{end:?}");
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

    #[test]
    fn values_that_no_vibration_has_are_refused_with_line_and_column() {
        for (header, row, name) in [
            ("response,re,im", "2:+Z,1e300,0", "re"),
            ("response,re,im", "2:+Z,0,-1e12", "im"),
            ("response,re,im,std", "2:+Z,1,0,1e200", "std"),
            ("response,magnitude", "2:+Z,1e300", "magnitude"),
        ] {
            let good = row.replace("1e300", "1").replace("-1e12", "1");
            let good = good.replace("1e200", "1").replace("2:+Z", "1:+Z");
            let error = refused(&format!("{HEAD}{header}\n{good}\n{row}\n"));
            assert_eq!(
                (error.line, error.field.as_deref()),
                (Some(5), Some(name)),
                "{row}"
            );
            let expected = error.expected.unwrap_or_default();
            assert!(expected.contains("m/s"), "{row}: {expected}");
        }
        // the unit counts: 1e9 um/s are a kilometre per second
        let slow = "# frequency_hz = 300\n# unit = um/s\nresponse,re,im\n1:+Z,1e9,0\n";
        assert!(parse_field(slow).is_ok());
        assert!(parse_field(&slow.replace("um/s", "m/s")).is_err());
    }

    #[test]
    fn a_field_of_zeros_is_refused() {
        for rows in [
            "response,re,im\n1:+Z,0,0\n2:+Z,-0,0\n",
            "response,magnitude,std\n1:+Z,0,1e-6\n",
            "response,re,im\n1:+Z,1e-300,0\n",
        ] {
            let error = refused(&format!("{HEAD}{rows}"));
            assert!(error.to_string().contains("nothing was measured"), "{rows}");
            assert!(error.field.is_some() && error.help.is_some(), "{rows}");
        }
        let one = format!("{HEAD}response,re,im\n1:+Z,0,0\n2:+Z,0,1e-9\n");
        assert!(parse_field(&one).is_ok());
    }

    #[test]
    fn words_after_the_unit_are_understood_or_refused() {
        let with = |unit: &str| {
            let rows = "response,re,im,std\n1:+Z,0,2,1\n";
            parse_field(&format!("# frequency_hz = 300\n# unit = {unit}\n{rows}"))
        };
        for (unit, factor) in [
            ("mm/s", 1e-3),
            ("mm/s peak", 1e-3),
            ("m/s\t[peak]", 1.0),
            ("m/s   (or mm/s, um/s; peak; phase as e^{+jωt})", 1.0),
            ("mm/s rms", 2f64.sqrt() * 1e-3),
        ] {
            let [point] = with(unit).unwrap().points[..] else {
                panic!("{unit}")
            };
            let (value, std) = (point.velocity_m_per_s.im, point.std_m_per_s.unwrap());
            assert!((value / (2.0 * factor) - 1.0).abs() < 1e-12, "{unit}");
            assert!((std / factor - 1.0).abs() < 1e-12, "{unit}");
        }
        for (unit, word) in [
            ("m/s peak-to-peak", "peak-to-peak"),
            ("mm/s pk-pk", "pk-pk"),
            ("mm/s dB", "dB"),
            ("m/s (peak, from rms)", "rms"),
        ] {
            let error = with(unit).unwrap_err();
            assert_eq!(
                (error.line, error.found.as_deref()),
                (Some(2), Some(word)),
                "{unit}"
            );
            assert!(error.help.unwrap_or_default().contains("peak"), "{unit}");
        }
    }
}
