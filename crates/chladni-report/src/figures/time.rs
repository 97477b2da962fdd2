//! Hot and cold ground over time, and the drive that moves it.

use crate::chart::{Axis, Chart, ColourBar, Figure, Height, Layer, Place};
use crate::drawing::{Colour, ColourMap, Dash, Image, Stroke};
use crate::sizes::{FIELD_RANGE_DB, WIDE_PX};
use chladni_frf::ReferenceUnit;
use chladni_render::{Ground, Played, TimeFrames, TimeTraces};
use ndarray::ArrayView1;

/// Lower end of the shown levels over the limits, dB.
const SHOWN_BELOW_DB: f64 = -25.0;
/// Upper end of the shown levels, dB.
const SHOWN_ABOVE_DB: f64 = 10.0;

/// Upper end of the drive axis over the largest drive.
const ROOM: f64 = 1.05;

/// The weakest hot and the loudest cold response over their limits, with those of plain ramps
/// for comparison; below them the drives, and every response over time.
pub fn time(name: &str, title: &str, played: &Played) -> Figure {
    let (traces, frames) = (&played.traces, played.frames.as_ref());
    let range = [SHOWN_BELOW_DB, SHOWN_ABOVE_DB];
    let traced_s = traces.step_s * traces.drive.len() as f64;
    let pictured_s = frames.map_or(0.0, |frames| {
        frames.step_s * frames.responses.nrows() as f64
    });
    let end_ms = 1e3 * traced_s.max(pictured_s);
    let mut levels = Chart::new(
        time_axis(end_ms),
        Axis::linear("Over its own limit", "dB").range(range),
    )
    .height(Height::Px(280.0));
    if let Some(plain) = &played.plain {
        let names = ["hot, plain ramps", "cold, plain ramps"];
        levels = with_levels(levels, plain, names, 0.8);
    }
    let names = ["weakest hot response", "loudest cold response"];
    levels = with_levels(levels, traces, names, 1.8);
    levels = levels.with(Layer::Horizontals {
        name: Some("limit".into()),
        at: vec![0.0],
        stroke: Stroke::new(Colour::Muted, 1.2),
    });
    let mut charts = vec![levels, forces(traces, frames, played.unit, end_ms)];
    charts.extend(frames.map(|frames| places(frames, end_ms)));
    Figure {
        name: name.into(),
        title: title.into(),
        caption: "Hot ground is to stay above its limit, cold ground below, at every instant."
            .into(),
        width: WIDE_PX,
        charts,
    }
}

/// The drive of every actuator; the largest drive alone where there are no pictures.
fn forces(
    traces: &TimeTraces,
    frames: Option<&TimeFrames>,
    unit: ReferenceUnit,
    end_ms: f64,
) -> Chart {
    let at = |step_s: f64, k: usize, value: f64| [1e3 * step_s * k as f64, 1e3 * value];
    let (label, lines, width): (&str, Vec<Vec<Place>>, f64) = match frames {
        Some(frames) => {
            let of = |column: ArrayView1<f64>| {
                let values = column.iter().enumerate();
                values
                    .map(|(k, &value)| at(frames.step_s, k, value))
                    .collect()
            };
            let lines = frames.drive.columns().into_iter().map(of).collect();
            ("Drives", lines, 0.7)
        }
        None => {
            let values = traces.drive.iter().enumerate();
            let line = values
                .map(|(k, &value)| at(traces.step_s, k, value))
                .collect();
            ("Largest drive", vec![line], 1.6)
        }
    };
    let most = lines.iter().flatten().map(|at| at[1]).fold(0.0, f64::max);
    let room = ROOM * most.max(f64::MIN_POSITIVE);
    Chart::new(
        time_axis(end_ms),
        Axis::linear(label, &format!("m{unit}")).range([0.0, room]),
    )
    .height(Height::Px(140.0))
    .with(Layer::Lines {
        name: None,
        lines,
        stroke: Stroke::new(Colour::Series(2), width),
    })
}

/// Number of the responses that are not judged at the beginning.
pub(crate) fn unjudged(frames: &TimeFrames) -> usize {
    let ground = frames.ground.iter();
    ground.filter(|&&ground| ground == Ground::Ignored).count()
}

/// Every response over time: hot ones above, cold ones below, and between two lines those that
/// are not judged.
fn places(frames: &TimeFrames, end_ms: f64) -> Chart {
    let (order, hot) = frames.by_ground();
    let (columns, rows) = (frames.responses.nrows(), order.len());
    let mut rgba = Vec::with_capacity(4 * columns * rows);
    for &response in &order {
        for &value in frames.responses.column(response) {
            let level = 20.0 * value.log10();
            let [r, g, b] = ColourMap::Sequential.at(0.5 + 0.5 * level / FIELD_RANGE_DB);
            rgba.extend([r, g, b, 255]);
        }
    }
    let last_ms = 1e3 * frames.step_s * columns as f64;
    let (label, borders) = match unjudged(frames) {
        0 => ("Responses, hot ones above", vec![rows - hot]),
        few => (
            "Responses: hot, not judged, cold",
            vec![rows - hot, rows - hot - few],
        ),
    };
    let mut chart = Chart::new(time_axis(end_ms), Axis::linear(label, "number"))
        .height(Height::Px(240.0))
        .with(Layer::Pixels {
            x: [0.0, last_ms],
            y: [0.0, rows as f64],
            image: Image {
                columns,
                rows,
                rgba,
            },
        })
        .with(Layer::Horizontals {
            name: None,
            at: borders.into_iter().map(|at| at as f64).collect(),
            stroke: Stroke::new(Colour::Rgb([255, 255, 255]), 1.4),
        });
    chart.colour_bar = Some(ColourBar {
        axis: Axis::linear("Velocity", "dB re threshold").range([-FIELD_RANGE_DB, FIELD_RANGE_DB]),
        map: ColourMap::Sequential,
        bands: 0,
        lines: Vec::new(),
    });
    chart
}

fn time_axis(end_ms: f64) -> Axis {
    Axis::linear("Time", "ms").range([0.0, end_ms])
}

/// A trace with gaps where nothing is judged; levels below the axis are drawn at its lower end.
fn curve(traces: &TimeTraces, levels: &[Option<f64>]) -> Vec<Place> {
    let shown = |level: Option<f64>| level.map_or(f64::NAN, |level| level.max(SHOWN_BELOW_DB));
    let places = levels.iter().enumerate();
    places
        .map(|(k, &level)| [1e3 * traces.step_s * k as f64, shown(level)])
        .collect()
}

/// The chart with the levels of hot and cold ground under one kind of ramps.
fn with_levels(chart: Chart, traces: &TimeTraces, names: [&str; 2], width: f64) -> Chart {
    let styles = [(1, Dash::Solid), (0, Dash::Dashed)];
    let levels = [&traces.hot_db, &traces.cold_db];
    let named = names.into_iter().zip(levels).zip(styles);
    named.fold(chart, |chart, ((name, levels), (series, dash))| {
        let stroke = Stroke::new(Colour::Series(series), width).dashed(dash);
        chart.line(name, curve(traces, levels), stroke)
    })
}
