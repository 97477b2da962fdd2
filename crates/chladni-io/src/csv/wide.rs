//! Tables with a frequency column and a pair of columns per FRF: one FRF per file, wide,
//! named pairs.

use super::column_header::ColumnHeader;
use super::dofs::{dof_pair, Dofs};
use super::factors::refuse_factor;
use super::form::{Column, Form};
use super::frequency::factor_to_hz;
use super::groups::{group_columns, Group};
use super::table::Table;
use super::vocabulary::{is_frequency, words};
use super::{TableFacts, Trace};
use crate::unit_label::frequency_unit;
use chladni_frf::{Error, Finding, Result};

/// Frequencies in Hz and one trace per pair of columns.
pub(super) fn traces(
    table: &Table,
    facts: &TableFacts,
    warnings: &mut Vec<Finding>,
) -> Result<(Vec<f64>, Vec<Trace>)> {
    let heads = ColumnHeader::of_columns(&table.names, &table.units);
    let frequency_hz = frequency_axis(table, facts)?;
    for (column, head) in heads.iter().enumerate().skip(1) {
        refuse_factor(column, &table.names, &table.units, head, facts)?;
    }
    let mut traces: Vec<Trace> = Vec::new();
    for group in group_columns(table, &heads, warnings)? {
        traces.push(trace(table, &heads, &group, facts, warnings)?);
    }
    Ok((frequency_hz, traces))
}

fn frequency_axis(table: &Table, facts: &TableFacts) -> Result<Vec<f64>> {
    let raw = table.column(0);
    let factor = frequency_factor(table, facts)?;
    if table.names[0].is_empty() && !table.is_nameless() {
        refuse_row_numbers(table, &raw)?;
    }
    for (k, pair) in raw.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let what = if pair[1] == pair[0] {
                "a frequency occurs twice"
            } else {
                "the frequency axis falls"
            };
            return Err(Error::bad_data(what)
                .at_line(table.lines[k + 1])
                .field("frequency")
                .found(format!("{} after {}", pair[1], pair[0]))
                .expected("strictly rising frequencies")
                .help(
                    "sort the rows, remove doubled ones; for several FRFs in one list use the \
                     columns node,dir,ref_node,ref_dir,f,re,im",
                ));
        }
    }
    Ok(raw.into_iter().map(|f| f * factor).collect())
}

/// Factor of the first column to Hz.
fn frequency_factor(table: &Table, facts: &TableFacts) -> Result<f64> {
    let factor = match table.keyword("x axis units", 1) {
        Some(unit) => frequency_unit(unit),
        None => factor_to_hz(&table.names[0], &table.units[0]),
    };
    let label = format!("{} {}", table.names[0], table.units[0]);
    if factor.is_none() {
        refuse_own_axes(table)?;
    }
    let factor = factor.ok_or_else(|| {
        Error::bad_data("the first column is no frequency axis, or its unit is not said")
            .field("column 1")
            .found(label.trim())
            .expected("a frequency in Hz, kHz, MHz, rad/s or rpm, with the unit in the header")
            .help(
                "name the first column as in `f [Hz]` or `omega [rad/s]`; time records without a \
                 time column need `sample_rate HZ` of the estimation",
            )
    })?;
    facts.frequency_factor(factor, label.trim())
}

/// Refuses names such as `f1,re1,im1,f2,re2,im2`, where each FRF has its own frequencies.
fn refuse_own_axes(table: &Table) -> Result<()> {
    let is_numbered = |name: &String| {
        let lower = name.to_lowercase();
        let word = words(&lower).next().unwrap_or_default();
        is_frequency(word.trim_end_matches(|c: char| c.is_ascii_digit()))
    };
    let mut columns = (0..table.columns).filter(|&column| is_numbered(&table.names[column]));
    match (columns.next(), columns.next()) {
        (Some(0), Some(second)) => Err(Error::bad_data("a second frequency column")
            .field(format!("column {}", second + 1))
            .found(&table.names[second])
            .expected("one frequency axis for all FRFs of a table, in the first column")
            .help("keep the first one as `f [Hz]`, or put FRFs with other axes into files of their own")),
        _ => Ok(()),
    }
}

/// Refuses a first column without a name that holds row numbers, as other programs write.
fn refuse_row_numbers(table: &Table, raw: &[f64]) -> Result<()> {
    let counts = raw.len() > 1
        && (raw.iter().enumerate()).all(|(row, value)| *value - raw[0] == row as f64)
        && (raw[0] == 0.0 || raw[0] == 1.0);
    let elsewhere = table.names[1..].iter().any(|name| {
        words(name)
            .next()
            .is_some_and(|word| is_frequency(&word.to_lowercase()))
    });
    if !counts && !elsewhere {
        return Ok(());
    }
    Err(
        Error::bad_data("the first column has no name and may count the rows")
            .field("column 1")
            .found("no name")
            .expected("the frequency in the first column")
            .help("leave the column out, or name it in the header as in `f [Hz]`"),
    )
}

fn trace(
    table: &Table,
    heads: &[ColumnHeader],
    group: &Group,
    facts: &TableFacts,
    warnings: &mut Vec<Finding>,
) -> Result<Trace> {
    let (a, b) = (table.column(group.first), table.column(group.second));
    let mut head = heads[group.first].clone();
    if let Some(unit) = table.keyword("y axis units", group.first) {
        if head.unit.is_empty() {
            head.unit = unit.to_owned();
        }
    }
    let first = Column {
        number: group.first,
        name: &table.names[group.first],
        head: &head,
        values: &a,
    };
    let second = Column {
        number: group.second,
        name: &table.names[group.second],
        head: &heads[group.second],
        values: &b,
    };
    let form = if group.polar {
        Form::polar(&first, &second, facts, warnings)?
    } else {
        Form::rectangular(&first, &second)?
    };
    let dofs = dofs_of_pair(&first, &second)?;
    let keyword = table.keyword("y axis dofs", group.first);
    let keyword = keyword.and_then(|text| dof_pair(first_word(text)));
    let (response, reference) = match keyword.filter(|_| dofs.is_empty()) {
        Some((response, reference)) => (Some(response), reference),
        None => (dofs.response, dofs.reference),
    };
    Ok(Trace {
        response,
        reference,
        values: (a.iter().zip(&b))
            .map(|(&a, &b)| form.value(a, b))
            .collect(),
        coherence: group.coherence.map(|column| table.column(column)),
        unit: form.unit,
        unit_text: form.unit_text,
    })
}

/// The DOFs in the names of two columns.
///
/// # Errors
/// Different DOFs; words that do not tell response from reference.
fn dofs_of_pair(first: &Column<'_>, second: &Column<'_>) -> Result<Dofs> {
    for column in [first, second] {
        if column.head.dofs.is_unclear {
            return Err(
                Error::bad_data("a name does not tell which DOF is the response")
                    .field(format!("column {}", column.number + 1))
                    .found(column.name)
                    .expected("`Rsp 1Z Ref 101Z`, or the response first: `1Z/101Z`")
                    .help("correct the header: one word in front of each DOF, or none"),
            );
        }
    }
    let (one, other) = (first.head.dofs, second.head.dofs);
    if !one.is_empty() && !other.is_empty() && one != other {
        return Err(
            Error::bad_data("two columns of one FRF name different DOFs")
                .field(format!("column {}", second.number + 1))
                .found(second.name)
                .expected(format!("the DOFs of `{}`", first.name))
                .help("correct the header"),
        );
    }
    Ok(if one.is_empty() { other } else { one })
}

/// `1Z:3Z [2]` without its set number.
fn first_word(text: &str) -> &str {
    text.split_whitespace().next().unwrap_or("")
}
