//! How well weights do, as a table.

use crate::table::{significant, table};
use chladni_render::{Indices, Weights};

/// Indices at the responses and over the area between them.
pub fn indices_table(indices: &Indices) -> String {
    const HEADER: [&str; 8] = ["", "hot", "cold", "success", "silence", "contrast, dB", "margin, dB", "largest drive"];
    let ratio = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.3}"));
    let level = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.1}"));
    let points = &indices.points;
    let drive = match (points.max_force_n, points.max_voltage_v) {
        (Some(force), _) => format!("{} N", significant(force, 3)),
        (None, Some(voltage)) => format!("{} V", significant(voltage, 3)),
        (None, None) => String::new(),
    };
    let mut rows = vec![vec![
        "responses".into(),
        ratio(Some(points.hot_ratio)),
        ratio(Some(points.cold_ratio)),
        ratio(Some(points.success_ratio)),
        ratio(Some(points.silence_ratio)),
        level(points.contrast_db),
        level(points.margin_db),
        drive,
    ]];
    if let Some(area) = &indices.area {
        rows.push(
            ["area between".into(), ratio(area.hot_ratio), ratio(area.cold_ratio)].into_iter().chain(vec![String::new(); 5]).collect(),
        );
    }
    table(&HEADER, &rows)
}

/// The drive of each actuator.
pub fn weights_table(weights: &Weights) -> String {
    let amplitude = format!("amplitude, {}", weights.unit());
    let rows: Vec<Vec<String>> = weights
        .weights
        .iter()
        .map(|weight| vec![weight.reference.to_string(), significant(weight.amplitude, 4), format!("{:.1}", weight.phase_deg)])
        .collect();
    table(&["reference", &amplitude, "phase, deg"], &rows)
}
