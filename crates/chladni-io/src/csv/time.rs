//! Tables of time records: `t [s], 101:+Z [N], 1:+Z [m/s]`, one column per channel.

use super::head::Head;
use super::table::Table;
use crate::unit_label;
use crate::{Abscissa, Axis, DatasetInfo, Document, FileFormat, Function, Ordinate};
use chladni_frf::{Direction, Dof, Error, Result};
use std::path::Path;

/// Names that a time axis goes by.
const TIME_NAMES: [&str; 4] = ["t", "time", "zeit", "temps"];

/// Factor of the first column to seconds, where its name or unit says that it is time.
pub(super) fn seconds(table: &Table) -> Option<f64> {
    let head = Head::parse(table.names.first()?, table.units.first()?);
    let named = TIME_NAMES.contains(&head.base.trim());
    match unit_label::parse(&head.unit) {
        Some(unit) => unit.to_seconds(),
        None => (named && head.unit.is_empty()).then_some(1.0),
    }
}

/// The channels as functions of type 1.
///
/// # Errors
/// A time axis that does not rise; masked samples; no channel beside the time.
pub(super) fn document(
    table: &Table,
    to_seconds: f64,
    mut warnings: Vec<String>,
    file: &Path,
) -> Result<Document> {
    let times = table.column(0);
    if let Some(k) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
        return Err(Error::bad_data("the time axis does not rise")
            .at_line(table.lines[k + 1])
            .field("time")
            .found(format!("{} after {}", times[k + 1], times[k]))
            .expected("strictly rising times"));
    }
    if table.columns < 2 {
        return Err(Error::bad_data("a time axis without a channel")
            .at_line(table.lines[0])
            .found("1 column")
            .expected("a column per channel"));
    }
    let mut document = Document::new(file, FileFormat::Csv);
    let mut numbered = 0;
    for column in 1..table.columns {
        let head = Head::parse(&table.names[column], &table.units[column]);
        let samples = table.column(column);
        if let Some(row) = samples.iter().position(|sample| sample.is_nan()) {
            return Err(Error::bad_data("a sample is missing")
                .at_line(table.lines[row])
                .field(&table.names[column])
                .found("an empty or masked cell")
                .expected("a number in every row of a time record"));
        }
        let response = head.dofs.map_or_else(
            || {
                numbered += 1;
                Dof::new(column as u64, Direction::SCALAR)
            },
            |(response, _)| response,
        );
        let unit = unit_label::parse(&head.unit);
        if unit.is_none() {
            warnings.push(format!(
                "column {}: no unit that is understood; values are taken as they are",
                column + 1
            ));
        }
        document.datasets.push(DatasetInfo {
            name: "table".into(),
            line: table.lines.first().copied(),
            function: Some("time".into()),
            response: Some(response.to_string()),
            values: Some(samples.len()),
            ..DatasetInfo::default()
        });
        let channel = Axis {
            label: table.names[column].clone(),
            unit: head.unit.clone(),
            ..Axis::default()
        };
        document.functions.push(Function {
            scale_to_si: unit.map_or(1.0, |unit| unit.factor),
            abscissa_to_si: to_seconds,
            ..Function::time_record(
                response,
                Abscissa::Uneven(times.clone()),
                channel,
                Ordinate::Real64(samples),
            )
        });
    }
    if numbered > 0 {
        warnings.push(format!(
            "{numbered} columns name no DOF; they are numbered by their place, as 2:S"
        ));
    }
    Ok(Document {
        warnings,
        ..document
    })
}
