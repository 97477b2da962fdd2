//! The field of a rendering: level re threshold, zones, limits, and the responses that miss
//! their limits.

use super::level;
use super::mode_shape::whole;
use super::plane::{corners_mm, mm, Plane};
use crate::chart::{named, Axis, Chart, ColourBar, Disc, Figure, Layer, Mark, Place};
use crate::drawing::{Anchor, Colour, ColourMap, Dash, Image, Stroke};
use crate::input::ShownField;
use crate::sizes;
use crate::surface::{contours, Surface};
use crate::text::fixed;
use chladni_frf::ModalModel;
use chladni_render::{Ground, Position};
use ndarray::Array2;

const BLACK: Colour = Colour::Rgb([0, 0, 0]);
const WHITE: Colour = Colour::Rgb([255, 255, 255]);

/// The map `field-NUMBER` of a field, as [`super::all`] makes it. `model` gives the plane and
/// the ground around the responses. `None` where the responses span no plane.
pub fn field_map(
    shown: &ShownField,
    model: Option<&ModalModel>,
    frequency_hz: f64,
    number: usize,
) -> Option<Figure> {
    let plane = model
        .and_then(Plane::of)
        .or_else(|| Plane::around(&shown.field.positions_m))?;
    let mut chart = plane.chart(460.0);
    let threshold = shown.limits.threshold_m_per_s;
    let limits_db =
        [shown.limits.hot_m_per_s, shown.limits.cold_m_per_s].map(|limit| level(limit / threshold));
    let (felt, quiet) = (
        Stroke::new(BLACK, 1.8),
        Stroke::new(BLACK, 1.6).dashed(Dash::Dashed),
    );
    chart = match shown.area {
        Some(area) => {
            let surface = Surface::of_area(area);
            with_levels(chart, shown, &surface, limits_db, [felt, quiet])
        }
        None => with_discs(chart, shown),
    };
    chart = chart.with(judged_area(shown, Colour::Muted));
    chart = with_responses(with_hot_zones(chart, shown), shown);
    for outline in shown.zones.hot_outlines() {
        if let Some(at) = centre_of(shown, outline) {
            chart = chart.with(Layer::Words {
                at: mm(at),
                text: "hot".into(),
                anchor: Anchor::Middle,
                bold: true,
            });
        }
    }
    chart.colour_bar = Some(ColourBar {
        axis: Axis::linear("Velocity", "dB re threshold")
            .range([-sizes::FIELD_RANGE_DB, sizes::FIELD_RANGE_DB])
            .step(3.0),
        map: ColourMap::Sequential,
        bands: 0,
        lines: vec![(limits_db[0], felt), (limits_db[1], quiet)],
    });
    Some(Figure {
        name: format!("field-{number}"),
        title: format!("Field at {} Hz ({})", fixed(frequency_hz, 1), shown.on),
        caption: format!(
            "Level of the velocity re the threshold of {} mm/s peak. Hot ground is to lie above {} dB{}, cold ground below {} dB; \
             hatched ground is not judged. Levels beyond ±{} dB have the colours of the ends.",
            fixed(1e3 * threshold, 3),
            signed(limits_db[0]),
            louder_zones(shown, limits_db[0]),
            signed(limits_db[1]),
            fixed(sizes::FIELD_RANGE_DB, 0),
        ),
        width: sizes::MAP_PX,
        charts: vec![chart],
    })
}

/// A level with its sign, dB.
fn signed(db: f64) -> String {
    let sign = if db >= 0.0 { "+" } else { "" };
    sign.to_owned() + &fixed(db, 1)
}

/// The limit of the loudest zone in words, where zones differ from the scene's limit `hot_db`.
fn louder_zones(shown: &ShownField, hot_db: f64) -> String {
    let places = shown.field.positions_m.iter();
    let most = places
        .map(|&place| shown.zones.level_at(place))
        .fold(1.0, f64::max);
    match most > 1.0 {
        true => format!(
            ", in the loudest zone above {} dB",
            signed(hot_db + level(most))
        ),
        false => String::new(),
    }
}

/// The outline of the judged area.
pub(super) fn judged_area(shown: &ShownField, colour: Colour) -> Layer {
    Layer::Outline {
        name: named("judged area"),
        points: corners_mm(shown.zones.area()),
        stroke: Stroke::new(colour, 1.2).dashed(Dash::Dotted),
        casing: false,
    }
}

/// The chart with the outlines of the hot zones.
pub(super) fn with_hot_zones(mut chart: Chart, shown: &ShownField) -> Chart {
    for (k, outline) in shown.zones.hot_outlines().iter().enumerate() {
        chart = chart.with(Layer::Outline {
            name: if k == 0 { named("hot zone") } else { None },
            points: outline.iter().map(|&place| mm(place)).collect(),
            stroke: Stroke::new(Colour::Rgb([200, 30, 30]), 2.4),
            casing: true,
        });
    }
    chart
}

fn with_levels(
    chart: Chart,
    shown: &ShownField,
    surface: &Surface,
    [hot_db, cold_db]: [f64; 2],
    [felt, quiet]: [Stroke; 2],
) -> Chart {
    let threshold = shown.limits.threshold_m_per_s;
    let fine = surface.refined(sizes::FIELD_COLUMNS);
    // zero motion has no level, so it takes the lowest one
    let levels = fine.values.mapv(|v| {
        if v.is_nan() {
            f64::NAN
        } else {
            level((v.norm() / threshold).max(1e-15))
        }
    });
    let [x, y] =
        [&fine.x, &fine.y].map(|axis| axis.iter().map(|value| 1e3 * value).collect::<Vec<f64>>());
    let lines = |at: f64| contours(&x, &y, &levels, at);
    let image = level_pixels(shown, &fine, &levels);
    let mut chart = chart.with(Layer::Pixels {
        x: whole(&x),
        y: whole(&y),
        image,
    });
    for at in [hot_db, cold_db] {
        chart = chart.with(Layer::Lines {
            name: None,
            lines: lines(at),
            stroke: Stroke::new(WHITE, felt.width + 2.2),
        });
    }
    chart = chart.with(Layer::Lines {
        name: named(&format!("{} dB (felt beyond)", signed(hot_db))),
        lines: lines(hot_db),
        stroke: felt,
    });
    chart.with(Layer::Lines {
        name: named(&format!("{} dB (quiet below)", signed(cold_db))),
        lines: lines(cold_db),
        stroke: quiet,
    })
}

/// Colours of the levels; ground that is not judged is hatched.
fn level_pixels(shown: &ShownField, fine: &Surface, levels: &Array2<f64>) -> Image {
    let (rows, columns) = levels.dim();
    let mut rgba = Vec::with_capacity(4 * rows * columns);
    for row in (0..rows).rev() {
        for column in 0..columns {
            let value = levels[[row, column]];
            let judged = shown.zones.classify([fine.x[column], fine.y[row]]) != Ground::Ignored;
            let hatched = !judged && (row + column) % 6 < 2;
            let [r, g, b] = if hatched {
                [255, 255, 255]
            } else {
                ColourMap::Sequential.at(0.5 + 0.5 * value / sizes::FIELD_RANGE_DB)
            };
            rgba.extend([r, g, b, if value.is_nan() { 0 } else { 255 }]);
        }
    }
    Image {
        columns,
        rows,
        rgba,
    }
}

/// Responses as discs in the colour of their level, where the field between them is not known.
fn with_discs(chart: Chart, shown: &ShownField) -> Chart {
    let discs = shown
        .field
        .positions_m
        .iter()
        .zip(&shown.field.velocity_m_per_s)
        .map(|(&place, v)| {
            let value = level(v.norm() / shown.limits.threshold_m_per_s);
            let fill =
                Colour::Rgb(ColourMap::Sequential.at(0.5 + 0.5 * value / sizes::FIELD_RANGE_DB));
            Disc {
                at: mm(place),
                radius: 9.0,
                fill,
                hand: None,
                hint: format!("{} dB re threshold", fixed(value, 1)),
            }
        });
    chart.with(Layer::Discs(discs.collect()))
}

fn with_responses(chart: Chart, shown: &ShownField) -> Chart {
    let field = shown.field;
    let misses = |k: usize| field.keeps(k, &shown.limits, shown.zones) == Some(false);
    let of = |wanted: &dyn Fn(usize) -> bool| -> Vec<Place> {
        (0..field.positions_m.len())
            .filter(|&k| wanted(k))
            .map(|k| mm(field.positions_m[k]))
            .collect()
    };
    let judged = |ground: Ground| of(&|k| field.ground[k] == ground && !misses(k));
    let missed = of(&misses);
    let name = |points: &[Place], text: &str| {
        if points.is_empty() {
            String::new()
        } else {
            text.to_owned()
        }
    };
    let (hot, cold, ignored) = (
        judged(Ground::Hot),
        judged(Ground::Cold),
        judged(Ground::Ignored),
    );
    let chart = chart.marks(
        &name(&hot, "response, felt as wished"),
        hot,
        Mark::Triangle,
        BLACK,
        7.0,
    );
    let chart = chart.marks(
        &name(&cold, "response, quiet as wished"),
        cold,
        Mark::Ring,
        Colour::Rgb([235, 235, 235]),
        6.0,
    );
    let chart = chart.marks(
        &name(&ignored, "response, not judged"),
        ignored,
        Mark::Dot,
        Colour::Rgb([90, 90, 90]),
        3.0,
    );
    chart.marks(
        &name(&missed, "response, misses its limit"),
        missed,
        Mark::Cross,
        Colour::Rgb([210, 20, 20]),
        9.0,
    )
}

/// Centre of the part of an outline's box inside the judged area.
fn centre_of(shown: &ShownField, outline: &[Position]) -> Option<Position> {
    let hot = chladni_render::Rectangle::around(outline)?;
    let area = shown.zones.area();
    let middle = |low: f64, high: f64| (low <= high).then_some((low + high) / 2.0);
    Some([
        middle(hot.x_min.max(area.x_min), hot.x_max.min(area.x_max))?,
        middle(hot.y_min.max(area.y_min), hot.y_max.min(area.y_max))?,
    ])
}
