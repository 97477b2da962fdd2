//! A table of numbers with its header: names, units, keywords.

use super::head::looks_like_unit;
use super::text::{Cell, Dialect, Line};
use chladni_frf::{Error, Result};

/// Keywords of ME'scope spreadsheets that stand in the first column above the data.
const KEYWORDS: [&str; 6] = [
    "measurement type",
    "x axis spacing",
    "x axis units",
    "y axis type",
    "y axis units",
    "y axis dofs",
];

/// Rows of numbers, NaN where a cell is empty or masked.
#[derive(Debug)]
pub(super) struct Table {
    /// Names of the columns; empty texts where the file has none.
    pub(super) names: Vec<String>,
    /// Units of the columns in a row of their own; empty texts where there is none.
    pub(super) units: Vec<String>,
    /// Keyword rows above the data, by keyword.
    keywords: Vec<(String, Vec<String>)>,
    /// All header text in lower case, to see what an unnamed table may be about.
    pub(super) header_text: String,
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
        lenient: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self> {
        let dialect = Dialect::detect(lines).ok_or_else(|| no_numbers(lines))?;
        let start = lines
            .iter()
            .position(|line| dialect.is_row(line.text))
            .unwrap_or(0);
        let (header, rows) = lines.split_at(start);
        let columns = dialect.cells(rows[0].text).len();
        let mut table = Self {
            names: vec![String::new(); columns],
            units: vec![String::new(); columns],
            keywords: Vec::new(),
            header_text: header
                .iter()
                .map(|line| line.text.to_lowercase())
                .collect::<Vec<_>>()
                .join("\n"),
            columns,
            values: Vec::with_capacity(rows.len() * columns),
            lines: Vec::with_capacity(rows.len()),
        };
        table.read_header(header, dialect);
        refuse_decimal_comma(&rows[0], header, dialect, columns)?;
        let mut masked = Masked::default();
        for line in rows {
            table.read_row(line, dialect, lenient, &mut masked)?;
        }
        masked.report(warnings);
        table.drop_empty_columns();
        Ok(table)
    }

    fn read_header(&mut self, header: &[Line<'_>], dialect: Dialect) {
        let mut candidates: Vec<Vec<String>> = Vec::new();
        for line in header {
            let mut cut: Vec<Vec<String>> = dialect
                .and_others()
                .map(|dialect| {
                    dialect
                        .cells(line.text)
                        .into_iter()
                        .map(|cell| cell.into_owned())
                        .collect()
                })
                .collect();
            // names with single blanks in them, aligned by several
            cut.push(
                line.text
                    .split("  ")
                    .map(str::trim)
                    .filter(|name| !name.is_empty())
                    .map(str::to_owned)
                    .collect(),
            );
            let keyword = |cells: &Vec<String>| {
                let key = cells[0].trim_end_matches(':').to_lowercase();
                KEYWORDS.contains(&key.as_str()).then_some(key)
            };
            if let Some((key, cells)) = cut
                .iter()
                .filter(|cells| !cells.is_empty())
                .find_map(|cells| Some((keyword(cells)?, cells)))
            {
                self.keywords.push((key, cells.clone()));
                continue;
            }
            if let Some(cells) = cut.into_iter().find(|cells| cells.len() == self.columns) {
                candidates.push(cells);
            }
        }
        let is_unit_row = |cells: &Vec<String>| {
            cells.iter().all(|cell| looks_like_unit(cell))
                && cells.iter().any(|cell| !cell.is_empty())
        };
        if let Some(last) = candidates.pop() {
            if is_unit_row(&last) {
                self.units = last;
                if let Some(names) = candidates.pop() {
                    self.names = names;
                }
            } else {
                self.names = last;
            }
        }
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
                .help("correct the row, or read it with --lenient, which leaves it out"));
        }
        for (column, cell) in cells.iter().enumerate() {
            let value = match dialect.number(cell) {
                Cell::Value(value) => value,
                Cell::Empty if column > 0 => {
                    masked.empty(line.number);
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
                    return Err(Error::bad_data("not a finite number")
                        .at_line(line.number)
                        .field(name)
                        .found(if cell.is_empty() {
                            "an empty cell"
                        } else {
                            cell
                        })
                        .expected("a number")
                        .help(
                            "correct the cell, or read the file with --lenient, which masks it",
                        ));
                }
            };
            self.values.push(value);
        }
        self.lines.push(line.number);
        Ok(())
    }

    /// A delimiter at the end of each row makes a column without content or name.
    fn drop_empty_columns(&mut self) {
        let rows = self.lines.len();
        while self.columns > 1 {
            let last = self.columns - 1;
            let empty = self.names[last].is_empty()
                && (0..rows).all(|row| self.values[row * self.columns + last].is_nan());
            if !empty {
                return;
            }
            self.values = (0..rows)
                .flat_map(|row| self.values[row * self.columns..][..last].to_vec())
                .collect();
            self.names.pop();
            self.units.pop();
            self.columns = last;
        }
    }

    /// One column.
    pub(super) fn column(&self, column: usize) -> Vec<f64> {
        self.values
            .iter()
            .skip(column)
            .step_by(self.columns)
            .copied()
            .collect()
    }

    /// What a keyword row says for a column: its own cell, else the nearest one to the
    /// left.
    pub(super) fn keyword(&self, key: &str, column: usize) -> Option<&str> {
        let (_, cells) = self.keywords.iter().find(|(found, _)| found == key)?;
        let upto = cells.get(1..=column.min(cells.len().saturating_sub(1)))?;
        upto.iter()
            .rev()
            .find(|cell| !cell.is_empty())
            .map(String::as_str)
    }

    /// True where no column has a name.
    pub(super) fn is_nameless(&self) -> bool {
        self.names.iter().all(String::is_empty)
    }
}

fn no_numbers(lines: &[Line<'_>]) -> Error {
    let error = Error::bad_data("no row of numbers in this text file");
    let error = match lines.first() {
        Some(line) => error.at_line(line.number).found(line.text.trim()),
        None => error.at_line(1).found("only comments or blank lines"),
    };
    if Dialect::commas_everywhere(lines) {
        return both_commas(error);
    }
    error
        .expected("columns of numbers, frequency first")
        .help("tables need rows like 10.5,0.1,-0.2 under a header like f,re,im")
}

fn both_commas(error: Error) -> Error {
    error
        .expected("a decimal point, or another delimiter")
        .help(
            "a decimal comma together with `,` as delimiter cannot be read: export with `;` or \
               tabs between the columns",
        )
}

/// More cells than names, up to twice as many: the commas inside the numbers were taken
/// for delimiters.
fn refuse_decimal_comma(
    first: &Line<'_>,
    header: &[Line<'_>],
    dialect: Dialect,
    columns: usize,
) -> Result<()> {
    let Some(last) = header.last().filter(|_| dialect.delimiter == Some(',')) else {
        return Ok(());
    };
    let names = dialect.cells(last.text).len();
    if names >= 2 && names < columns && columns <= 2 * names {
        return Err(both_commas(
            Error::bad_data("more columns than names; do the numbers have a decimal comma?")
                .at_line(first.number)
                .found(format!(
                    "{columns} columns under {names} names: {}",
                    first.text.trim()
                )),
        ));
    }
    Ok(())
}

/// What was left out or masked, and where first.
#[derive(Default)]
struct Masked {
    empty: Option<(u64, usize)>,
    bad: Option<(u64, usize)>,
    skipped: Option<(u64, usize)>,
}

impl Masked {
    fn count(slot: &mut Option<(u64, usize)>, line: u64) {
        slot.get_or_insert((line, 0)).1 += 1;
    }
    fn empty(&mut self, line: u64) {
        Self::count(&mut self.empty, line);
    }
    fn bad(&mut self, line: u64) {
        Self::count(&mut self.bad, line);
    }
    fn skip(&mut self, line: u64) {
        Self::count(&mut self.skipped, line);
    }
    fn report(self, warnings: &mut Vec<String>) {
        for (slot, what) in [
            (self.empty, "cells are empty or NaN; masked"),
            (self.bad, "cells are no finite numbers; masked"),
            (self.skipped, "rows have another length; left out"),
        ] {
            if let Some((line, count)) = slot {
                warnings.push(format!("{count} {what} (first in line {line})"));
            }
        }
    }
}
