//! Charts: which properties of a draw make fits fail, and whether bars hold.

use super::tables::PROPERTIES;
use super::{Draw, WildRow};
use crate::statistics::quantile;
use chladni_report::{Axis, Chart, Colour, Figure, Height, Mark};

/// Width of a picture, px.
const WIDTH_PX: f64 = 640.0;
/// Parts of equal count that the values of a property are cut into.
const PARTS: usize = 5;
/// Properties whose charts are drawn, with their labels and units.
const SHOWN: [(&str, &str, &str); 8] = [
    ("overlap", "Modal overlap", "–"),
    ("lines_per_bandwidth", "Lines per half-power bandwidth", "–"),
    ("loss_factor", "Loss factor", "–"),
    ("snr_db", "Signal to noise", "dB"),
    ("modes", "Modes", "–"),
    ("outside_distance", "Nearest mode outside", "spacings"),
    ("least_spacing", "Least spacing", "bandwidths"),
    ("references", "References", "–"),
];

fn value(name: &str, draw: &Draw) -> f64 {
    let of_list = PROPERTIES.iter().find(|(own, _)| *own == name);
    match (name, of_list) {
        (_, Some((_, value))) => value(draw),
        ("snr_db", _) => draw.snr_db,
        ("modes", _) => draw.modes as f64,
        _ => draw.references as f64,
    }
}

/// One figure with a chart for each property: the share of fits that are wrong, and of
/// those that do not say so, in five parts of equal count.
pub fn wild_figures(rows: &[WildRow]) -> Vec<Figure> {
    if rows.is_empty() {
        return Vec::new();
    }
    let charts = SHOWN.map(|(name, label, unit)| chart(rows, name, label, unit));
    vec![Figure {
        name: "wild".into(),
        title: "Which structures fail".into(),
        caption: format!(
            "{} structures, each property cut into five parts of equal count, shown at their \
             medians. Wrong: a missed or spurious mode.",
            rows.len()
        ),
        width: WIDTH_PX,
        charts: charts.into(),
    }]
}

fn chart(rows: &[WildRow], name: &str, label: &str, unit: &str) -> Chart {
    let mut values: Vec<(f64, &WildRow)> = rows
        .iter()
        .map(|row| (value(name, &row.draw), row))
        .collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let part = values.len().div_ceil(PARTS);
    let parts: Vec<&[(f64, &WildRow)]> = values.chunks(part).collect();
    let place = |part: &[(f64, &WildRow)]| {
        quantile(
            &part.iter().map(|(value, _)| *value).collect::<Vec<_>>(),
            0.5,
        )
    };
    let points = |counts: &dyn Fn(&WildRow) -> bool| {
        parts
            .iter()
            .map(|part| {
                let count = part.iter().filter(|(_, row)| counts(row)).count();
                [place(part), 100.0 * count as f64 / part.len() as f64]
            })
            .collect::<Vec<_>>()
    };
    Chart::new(Axis::linear(label, unit), Axis::linear("Fits", "%"))
        .height(Height::Px(150.0))
        .marks(
            "wrong",
            points(&|row| !row.outcome.exact()),
            Mark::Ring,
            Colour::Ink,
            9.0,
        )
        .marks(
            "wrong and silent",
            points(&|row| row.outcome.silent()),
            Mark::Cross,
            Colour::Series(1),
            9.0,
        )
        .marks(
            "law undecided",
            points(&|row| row.outcome.undecidable),
            Mark::Triangle,
            Colour::Series(0),
            8.0,
        )
}
