//! Stabilization diagram.

use super::frf_overlay::{band_lines, frequency_axis, pole_lines};
use super::natural_frequencies;
use crate::chart::{Axis, Chart, Figure, Height, Mark, Place};
use crate::comparison::Comparison;
use crate::drawing::Colour;
use crate::sizes;
use chladni_rfp::{Stability, Stabilization};

/// Poles of rising order over frequency.
pub(crate) fn stabilization(comparison: &Comparison, diagram: &Stabilization) -> Figure {
    let ends = [diagram.orders.first().copied().unwrap_or(0) as f64, diagram.orders.last().copied().unwrap_or(1) as f64];
    let axis = Axis::linear("Order of the denominator", "poles").range([ends[0] - 1.0, ends[1] + 1.0]);
    let mut chart = Chart::new(frequency_axis(comparison), axis).height(Height::Px(300.0));
    chart = chart.with(pole_lines(&natural_frequencies(comparison.model)));
    if let Some(band) = band_lines(comparison) {
        chart = chart.with(band);
    }
    let kinds = [
        (Stability::New, "new at this order", Mark::Cross, Colour::Muted, 4.0),
        (Stability::Frequency, "stable in frequency", Mark::Ring, Colour::Series(0), 4.5),
        (Stability::Stable, "stable in frequency and damping", Mark::Dot, Colour::Series(1), 4.5),
    ];
    for (stability, name, mark, colour, size) in kinds {
        let poles = diagram.poles.iter().filter(|pole| pole.stability == stability);
        let points: Vec<Place> = poles.map(|pole| [pole.frequency_hz, pole.order as f64]).collect();
        chart = chart.marks(name, points, mark, colour, size);
    }
    Figure {
        name: "stabilization".into(),
        title: "Stabilization diagram of the measured FRFs".into(),
        caption: "Damped poles of a common denominator (method lscf) at rising order. Those of the structure come back at every \
                  order and make columns; those of the noise do not. The diagram is a display: the poles of the model were found by \
                  its own method."
            .into(),
        width: sizes::WIDE_PX,
        charts: vec![chart],
    }
}
