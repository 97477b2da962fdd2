//! Tables of `chladni bench` as figures: error over time, a mark for each method and case.

use crate::chart::{Axis, Chart, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Anchor, Colour};
use crate::input::Table;
use crate::sizes::WIDE_PX;

/// Columns of time and error, as `chladni bench accuracy` writes them.
const COLUMNS: [&str; 2] = ["time_s", "frequency_rmse_over_crlb"];

/// Error over time; `None` where the table lacks these columns, or numbers in them.
pub(crate) fn speed(table: &Table, number: usize) -> Option<Figure> {
    let column = |name: &str| table.header.iter().position(|header| header == name);
    let [time, error] = [column(COLUMNS[0])?, column(COLUMNS[1])?];
    let [case, method] = [column("case")?, column("method")?];
    let mut cases: Vec<&str> = table
        .rows
        .iter()
        .filter_map(|row| row.get(case).map(String::as_str))
        .collect();
    cases.dedup();
    let mut chart = Chart::new(
        Axis::log("Time of a fit", "s").padded(0.1),
        Axis::log("Rms frequency error over the bound", "–").padded(0.1),
    );
    chart = chart.height(Height::Px(380.0));
    let mut any = false;
    for (k, name) in cases.iter().enumerate() {
        let rows = table
            .rows
            .iter()
            .filter(|row| row.get(case).is_some_and(|cell| cell == name));
        let place =
            |row: &Vec<String>| Some([row.get(time)?.parse().ok()?, row.get(error)?.parse().ok()?]);
        let shown: Vec<(Place, &str)> = rows
            .filter_map(|row| Some((place(row)?, row.get(method)?.as_str())))
            .collect();
        let shown: Vec<_> = shown
            .into_iter()
            .filter(|(at, _)| at.iter().all(|v| *v > 0.0))
            .collect();
        any |= !shown.is_empty();
        for (at, method) in &shown {
            chart = chart.with(Layer::Words {
                at: [at[0] * 1.05, at[1]],
                text: (*method).to_owned(),
                anchor: Anchor::Start,
                bold: false,
            });
        }
        let points = shown.into_iter().map(|(at, _)| at).collect();
        chart = chart.marks(
            name,
            points,
            Mark::of_series(k),
            Colour::Series(k as u8),
            7.0,
        );
    }
    any.then(|| Figure {
        name: format!("speed-{number}"),
        title: format!("Speed against accuracy ({})", table.name),
        caption: "Lower left is better. An error of 1 is what the noise allows.".into(),
        width: WIDE_PX,
        charts: vec![chart],
    })
}
