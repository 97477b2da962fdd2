//! Complexity plot: every response of every shape in the complex plane. Each shape is turned to
//! the phase at which it is most real, and its largest motion is 1.

use super::mode_shape::turned;
use super::shown_responses;
use crate::chart::{Axis, Chart, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Colour, Stroke};
use crate::sizes::MAP_PX;
use chladni_frf::ModalModel;

/// The complexity plot of all modes in the band; `None` without modes.
pub(crate) fn complexity(model: &ModalModel) -> Option<Figure> {
    let shown = shown_responses(&model.responses);
    let mut points: Vec<Place> = Vec::new();
    for mode in model.in_band_modes() {
        points.extend(
            turned(model, mode, &shown)
                .iter()
                .map(|value| [value.re, value.im]),
        );
    }
    if points.is_empty() {
        return None;
    }
    let axis = |label| {
        Axis::linear(label, "largest = 1")
            .range([-1.15, 1.15])
            .step(0.5)
    };
    let zero = Layer::Horizontals {
        name: None,
        at: vec![0.0],
        stroke: Stroke::new(Colour::Ink, 1.2),
    };
    let chart = Chart::new(axis("Real part"), axis("Imaginary part"))
        .height(Height::EqualScales(430.0))
        .with(zero);
    Some(Figure {
        name: "complexity".into(),
        title: "Complexity of the shapes".into(),
        caption: "Every response of every mode in the band. Real modes lie on the line; a cloud \
                  around it is complexity, or noise."
            .into(),
        width: MAP_PX,
        charts: vec![chart.marks("", points, Mark::Dot, Colour::Series(0), 3.5)],
    })
}
