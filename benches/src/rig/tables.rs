//! The table: a row for each rig, way and number of measured fields.

use super::RigRow;
use crate::csv;

const HEADER: [&str; 10] = [
    "panel",
    "seed",
    "error",
    "fields",
    "min_ratio",
    "way",
    "time_s",
    "scene",
    "predicted",
    "nis",
];

/// A row for each rig, way and number of measured fields, as CSV.
pub fn rig_csv(rows: &[RigRow]) -> String {
    let comment = "min_ratio: smaller share of hot and cold responses served on the true rig; \
                   scene: columns x rows of cells, hot cell, Hz";
    let cells = rows.iter().map(|row| {
        vec![
            row.panel.clone(),
            row.seed.to_string(),
            row.error.clone(),
            row.fields.to_string(),
            csv::number(row.min_ratio),
            row.way.name().into(),
            csv::number(row.time_s),
            row.scene.clone(),
            csv::number(row.predicted),
            csv::number(row.nis),
        ]
    });
    csv::table(comment, &HEADER, cells)
}
