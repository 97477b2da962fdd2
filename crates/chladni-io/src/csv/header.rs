//! The header of a table: its lines of names and of units, and how they are cut.

use super::column_header::{looks_like_unit, without_brackets, ColumnHeader};
use super::frequency::factor_to_hz;
use super::table::Table;
use super::text::{both_commas, Dialect, Line};
use super::time;
use super::vocabulary::{known_words, part_of, role_of, words, Part};
use crate::limits::ROWS_TRIED;
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

impl Table {
    /// Reads names, units and keywords. `filled` columns are not empty in the first row.
    pub(super) fn read_header(
        &mut self,
        header: &[Line<'_>],
        dialect: Dialect,
        filled: usize,
        has_rate: bool,
    ) -> Result<()> {
        let between_blanks = dialect.delimiter.is_none();
        let mut candidates: Vec<Vec<String>> = Vec::new();
        for line in header.iter().filter(|line| !dialect.is_row(line.text)) {
            let mut keyword = None;
            let mut fitting = None;
            for (cut, mut cells) in cuts(line.text, dialect).enumerate() {
                let first = cells.first().map(|cell| cell.trim_end_matches(':'));
                let key = first.unwrap_or_default().to_lowercase();
                if KEYWORDS.contains(&key.as_str()) {
                    keyword = Some((key, cells));
                    break;
                }
                while cells.len() > filled && cells.last().is_some_and(String::is_empty) {
                    cells.pop();
                }
                if cells.len() != self.columns && cells.len() != filled {
                    continue;
                }
                // a remark below the names, such as `Time zone, local, CET`
                if time::is_first(&cells) && candidates.iter().any(|cells| names_frequency(cells)) {
                    break;
                }
                // prose may have as many words as there are columns
                let cut_as_numbers = cut == 0 || between_blanks;
                let is_header = line.text.contains([',', ';'])
                    || known_words(line.text) > 0
                    || cells.iter().all(|cell| looks_like_unit(cell))
                    || (cut_as_numbers && time::is_header(&cells, between_blanks))
                    || (cut == 0 && time::is_unit_row(&cells))
                    || cells
                        .iter()
                        .any(|cell| !ColumnHeader::parse(cell, "").dofs.is_empty());
                if is_header && words(line.text).next().is_some() {
                    cells.resize(self.columns, String::new());
                    fitting = Some(cells);
                    break;
                }
            }
            match (keyword, fitting) {
                (Some((key, cells)), _) => self.keywords.push((key, filled_forward(cells))),
                (None, Some(cells)) => candidates.push(cells),
                (None, None) => {
                    refuse_units_that_do_not_fit(line, self.columns)?;
                    self.prose.push_str(line.text);
                    self.prose.push('\n');
                }
            }
        }
        let Some(names) = self.take_units(&mut candidates) else {
            if !has_rate {
                self.refuse_time_that_does_not_fit(header, dialect)?;
            }
            return self.refuse_header_that_does_not_fit(header);
        };
        self.names = names;
        self.add_rows_above(&candidates);
        Ok(())
    }

    /// Adds DOFs or parts from rows above the names, with the word for response or reference
    /// at the beginning of such a row.
    fn add_rows_above(&mut self, candidates: &[Vec<String>]) {
        let mut all_above = vec![String::new(); self.columns];
        for above in candidates.iter().rev() {
            let speaks = |cell: &String| {
                let head = ColumnHeader::parse(cell, "");
                !head.dofs.is_empty() || words(cell).any(|word| part_of(word).is_some())
            };
            if !above[1..].iter().any(speaks) {
                break;
            }
            let role = words(&above[0]).find(|word| role_of(word).is_some());
            let cells = filled_forward(above.clone());
            let with_role = |cell: &String| match role.filter(|_| !cell.is_empty()) {
                Some(role) => format!("{role} {cell}"),
                None => cell.clone(),
            };
            let texts: Vec<String> = cells.iter().map(with_role).collect();
            // a row may be written twice
            let mut known = all_above.iter().zip(&texts).skip(1);
            if known.all(|(known, text)| holds(known, text)) {
                continue;
            }
            for (column, text) in texts.iter().enumerate().skip(1) {
                if !holds(&self.names[column], &cells[column]) {
                    all_above[column] = format!("{text} {}", all_above[column]);
                }
            }
        }
        for (name, above) in self.names.iter_mut().zip(&all_above).skip(1) {
            if !name.is_empty() {
                *name = format!("{above}{name}").trim().to_owned();
            }
        }
    }

    /// Takes the row of units out of the rows above the data. Returns the names, which are the
    /// last of the others.
    fn take_units(&mut self, candidates: &mut Vec<Vec<String>>) -> Option<Vec<String>> {
        let is_unit_row = |cells: &Vec<String>| {
            let all = is_all_units(cells);
            let names_parts = cells
                .iter()
                .flat_map(|cell| words(cell))
                .any(|word| matches!(part_of(word), Some(part) if part != Part::Magnitude));
            let first = without_brackets(&cells[0]);
            cells.iter().any(|cell| !cell.is_empty())
                && (all || (frequency_unit(&first).is_some() && !names_parts))
        };
        let at = candidates.iter().rposition(is_unit_row);
        // a row that can only be units, or one that stands beside names
        if let Some(at) = at.filter(|at| at + 2 >= candidates.len()) {
            let all = is_all_units(&candidates[at]);
            if all || candidates.len() > 1 {
                self.units = candidates.remove(at);
            }
        }
        if candidates.is_empty() && self.units.iter().any(|unit| !unit.is_empty()) {
            return Some(vec![String::new(); self.columns]);
        }
        candidates.pop()
    }

    /// Refuses a header of a time record whose number of names is not that of the columns: its
    /// times would pass for frequencies.
    fn refuse_time_that_does_not_fit(&self, header: &[Line<'_>], dialect: Dialect) -> Result<()> {
        let last = header.last().filter(|_| self.keywords.is_empty());
        let Some(line) = last.filter(|line| time::is_named_first(line.text, dialect)) else {
            return Ok(());
        };
        Err(
            Error::bad_data("the header begins with a time and does not fit the columns")
                .at_line(line.number)
                .found(line.text.trim())
                .expected(format!("{} names, one for each column", self.columns))
                .help(
                    "write the names between the delimiters of the numbers, as \
                     t [s],101:+Z [N],1:+Z [m/s] for a time record",
                ),
        )
    }

    /// Refuses a header whose number of names is not that of the columns.
    fn refuse_header_that_does_not_fit(&self, header: &[Line<'_>]) -> Result<()> {
        let Some(line) = header
            .iter()
            .rev()
            .find(|line| self.keywords.is_empty() && known_words(line.text) > 1)
        else {
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

    /// Refuses whole numbers between commas without names: they may be the halves of numbers
    /// with a decimal comma.
    pub(super) fn refuse_whole_numbers(&self, rows: &[&Line<'_>], dialect: Dialect) -> Result<()> {
        let whole = |row: &&Line<'_>| !row.text.contains(['.', 'e', 'E']);
        if !self.is_nameless()
            || !self.keywords.is_empty()
            || dialect.delimiter != Some(',')
            || !rows.iter().take(ROWS_TRIED).all(whole)
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

    /// Refuses a column of numbers that the header does not name.
    pub(super) fn refuse_nameless_column(&self) -> Result<()> {
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
}

/// True for names of a frequency and of what stands beside it: `f,re,im`.
fn names_frequency(cells: &[String]) -> bool {
    factor_to_hz(&cells[0], "").is_some() && cells[1..].iter().any(|cell| known_words(cell) > 0)
}

/// True for a row that can only be units, of FRFs or of a time record.
fn is_all_units(cells: &[String]) -> bool {
    cells.iter().all(|cell| looks_like_unit(cell)) || time::is_unit_row(cells)
}

/// True where a name contains the text as a whole: `101:+Z` does not contain `1:+Z`.
fn holds(name: &str, text: &str) -> bool {
    let ends = |c: Option<char>| !c.is_some_and(char::is_alphanumeric);
    text.is_empty()
        || name.match_indices(text).any(|(at, _)| {
            ends(name[..at].chars().next_back()) && ends(name[at + text.len()..].chars().next())
        })
}

/// The cells of a header line, cut as the numbers are, then in every other way.
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

/// Cuts at blanks, but neither inside brackets nor before them: `Frequency (Hz) Real`.
pub(super) fn outside_brackets(line: &str) -> Vec<String> {
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

/// Copies each filled cell into the empty ones after it, except from the first column.
fn filled_forward(mut cells: Vec<String>) -> Vec<String> {
    for at in 2..cells.len() {
        if cells[at].is_empty() {
            cells[at] = cells[at - 1].clone();
        }
    }
    cells
}

/// Refuses a row of units whose number is not that of the columns, such as one between blanks
/// that leaves a unit out.
fn refuse_units_that_do_not_fit(line: &Line<'_>, columns: usize) -> Result<()> {
    let labels: Vec<&str> = line
        .text
        .split(|c: char| c.is_whitespace() || ",;".contains(c))
        .filter(|label| !label.is_empty())
        .collect();
    let begins_with_frequency = labels
        .first()
        .is_some_and(|label| frequency_unit(&without_brackets(label)).is_some());
    if labels.len() < 2
        || !begins_with_frequency
        || !labels.iter().all(|label| looks_like_unit(label))
    {
        return Ok(());
    }
    Err(Error::bad_data("the row of units does not fit the columns")
        .at_line(line.number)
        .found(line.text.trim())
        .expected(format!("{columns} units, one for each column"))
        .help("write `-` where a column has no unit, or put the units into the names"))
}
