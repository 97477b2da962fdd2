//! Performance in the scene with fewer modes and with fewer actuators.

use crate::chart::{Axis, Chart, Figure, Height, Mark, Place};
use crate::drawing::{Colour, Dash, Stroke};
use crate::input::{CurvePoint, RenderedScene};
use crate::sizes::WIDE_PX;

/// A figure over the number of modes and one over the number of actuators; none where the scene
/// has no curves.
pub(crate) fn curves(scene: &RenderedScene, number: usize) -> Vec<Figure> {
    let Some(curves) = scene.curves else {
        return Vec::new();
    };
    let (weights, own) = (
        scene.weights,
        scene
            .shown
            .map_or(&scene.weights.indices, |shown| shown.indices),
    );
    let served = 100.0 * own.points.success_ratio;
    let figure = |what: &str, label: &str, points: &[CurvePoint], used: usize, how: &str| {
        (!points.is_empty()).then(|| Figure {
            name: format!("fewer-{what}-{number}"),
            title: format!("Scene {number} with fewer {what}"),
            caption: format!(
                "For each number weights of their own (method {}), {how}; judged in the whole model.",
                curves.method
            ),
            width: WIDE_PX,
            charts: vec![chart(label, points, &weights.method, [used as f64, served])],
        })
    };
    let modes = figure(
        "modes",
        "Modes summed",
        &curves.modes,
        weights.modes_used,
        "with the modes that count most at the drive frequency, the others folded into residual terms",
    );
    let actuators = figure(
        "actuators",
        "Actuators driven",
        &curves.actuators,
        weights.actuators_used,
        "with the actuators that are strongest in these weights (rendering for a given number of \
         actuators chooses them better)",
    );
    modes.into_iter().chain(actuators).collect()
}

fn chart(label: &str, points: &[CurvePoint], method: &str, own: Place) -> Chart {
    let last = points.last().map_or(1, |point| point.count) as f64;
    let step = [1.0, 2.0, 5.0, 10.0, 20.0]
        .into_iter()
        .find(|step| last / step <= 12.0)
        .unwrap_or(50.0);
    let x = Axis::linear(label, "number")
        .range([0.5, (last + 0.5).max(2.0)])
        .step(step);
    let mut chart = Chart::new(x, Axis::linear("Responses served", "%").range([0.0, 103.0]))
        .height(Height::Px(190.0));
    let curve = |of: &dyn Fn(&CurvePoint) -> f64| {
        points
            .iter()
            .map(|point| [point.count as f64, 100.0 * of(point)])
            .collect::<Vec<Place>>()
    };
    let strokes = [
        (Colour::Series(1), 1.6, Dash::Solid),
        (Colour::Series(0), 1.6, Dash::Dashed),
        (Colour::Ink, 2.0, Dash::Solid),
    ];
    let both = curve(&|point| point.success_ratio);
    let curves = [
        ("hot", curve(&|point| point.hot_ratio)),
        ("cold", curve(&|point| point.cold_ratio)),
        ("both", both.clone()),
    ];
    for ((name, points), (colour, width, dash)) in curves.into_iter().zip(strokes) {
        chart = chart.line(name, points, Stroke::new(colour, width).dashed(dash));
    }
    chart = chart.marks("", both, Mark::Dot, Colour::Ink, 4.0);
    chart.marks(
        &format!("the scene's own weights ({method})"),
        vec![own],
        Mark::Square,
        Colour::Series(3),
        7.0,
    )
}
