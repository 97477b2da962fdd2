//! Charts: rigs that are served over the number of measured fields.

use super::{RigError, RigRow, RigWay};
use crate::statistics::mean;
use chladni_report::{Axis, Chart, Colour, Figure, Height, Mark};

/// Width of a picture, px.
const WIDTH_PX: f64 = 640.0;
/// A rig counts as served from here on.
const SERVED: f64 = 0.99;

/// One figure with a chart for each kind of fault.
pub fn rig_figures(rows: &[RigRow]) -> Vec<Figure> {
    let kinds = RigError::ALL.into_iter().filter_map(|kind| {
        let own: Vec<&RigRow> = rows.iter().filter(|row| row.error == kind.name()).collect();
        (!own.is_empty()).then(|| chart(kind, &own))
    });
    let charts: Vec<Chart> = kinds.collect();
    if charts.is_empty() {
        return Vec::new();
    }
    vec![Figure {
        name: "rig".into(),
        title: "Drives corrected by measured fields".into(),
        caption: format!(
            "Share of rigs of which {} % of hot and of cold responses are served, over the \
             number of measured fields.",
            100.0 * SERVED
        ),
        width: WIDTH_PX,
        charts,
    }]
}

fn chart(kind: RigError, rows: &[&RigRow]) -> Chart {
    let fields = rows.iter().map(|row| row.fields).max().unwrap_or(0);
    let points = |way: RigWay| -> Vec<[f64; 2]> {
        (0..=fields)
            .map(|count| {
                let own = rows
                    .iter()
                    .filter(|row| row.way == way && row.fields == count)
                    .map(|row| f64::from(u8::from(row.min_ratio >= SERVED)));
                [count as f64, 100.0 * mean(own)]
            })
            .collect()
    };
    let label = format!("Measured fields ({})", kind.name());
    Chart::new(Axis::linear(&label, "–"), Axis::linear("Rigs served", "%"))
        .height(Height::Px(150.0))
        .marks(
            "corrected",
            points(RigWay::Correct),
            Mark::Ring,
            Colour::Ink,
            9.0,
        )
        .marks(
            "iterative learning",
            points(RigWay::Learning),
            Mark::Cross,
            Colour::Series(1),
            9.0,
        )
        .marks(
            "first drive",
            points(RigWay::Unchanged),
            Mark::Triangle,
            Colour::Series(0),
            8.0,
        )
}
