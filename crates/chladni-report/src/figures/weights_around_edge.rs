//! Weights: phasors at the places of the actuators, and amplitude and phase by actuator.

use super::plane::{corners_mm, mm, Plane};
use crate::chart::{named, Axis, Chart, ColourBar, Disc, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Colour, ColourMap, Dash, Stroke};
use crate::sizes;
use crate::text::fixed;
use chladni_frf::{ModalModel, ReferenceUnit};
use chladni_render::{Position, Weight, Weights};

/// Largest radius of a phasor, px.
const MAX_RADIUS_PX: f64 = 22.0;

/// A unit that gives short numbers, and the factor to it.
struct Scaled {
    factor: f64,
    unit: String,
}

fn scaled(weights: &Weights) -> Scaled {
    let largest = largest(weights);
    let unit = match weights.unit() {
        ReferenceUnit::Newton => "N",
        ReferenceUnit::Volt => "V",
    };
    let (factor, prefix) = [(1.0, ""), (1e3, "m"), (1e6, "µ")]
        .into_iter()
        .find(|(factor, _)| largest * factor >= 0.5)
        .unwrap_or((1e9, "n"));
    Scaled {
        factor,
        unit: format!("{prefix}{unit} peak"),
    }
}

fn largest(weights: &Weights) -> f64 {
    weights
        .weights
        .iter()
        .map(|weight| weight.value().norm())
        .fold(0.0, f64::max)
}

fn hint(weight: &Weight, scale: &Scaled) -> String {
    let value = weight.value();
    let amplitude = fixed(value.norm() * scale.factor, 3);
    format!(
        "{}: {amplitude} {}, {}°",
        weight.reference,
        scale.unit,
        fixed(value.arg().to_degrees(), 1)
    )
}

/// Phasors around the panel, `weights-NUMBER-panel`, as [`super::all`] makes them; `None`
/// where the positions of the actuators are not known.
pub fn weights_around_edge(weights: &Weights, model: &ModalModel, number: usize) -> Option<Figure> {
    let plane = Plane::of(model)?;
    let places: Vec<Position> = weights
        .weights
        .iter()
        .map(|weight| plane.position(&model.nodes, &weight.reference))
        .collect::<Option<_>>()?;
    let (scale, largest) = (scaled(weights), largest(weights));
    let width_px = sizes::MAP_PX - 150.0;
    let px_per_m =
        width_px / ((1.0 + 2.0 * sizes::MAP_BORDER) * (plane.around.x_max - plane.around.x_min));
    let radius = (0.5 * nearest(&places) * px_per_m).clamp(4.0, MAX_RADIUS_PX);
    let discs = weights.weights.iter().zip(&places).map(|(weight, &place)| {
        let value = weight.value();
        Disc {
            at: mm(place),
            radius: if largest > 0.0 {
                radius * (value.norm() / largest).sqrt()
            } else {
                0.0
            },
            fill: Colour::Rgb(ColourMap::Cyclic.at(value.arg() / std::f64::consts::TAU + 0.5)),
            hand: Some(value.arg()),
            hint: hint(weight, &scale),
        }
    });
    let frame = Stroke::new(Colour::Muted, 1.2).dashed(Dash::Dashed);
    let mut chart = plane.chart(420.0);
    chart = chart.with(Layer::Outline {
        name: named("box around all nodes"),
        points: corners_mm(plane.around),
        stroke: frame,
        casing: false,
    });
    chart = chart.with(Layer::Discs(discs.collect()));
    chart.colour_bar = Some(ColourBar {
        axis: Axis::linear("Phase", "degrees")
            .range([-180.0, 180.0])
            .step(90.0),
        map: ColourMap::Cyclic,
        bands: 0,
        lines: Vec::new(),
    });
    Some(Figure {
        name: format!("weights-{number}-panel"),
        title: format!(
            "Weights around the panel at {} Hz, largest {} {}",
            fixed(weights.frequency_hz, 1),
            fixed(largest * scale.factor, 2),
            scale.unit
        ),
        caption:
            "The area of a disc is the amplitude of the actuator there. Its hand and colour are \
             the phase: right 0°, up 90°, left 180°."
                .into(),
        width: sizes::MAP_PX,
        charts: vec![chart],
    })
}

/// Least distance between two different places, m.
fn nearest(places: &[Position]) -> f64 {
    let mut least = f64::INFINITY;
    for (k, a) in places.iter().enumerate() {
        for b in &places[..k] {
            let distance = (a[0] - b[0]).hypot(a[1] - b[1]);
            if distance > 0.0 {
                least = least.min(distance);
            }
        }
    }
    least
}

/// Amplitude and phase, actuator by actuator.
pub(crate) fn weights_by_actuator(weights: &Weights, number: usize) -> Figure {
    let scale = scaled(weights);
    let count = weights.weights.len();
    let names = weights
        .weights
        .iter()
        .enumerate()
        .map(|(k, weight)| (k as f64 + 1.0, weight.reference.to_string()));
    let x = Axis::linear("Actuator", "reference DOF")
        .range([0.0, count as f64 + 1.0])
        .names(names.collect());
    let stems = |value: &dyn Fn(&Weight) -> f64| -> Vec<(Place, String)> {
        let list = weights.weights.iter().enumerate();
        list.map(|(k, weight)| ([k as f64 + 1.0, value(weight)], hint(weight, &scale)))
            .collect()
    };
    let top = (largest(weights) * scale.factor * 1.08).max(f64::MIN_POSITIVE);
    let amplitude = Chart::new(
        x.clone(),
        Axis::linear("Amplitude", &scale.unit).range([0.0, top]),
    )
    .height(Height::Px(150.0))
    .with(Layer::Stems {
        name: None,
        points: stems(&|weight| weight.value().norm() * scale.factor),
        mark: Mark::Dot,
        colour: Colour::Series(0),
    });
    let phase = Chart::new(
        x,
        Axis::linear("Phase", "degrees")
            .range([-190.0, 190.0])
            .step(90.0),
    )
    .height(Height::Px(150.0))
    .with(Layer::Stems {
        name: None,
        points: stems(&|weight| weight.value().arg().to_degrees()),
        mark: Mark::Square,
        colour: Colour::Series(1),
    });
    Figure {
        name: format!("weights-{number}-list"),
        title: format!(
            "Weights by actuator at {} Hz",
            fixed(weights.frequency_hz, 1)
        ),
        caption: "Peak phasors of e^(+jωt): a positive phase leads.".into(),
        width: sizes::WIDE_PX,
        charts: vec![amplitude, phase],
    }
}
