//! Hot and cold ground over time, and the drive that moves it.

use crate::chart::{Axis, Chart, Figure, Height, Layer, Place};
use crate::drawing::{Colour, Dash, Stroke};
use crate::sizes::WIDE_PX;
use chladni_frf::ReferenceUnit;
use chladni_render::TimeTraces;

/// Levels below the limits that are shown, dB.
const SHOWN_BELOW_DB: f64 = -25.0;
/// Levels above them.
const SHOWN_ABOVE_DB: f64 = 10.0;

/// The weakest hot and the loudest cold response over their limits, and the largest
/// drive; `plain` are those of plain ramps, behind.
pub fn time(
    name: &str,
    title: &str,
    traces: &TimeTraces,
    plain: Option<&TimeTraces>,
    unit: ReferenceUnit,
) -> Figure {
    let range = [SHOWN_BELOW_DB, SHOWN_ABOVE_DB];
    let mut levels = Chart::new(
        Axis::linear("Time", "ms"),
        Axis::linear("Over its own limit", "dB").range(range),
    )
    .height(Height::Px(280.0));
    if let Some(plain) = plain {
        levels = with_lines(
            levels,
            &curves(plain, &plain.hot_db),
            "hot, plain ramps",
            0,
            1.0,
            Dash::Dotted,
        );
        levels = with_lines(
            levels,
            &curves(plain, &plain.cold_db),
            "cold, plain ramps",
            1,
            1.0,
            Dash::Dotted,
        );
    }
    levels = with_lines(
        levels,
        &curves(traces, &traces.hot_db),
        "weakest hot response",
        0,
        1.8,
        Dash::Solid,
    );
    levels = with_lines(
        levels,
        &curves(traces, &traces.cold_db),
        "loudest cold response",
        1,
        1.8,
        Dash::Solid,
    );
    levels = levels.with(Layer::Horizontals {
        name: Some("limit".into()),
        at: vec![0.0],
        stroke: Stroke::new(Colour::Muted, 1.2),
    });
    let scale = 1e3;
    let drive: Vec<Place> = traces
        .drive
        .iter()
        .enumerate()
        .map(|(k, value)| [1e3 * traces.step_s * k as f64, scale * value])
        .collect();
    let forces = Chart::new(
        Axis::linear("Time", "ms"),
        Axis::linear("Largest drive", &format!("m{unit}")),
    )
    .height(Height::Px(120.0))
    .line("", drive, Stroke::new(Colour::Series(2), 1.6));
    Figure {
        name: name.into(),
        title: title.into(),
        caption: "Hot ground is to stay above its limit, cold ground below, at every instant."
            .into(),
        width: WIDE_PX,
        charts: vec![levels, forces],
    }
}

/// Pieces of a trace without gaps; what lies far below is drawn at the lower end.
fn curves(traces: &TimeTraces, levels: &[Option<f64>]) -> Vec<Vec<Place>> {
    let mut pieces: Vec<Vec<Place>> = vec![Vec::new()];
    for (k, level) in levels.iter().enumerate() {
        match level {
            Some(level) => {
                let at = [1e3 * traces.step_s * k as f64, level.max(SHOWN_BELOW_DB)];
                if let Some(piece) = pieces.last_mut() {
                    piece.push(at);
                }
            }
            None if pieces.last().is_some_and(|piece| !piece.is_empty()) => pieces.push(Vec::new()),
            None => {}
        }
    }
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

fn with_lines(
    chart: Chart,
    lines: &[Vec<Place>],
    name: &str,
    series: u8,
    width: f64,
    dash: Dash,
) -> Chart {
    chart.with(Layer::Lines {
        name: Some(name.into()),
        lines: lines.to_vec(),
        stroke: Stroke::new(Colour::Series(series), width).dashed(dash),
    })
}
