//! A table of numbers with its header: names, units, keywords.

use super::head::{looks_like_unit, Head};
use super::text::{Cell, Dialect, Line};
use super::vocabulary::{known_words, part_of, words, Part};
use crate::unit_label::frequency_unit;
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
    /// All text above the rows, to see what an unnamed column may be about.
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
        let (header, rows, columns) = split(lines, dialect);
        let first = dialect.cells(rows[0].text);
        let filled = columns
            - first
                .iter()
                .rev()
                .take_while(|cell| cell.is_empty())
                .count();
        let mut table = Self {
            names: vec![String::new(); columns],
            units: vec![String::new(); columns],
            keywords: Vec::new(),
            header_text: header
                .iter()
                .map(|line| line.text)
                .collect::<Vec<_>>()
                .join("\n"),
            columns,
            values: Vec::with_capacity(rows.len() * columns),
            lines: Vec::with_capacity(rows.len()),
        };
        refuse_decimal_comma(&rows[0], header, dialect, filled)?;
        table.read_header(header, dialect, filled)?;
        table.refuse_whole_numbers(&rows, dialect)?;
        let mut masked = Masked::default();
        for line in &rows {
            table.read_row(line, dialect, lenient, &mut masked)?;
        }
        masked.report(warnings);
        let commented: Vec<_> = lines
            .iter()
            .filter(|line| line.is_comment && dialect.is_row(line.text))
            .collect();
        if let Some(first) = commented.first() {
            warnings.push(format!(
                "{} rows of numbers are comments: left out (first in line {})",
                commented.len(),
                first.number
            ));
        }
        table.drop_empty_columns();
        table.refuse_nameless_column()?;
        Ok(table)
    }

    /// Names, units and keywords. `filled` columns are not empty in the first row.
    fn read_header(&mut self, header: &[Line<'_>], dialect: Dialect, filled: usize) -> Result<()> {
        let mut candidates: Vec<Vec<String>> = Vec::new();
        for line in header.iter().filter(|line| !dialect.is_row(line.text)) {
            let mut keyword = None;
            let mut fitting = None;
            for mut cells in cuts(line.text, dialect) {
                let first = cells.first().map(|cell| cell.trim_end_matches(':'));
                let key = first.unwrap_or_default().to_lowercase();
                if KEYWORDS.contains(&key.as_str()) {
                    keyword = Some((key, cells));
                    break;
                }
                while cells.len() > filled && cells.last().is_some_and(String::is_empty) {
                    cells.pop();
                }
                let fits = cells.len() == self.columns || cells.len() == filled;
                let says = known_words(line.text) > 0
                    || cells.iter().all(|cell| looks_like_unit(cell))
                    || cells
                        .iter()
                        .any(|cell| Head::parse(cell, "").dofs.is_some());
                // prose of as many words as there are columns is no header
                let is_header = says || (line.text.contains(',') || line.text.contains(';'));
                let has_words = words(line.text).next().is_some();
                if fitting.is_none() && fits && is_header && has_words {
                    cells.resize(self.columns, String::new());
                    fitting = Some(cells);
                }
            }
            match (keyword, fitting) {
                (Some((key, cells)), _) => self.keywords.push((key, filled_forward(cells))),
                (None, Some(cells)) => candidates.push(cells),
                (None, None) => {}
            }
        }
        let Some(names) = self.take_units(&mut candidates) else {
            return self.refuse_header_that_does_not_fit(header);
        };
        self.names = names;
        // DOFs or parts in a row of their own above the names
        for above in candidates.iter().rev() {
            let speaks = |cell: &String| {
                let head = Head::parse(cell, "");
                head.dofs.is_some() || words(cell).any(|word| part_of(word).is_some())
            };
            if !above[1..].iter().any(speaks) {
                break;
            }
            let cells = filled_forward(above.clone());
            for (name, more) in self.names.iter_mut().zip(&cells).skip(1) {
                if !name.contains(more.as_str()) {
                    *name = format!("{more} {name}").trim().to_owned();
                }
            }
        }
        Ok(())
    }

    /// Takes the row of units out of the rows above the data; what is left ends with the
    /// names, which are returned.
    fn take_units(&mut self, candidates: &mut Vec<Vec<String>>) -> Option<Vec<String>> {
        let is_unit_row = |cells: &Vec<String>| {
            let all = cells.iter().all(|cell| looks_like_unit(cell));
            let names_parts = cells
                .iter()
                .flat_map(|cell| words(cell))
                .any(|word| matches!(part_of(word), Some(part) if part != Part::Magnitude));
            let first = cells[0].trim().trim_matches(['[', ']', '(', ')']);
            cells.iter().any(|cell| !cell.is_empty())
                && (all || (frequency_unit(first).is_some() && !names_parts))
        };
        let at = candidates.iter().rposition(is_unit_row);
        // a row that can only be units, or one that stands beside names
        if let Some(at) = at.filter(|at| at + 2 >= candidates.len()) {
            let all = candidates[at].iter().all(|cell| looks_like_unit(cell));
            if all || candidates.len() > 1 {
                self.units = candidates.remove(at);
            }
        }
        if candidates.is_empty() && self.units.iter().any(|unit| !unit.is_empty()) {
            return Some(vec![String::new(); self.columns]);
        }
        candidates.pop()
    }

    /// A header whose names are not as many as the columns, and cannot be told apart.
    fn refuse_header_that_does_not_fit(&self, header: &[Line<'_>]) -> Result<()> {
        let Some(line) = header.iter().rev().find(|line| known_words(line.text) > 1) else {
            return Ok(());
        };
        Err(Error::bad_data(
            "the header does not fit the columns, which may be magnitude and phase, or real and \
             imaginary part",
        )
        .at_line(line.number)
        .found(line.text.trim())
        .expected(format!("{} names, one for each column", self.columns))
        .help("put a header line above the numbers: f,re,im or f,mag,phase"))
    }

    /// Whole numbers between commas, without names to count them, may be the halves of
    /// numbers with a decimal comma.
    fn refuse_whole_numbers(&self, rows: &[&Line<'_>], dialect: Dialect) -> Result<()> {
        const ROWS_TRIED: usize = 50;
        let whole = |row: &&Line<'_>| !row.text.contains(['.', 'e', 'E']);
        if !self.is_nameless()
            || dialect.delimiter != Some(',')
            || !rows.iter().take(ROWS_TRIED).all(|row| whole(row))
        {
            return Ok(());
        }
        Err(both_commas(
            Error::bad_data("whole numbers without names; do the numbers have a decimal comma?")
                .at_line(rows[0].number)
                .found(rows[0].text.trim()),
        )
        .expected("names that count the columns, or numbers with a decimal point"))
    }

    /// A column of numbers that the header does not count.
    fn refuse_nameless_column(&self) -> Result<()> {
        let nameless = (1..self.columns).find(|&column| {
            self.names[column].is_empty()
                && self.units[column].is_empty()
                && self.keywords.is_empty()
        });
        match nameless.filter(|_| !self.is_nameless()) {
            None => Ok(()),
            Some(column) => Err(Error::bad_data("a column without a name beside named ones")
                .field(format!("column {}", column + 1))
                .found("no name")
                .expected("a name for each column, as in f,re,im")
                .help("name the column in the header line, or leave it out")),
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
        let at = column.min(cells.len().saturating_sub(1));
        let cell = cells.get(at).filter(|cell| at > 0 && !cell.is_empty())?;
        Some(cell)
    }

    /// True where no column has a name.
    pub(super) fn is_nameless(&self) -> bool {
        self.names.iter().all(String::is_empty)
    }
}

/// Header lines, rows and the number of columns: rows begin at the first clean row of
/// numbers, or above it where cells of the first rows are missing, as at 0 Hz.
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

/// The cells of a header line, cut as the numbers are and in every other way.
fn cuts(line: &str, dialect: Dialect) -> impl Iterator<Item = Vec<String>> + '_ {
    let by_dialect = dialect.and_others().map(move |dialect| {
        let cells = dialect.cells(line).into_iter();
        cells.map(|cell| cell.into_owned()).collect::<Vec<_>>()
    });
    // names with single blanks in them, aligned by several
    let by_gaps = || {
        line.split("  ")
            .map(str::trim)
            .filter(|name| !name.is_empty())
            .map(str::to_owned)
            .collect()
    };
    by_dialect
        .chain(std::iter::once_with(by_gaps))
        .chain(std::iter::once_with(|| outside_brackets(line)))
}

/// Cuts at blanks, but not inside brackets nor in front of them: `Frequency (Hz) Real`.
fn outside_brackets(line: &str) -> Vec<String> {
    let mut cells: Vec<String> = Vec::new();
    let mut depth = 0_usize;
    for word in line.split_whitespace() {
        match cells.last_mut() {
            Some(last) if depth > 0 || word.starts_with(['(', '[']) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => cells.push(word.to_owned()),
        }
        depth += word.matches(['(', '[']).count();
        depth = depth.saturating_sub(word.matches([')', ']']).count());
    }
    cells
}

/// Empty cells behind a filled one belong to it, but for the first column.
fn filled_forward(mut cells: Vec<String>) -> Vec<String> {
    for at in 2..cells.len() {
        if cells[at].is_empty() {
            cells[at] = cells[at - 1].clone();
        }
    }
    cells
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

/// The error of a table with `,` for the decimal sign and the delimiter.
pub(super) fn both_commas(error: Error) -> Error {
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
    filled: usize,
) -> Result<()> {
    let Some(last) = header.last().filter(|_| dialect.delimiter == Some(',')) else {
        return Ok(());
    };
    let names = dialect.cells(last.text).len();
    if names >= 2 && names < filled && filled <= 2 * names {
        return Err(both_commas(
            Error::bad_data("more columns than names; do the numbers have a decimal comma?")
                .at_line(first.number)
                .found(format!(
                    "{filled} columns under {names} names: {}",
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
