//! The figures of the seed paper, drawn from its reproduction, and its success over modes
//! and places.

mod drive;
mod ground;
mod success;

use super::paper::{places, PaperModes, PaperRun, PAPER_MODES};
use chladni_frf::Result;
use chladni_render::Position;
use chladni_report::{field_map, Colour, Figure, Layer, Place, RenderedScene, Stroke};

/// Width of a picture, px.
const WIDTH_PX: f64 = 760.0;
/// Height of a chart, px.
const CHART_PX: f64 = 130.0;

/// Modal coefficients, actuator weightings, levels and fields of the first place with 34
/// exact modes, then success over modes and over places.
///
/// # Errors
/// None for a run of [`super::paper()`].
pub fn paper_figures(run: &PaperRun) -> Result<Vec<Figure>> {
    let Some(first) = places().next() else {
        return Ok(Vec::new());
    };
    let paper = run
        .two_steps(first.name, PaperModes::Exact, None)
        .find(|row| row.weights.modes_used == PAPER_MODES);
    let (Some(paper), Some(ours)) = (paper, run.ours(first.name)) else {
        return Ok(Vec::new());
    };
    let [of_paper, of_ours] = [run.on_the_panel(paper)?, run.on_the_panel(ours)?];
    let mut figures = vec![ground::layout(run, &of_paper)];
    figures.extend(drive::coefficients(paper));
    figures.extend(drive::weightings(run, paper, &of_paper));
    figures.push(ground::levels([
        ("the two steps", &of_paper),
        ("the default method", &of_ours),
    ]));
    for (row, evaluation, name) in [
        (paper, &of_paper, "paper-field"),
        (ours, &of_ours, "paper-field-default"),
    ] {
        let shown = RenderedScene::of_evaluation(&row.weights, evaluation, "the true plate").shown;
        let map = shown
            .and_then(|shown| field_map(&shown, Some(&run.exact), row.weights.frequency_hz, 1));
        figures.extend(map.map(|map| Figure {
            name: name.into(),
            ..map
        }));
    }
    figures.push(success::over_modes(run, ours));
    figures.push(success::over_places(run));
    Ok(figures)
}

fn mm(place: Position) -> Place {
    place.map(|metres| 1e3 * metres)
}

/// The edge of a hot zone.
fn hot_zone(name: &str, outline: &[Position]) -> Layer {
    Layer::Outline {
        name: Some(name.into()),
        points: outline.iter().map(|&place| mm(place)).collect(),
        stroke: Stroke::new(Colour::Rgb([200, 30, 30]), 2.4),
        casing: false,
    }
}
