//! Poles with their bounds: loss factor over natural frequency.

use crate::chart::{Axis, Chart, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Colour, Stroke};
use crate::sizes::{SIGMAS, WIDE_PX};
use chladni_frf::{ModalModel, Mode, Trust};

/// Loss factor over natural frequency of all modes in the band; `None` without modes.
pub(crate) fn poles(model: &ModalModel) -> Option<Figure> {
    let modes: Vec<&Mode> = model.in_band_modes().collect();
    if modes.is_empty() {
        return None;
    }
    let place = |mode: &Mode| -> Place { [mode.frequency_hz, 100.0 * mode.loss_factor] };
    let bars = |mode: &&Mode| {
        let ([f, loss], [df, dloss]) = (
            place(mode),
            [
                SIGMAS * mode.frequency_std_hz,
                SIGMAS * 100.0 * mode.loss_factor_std,
            ],
        );
        [
            vec![[f - df, loss], [f + df, loss]],
            vec![[f, loss - dloss], [f, loss + dloss]],
        ]
    };
    let of = |trust: Trust| -> Vec<Place> {
        modes
            .iter()
            .filter(|mode| mode.trust == trust)
            .map(|mode| place(mode))
            .collect()
    };
    let (sure, weak) = (of(Trust::Sure), of(Trust::Weak));
    let bars = Layer::Lines {
        name: Some("95 % bounds".into()),
        lines: modes.iter().flat_map(bars).collect(),
        stroke: Stroke::new(Colour::Ink, 1.4),
    };
    let y = Axis::linear("Loss factor", "%").padded(0.15);
    let mut chart = Chart::new(
        Axis::linear("Natural frequency", "Hz").range(model.band_hz),
        y,
    )
    .height(Height::Px(260.0))
    .with(bars);
    for (name, points, mark, series) in
        [("sure", sure, Mark::Dot, 0), ("weak", weak, Mark::Ring, 1)]
    {
        let name = if points.is_empty() { "" } else { name };
        chart = chart.marks(name, points, mark, Colour::Series(series), 6.0);
    }
    Some(Figure {
        name: "poles".into(),
        title: "Poles with their bounds".into(),
        caption: "Loss factor over natural frequency, with 95 % bounds of both. Bars shorter than \
                  the mark cannot be seen."
            .into(),
        width: WIDE_PX,
        charts: vec![chart],
    })
}
