//! Long tables: one row per FRF and line, `node,dir,ref_node,ref_dir,f,re,im`.

use super::factors::refuse_factor;
use super::facts::is_same_unit;
use super::form::{Column, Form};
use super::frequency::factor_to_hz;
use super::long_header::{DofColumns, LongTable};
use super::table::not_finite;
use super::text::{both_commas, Cell, Line};
use super::vocabulary::Part;
use super::{TableFacts, Trace};
use crate::limits::{LONG_SPARSE_FACTOR, SAME_LINE, SPARSE_CELLS};
use chladni_frf::{counted, Direction, Dof, Error, Finding, Result};
use num_complex::Complex64;
use std::borrow::Cow;
use std::collections::HashMap;

/// Rows of one (response, reference) pair.
struct Pair {
    response: Dof,
    reference: Dof,
    rows: Vec<Row>,
}

/// Line, frequency in the unit of the file, the two numbers of a value, coherence.
type Row = (u64, f64, [f64; 2], f64);

impl LongTable<'_> {
    /// First row, for messages.
    pub(super) fn first_line(&self) -> u64 {
        self.rows.first().map_or(0, |row| row.number)
    }

    /// All text above the header.
    pub(super) fn text_above(&self) -> String {
        let lines: Vec<&str> = self.above.iter().map(|line| line.text).collect();
        lines.join("\n")
    }

    /// Frequencies in Hz and one trace per pair, NaN where a pair has no row.
    pub(super) fn traces(
        &self,
        facts: &TableFacts,
        lenient: bool,
        warnings: &mut Vec<Finding>,
    ) -> Result<(Vec<f64>, Vec<Trace>)> {
        if let Some((count, line)) = self.commented {
            warnings.push(Finding::caution(
                "rows-left-out",
                format!("{count} rows of numbers are comments: left out (first in line {line})"),
            ));
        }
        self.refuse_doubled_columns()?;
        warnings.extend(self.columns.unused());
        let f_to_hz = self.frequency_factor(facts)?;
        let pairs = self.pairs(lenient, warnings)?;
        let form = self.form(&pairs, facts, warnings)?;
        let Some(longest) = pairs.iter().max_by_key(|pair| {
            (
                pair.rows.len(),
                std::cmp::Reverse(pair.rows.first().map(|row| row.0)),
            )
        }) else {
            return Err(Error::bad_data("a header, but no rows")
                .found("no row")
                .expected("rows of numbers under node,dir,ref_node,ref_dir,f,re,im")
                .help("export the table again, with its rows"));
        };
        let axis: Vec<f64> = longest.rows.iter().map(|row| row.1).collect();
        let cells = pairs.len().saturating_mul(axis.len());
        let rows: usize = pairs.iter().map(|pair| pair.rows.len()).sum();
        if cells > SPARSE_CELLS && cells / LONG_SPARSE_FACTOR > rows {
            return Err(
                Error::bad_data("almost all (pair, frequency) rows are missing")
                    .found(format!(
                        "{rows} rows for {} pairs on {} lines",
                        pairs.len(),
                        axis.len()
                    ))
                    .expected("a row for each pair and frequency")
                    .help("put FRFs of other pairs or axes into files of their own"),
            );
        }
        let mut absent = 0;
        let mut traces = Vec::with_capacity(pairs.len());
        for pair in &pairs {
            traces.push(self.on_axis(pair, &axis, &form, &mut absent)?);
        }
        if absent > 0 {
            warnings.push(Finding::caution(
                "lines-masked",
                format!(
                    "masked, since missing: {} (pair and frequency)",
                    counted(absent, "row")
                ),
            ));
        }
        Ok((axis.into_iter().map(|f| f * f_to_hz).collect(), traces))
    }

    /// The unit in a column of units, which must be the same in all rows that have one.
    ///
    /// # Errors
    /// A row with another unit.
    pub(super) fn unit(&self) -> Result<Option<String>> {
        let Some(column) = self.columns.unit else {
            return Ok(None);
        };
        let mut unit: Option<(String, u64)> = None;
        for row in &self.rows {
            let cells = self.columns.dialect.cells(row.text);
            let is_whole = self.check_length(row, &cells).is_ok(); // else refused by its length
            let label = cells
                .get(column)
                .filter(|label| is_whole && !label.is_empty());
            let Some(label) = label else {
                continue;
            };
            match &unit {
                None => unit = Some((label.to_string(), row.number)),
                Some((known, line)) if !is_same_unit(known, label) => {
                    return Err(Error::bad_data("units that differ from row to row")
                        .at_line(row.number)
                        .field(&self.columns.names[column])
                        .found(format!("`{label}` after `{known}` in line {line}"))
                        .expected("one unit in all rows")
                        .help("write all values in one unit, or split the file"));
                }
                Some(_) => {}
            }
        }
        Ok(unit.map(|(label, _)| label))
    }

    /// Refuses two columns of the same meaning.
    fn refuse_doubled_columns(&self) -> Result<()> {
        for (column, head) in self.columns.heads.iter().enumerate() {
            let before = &self.columns.heads[..column];
            let doubled =
                head.part != Part::Unknown && before.iter().any(|other| other.part == head.part);
            if doubled {
                return Err(Error::bad_data("a second column of the same kind")
                    .field(format!("column {}", column + 1))
                    .found(&self.columns.names[column])
                    .expected("one FRF in the columns of a long table")
                    .help("leave the column out, or rename it"));
            }
        }
        Ok(())
    }

    fn frequency_factor(&self, facts: &TableFacts) -> Result<f64> {
        let name = &self.columns.names[self.columns.f];
        let own = factor_to_hz(name, "").ok_or_else(|| {
            Error::bad_data("the unit of the frequency is not understood")
                .field(format!("column {}", self.columns.f + 1))
                .found(name)
                .expected("Hz, kHz, MHz, rad/s or rpm")
                .help("name the column as in `f [Hz]`")
        })?;
        facts.frequency_factor(own, name)
    }

    /// The form of the values in the two numbers of each row.
    fn form(
        &self,
        pairs: &[Pair],
        facts: &TableFacts,
        warnings: &mut Vec<Finding>,
    ) -> Result<Form> {
        let values = |at: usize| -> Vec<f64> {
            let rows = pairs.iter().flat_map(|pair| &pair.rows);
            rows.map(|row| row.2[at]).collect()
        };
        for column in [self.columns.first, self.columns.second] {
            let head = &self.columns.heads[column];
            refuse_factor(column, &self.columns.names, &[], head, facts)?;
        }
        let (a, b) = (values(0), values(1));
        let column = |number: usize, values| Column {
            number,
            name: &self.columns.names[number],
            head: &self.columns.heads[number],
            values,
        };
        let first = column(self.columns.first, &a[..]);
        let second = column(self.columns.second, &b[..]);
        if self.columns.is_polar {
            Form::polar(&first, &second, facts, warnings)
        } else {
            Form::rectangular(&first, &second)
        }
    }

    /// Refuses a row whose number of cells is not that of the names in the header; empty cells
    /// at the end do not count.
    fn check_length(&self, row: &Line<'_>, cells: &[Cow<'_, str>]) -> Result<()> {
        let names = self.columns.names.len();
        let surplus = cells.get(names..).unwrap_or_default();
        if cells.len() >= names && surplus.iter().all(|cell| cell.is_empty()) {
            return Ok(());
        }
        let error = Error::bad_data("a row of another length")
            .at_line(row.number)
            .found(format!("{} columns: {}", cells.len(), row.text.trim()));
        let commas = self.columns.dialect.delimiter == Some(',') && cells.len() > names;
        Err(if commas && !row.text.contains('.') {
            both_commas(error)
        } else {
            error
                .expected(format!("{names}, as in the header"))
                .help("correct the row, or leave it out")
        })
    }

    fn pairs(&self, lenient: bool, warnings: &mut Vec<Finding>) -> Result<Vec<Pair>> {
        let mut pairs: Vec<Pair> = Vec::new();
        let mut index: HashMap<(Dof, Dof), usize> = HashMap::new();
        let mut masked: Option<(u64, usize)> = None;
        for &row in &self.rows {
            let cells = self.columns.dialect.cells(row.text);
            self.check_length(row, &cells)?;
            let response = self.dof(row, &cells, &self.columns.response)?;
            let reference = self.dof(row, &cells, &self.columns.reference)?;
            let f = self
                .number(row, &cells, self.columns.f)?
                .ok_or_else(|| self.no_number(row, &cells, self.columns.f))?;
            let a = self.masked_number(row, &cells, self.columns.first, lenient)?;
            let b = self.masked_number(row, &cells, self.columns.second, lenient)?;
            if a.is_nan() || b.is_nan() {
                masked.get_or_insert((row.number, 0)).1 += 1;
            }
            let coherence = match self.columns.coherence {
                Some(column) => self.masked_number(row, &cells, column, lenient)?,
                None => f64::NAN,
            };
            let at = *index.entry((response, reference)).or_insert_with(|| {
                pairs.push(Pair {
                    response,
                    reference,
                    rows: Vec::new(),
                });
                pairs.len() - 1
            });
            if let Some(before) = pairs[at].rows.last().filter(|before| f <= before.1) {
                let (what, help) = if f == before.1 {
                    (
                        "a frequency occurs twice for one pair",
                        "leave one of the two rows out, or correct its DOFs",
                    )
                } else {
                    (
                        "the frequency axis falls",
                        "sort the rows of each pair by their frequency, and leave doubled ones out",
                    )
                };
                return Err(Error::bad_data(what)
                    .at_line(row.number)
                    .field(&self.columns.names[self.columns.f])
                    .found(format!(
                        "{f} after {} in line {} for ({response}, {reference})",
                        before.1, before.0
                    ))
                    .expected("strictly rising frequencies of each pair")
                    .help(help));
            }
            pairs[at].rows.push((row.number, f, [a, b], coherence));
        }
        if let Some((line, count)) = masked {
            warnings.push(Finding::caution(
                "lines-masked",
                format!("{count} rows hold no finite value; masked (first in line {line})"),
            ));
        }
        Ok(pairs)
    }

    fn dof(&self, row: &Line<'_>, cells: &[Cow<'_, str>], columns: &DofColumns) -> Result<Dof> {
        let wrong =
            |column: usize, expected: &str| {
                Error::bad_data("not a degree of freedom")
                .at_line(row.number)
                .field(&self.columns.names[column])
                .found(&cells[column])
                .expected(expected)
                .help("write DOFs like 12:+Z, or node and direction code (±1 X, ±2 Y, ±3 Z, ±4 to \
                       ±6 rotations) in columns of their own")
            };
        match *columns {
            DofColumns::Text(column) => cells[column]
                .parse()
                .map_err(|_| wrong(column, "a DOF like 12:+Z")),
            DofColumns::NodeAndDirection(node, direction) => {
                let node = whole(&cells[node]).ok_or_else(|| wrong(node, "a node number"))?;
                let code = cells[direction]
                    .parse::<i64>()
                    .ok()
                    .and_then(Direction::from_code);
                let direction = code.or_else(|| {
                    cells[direction]
                        .parse()
                        .ok()
                        .filter(|_| !cells[direction].is_empty())
                });
                let direction = direction.ok_or_else(|| {
                    let DofColumns::NodeAndDirection(_, column) = *columns else {
                        return wrong(0, "");
                    };
                    wrong(column, "a code from -6 to 6, or a direction like +Z")
                })?;
                Ok(Dof::new(node, direction))
            }
        }
    }

    /// A number, `None` for an empty cell or NaN.
    fn number(&self, row: &Line<'_>, cells: &[Cow<'_, str>], column: usize) -> Result<Option<f64>> {
        match self.columns.dialect.number(&cells[column]) {
            Cell::Value(value) => Ok(Some(value)),
            Cell::Empty => Ok(None),
            Cell::Overflow | Cell::Text => Err(self.no_number(row, cells, column)),
        }
    }

    /// A number, or NaN for an empty cell; with `lenient`, NaN for any other cell.
    fn masked_number(
        &self,
        row: &Line<'_>,
        cells: &[Cow<'_, str>],
        column: usize,
        lenient: bool,
    ) -> Result<f64> {
        match self.number(row, cells, column) {
            Ok(value) => Ok(value.unwrap_or(f64::NAN)),
            Err(_) if lenient => Ok(f64::NAN),
            Err(error) => Err(error),
        }
    }

    fn no_number(&self, row: &Line<'_>, cells: &[Cow<'_, str>], column: usize) -> Error {
        let name = self.columns.names[column].clone();
        not_finite(row.number, name, &cells[column], column == self.columns.f)
    }

    /// The pair on the common axis. Its rows must lie on the axis; lines without a row are NaN.
    fn on_axis(&self, pair: &Pair, axis: &[f64], form: &Form, absent: &mut usize) -> Result<Trace> {
        let mut values = vec![Complex64::new(f64::NAN, f64::NAN); axis.len()];
        let mut coherence = vec![f64::NAN; axis.len()];
        let mut at = 0;
        for &(line, f, [a, b], gamma) in &pair.rows {
            while at < axis.len() && axis[at] < f && !is_same_line(axis, at, f) {
                at += 1;
            }
            if at == axis.len() || !is_same_line(axis, at, f) {
                return Err(Error::bad_data(
                    "a frequency that is not on the axis of the other FRFs",
                )
                .at_line(line)
                .field(&self.columns.names[self.columns.f])
                .found(format!("{f} for ({}, {})", pair.response, pair.reference))
                .expected("one frequency axis for all FRFs of a table")
                .help("put FRFs with other axes into files of their own"));
            }
            if !(a.is_nan() || b.is_nan()) {
                values[at] = form.value(a, b);
            }
            coherence[at] = gamma;
            at += 1;
        }
        *absent += axis.len() - pair.rows.len();
        Ok(Trace {
            response: Some(pair.response),
            reference: Some(pair.reference),
            values,
            coherence: self.columns.coherence.map(|_| coherence),
            unit: form.unit,
            unit_text: form.unit_text.clone(),
        })
    }
}

fn is_same_line(axis: &[f64], at: usize, f: f64) -> bool {
    if axis[at] == f {
        return true;
    }
    let spacing = match (at.checked_sub(1), axis.get(at + 1)) {
        (_, Some(next)) => next - axis[at],
        (Some(before), None) => axis[at] - axis[before],
        (None, None) => 0.0,
    };
    (axis[at] - f).abs() <= SAME_LINE * spacing
}

/// A node number; `12.0` is 12, as pandas writes integers of a column with gaps.
fn whole(text: &str) -> Option<u64> {
    text.parse()
        .ok()
        .or_else(|| text.strip_suffix(".0")?.parse().ok())
}
