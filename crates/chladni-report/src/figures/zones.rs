//! The demands of a scene on each place: hot, cold and unjudged ground, with the responses and
//! the actuators.

use super::field_map::{judged_area, with_hot_zones};
use super::plane::{mm, Plane};
use crate::chart::{Chart, Figure, Layer, Mark, Place};
use crate::drawing::{Colour, Image};
use crate::input::ShownField;
use crate::sizes;
use crate::text::fixed;
use chladni_frf::ModalModel;
use chladni_render::{Ground, Rectangle};

/// Pale colours of the grounds: red, blue, white. Hatching and names distinguish them in grey.
const HOT: [u8; 3] = [250, 205, 195];
const COLD: [u8; 3] = [205, 222, 242];
const IGNORED: [u8; 3] = [255, 255, 255];
const STRIPE: [u8; 3] = [205, 205, 205];

/// A map of the demands; `None` where the responses span no plane.
pub(crate) fn zones(
    shown: &ShownField,
    model: Option<&ModalModel>,
    number: usize,
) -> Option<Figure> {
    let plane = model
        .and_then(Plane::of)
        .or_else(|| Plane::around(&shown.field.positions_m))?;
    let mut chart = plane.chart(460.0).with(grounds(shown, plane.around));
    chart = chart.with(judged_area(shown, Colour::Ink));
    chart = with_responses(with_hot_zones(chart, shown), shown);
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
