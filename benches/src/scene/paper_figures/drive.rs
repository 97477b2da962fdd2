//! The drive of the first place: what is asked of its modes, and its weights.

use super::{hot_zone, CHART_PX, WIDTH_PX};
use crate::scene::paper::{PaperRow, PaperRun};
use chladni_frf::ComplexVector;
use chladni_render::{Evaluation, ModalSteps};
use chladni_report::{
    weights_around_edge, Axis, Chart, Colour, Figure, Height, Layer, Mark, Place,
};
use num_complex::Complex64;

/// A real number of a complex one.
type Part = fn(Complex64) -> f64;

/// Fig. 3a: |W_n| and its phase.
pub(super) fn coefficients(row: &PaperRow) -> Option<Figure> {
    let steps = row.steps()?;
    let x = || {
        Axis::linear("Mode, by rising natural frequency", "number")
            .range([0.0, steps.frequency_hz.len() as f64 + 1.0])
            .step(2.0)
    };
    let chart = |y: Axis, of: Part| {
        let asked = Layer::Stems {
            name: Some("asked of the mode".into()),
            points: points(steps, &steps.asked, of),
            mark: Mark::Dot,
            colour: Colour::Series(0),
        };
        let driven = points(steps, &steps.driven, of).into_iter();
        Chart::new(x(), y)
            .height(Height::Px(1.4 * CHART_PX))
            .with(asked)
            .marks(
                "given by the actuators",
                driven.map(|(place, _)| place).collect(),
                Mark::Ring,
                Colour::Series(1),
                10.0,
            )
    };
    let phase = Axis::linear("Phase", "degrees");
    Some(Figure {
        name: "paper-coefficients".into(),
        title: format!(
            "Modal coefficients of the {} lowest modes, quarter 1",
            steps.frequency_hz.len()
        ),
        caption: "Modal force that the target asks of each mode, and what the actuators give it. \
                  Modes 1 to 3 are those of the rigid body."
            .into(),
        width: WIDTH_PX,
        charts: vec![
            chart(
                Axis::log("Amplitude", "N/√kg").padded(0.06),
                Complex64::norm,
            ),
            chart(phase.range([-190.0, 190.0]).step(90.0), degrees),
        ],
    })
}

/// A part of the coefficients by the number of their mode, and all of it in words.
fn points(steps: &ModalSteps, values: &ComplexVector, of: Part) -> Vec<(Place, String)> {
    let all = values.0.iter().zip(&steps.frequency_hz).enumerate();
    all.map(|(n, (&value, hz))| {
        let (size, phase) = (value.norm(), degrees(value));
        (
            [n as f64 + 1.0, of(value)],
            format!("{hz:.1} Hz: {size:.3e} N/√kg, {phase:.0}°"),
        )
    })
    .collect()
}

fn degrees(value: Complex64) -> f64 {
    value.arg().to_degrees()
}

/// Fig. 3b: weights around the edge, and the hot zone.
pub(super) fn weightings(
    run: &PaperRun,
    row: &PaperRow,
    evaluation: &Evaluation,
) -> Option<Figure> {
    let mut figure = weights_around_edge(&row.weights, &run.exact, 1)?;
    for outline in evaluation.zones.hot_outlines() {
        let zone = hot_zone("hot zone", outline);
        figure.charts[0].layers.insert(0, zone);
    }
    Some(Figure {
        name: "paper-weightings".into(),
        ..figure
    })
}
