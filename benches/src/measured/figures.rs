//! Charts: bias of damping and coverage of its bars over the lines per bandwidth.

use super::cell::SNR_DB;
use super::{MeasuredSummary, MeasuredWay};
use chladni_report::{Axis, Chart, Colour, Figure, Height, Mark};

/// Width of a picture, px.
const WIDTH_PX: f64 = 640.0;

/// One figure with a chart for each way to measure, cells of a force that neither drops nor
/// is noisy, at the usual noise.
pub fn measured_figures(summaries: &[MeasuredSummary]) -> Vec<Figure> {
    let kind = |row: &MeasuredSummary| {
        let name = row.cell.name();
        name.split(" b=").next().unwrap_or_default().to_owned()
    };
    let plain: Vec<&MeasuredSummary> = summaries
        .iter()
        .filter(|row| row.cell.drop_db == 0.0 && row.cell.force_snr_db.is_infinite())
        .filter(|row| row.cell.snr_db == SNR_DB)
        .collect();
    let mut kinds: Vec<String> = plain.iter().map(|row| kind(row)).collect();
    kinds.dedup();
    kinds.sort();
    kinds.dedup();
    let mut charts = Vec::new();
    for name in &kinds {
        let own: Vec<&MeasuredSummary> = plain
            .iter()
            .copied()
            .filter(|row| kind(row) == *name)
            .collect();
        charts.push(chart(name, "Bias of loss factors", &own, |row| {
            100.0 * row.loss_bias
        }));
        charts.push(chart(name, "Loss factors in 95 % intervals", &own, |row| {
            100.0 * row.coverage[1]
        }));
    }
    if charts.is_empty() {
        return Vec::new();
    }
    vec![Figure {
        name: "measured".into(),
        title: "Damping of tests simulated in time".into(),
        caption: "Mean relative error of loss factors, and how many lie in their 95 % intervals, \
                  over the lines per half-power bandwidth."
            .into(),
        width: WIDTH_PX,
        charts,
    }]
}

fn chart(
    name: &str,
    what: &str,
    rows: &[&MeasuredSummary],
    value: impl Fn(&MeasuredSummary) -> f64,
) -> Chart {
    let points = |way: MeasuredWay| -> Vec<[f64; 2]> {
        rows.iter()
            .filter(|row| row.way == way)
            .map(|row| [row.cell.lines_per_bandwidth, value(row)])
            .collect()
    };
    let label = format!("Lines per bandwidth ({name})");
    let marks = [
        (MeasuredWay::Told, Mark::Ring, Colour::Ink),
        (MeasuredWay::Plain, Mark::Cross, Colour::Series(1)),
        (MeasuredWay::Lrm, Mark::Triangle, Colour::Series(0)),
    ];
    let empty = Chart::new(Axis::linear(&label, "–"), Axis::linear(what, "%"));
    marks
        .into_iter()
        .filter(|(way, ..)| !points(*way).is_empty())
        .fold(
            empty.height(Height::Px(130.0)),
            |chart, (way, mark, colour)| chart.marks(way.name(), points(way), mark, colour, 9.0),
        )
}
