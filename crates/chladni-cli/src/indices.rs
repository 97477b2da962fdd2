//! Performance of weights, as tables.

use crate::limits::BEST_SHOWN;
use chladni_console::table::{significant, table};
use chladni_render::{FrequencySweep, Indices, Method, StressRow, SweptFrequency, Weights};
use serde_json::Value;

/// Indices at the responses and over the area between them.
pub fn indices_table(indices: &Indices) -> String {
    const HEADER: [&str; 8] = [
        "",
        "hot",
        "cold",
        "success",
        "silence",
        "contrast, dB",
        "margin, dB",
        "largest drive",
    ];
    let ratio =
        |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.3}"));
    let level =
        |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.1}"));
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
            [
                "area between".into(),
                ratio(area.hot_ratio),
                ratio(area.cold_ratio),
            ]
            .into_iter()
            .chain(vec![String::new(); 5])
            .collect(),
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
        .map(|weight| {
            vec![
                weight.reference.to_string(),
                significant(weight.amplitude, 4),
                format!("{:.1}", weight.phase_deg),
            ]
        })
        .collect();
    table(&["reference", &amplitude, "phase, deg"], &rows)
}

/// Performance of the weights on panels that differ from the model.
pub fn stress_table(rows: &[StressRow]) -> String {
    let cells = rows.iter().map(|row| {
        let shares = [
            row.success_mean,
            row.success_worst_5_percent,
            row.min_worst_5_percent,
        ]
        .map(|share| format!("{share:.3}"));
        [row.trial.clone(), row.cases.to_string()]
            .into_iter()
            .chain(shares)
            .collect()
    });
    let header = [
        "stress",
        "cases",
        "success, mean",
        "worst 5 %",
        "smaller of hot and cold, worst 5 %",
    ];
    format!("\n{}", table(&header, &cells.collect::<Vec<_>>()))
}

/// The best frequencies of a sweep and the suggested one, in rising order. The best serves the most responses under a
/// finger, then the most without one, then has the largest κ.
fn best_of(sweep: &FrequencySweep) -> Vec<&SweptFrequency> {
    let rank = |f: &SweptFrequency| {
        let touched = f.touched_ratio.unwrap_or(f.success_ratio);
        [touched, f.success_ratio, f.kappa.unwrap_or(f64::INFINITY)]
    };
    let mut best: Vec<&SweptFrequency> = sweep.frequencies.iter().collect();
    best.sort_by(|a, b| {
        let pairs = rank(b).into_iter().zip(rank(a));
        pairs.fold(std::cmp::Ordering::Equal, |order, (b, a)| {
            order.then(b.total_cmp(&a))
        })
    });
    // the suggestion is the best by a rule of its own: it is shown whatever its rank
    best.sort_by_key(|f| Some(f.frequency_hz) != sweep.suggested_hz);
    best.truncate(BEST_SHOWN);
    best.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    best
}

/// The scene at other frequencies (the best, or all), and the suggested frequency.
pub fn sweep_table(sweep: &FrequencySweep, weights: &Weights, all: bool) -> String {
    let asked = weights.options.get("method").and_then(Value::as_str);
    let method = match asked {
        None | Some("default") => Method::Mls.as_str(),
        Some(asked) => asked,
    };
    let drive = format!("largest drive, {}", weights.unit());
    let shown = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "unknown".into(), |value| format!("{value:.decimals$}"))
    };
    let row = |f: &SweptFrequency| {
        vec![
            significant(f.frequency_hz, 6),
            shown(f.kappa, 1),
            format!("{:.3}", f.success_ratio),
            match f.touched_kappa {
                Some(kappa) => format!("κ {kappa:.1}"),
                None => shown(f.touched_ratio, 3),
            },
            significant(f.largest_drive, 3),
            f.on_mode_hz
                .map_or_else(String::new, |hz| format!("on the mode at {hz:.1} Hz")),
        ]
    };
    let shown_rows = match all {
        true => sweep.frequencies.iter().collect(),
        false => best_of(sweep),
    };
    let left = sweep.frequencies.len() - shown_rows.len();
    let rows: Vec<Vec<String>> = shown_rows.into_iter().map(row).collect();
    let more = match left {
        0 => String::new(),
        _ => format!("the best of {}: -v lists all; ", sweep.frequencies.len()),
    };
    let suggestion = match sweep.suggestion() {
        Some(f) if f.is_met() => format!("suggested: {} Hz\n", significant(f.frequency_hz, 6)),
        Some(f) => format!(
            "no frequency serves every response; {} Hz comes nearest\n",
            significant(f.frequency_hz, 6)
        ),
        None if sweep.outside_band => "no frequency of the sweep lies in the fitted band\n".into(),
        None => "no frequency in the fitted band serves any response\n".into(),
    };
    format!(
        "\n{}by method {method}; kappa: standard deviations of the model's error tolerated, 1 \
         needed\n{more}{suggestion}",
        table(
            &["frequency, Hz", "kappa", "success", "touched", &drive, ""],
            &rows
        )
    )
}
