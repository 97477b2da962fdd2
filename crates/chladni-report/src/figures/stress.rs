//! Stress table as a figure: share of responses served on panels that differ from the model.

use crate::chart::{Axis, Chart, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Anchor, Colour, Stroke};
use crate::sizes::WIDE_PX;
use chladni_render::Weights;

/// Height of a trial, px: its name is above its marks.
const ROW_PX: f64 = 40.0;
/// Height of the name above the marks, rows.
const ABOVE: f64 = 0.4;

/// Mean and worst share of each trial; `None` without a stress table.
pub(crate) fn stress(weights: &Weights, number: usize) -> Option<Figure> {
    let rows = weights.stress.as_ref().filter(|rows| !rows.is_empty())?;
    let count = rows.len() as f64;
    let at = |k: usize| count - k as f64;
    let points = |of: &dyn Fn(usize) -> f64| -> Vec<Place> {
        (0..rows.len()).map(|k| [100.0 * of(k), at(k)]).collect()
    };
    let bars = rows.iter().enumerate().map(|(k, row)| {
        vec![
            [100.0 * row.success_worst_5_percent, at(k)],
            [100.0 * row.success_mean, at(k)],
        ]
    });
    let bars = Layer::Lines {
        name: None,
        lines: bars.collect(),
        stroke: Stroke::new(Colour::Series(0), 2.0),
    };
    let names = (0..rows.len())
        .map(|k| (at(k), (k + 1).to_string()))
        .collect();
    let y = Axis::linear("Trial", "number")
        .range([0.5, count + 0.8])
        .names(names);
    let mut chart = Chart::new(Axis::linear("Responses served", "%").range([0.0, 103.0]), y)
        .height(Height::Px(ROW_PX * count + 20.0))
        .with(bars);
    chart = chart.marks(
        "mean",
        points(&|k| rows[k].success_mean),
        Mark::Dot,
        Colour::Series(0),
        7.0,
    );
    chart = chart.marks(
        "what 95 % of the cases reach",
        points(&|k| rows[k].success_worst_5_percent),
        Mark::Ring,
        Colour::Series(1),
        7.0,
    );
    for (k, row) in rows.iter().enumerate() {
        chart = chart.with(Layer::Words {
            at: [2.0, at(k) + ABOVE],
            text: row.trial.clone(),
            anchor: Anchor::Start,
            bold: false,
        });
    }
    Some(Figure {
        name: format!("stress-{number}"),
        title: format!("Scene {number} on a panel that is not the model"),
        caption: String::new(),
        width: WIDE_PX,
        charts: vec![chart],
    })
}
