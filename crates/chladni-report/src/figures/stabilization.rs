//! Stabilization diagram over the CMIF, with the poles of the model and their bounds.

use super::cmif::{self, Cmif};
use crate::chart::{Axis, Figure, Height, Layer, Mark, Place, RightAxis};
use crate::comparison::Comparison;
use crate::drawing::{Colour, Stroke};
use crate::sizes;
use chladni_frf::ModalModel;
use chladni_rfp::{Stability, Stabilization};

/// Height of the model's poles, part of the highest order.
const LANE: f64 = 1.06;

/// A kind of poles: stability, name, and sign with its colour and size, px.
type Kind = (Stability, &'static str, Mark, Colour, f64);

/// The kinds of poles, from new to stable.
const KINDS: [Kind; 3] = [
    (
        Stability::New,
        "new at this order",
        Mark::Cross,
        Colour::Muted,
        4.0,
    ),
    (
        Stability::Frequency,
        "stable in frequency",
        Mark::Ring,
        Colour::Series(0),
        4.5,
    ),
    (
        Stability::Stable,
        "stable in frequency and damping",
        Mark::Dot,
        Colour::Series(1),
        4.5,
    ),
];

/// Poles of rising order over frequency, above the singular values.
pub(crate) fn stabilization(
    comparison: &Comparison,
    diagram: &Stabilization,
    cmif: &Cmif,
) -> Figure {
    let top = diagram.orders.last().copied().unwrap_or(1) as f64;
    let mut layers: Vec<Layer> = KINDS.into_iter().map(|kind| marks(diagram, kind)).collect();
    let model = comparison.model.into_iter();
    layers.extend(model.flat_map(|model| poles_of_model(model, LANE * top)));
    let mut chart = cmif::chart(comparison, cmif).height(Height::Px(380.0));
    chart.right = Some(RightAxis {
        axis: Axis::linear("Order of the denominator", "poles").range([0.0, 1.12 * top]),
        layers,
    });
    Figure {
        name: "stabilization".into(),
        title: format!("Stabilization diagram over the CMIF {}", cmif.of),
        caption: "Damped poles of a common denominator (method lscf) at rising order. Those of the structure come back at every \
                  order and make columns; those of the noise do not. The diagram is a display: the poles of the model at the top, with \
                  95 % bounds of their natural frequencies, were found by its own method."
            .into(),
        width: sizes::WIDE_PX,
        charts: vec![chart],
    }
}

/// The poles of one kind.
fn marks(diagram: &Stabilization, (stability, name, mark, colour, size): Kind) -> Layer {
    let poles = diagram
        .poles
        .iter()
        .filter(|pole| pole.stability == stability);
    let points = poles
        .map(|pole| [pole.frequency_hz, pole.order as f64])
        .collect();
    Layer::Marks {
        name: Some(name.into()),
        points,
        mark,
        colour,
        size,
    }
}

/// The poles of the model at this `height`, and the bounds of their natural frequencies.
fn poles_of_model(model: &ModalModel, height: f64) -> [Layer; 2] {
    let place = |f: f64| -> Place { [f, height] };
    let bar = |f: f64, std: f64| {
        vec![
            place(f - sizes::SIGMAS * std),
            place(f + sizes::SIGMAS * std),
        ]
    };
    let bars = model
        .in_band_modes()
        .map(|mode| bar(mode.frequency_hz, mode.frequency_std_hz))
        .collect();
    let points = model
        .in_band_modes()
        .map(|mode| place(mode.frequency_hz))
        .collect();
    [
        Layer::Lines {
            name: None,
            lines: bars,
            stroke: Stroke::new(Colour::Ink, 1.6),
        },
        Layer::Marks {
            name: Some("pole of the model".into()),
            points,
            mark: Mark::Triangle,
            colour: Colour::Series(2),
            size: 8.0,
        },
    ]
}
