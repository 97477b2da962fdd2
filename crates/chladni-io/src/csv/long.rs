//! Long tables: one row per FRF and line, `node,dir,ref_node,ref_dir,f,re,im`.

use super::text::{Cell, Dialect, Line};
use super::Trace;
use chladni_frf::{Direction, Dof, Error, Result};
use num_complex::Complex64;
use std::borrow::Cow;
use std::collections::HashMap;

/// A grid of FRFs and lines this many times larger than the rows, and above
/// [`SPARSE_CELLS`], is refused.
const SPARSE_FACTOR: usize = 16;
/// See [`SPARSE_FACTOR`].
const SPARSE_CELLS: usize = 1 << 22;
/// Two frequencies closer than this part of their spacing are one line.
const SAME_LINE: f64 = 1e-3;

/// Where each column stands.
struct Columns {
    response: DofColumns,
    reference: DofColumns,
    f: usize,
    f_to_hz: f64,
    re: usize,
    im: usize,
    coherence: Option<usize>,
    names: Vec<String>,
    dialect: Dialect,
}

/// A DOF in one column (`12:+Z`) or two (node, direction).
enum DofColumns {
    Text(usize),
    NodeAndDirection(usize, usize),
}

/// The header line and its columns, where the file is a long table.
pub(super) struct LongTable<'a> {
    columns: Columns,
    rows: &'a [Line<'a>],
}

/// Finds the header of a long table.
pub(super) fn find<'a>(lines: &'a [Line<'a>]) -> Option<LongTable<'a>> {
    const HEADER_LINES: usize = 100;
    lines
        .iter()
        .take(HEADER_LINES)
        .enumerate()
        .find_map(|(at, line)| {
            let any = Dialect {
                delimiter: Some('\t'),
                decimal_comma: false,
            };
            let mut columns = any
                .and_others()
                .find_map(|dialect| header(&dialect.cells(line.text), dialect))?;
            let rows = &lines[at + 1..];
            if columns.dialect.delimiter != Some(',') {
                let numbers = [columns.f, columns.re, columns.im];
                let has_comma = |row: &Line<'_>| {
                    let cells = columns.dialect.cells(row.text);
                    numbers
                        .iter()
                        .any(|&column| cells.get(column).is_some_and(|cell| cell.contains(',')))
                };
                columns.dialect.decimal_comma = rows.iter().take(HEADER_LINES).any(has_comma);
            }
            Some(LongTable { columns, rows })
        })
}

fn header(cells: &[Cow<'_, str>], dialect: Dialect) -> Option<Columns> {
    let names: Vec<String> = cells
        .iter()
        .map(|cell| cell.trim().to_lowercase().replace([' ', '-'], "_"))
        .collect();
    let find = |known: &[&str]| names.iter().position(|name| known.contains(&name.as_str()));
    let dof = |one: &[&str], node: &[&str], direction: &[&str]| match (
        find(one),
        find(node),
        find(direction),
    ) {
        (_, Some(node), Some(direction)) => Some(DofColumns::NodeAndDirection(node, direction)),
        (Some(one), None, _) => Some(DofColumns::Text(one)),
        _ => None,
    };
    Some(Columns {
        response: dof(
            &["response", "response_dof"],
            &["node", "response_node", "rsp_node"],
            &["dir", "direction", "response_dir", "rsp_dir"],
        )?,
        reference: dof(
            &["reference", "reference_dof"],
            &["ref_node", "reference_node"],
            &[
                "ref_dir",
                "reference_dir",
                "ref_direction",
                "reference_direction",
            ],
        )?,
        f: find(&[
            "f",
            "freq",
            "frequency",
            "f_hz",
            "freq_hz",
            "frequency_hz",
            "f_khz",
            "freq_khz",
            "frequency_khz",
        ])?,
        f_to_hz: if names.iter().any(|name| name.ends_with("_khz")) {
            1e3
        } else {
            1.0
        },
        re: find(&["re", "real"])?,
        im: find(&["im", "imag"])?,
        coherence: find(&["coherence", "coh"]),
        names,
        dialect,
    })
}

/// Rows of one (response, reference) pair.
struct Pair {
    response: Dof,
    reference: Dof,
    rows: Vec<(u64, f64, Complex64, f64)>,
}

impl LongTable<'_> {
    /// First row, for messages.
    pub(super) fn first_line(&self) -> u64 {
        self.rows.first().map_or(0, |row| row.number)
    }

    /// Frequencies in Hz and one trace per pair, NaN where a pair has no row.
    pub(super) fn traces(
        &self,
        lenient: bool,
        warnings: &mut Vec<String>,
    ) -> Result<(Vec<f64>, Vec<Trace>)> {
        let pairs = self.pairs(lenient, warnings)?;
        let Some(longest) = pairs.iter().max_by_key(|pair| {
            (
                pair.rows.len(),
                std::cmp::Reverse(pair.rows.first().map(|row| row.0)),
            )
        }) else {
            return Err(Error::bad_data("a header, but no rows")
                .found("no row")
                .expected("rows of numbers under node,dir,ref_node,ref_dir,f,re,im"));
        };
        let axis: Vec<f64> = longest.rows.iter().map(|row| row.1).collect();
        let cells = pairs.len().saturating_mul(axis.len());
        let rows: usize = pairs.iter().map(|pair| pair.rows.len()).sum();
        if cells > SPARSE_CELLS && cells / SPARSE_FACTOR > rows {
            return Err(
                Error::bad_data("almost all (pair, frequency) rows are missing").found(format!(
                    "{rows} rows for {} pairs on {} lines",
                    pairs.len(),
                    axis.len()
                )),
            );
        }
        let mut absent = 0;
        let mut traces = Vec::with_capacity(pairs.len());
        for pair in &pairs {
            traces.push(self.on_axis(pair, &axis, &mut absent)?);
        }
        if absent > 0 {
            warnings.push(format!(
                "{absent} rows (pair and frequency) are missing; these lines are masked"
            ));
        }
        Ok((axis, traces))
    }

    fn pairs(&self, lenient: bool, warnings: &mut Vec<String>) -> Result<Vec<Pair>> {
        let mut pairs: Vec<Pair> = Vec::new();
        let mut index: HashMap<(Dof, Dof), usize> = HashMap::new();
        let mut masked: Option<(u64, usize)> = None;
        for row in self.rows {
            let cells = self.columns.dialect.cells(row.text);
            if cells.len() < self.columns.names.len() {
                return Err(Error::bad_data("a row of another length")
                    .at_line(row.number)
                    .found(format!("{} columns", cells.len()))
                    .expected(format!("{}, as in the header", self.columns.names.len())));
            }
            let response = self.dof(row, &cells, &self.columns.response)?;
            let reference = self.dof(row, &cells, &self.columns.reference)?;
            let f = self
                .number(row, &cells, self.columns.f)?
                .ok_or_else(|| self.no_number(row, &cells, self.columns.f))?;
            let f = f * self.columns.f_to_hz;
            let re = self.masked_number(row, &cells, self.columns.re, lenient)?;
            let im = self.masked_number(row, &cells, self.columns.im, lenient)?;
            let value = if re.is_nan() || im.is_nan() {
                Complex64::new(f64::NAN, f64::NAN)
            } else {
                Complex64::new(re, im)
            };
            if value.re.is_nan() {
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
                let what = if f == before.1 {
                    "a frequency stands twice for one pair"
                } else {
                    "the frequency axis falls"
                };
                return Err(Error::bad_data(what)
                    .at_line(row.number)
                    .field(&self.columns.names[self.columns.f])
                    .found(format!(
                        "{f} after {} in line {} for ({response}, {reference})",
                        before.1, before.0
                    ))
                    .expected("strictly rising frequencies of each pair"));
            }
            pairs[at].rows.push((row.number, f, value, coherence));
        }
        if let Some((line, count)) = masked {
            warnings.push(format!(
                "{count} rows hold no finite value; masked (first in line {line})"
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

    /// A number, NaN for an empty cell; for anything else too, when `lenient`.
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
        Error::bad_data("not a finite number")
            .at_line(row.number)
            .field(&self.columns.names[column])
            .found(if cells[column].is_empty() {
                "an empty cell"
            } else {
                &cells[column]
            })
            .expected("a number")
            .help("correct the cell, or read the file with --lenient, which masks it")
    }

    /// The pair on the common axis: its rows must lie on it, and may leave lines out.
    fn on_axis(&self, pair: &Pair, axis: &[f64], absent: &mut usize) -> Result<Trace> {
        let mut values = vec![Complex64::new(f64::NAN, f64::NAN); axis.len()];
        let mut coherence = vec![f64::NAN; axis.len()];
        let mut at = 0;
        for &(line, f, value, gamma) in &pair.rows {
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
            values[at] = value;
            coherence[at] = gamma;
            at += 1;
        }
        *absent += axis.len() - pair.rows.len();
        Ok(Trace {
            response: Some(pair.response),
            reference: Some(pair.reference),
            values,
            coherence: self.columns.coherence.map(|_| coherence),
            unit: None,
            unit_text: String::new(),
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

/// A node number; `12.0` is 12 (pandas writes integers with gaps like that).
fn whole(text: &str) -> Option<u64> {
    text.parse()
        .ok()
        .or_else(|| text.strip_suffix(".0")?.parse().ok())
}
