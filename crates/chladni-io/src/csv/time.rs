//! Tables of time records: `t [s], 101:+Z [N], 1:+Z [m/s]`, one column per channel.

use super::column_header::{without_brackets, ColumnHeader};
use super::header::outside_brackets;
use super::table::Table;
use super::text::Dialect;
use super::vocabulary::{is_frequency, words};
use crate::runs::signal_unit;
use crate::unit_label::{self, Unit};
use crate::{Abscissa, Axis, DatasetInfo, Document, FileFormat, Function, Ordinate};
use chladni_frf::{Direction, Dof, Error, Finding, Result};
use std::borrow::Cow;
use std::path::Path;

/// Names of a time axis.
const TIME_NAMES: [&str; 4] = ["t", "time", "zeit", "temps"];

/// The times of the samples of a table.
pub(super) enum Times {
    /// Times in the first column, with their factor to seconds.
    FirstColumn {
        to_seconds: f64,
        /// True where the user gives a rate as well.
        has_rate: bool,
    },
    /// Even sampling at this rate, Hz, without a column of times.
    Rate(f64),
}

/// The time axis of a table: its first column where name or unit are of a time, else the
/// `rate_hz` of the user.
pub(super) fn axis(table: &Table, rate_hz: Option<f64>) -> Option<Times> {
    let times = |to_seconds| Times::FirstColumn {
        to_seconds,
        has_rate: rate_hz.is_some(),
    };
    let factor = to_seconds(table.names.first()?, table.units.first()?);
    factor.map(times).or(rate_hz.map(Times::Rate))
}

/// The factor to seconds of a column whose name or unit are of a time.
fn to_seconds(name: &str, unit_row: &str) -> Option<f64> {
    let head = ColumnHeader::parse(name, unit_row);
    let named = TIME_NAMES.contains(&head.base.trim());
    match unit_label::parse(&head.unit).or_else(|| in_name(name)) {
        Some(unit) => unit.to_seconds(),
        None => (named && head.unit.is_empty()).then_some(1.0),
    }
}

/// True for cells of which the first is a time.
pub(super) fn is_first(cells: &[String]) -> bool {
    let first = cells.first();
    first.is_some_and(|first| to_seconds(first, "").is_some())
}

/// True for the name of a time and nothing else: it may begin a sentence.
fn is_mere_word(name: &str) -> bool {
    let word = name.trim_matches(|c: char| !c.is_alphanumeric());
    TIME_NAMES.contains(&word.to_lowercase().as_str())
}

/// True for a name that begins with the name of a time.
fn is_named(name: &str) -> bool {
    let first = words(name).next().unwrap_or_default();
    TIME_NAMES.contains(&first.to_lowercase().as_str())
}

/// True for the cells of a header of a time record: the first is a time, and no other begins
/// with a digit, as in `Time 10:30:00`. Prose between blanks looks alike: there, a cell has a
/// unit or a DOF as well.
pub(super) fn is_header(cells: &[String], between_blanks: bool) -> bool {
    let begins_with = |is_sign: fn(char) -> bool| cells[1..].iter().any(|c| c.starts_with(is_sign));
    let says_more = |name: &String| {
        let head = ColumnHeader::parse(name, "");
        !head.dofs.is_empty() || channel_unit(name, &head).1.is_some()
    };
    let is_prose = || {
        let units_alone = begins_with(|c| "([".contains(c));
        units_alone
            || !is_named(&cells[0])
            || (is_mere_word(&cells[0]) && !cells[1..].iter().any(says_more))
    };
    is_first(cells) && !begins_with(|c| c.is_ascii_digit()) && !(between_blanks && is_prose())
}

/// True for a row of units of which the first is that of a time: `s, N, m/s`.
pub(super) fn is_unit_row(cells: &[String]) -> bool {
    let unit = |cell: &String| unit_label::parse(&without_brackets(cell));
    let is_time = |cell: &String| unit(cell).is_some_and(|unit| unit.to_seconds().is_some());
    let is_unit = |cell: &String| ["", "-"].contains(&cell.trim()) || unit(cell).is_some();
    cells.first().is_some_and(is_time) && cells.iter().all(is_unit)
}

/// True for a line that begins with the name of a time and goes on with names: none of them
/// begins with a digit, as a time of day does, unless it is a DOF, and none is a frequency. The
/// delimiter of the numbers follows, or the time has its unit: `Time averaged` is prose.
pub(super) fn is_named_first(line: &str, dialect: Dialect) -> bool {
    let is_delimited = dialect.delimiter.is_some_and(|sign| line.contains(sign));
    let cells = match is_delimited {
        true => dialect
            .cells(line)
            .into_iter()
            .map(Cow::into_owned)
            .collect(),
        false => outside_brackets(line),
    };
    // `Time:` says when it was measured
    let is_name = is_delimited && !cells[0].ends_with(':');
    if !is_first(&cells) || !is_named(&cells[0]) || (!is_name && is_mere_word(&cells[0])) {
        return false;
    }
    let lower = line.to_lowercase();
    let is_frequency = |word: &str| is_frequency(word) && word != "x";
    let is_number =
        |name: &str| name.starts_with(|c: char| c.is_ascii_digit()) && name.parse::<Dof>().is_err();
    let mut names = lower
        .split(|c: char| c.is_whitespace() || ",;\"".contains(c))
        .filter(|name| !name.is_empty());
    names.next();
    names.clone().next().is_some() && !names.any(is_number) && !words(&lower).any(is_frequency)
}

/// The unit of a time at the end of a name: `time_ms`, `t (s)`.
fn in_name(name: &str) -> Option<Unit> {
    let words: Vec<&str> = name
        .split(|c: char| c.is_whitespace() || "_()[]".contains(c))
        .filter(|word| !word.is_empty())
        .collect();
    match words.as_slice() {
        [first, unit] if TIME_NAMES.contains(&first.to_lowercase().as_str()) => {
            unit_label::parse(unit)
        }
        _ => None,
    }
}

/// Label and unit of a channel: in brackets, in the unit row, or at the end of its name:
/// `Force (N)`, `force_N`, `acc m/s^2`, `acc_m_s2`.
fn channel_unit(name: &str, head: &ColumnHeader) -> (String, Option<Unit>) {
    if let Some(unit) = unit_label::parse(&head.unit) {
        return (head.unit.clone(), Some(unit));
    }
    let is_signal = |label: &String| signal_unit(label).is_some();
    let starts = name
        .match_indices(|c: char| c.is_whitespace() || "_([".contains(c))
        .map(|(at, sign)| at + sign.len());
    let label = starts
        .flat_map(|at| {
            let label = name[at..].trim().trim_end_matches([')', ']']);
            let label = label.replace("_per_", "/").replace(" per ", "/");
            [label.replace('_', "/"), label]
        })
        .find(is_signal);
    match label.filter(|_| head.unit.is_empty()) {
        Some(label) => {
            let unit = unit_label::parse(&label);
            (label, unit)
        }
        None => (head.unit.clone(), None),
    }
}

/// The channels as functions of type 1.
///
/// # Errors
/// A time axis that does not rise; masked samples; no channel beside the time.
pub(super) fn document(
    table: &Table,
    times: &Times,
    mut warnings: Vec<Finding>,
    file: &Path,
) -> Result<Document> {
    let (first_channel, abscissa, to_seconds) = abscissa(table, times)?;
    if table.columns <= first_channel {
        return Err(Error::bad_data("a time axis without a channel")
            .at_line(table.lines[0])
            .found("1 column")
            .expected("a column per channel")
            .help("export the channels beside the time, with units in their names"));
    }
    let mut document = Document::new(file, FileFormat::Csv);
    let mut numbered = 0;
    let heads = ColumnHeader::of_columns(&table.names, &table.units);
    for (column, head) in heads.iter().enumerate().skip(first_channel) {
        let samples = samples(table, column)?;
        // the DOF of a channel, be it a force or a motion
        let response = head.dofs.response.or(head.dofs.reference);
        let response = response.unwrap_or_else(|| {
            numbered += 1;
            Dof::new((column + 1 - first_channel) as u64, Direction::SCALAR)
        });
        let (label, unit) = channel_unit(&table.names[column], head);
        if unit.is_none() {
            let words = format!(
                "column {}: no unit that is understood; values are taken as they are",
                column + 1
            );
            warnings.push(Finding::caution("unit-assumed", words));
        }
        let info = dataset_info(table, response, samples.len());
        document.datasets.push(info);
        let channel = Axis {
            label: table.names[column].clone(),
            unit: label,
            ..Axis::default()
        };
        let ordinate = Ordinate::Real64(samples);
        document.functions.push(Function {
            scale_to_si: unit.map_or(1.0, |unit| unit.factor),
            abscissa_to_si: to_seconds,
            ..Function::time_record(response, abscissa.clone(), channel, ordinate)
        });
    }
    if numbered > 0 {
        warnings.push(Finding::caution(
            "dofs-assumed",
            format!("{numbered} columns name no DOF; they are numbered by their place, as 2:S"),
        ));
    }
    Ok(Document {
        warnings,
        ..document
    })
}

/// The column of the first channel, the times, and their factor to seconds.
fn abscissa(table: &Table, times: &Times) -> Result<(usize, Abscissa, f64)> {
    Ok(match *times {
        Times::FirstColumn {
            to_seconds,
            has_rate,
        } => {
            let times = table.column(0);
            refuse_falling(table, &times, has_rate)?;
            (1, Abscissa::Uneven(times), to_seconds)
        }
        Times::Rate(rate_hz) => {
            let step = 1.0 / rate_hz;
            (0, Abscissa::Even { start: 0.0, step }, 1.0)
        }
    })
}

/// The samples of a column, none of which may be missing.
fn samples(table: &Table, column: usize) -> Result<Vec<f64>> {
    let samples = table.column(column);
    match samples.iter().position(|sample| sample.is_nan()) {
        None => Ok(samples),
        Some(row) => Err(Error::bad_data("a sample is missing")
            .at_line(table.lines[row])
            .field(&table.names[column])
            .found("an empty or masked cell")
            .expected("a number in every row of a time record")
            .help("leave the column out, or keep the rows before or after the gap")),
    }
}

fn dataset_info(table: &Table, response: Dof, samples: usize) -> DatasetInfo {
    DatasetInfo {
        name: "table".into(),
        line: table.lines.first().copied(),
        function: Some("time".into()),
        response: Some(response.to_string()),
        values: Some(samples),
        ..DatasetInfo::default()
    }
}

fn refuse_falling(table: &Table, times: &[f64], has_rate: bool) -> Result<()> {
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(()),
        Some(k) => Err(Error::bad_data("the time axis does not rise")
            .at_line(table.lines[k + 1])
            .field("time")
            .found(format!("{} after {}", times[k + 1], times[k]))
            .expected("strictly rising times")
            .help(match has_rate {
                true => "export the times with more digits, or leave their column out",
                false => {
                    "export the times with more digits, or leave their column out and say \
                     `sample_rate HZ`"
                }
            })),
    }
}
