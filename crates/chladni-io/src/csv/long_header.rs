//! The header of a long table: the meaning of its columns.

use super::column_header::ColumnHeader;
use super::frequency::factor_to_hz;
use super::header::outside_brackets;
use super::remarks::key_of;
use super::text::{Cell, Dialect, Line};
use super::time;
use super::vocabulary::{is_beside_dof, is_frequency, words, Part, ANGULAR};
use crate::limits::{HEADER_LINES, LONG_COLUMNS_LEAST};
use chladni_frf::{Error, Finding};
use std::borrow::Cow;

/// The columns of a long table, by their meaning; numbers of columns count from 0.
pub(super) struct Columns {
    pub(super) response: DofColumns,
    pub(super) reference: DofColumns,
    pub(super) f: usize,
    /// Real part or magnitude.
    pub(super) first: usize,
    /// Imaginary part or phase.
    pub(super) second: usize,
    pub(super) is_polar: bool,
    pub(super) coherence: Option<usize>,
    /// The unit of the FRFs, in each row.
    pub(super) unit: Option<usize>,
    pub(super) names: Vec<String>,
    pub(super) heads: Vec<ColumnHeader>,
    pub(super) dialect: Dialect,
}

/// A DOF in one column (`12:+Z`) or two (node, direction).
pub(super) enum DofColumns {
    Text(usize),
    NodeAndDirection(usize, usize),
}

/// The header line and its columns, where the file is a long table.
pub(super) struct LongTable<'a> {
    pub(super) columns: Columns,
    pub(super) above: &'a [Line<'a>],
    pub(super) rows: Vec<&'a Line<'a>>,
    /// Number of rows that are comments, and the line of the first.
    pub(super) commented: Option<(usize, u64)>,
}

/// Finds the header of a long table.
pub(super) fn find<'a>(lines: &'a [Line<'a>]) -> Option<LongTable<'a>> {
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
                .find_map(|dialect| header(&names_of(line.text, dialect), dialect))?;
            let (comments, rows): (Vec<_>, Vec<_>) =
                lines[at + 1..].iter().partition(|line| line.is_comment);
            if columns.dialect.delimiter != Some(',') {
                let numbers = [columns.f, columns.first, columns.second];
                let has_comma = |row: &&Line<'_>| {
                    let cells = columns.dialect.cells(row.text);
                    numbers
                        .iter()
                        .any(|&column| cells.get(column).is_some_and(|cell| cell.contains(',')))
                };
                columns.dialect.decimal_comma = rows.iter().take(HEADER_LINES).any(has_comma);
            }
            let dialect = columns.dialect;
            let mut commented = comments.iter().filter(|line| {
                let cells = dialect.cells(line.text);
                cells.len() == columns.names.len()
                    && matches!(dialect.number(&cells[columns.f]), Cell::Value(_))
            });
            let first = commented.next().map(|line| line.number);
            Some(LongTable {
                above: &lines[..at],
                commented: first.map(|line| (1 + commented.count(), line)),
                columns,
                rows,
            })
        })
}

/// The error about a header of a long table that lacks a column of a DOF: the frequency is not
/// in the first column, both parts of a value are there, and some name belongs to a DOF. The
/// line below has as many cells, and a number for the frequency: the header is no remark.
pub(super) fn incomplete(lines: &[Line<'_>]) -> Option<Error> {
    let any = Dialect {
        delimiter: Some('\t'),
        decimal_comma: false,
    };
    let begins_as_number = |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    let mut pairs = lines.windows(2).take(HEADER_LINES);
    pairs.find_map(|pair| {
        let names = any.and_others().find_map(|dialect| {
            let names = names_of(pair[0].text, dialect);
            let row = dialect.cells(pair[1].text);
            let is_right_above = row.len() == names.len()
                && frequency_column(&names).is_some_and(|f| begins_as_number(&row[f]));
            (is_right_above && is_incomplete(&names)).then_some(names)
        })?;
        let error = incomplete_error(&names).at_line(pair[0].number);
        Some(error.found(pair[0].text.trim()))
    })
}

fn is_incomplete(cells: &[String]) -> bool {
    // a wide header is one long cell in other dialects
    if cells.len() < LONG_COLUMNS_LEAST || frequency_column(cells).is_none_or(|column| column == 0)
    {
        return false;
    }
    let has_first = !cells[0].trim().is_empty() && !time::is_header(cells, false);
    let heads = heads_of(cells);
    // `Ref 101:+Z Re` is a column of a wide table
    let is_of_dof = |(name, head): (&String, &ColumnHeader)| {
        let lower = name.to_lowercase();
        let first = lower.split('_').flat_map(words).next();
        let is_named = first.is_some_and(is_beside_dof) || is_dof_name(&column_name(name));
        is_named && head.part == Part::Unknown && head.dofs.is_empty()
    };
    has_first && parts(&heads).is_some() && cells.iter().zip(&heads).any(is_of_dof)
}

/// The error of a header without all columns of its DOFs, which names those that are missing and
/// those that are not understood.
fn incomplete_error(cells: &[String]) -> Error {
    let names: Vec<String> = cells.iter().map(|cell| column_name(cell)).collect();
    let has = |known: &[&str]| names.iter().any(|name| known.contains(&name.as_str()));
    let missing = |dof: &DofNames| match (has(dof.dof), has(dof.node), has(dof.direction)) {
        (_, true, true) | (true, false, _) => None,
        (_, true, false) => Some(dof.direction[0]),
        (_, false, true) => Some(dof.node[0]),
        (false, false, false) => Some(dof.dof[0]),
    };
    // without backticks, in which `reference` is an option
    let missing: Vec<&str> = [&RESPONSE, &REFERENCE]
        .into_iter()
        .filter_map(missing)
        .collect();
    let frequency = frequency_column(cells);
    let heads = heads_of(cells);
    let is_unknown = |column: usize| {
        let is_meant = heads[column].part != Part::Unknown || Some(column) == frequency;
        !is_meant && !is_dof_name(&names[column]) && key_of(&names[column]) != "unit"
    };
    let unknown: Vec<String> = (0..cells.len())
        .filter(|&column| is_unknown(column))
        .map(|column| format!("`{}`", cells[column].trim()))
        .collect();
    let columns = match missing.as_slice() {
        [_] => "column",
        _ => "columns",
    };
    let mut message = format!(
        "a long table without the {columns} {}",
        missing.join(" and ")
    );
    if !unknown.is_empty() {
        message += &format!("; not understood: {}", unknown.join(", "));
    }
    let mut help = "name the columns so; DOFs are written as 12:+Z, or as node and direction code \
                    (±1 X, ±2 Y, ±3 Z) in columns of their own"
        .to_owned();
    if frequency == Some(1) {
        help += &format!(
            "; or leave the column `{}` out, where it only counts the rows",
            cells[0].trim()
        );
    }
    Error::bad_data(message)
        .expected("response,reference,f,re,im or node,dir,ref_node,ref_dir,f,re,im")
        .help(help)
}

/// True for a name of a column of DOFs, nodes or directions.
fn is_dof_name(name: &str) -> bool {
    [&RESPONSE, &REFERENCE]
        .iter()
        .flat_map(|dof| [dof.dof, dof.node, dof.direction])
        .any(|known| known.contains(&name))
}

/// A name as the lists of known names have it.
fn column_name(cell: &str) -> String {
    cell.trim().to_lowercase().replace([' ', '-'], "_")
}

fn heads_of(cells: &[String]) -> Vec<ColumnHeader> {
    let heads = cells.iter().map(|cell| ColumnHeader::parse(cell, ""));
    heads.collect()
}

/// The two columns of a value, and whether they are magnitude and phase.
fn parts(heads: &[ColumnHeader]) -> Option<(usize, usize, bool)> {
    let part = |part: Part| heads.iter().position(|head| head.part == part);
    match (part(Part::Re), part(Part::Im)) {
        (Some(re), Some(im)) => Some((re, im, false)),
        _ => Some((part(Part::Magnitude)?, part(Part::Phase)?, true)),
    }
}

/// The names of a header line; blanks before a unit in brackets do not cut.
fn names_of(line: &str, dialect: Dialect) -> Vec<String> {
    match dialect.delimiter {
        None => outside_brackets(line),
        Some(_) => {
            let cells = dialect.cells(line).into_iter();
            cells.map(Cow::into_owned).collect()
        }
    }
}

/// Names of the columns of a DOF: one column, or node and direction.
struct DofNames {
    dof: &'static [&'static str],
    node: &'static [&'static str],
    direction: &'static [&'static str],
}

const RESPONSE: DofNames = DofNames {
    dof: &[
        "response",
        "response_dof",
        "resp",
        "rsp",
        "rsp_dof",
        "output",
        "output_dof",
    ],
    node: &["node", "response_node", "rsp_node"],
    direction: &["dir", "direction", "response_dir", "rsp_dir"],
};
const REFERENCE: DofNames = DofNames {
    dof: &[
        "reference",
        "reference_dof",
        "ref",
        "ref_dof",
        "excitation",
        "exc",
        "input",
        "input_dof",
    ],
    node: &["ref_node", "reference_node"],
    direction: &[
        "ref_dir",
        "reference_dir",
        "ref_direction",
        "reference_direction",
    ],
};

fn header(cells: &[String], dialect: Dialect) -> Option<Columns> {
    let names: Vec<String> = cells.iter().map(|cell| column_name(cell)).collect();
    let find = |known: &[&str]| names.iter().position(|name| known.contains(&name.as_str()));
    let dof = |names: &DofNames| match (find(names.dof), find(names.node), find(names.direction)) {
        (_, Some(node), Some(direction)) => Some(DofColumns::NodeAndDirection(node, direction)),
        (Some(one), None, _) => Some(DofColumns::Text(one)),
        _ => None,
    };
    let response = dof(&RESPONSE)?;
    let reference = dof(&REFERENCE)?;
    let heads = heads_of(cells);
    let (first, second, is_polar) = parts(&heads)?;
    Some(Columns {
        response,
        reference,
        f: frequency_column(cells)?,
        first,
        second,
        is_polar,
        coherence: (heads.iter()).position(|head| head.part == Part::Coherence),
        unit: names.iter().position(|name| key_of(name) == "unit"),
        names: cells.iter().map(|cell| cell.trim().to_owned()).collect(),
        heads,
        dialect,
    })
}

/// The column of the frequency: one whose name and unit are understood, else one whose unit is
/// not, so that the error names it, else `x` without a unit, which may be a position.
fn frequency_column(cells: &[String]) -> Option<usize> {
    let rank = |name: &String| {
        let lower = name.to_lowercase();
        let first = lower.split('_').flat_map(words).next()?;
        let is_unit = first.ends_with("hz");
        if !(is_frequency(first) || is_unit || ANGULAR.contains(&first)) {
            return None;
        }
        let (has_factor, is_x) = (factor_to_hz(name, "").is_some(), words(&lower).eq(["x"]));
        Some(match (has_factor, is_x) {
            (true, false) => 0,
            (false, false) if first != "x" => 1,
            _ => 2,
        })
    };
    let ranked = cells.iter().enumerate();
    let ranked = ranked.filter_map(|(column, name)| Some((rank(name)?, column)));
    ranked.min().map(|(_, column)| column)
}

impl Columns {
    /// A note about columns that are not needed, such as positions.
    pub(super) fn unused(&self) -> Option<Finding> {
        let mut used = vec![self.f, self.first, self.second];
        used.extend(self.coherence);
        used.extend(self.unit);
        for dof in [&self.response, &self.reference] {
            match *dof {
                DofColumns::Text(one) => used.push(one),
                DofColumns::NodeAndDirection(node, direction) => used.extend([node, direction]),
            }
        }
        let others = self.names.iter().enumerate();
        let others = others.filter(|(column, name)| !used.contains(column) && !name.is_empty());
        let names: Vec<String> = others.map(|(_, name)| format!("`{name}`")).collect();
        (!names.is_empty()).then(|| {
            let words = format!("columns that are not used: {}", names.join(", "));
            Finding::note("not-read", words)
        })
    }
}
