//! The demands of a scene on each place: hot, cold and unjudged ground, with the
//! responses that judge it and the actuators that serve it.

use super::plane::{corners_mm, mm, Plane};
use crate::chart::{named, Chart, Figure, Layer, Mark, Place};
use crate::drawing::{Colour, Dash, Image, Stroke};
use crate::input::ShownField;
use crate::sizes;
use crate::text::fixed;
use chladni_frf::ModalModel;
use chladni_render::{Ground, Rectangle};

/// Pale grounds: red, blue and white; hatching and names tell them apart in grey.
const HOT: [u8; 3] = [250, 205, 195];
const COLD: [u8; 3] = [205, 222, 242];
const IGNORED: [u8; 3] = [255, 255, 255];
const STRIPE: [u8; 3] = [205, 205, 205];

/// `None` where the responses carry no plane.
pub(crate) fn zones(
    shown: &ShownField,
    model: Option<&ModalModel>,
    number: usize,
) -> Option<Figure> {
    let plane = model
        .and_then(Plane::of)
        .or_else(|| Plane::around(&shown.field.positions_m))?;
    let area = shown.zones.area();
    let mut chart = plane.chart(460.0).with(grounds(shown, plane.around));
    let frame = Stroke::new(Colour::Ink, 1.2).dashed(Dash::Dotted);
    chart = chart.with(Layer::Outline {
        name: named("judged area"),
        points: corners_mm(area),
        stroke: frame,
        casing: false,
    });
    for (k, outline) in shown.zones.hot_outlines().iter().enumerate() {
        let points: Vec<Place> = outline.iter().map(|&place| mm(place)).collect();
        let stroke = Stroke::new(Colour::Rgb([200, 30, 30]), 2.4);
        chart = chart.with(Layer::Outline {
            name: if k == 0 { named("hot zone") } else { None },
            points,
            stroke,
            casing: true,
        });
    }
    chart = with_responses(chart, shown);
    if let Some(model) = model {
        let places = model
            .references
            .iter()
            .filter_map(|dof| plane.position(&model.nodes, dof))
            .map(mm)
            .collect();
        chart = chart.marks("actuator", places, Mark::Square, Colour::Ink, 6.0);
    }
    let transition = fixed(1e3 * shown.zones.transition_m(), 0);
    Some(Figure {
        name: format!("zones-{number}"),
        title: format!("What scene {number} asks of the panel"),
        caption: format!(
            "Pale red ground is to be felt, pale blue ground is to be quiet; hatched ground is not judged: {transition} mm on each side of \
             a hot border, and all outside the judged area."
        ),
        width: sizes::MAP_PX,
        charts: vec![chart],
    })
}

fn grounds(shown: &ShownField, around: Rectangle) -> Layer {
    let (width, height) = (around.x_max - around.x_min, around.y_max - around.y_min);
    let columns = sizes::FIELD_COLUMNS;
    let rows = ((columns as f64 * height / width).ceil() as usize).clamp(2, 2 * columns);
    let mut rgba = Vec::with_capacity(4 * rows * columns);
    for row in (0..rows).rev() {
        for column in 0..columns {
            let part = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
            let place = [
                around.x_min + width * part(column, columns),
                around.y_min + height * part(row, rows),
            ];
            let [r, g, b] = match shown.zones.classify(place) {
                Ground::Hot => HOT,
                Ground::Cold => COLD,
                Ground::Ignored if (row + column) % 8 < 2 => STRIPE,
                Ground::Ignored => IGNORED,
            };
            rgba.extend([r, g, b, 255]);
        }
    }
    let [x, y] = [[around.x_min, around.x_max], [around.y_min, around.y_max]].map(mm);
    Layer::Pixels {
        x,
        y,
        image: Image {
            columns,
            rows,
            rgba,
        },
    }
}

fn with_responses(chart: Chart, shown: &ShownField) -> Chart {
    let of = |ground: Ground| -> Vec<Place> {
        let places = shown.field.positions_m.iter().zip(&shown.field.ground);
        places
            .filter(|(_, found)| **found == ground)
            .map(|(&place, _)| mm(place))
            .collect()
    };
    let kinds = [
        (Ground::Hot, "response, to be felt", Mark::Triangle, 7.0),
        (Ground::Cold, "response, to be quiet", Mark::Ring, 6.0),
        (Ground::Ignored, "response, not judged", Mark::Dot, 3.0),
    ];
    kinds
        .into_iter()
        .fold(chart, |chart, (ground, name, mark, size)| {
            let points = of(ground);
            chart.marks(
                if points.is_empty() { "" } else { name },
                points,
                mark,
                Colour::Ink,
                size,
            )
        })
}
