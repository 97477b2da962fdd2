//! The chart of stage times.

use super::{ProfileRow, ScalingRow};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Height, Layer, Mark, Place, Stroke};
use chladni_rfp::Method;

/// Width of the picture, px.
const WIDTH_PX: f64 = 720.0;
/// Height of each plotted box, px.
const HEIGHT_PX: f64 = 170.0;

/// One figure: a chart for each set and method, a stem for each stage, the floor as a
/// line.
pub fn profile_figure(rows: &[ProfileRow]) -> Figure {
    let mut runs: Vec<(&str, Method)> = rows
        .iter()
        .map(|row| (row.case.as_str(), row.method))
        .collect();
    runs.dedup();
    let charts = runs.into_iter().map(|(case, method)| {
        chart(
            &rows
                .iter()
                .filter(|r| r.case == case && r.method == method)
                .collect::<Vec<_>>(),
        )
    });
    Figure {
        name: "profile".into(),
        title: "Time of each stage of a fit, and the floor".into(),
        caption: "Floor: one pass over memory and the flops of one projection of all FRFs, both \
                  measured in the same run."
            .into(),
        width: WIDTH_PX,
        charts: charts.collect(),
    }
}

fn chart(rows: &[&ProfileRow]) -> Chart {
    let stages: Vec<&&ProfileRow> = rows
        .iter()
        .filter(|row| !row.stage.starts_with("floor") && row.stage != "fit")
        .collect();
    let sum = |name: &str| rows.iter().find(|row| row.stage == name);
    let label = rows.first().map_or_else(String::new, |row| {
        let over = sum("fit").map_or(f64::NAN, |fit| fit.over_floor);
        format!(
            "{}, {}: the fit takes {over:.1} times the floor",
            row.case, row.method
        )
    });
    let names = stages
        .iter()
        .enumerate()
        .map(|(k, row)| (k as f64, row.stage.clone()))
        .collect();
    let points = stages.iter().enumerate().map(|(k, row)| {
        (
            [k as f64, row.time_s],
            format!("{}: {:.3} s", row.stage, row.time_s),
        )
    });
    let floor: Vec<f64> = sum("floor").map(|row| row.time_s).into_iter().collect();
    let top = stages
        .iter()
        .map(|row| row.time_s)
        .chain(floor.iter().copied())
        .fold(0.0, f64::max);
    let mut chart = Chart::new(
        Axis::linear(&label, "stages of the fit")
            .range([-0.5, stages.len() as f64 - 0.5])
            .names(names),
        Axis::linear("Time", "s").range([0.0, 1.1 * top]),
    )
    .height(Height::Px(HEIGHT_PX))
    .with(Layer::Horizontals {
        name: Some("floor".into()),
        at: floor,
        stroke: Stroke::new(Colour::Ink, 1.4).dashed(Dash::Dashed),
    })
    .with(Layer::Stems {
        name: Some("stage".into()),
        points: points.collect(),
        mark: Mark::Dot,
        colour: Colour::Series(0),
    });
    chart.grid = false;
    chart
}

/// Time over each of the things that were varied, one line for each method, the exponent
/// in the legend.
pub fn scaling_figure(rows: &[ScalingRow]) -> Option<Figure> {
    let mut axes: Vec<&str> = rows.iter().map(|row| row.axis).collect();
    axes.dedup();
    let charts = axes.into_iter().filter_map(|axis| {
        let own: Vec<&ScalingRow> = rows.iter().filter(|row| row.axis == axis).collect();
        let mut methods: Vec<Method> = own.iter().map(|row| row.method).collect();
        methods.dedup();
        let mut chart = Chart::new(
            Axis::log(&format!("Number of {axis}"), "–").padded(0.08),
            Axis::log("Time of a fit, least", "s").padded(0.1),
        )
        .height(Height::Px(HEIGHT_PX));
        for (k, method) in methods.iter().enumerate() {
            let of_method: Vec<&&ScalingRow> =
                own.iter().filter(|row| row.method == *method).collect();
            let points: Vec<Place> = of_method
                .iter()
                .map(|row| [row.value as f64, row.time_s])
                .collect();
            let (colour, mark) = (Colour::Series(k as u8), Mark::of_series(k));
            chart = chart.line("", points.clone(), Stroke::new(colour, 1.6));
            chart = chart.marks(
                &format!("{method}: exponent {:.2}", of_method[0].exponent),
                points,
                mark,
                colour,
                8.0,
            );
        }
        (own.len() > methods.len()).then_some(chart)
    });
    let charts: Vec<Chart> = charts.collect();
    (!charts.is_empty()).then(|| Figure {
        name: "profile-scaling".into(),
        title: "How the time of a fit grows".into(),
        caption:
            "One thing varied at a time; exponents by least squares of log time over log value."
                .into(),
        width: WIDTH_PX,
        charts,
    })
}
