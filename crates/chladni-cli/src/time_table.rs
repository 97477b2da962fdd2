//! How ground does in time, for people.

use chladni_console::table::table;
use chladni_render::{TimeIndices, TimeMeasure};

/// One sentence, by the measure at each instant.
pub fn sentence(indices: &TimeIndices) -> String {
    let peak = &indices.peak;
    let hot = match peak.hot_reached_s {
        Some(reached_s) => format!("hot after {:.0} ms", 1e3 * reached_s),
        None => "hot ground never has its limit everywhere".into(),
    };
    let cold = match (peak.worst_cold_db, peak.ever_over_ratio > 0.0) {
        (None, _) => "cold never moves".into(),
        (Some(level), false) => format!("cold never over ({level:+.1} dB)"),
        (Some(level), true) => format!(
            "cold over by up to {level:.1} dB for {:.0} ms",
            1e3 * peak.over_s
        ),
    };
    let end = indices
        .events
        .iter()
        .map(|event| event.end_s - event.start_s);
    let drive_s = end.fold(0.0, f64::max);
    let quiet = match peak.quiet_s {
        Some(quiet_s) if quiet_s <= drive_s => {
            format!(
                "quiet {:.0} ms before the drive ends",
                1e3 * (drive_s - quiet_s)
            )
        }
        Some(quiet_s) => format!(
            "quiet {:.0} ms after the drive ends",
            1e3 * (quiet_s - drive_s)
        ),
        None => "not quiet before the next event".into(),
    };
    format!("{hot}, {cold}, {quiet}")
}

/// All measures.
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
