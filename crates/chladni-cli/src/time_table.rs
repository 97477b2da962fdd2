//! Performance of a drive in time, as tables.

use chladni_console::table::table;
use chladni_render::{TimeIndices, TimeMeasure, TimeStressRow};

/// Every measure, at the responses and over the area between them.
pub fn time_table(indices: &TimeIndices) -> String {
    let header = [
        "measure",
        "cold, dB",
        "ever over",
        "hot, dB",
        "hot held",
        "hot from, ms",
        "quiet from, ms",
        "contrast, dB",
    ];
    let number = |value: Option<f64>, decimals: usize, factor: f64| {
        value.map_or_else(
            || "–".to_owned(),
            |value| format!("{:.decimals$}", factor * value),
        )
    };
    let row = |name: String, measure: &TimeMeasure| {
        vec![
            name,
            number(measure.worst_cold_db, 1, 1.0),
            format!("{:.3}", measure.ever_over_ratio),
            number(measure.worst_hot_db, 1, 1.0),
            format!("{:.3}", measure.hot_held_ratio),
            number(measure.hot_reached_s, 0, 1e3),
            number(measure.quiet_s, 0, 1e3),
            number(measure.contrast_db, 1, 1.0),
        ]
    };
    let mut rows = vec![
        row("peak, responses".into(), &indices.peak),
        row("summed, responses".into(), &indices.summed),
        row("rms, responses".into(), &indices.rms),
    ];
    if let Some(area) = &indices.area {
        rows.push(row("peak, area".into(), &area.peak));
        rows.push(row("summed, area".into(), &area.summed));
        rows.push(row("rms, area".into(), &area.rms));
    }
    table(&header, &rows)
}

/// Performance of a drive in time on panels that differ from the model.
pub fn stress_table(rows: &[TimeStressRow]) -> String {
    let header = [
        "stress",
        "cases",
        "cold, dB",
        "hot, dB",
        "ever over",
        "hot held",
    ];
    let row = |row: &TimeStressRow| {
        vec![
            row.trial.clone(),
            row.cases.to_string(),
            format!("{:.1}", row.worst_cold_db),
            format!("{:.1}", row.worst_hot_db),
            format!("{:.3}", row.ever_over_mean),
            format!("{:.3}", row.hot_held_mean),
        ]
    };
    table(&header, &rows.iter().map(row).collect::<Vec<_>>())
}
