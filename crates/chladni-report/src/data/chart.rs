//! A chart as JSON for `page/modules/described.js`, which draws it: axes with their ends, and
//! layers of lines, marks, words and levels. Colours are given by their roles.

use super::array::f32s;
use crate::chart::{Axis, Chart, Figure, Height, Layer, Mark, Place};
use crate::drawing::{Colour, Dash, Stroke};
use serde_json::{json, Map, Value};

/// Widths up to which a line is thin on the page, and from which on it is strong, px.
const THIN_PX: f64 = 1.0;
const STRONG_PX: f64 = 2.0;

/// Title, caption and the first `count` charts of a figure.
pub(super) fn value(figure: &Figure, count: usize) -> Value {
    let charts: Vec<Value> = figure.charts.iter().take(count).map(chart).collect();
    json!({"name": figure.name, "title": figure.title, "caption": figure.caption, "charts": charts})
}

fn chart(chart: &Chart) -> Value {
    let [x_ends, y_ends] = chart.ends();
    let height = match chart.height {
        Height::Px(px) | Height::EqualScales(px) => px,
    };
    json!({
        "x": axis(&chart.x, x_ends),
        "y": axis(&chart.y, y_ends),
        "height": height,
        "layers": chart.layers.iter().filter_map(layer).collect::<Vec<_>>(),
    })
}

fn axis(axis: &Axis, ends: [f64; 2]) -> Value {
    let names = axis.names.iter().flatten();
    let names: Map<String, Value> = names
        .map(|(place, name)| (place.to_string(), name.as_str().into()))
        .collect();
    let names = (!names.is_empty()).then_some(names);
    json!({"label": axis.label, "unit": axis.unit, "range": ends, "step": axis.step, "names": names})
}

/// A layer as JSON; `None` for layers of areas, which the page draws as maps.
fn layer(layer: &Layer) -> Option<Value> {
    Some(match layer {
        Layer::Lines {
            name,
            lines,
            stroke,
        } => {
            json!({"lines": lines.iter().map(|line| places(line)).collect::<Vec<_>>(), "name": name, "style": style(*stroke)})
        }
        Layer::Marks {
            name,
            points,
            mark,
            colour,
            ..
        } => {
            let (sign, is_open) = sign(*mark);
            let style = format!("{}{}", role(*colour), if is_open { " open" } else { "" });
            json!({"points": places(points), "name": name, "sign": sign, "style": style})
        }
        Layer::Stems {
            points,
            mark,
            colour,
            ..
        } => {
            let (at, hints): (Vec<Place>, Vec<&str>) =
                points.iter().map(|(at, hint)| (*at, hint.as_str())).unzip();
            json!({"stems": places(&at), "hints": hints, "sign": sign(*mark).0, "style": role(*colour)})
        }
        Layer::Horizontals { at, stroke, .. } => json!({"levels": at, "style": style(*stroke)}),
        Layer::Verticals { name, at, stroke } => {
            json!({"verticals": at, "name": name, "style": style(*stroke)})
        }
        Layer::Words { at, text, .. } => json!({"words": text, "at": at}),
        _ => return None,
    })
}

fn places(places: &[Place]) -> Value {
    json!([0, 1].map(|which| f32s(places.iter().map(|place| place[which]))))
}

/// The page's name of a mark, and true for an outline.
fn sign(mark: Mark) -> (&'static str, bool) {
    match mark {
        Mark::Square | Mark::Diamond => ("square", false),
        Mark::Frame => ("square", true),
        Mark::Triangle => ("triangle", false),
        Mark::Inverted => ("down", false),
        Mark::Cross | Mark::Plus => ("cross", true),
        Mark::Bar => ("bar", true),
        Mark::Ring => ("dot", true),
        Mark::Dot => ("dot", false),
    }
}

/// Classes of a line in the page's style sheet.
fn style(stroke: Stroke) -> String {
    let dash = match stroke.dash {
        Dash::Solid => "",
        Dash::Dashed => " dashed",
        Dash::Dotted => " dotted",
    };
    let width = match stroke.width {
        width if width <= THIN_PX => " thin",
        width if width >= STRONG_PX => " strong",
        _ => "",
    };
    format!("{}{dash}{width}", role(stroke.colour))
}

fn role(colour: Colour) -> String {
    match colour {
        Colour::Series(number) => format!("drawn of-series-{number}"),
        Colour::Muted | Colour::Grid => "drawn of-muted".into(),
        Colour::Paper | Colour::Ink | Colour::Rgb(_) => "drawn of-ink".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_says_its_ends_its_roles_and_every_layer_of_lines_and_marks() {
        let line = Stroke::new(Colour::Series(1), 0.8).dashed(Dash::Dashed);
        let drawn = Chart::new(
            Axis::linear("Frequency", "Hz"),
            Axis::linear("Served", "%").range([0.0, 103.0]),
        )
        .line("hot", vec![[1.0, 2.0], [3.0, f64::NAN]], line)
        .marks("", vec![[2.0, 1.0]], Mark::Ring, Colour::Ink, 4.0);
        let figure = Figure {
            name: "n".into(),
            title: "t".into(),
            caption: "c".into(),
            width: 100.0,
            charts: vec![drawn.clone(), drawn],
        };
        let said = value(&figure, 1);
        assert_eq!(said["charts"].as_array().map(Vec::len), Some(1));
        let chart = &said["charts"][0];
        assert_eq!(chart["x"]["range"], json!([1.0, 3.0]));
        assert_eq!(chart["y"]["range"], json!([0.0, 103.0]));
        let [lines, marks] = [&chart["layers"][0], &chart["layers"][1]];
        assert_eq!(lines["style"], "drawn of-series-1 dashed thin");
        assert_eq!(lines["lines"][0][0], f32s([1.0, 3.0]));
        assert_eq!(
            [&marks["sign"], &marks["style"]],
            ["dot", "drawn of-ink open"]
        );
        assert!(marks["name"].is_null());
    }
}
