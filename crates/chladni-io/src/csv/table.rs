//! A table of numbers with its header: names, units, keywords.

use super::text::{
    both_commas, both_signs, has_thousands, refuse_decimal_comma, Cell, Dialect, Line,
};
use super::vocabulary::known_words;
use crate::limits::TABLE_ROWS_TRIED;
use crate::ReadOptions;
use chladni_frf::{counted, Error, Finding, Result};
use std::collections::BTreeMap;

/// Rows of numbers, NaN where a cell is empty or masked.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) dialect: Dialect,
    /// Names of the columns; empty texts where the file has none.
    pub(super) names: Vec<String>,
    /// Units of the columns in a row of their own; empty texts where there is none.
    pub(super) units: Vec<String>,
    /// Keyword rows above the data, by keyword.
    pub(super) keywords: Vec<(String, Vec<String>)>,
    /// All text above the rows, which may hint at the meaning of columns without names.
    pub(super) header_text: String,
    /// The lines of `header_text` that name no columns.
    pub(super) prose: String,
    pub(super) columns: usize,
    /// Row by row.
    pub(super) values: Vec<f64>,
    /// Line of each row in the file.
    pub(super) lines: Vec<u64>,
}

impl Table {
    /// Reads the header and all rows; cells that cannot be read are errors, or masked
    /// with a warning when `lenient`.
    pub(super) fn read(
        lines: &[Line<'_>],
        options: &ReadOptions,
        warnings: &mut Vec<Finding>,
    ) -> Result<Self> {
        let lenient = options.lenient;
        let dialect = Dialect::detect(lines).ok_or_else(|| no_numbers(lines))?;
        let (header, rows, columns) = split(lines, dialect);
        let filled = filled_columns(&rows, dialect);
        let mut table = Self {
            dialect,
            names: vec![String::new(); columns],
            units: vec![String::new(); columns],
            keywords: Vec::new(),
            header_text: header
                .iter()
                .map(|line| line.text)
                .collect::<Vec<_>>()
                .join("\n"),
            prose: String::new(),
            columns,
            values: Vec::with_capacity(rows.len() * columns),
            lines: Vec::with_capacity(rows.len()),
        };
        refuse_decimal_comma(rows[0], header, dialect, filled)?;
        table.read_header(header, dialect, filled, options.sample_rate_hz.is_some())?;
        table.refuse_whole_numbers(&rows, dialect)?;
        let mut masked = Masked::default();
        for line in &rows {
            table.read_row(line, dialect, lenient, &mut masked)?;
        }
        table.drop_empty_columns();
        masked.report(table.columns, warnings);
        let commented: Vec<_> = lines
            .iter()
            .filter(|line| line.is_comment && dialect.is_row(line.text))
            .collect();
        if let Some(first) = commented.first() {
            warnings.push(Finding::caution(
                "rows-left-out",
                format!(
                    "{} rows of numbers are comments: left out (first in line {})",
                    commented.len(),
                    first.number
                ),
            ));
        }
        table.refuse_nameless_column()?;
        Ok(table)
    }

    fn read_row(
        &mut self,
        line: &Line<'_>,
        dialect: Dialect,
        lenient: bool,
        masked: &mut Masked,
    ) -> Result<()> {
        let cells = dialect.cells(line.text);
        if cells.len() != self.columns {
            if lenient {
                masked.skip(line.number);
                return Ok(());
            }
            return Err(Error::bad_data("a row of another length")
                .at_line(line.number)
                .found(format!("{} columns", cells.len()))
                .expected(format!("{}, as in the first row of numbers", self.columns))
                .help("correct the row, or read it with `lenient`, which leaves it out"));
        }
        for (column, cell) in cells.iter().enumerate() {
            let value = match dialect.number(cell) {
                Cell::Value(value) => value,
                Cell::Empty if column > 0 => {
                    // a column of words for NaN is no mere delimiter: the first is always kept
                    masked.empty(line.number, if cell.is_empty() { column } else { 0 });
                    f64::NAN
                }
                Cell::Overflow | Cell::Text if lenient && column > 0 => {
                    masked.bad(line.number);
                    f64::NAN
                }
                _ => {
                    let name = if self.names[column].is_empty() {
                        format!("column {}", column + 1)
                    } else {
                        self.names[column].clone()
                    };
                    return Err(not_finite(line.number, name, cell, column == 0));
                }
            };
            self.values.push(value);
        }
        self.lines.push(line.number);
        Ok(())
    }

    /// Drops columns without content and name, which a delimiter at the end of each row makes.
    fn drop_empty_columns(&mut self) {
        let is_empty = |column: &usize| {
            self.names[*column].is_empty()
                && self
                    .values
                    .iter()
                    .skip(*column)
                    .step_by(self.columns)
                    .all(|value| value.is_nan())
        };
        let empty = (1..self.columns).rev().take_while(is_empty).count();
        if empty == 0 {
            return;
        }
        let kept = self.columns - empty;
        self.values = self
            .values
            .chunks_exact(self.columns)
            .flat_map(|row| &row[..kept])
            .copied()
            .collect();
        self.names.truncate(kept);
        self.units.truncate(kept);
        self.columns = kept;
    }

    /// The numbers of one column.
    pub(super) fn column(&self, column: usize) -> Vec<f64> {
        self.values
            .iter()
            .skip(column)
            .step_by(self.columns)
            .copied()
            .collect()
    }

    /// The entry of a keyword row for a column: its own cell, else the nearest one to the
    /// left.
    pub(super) fn keyword(&self, key: &str, column: usize) -> Option<&str> {
        let (_, cells) = self.keywords.iter().find(|(found, _)| found == key)?;
        let at = column.min(cells.len().saturating_sub(1));
        let cell = cells.get(at).filter(|cell| at > 0 && !cell.is_empty())?;
        Some(cell)
    }

    /// True where no column has a name.
    pub(super) fn is_nameless(&self) -> bool {
        self.names.iter().all(String::is_empty)
    }
}

/// Header lines, rows and the number of columns. Rows begin at the first clean row of numbers,
/// or above it where cells of the first rows are missing, as they often are at 0 Hz.
fn split<'l, 't>(
    lines: &'l [Line<'t>],
    dialect: Dialect,
) -> (&'l [Line<'t>], Vec<&'l Line<'t>>, usize) {
    let clean = lines
        .iter()
        .position(|line| !line.is_comment && dialect.is_row(line.text))
        .unwrap_or(0);
    let columns = dialect.cells(lines[clean].text).len();
    let damaged = lines[..clean]
        .iter()
        .rev()
        .take_while(|line| line.is_comment || dialect.is_damaged_row(line.text, columns))
        .collect::<Vec<_>>();
    // comments above the first row belong to the header
    let trailing = damaged
        .iter()
        .rev()
        .take_while(|line| line.is_comment)
        .count();
    let start = clean - damaged.len() + trailing;
    let rows = lines[start..].iter().filter(|line| !line.is_comment);
    (&lines[..start], rows.collect(), columns)
}

/// Number of columns up to the last that is filled in one of the first rows: each row may end
/// with a delimiter.
fn filled_columns(rows: &[&Line<'_>], dialect: Dialect) -> usize {
    let filled = |row: &&Line<'_>| {
        let cells = dialect.cells(row.text);
        cells.len()
            - cells
                .iter()
                .rev()
                .take_while(|cell| cell.is_empty())
                .count()
    };
    rows.iter()
        .take(TABLE_ROWS_TRIED)
        .map(filled)
        .max()
        .unwrap_or(0)
}

/// The line that is most likely meant as a row of numbers: the first with a digit, but not the
/// header above it.
fn meant_as_row<'l, 't>(lines: &'l [Line<'t>]) -> Option<&'l Line<'t>> {
    let (first, below) = lines.split_first()?;
    let has_digit = |line: &Line<'_>| line.text.contains(|c: char| c.is_ascii_digit());
    let is_header = known_words(first.text) > 1;
    if has_digit(first) && !is_header {
        return Some(first);
    }
    let mut rows = below.iter().filter(|line| !line.is_comment);
    let second = rows.clone().next().filter(|_| is_header);
    rows.find(|line| has_digit(line)).or(second).or(Some(first))
}

/// Help about the cells of a line that are no numbers.
fn help_for_row(line: &str) -> &'static str {
    let comma = Dialect {
        delimiter: Some(','),
        decimal_comma: false,
    };
    let is_grouped = |dialect: Dialect| {
        let mut cells = dialect.cells(line).into_iter();
        cells.any(|cell| has_thousands(&cell) && dialect.number(&cell) == Cell::Text)
    };
    if line.contains("np.float") || line.contains("np.int") {
        return "write plain numbers: in Python with float(value), or with numpy.savetxt";
    }
    match comma.and_others().any(is_grouped) {
        true => "write the numbers without separators of thousands",
        false => "tables need rows like 10.5,0.1,-0.2 under a header like f,re,im",
    }
}

fn no_numbers(lines: &[Line<'_>]) -> Error {
    let error = Error::bad_data("no row of numbers in this text file");
    let row = meant_as_row(lines);
    let error = match row {
        Some(line) => error.at_line(line.number).found(line.text.trim()),
        None => error.at_line(1).found("only comments or blank lines"),
    };
    if Dialect::commas_everywhere(lines) {
        return both_commas(error);
    }
    if let Some(error) = both_signs(lines) {
        return error;
    }
    error
        .expected("columns of numbers, frequency first")
        .help(help_for_row(row.map_or("", |line| line.text)))
}

/// The error of a cell that is no number. A frequency cannot be masked.
pub(super) fn not_finite(line: u64, name: String, cell: &str, is_axis: bool) -> Error {
    let help = match (has_thousands(cell), is_axis) {
        (true, _) => "write the numbers without separators of thousands",
        (_, true) => "correct the cell, or leave the row out: each needs its frequency",
        _ => "correct the cell, or read the file with `lenient`, which masks it",
    };
    Error::bad_data("not a finite number")
        .at_line(line)
        .field(name)
        .found(if cell.is_empty() {
            "an empty cell"
        } else {
            cell
        })
        .expected("a number")
        .help(help)
}

/// Numbers of rows left out and of values masked, each with the first line.
#[derive(Default)]
struct Masked {
    /// By column: one that is dropped as a whole masks nothing.
    empty: BTreeMap<usize, (u64, usize)>,
    bad: Option<(u64, usize)>,
    skipped: Option<(u64, usize)>,
}

impl Masked {
    fn count(slot: &mut Option<(u64, usize)>, line: u64) {
        slot.get_or_insert((line, 0)).1 += 1;
    }
    fn empty(&mut self, line: u64, column: usize) {
        self.empty.entry(column).or_insert((line, 0)).1 += 1;
    }
    fn bad(&mut self, line: u64) {
        Self::count(&mut self.bad, line);
    }
    fn skip(&mut self, line: u64) {
        Self::count(&mut self.skipped, line);
    }
    /// Adds the findings about a table that kept its first `columns` columns.
    fn report(self, columns: usize, warnings: &mut Vec<Finding>) {
        let kept = self.empty.range(..columns).map(|(_, found)| *found);
        let empty = kept.reduce(|(line, count), (other, more)| (line.min(other), count + more));
        for (slot, what, noun) in [
            (empty, "masked, since empty or NaN", "cell"),
            (self.bad, "masked, since no finite number", "cell"),
            (self.skipped, "left out, since of another length", "row"),
        ] {
            if let Some((line, count)) = slot {
                warnings.push(Finding::caution(
                    "lines-masked",
                    format!("{what}: {} (first in line {line})", counted(count, noun)),
                ));
            }
        }
    }
}
