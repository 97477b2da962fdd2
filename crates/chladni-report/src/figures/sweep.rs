//! Performance in the scene at other drive frequencies, each with weights of its own (a sweep).

use crate::chart::{Axis, Chart, Figure, Height, Mark, Place};
use crate::drawing::{Colour, Dash, Stroke};
use crate::sizes::WIDE_PX;
use crate::text::fixed;
use chladni_render::{SweptFrequency, Weights};

/// Share of responses served over drive frequency; `None` without a sweep.
pub(crate) fn sweep(weights: &Weights, number: usize) -> Option<Figure> {
    let sweep = weights.sweep.as_ref()?;
    let curve = |of: &dyn Fn(&SweptFrequency) -> Option<f64>| -> Vec<Place> {
        sweep
            .frequencies
            .iter()
            .filter_map(|swept| Some([swept.frequency_hz, of(swept)?]))
            .collect()
    };
    let chart = Chart::new(
        Axis::linear("Drive frequency", "Hz"),
        Axis::linear("Responses served", "%").range([0.0, 103.0]),
    );
    let mut chart = marked(
        chart.height(Height::Px(240.0)),
        "undisturbed",
        curve(&|swept| Some(100.0 * swept.success_ratio)),
        0,
        Dash::Solid,
    );
    let touched = curve(&|swept| swept.touched_ratio.map(|ratio| 100.0 * ratio));
    if !touched.is_empty() {
        chart = marked(
            chart,
            "with a finger in the hot zone",
            touched,
            1,
            Dash::Dashed,
        );
    }
    Some(Figure {
        name: format!("sweep-{number}"),
        title: format!("Scene {number} at other drive frequencies, each with weights of its own"),
        caption: sweep.suggestion().map_or(String::new(), |one| {
            let hz = fixed(one.frequency_hz, 1);
            match one.is_met() {
                true => format!("Suggested: {hz} Hz."),
                false => format!("No frequency serves every response; {hz} Hz comes nearest."),
            }
        }),
        width: WIDE_PX,
        charts: vec![chart],
    })
}

/// The chart with a curve and a mark at each point, so that single points are visible too.
fn marked(chart: Chart, name: &str, points: Vec<Place>, series: u8, dash: Dash) -> Chart {
    let colour = Colour::Series(series);
    chart
        .marks("", points.clone(), Mark::Dot, colour, 4.0)
        .line(name, points, Stroke::new(colour, 1.6).dashed(dash))
}
