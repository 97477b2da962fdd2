//! The chart of error against time, with the Pareto front: the methods that no other
//! beats in both.

use crate::knobs::{Knob, Setting, KNOBS};
use crate::statistics::distinct;
use chladni_report::{
    Anchor, Axis, Chart, Colour, Dash, Height, Layer, Mark, Place, Stroke, SERIES,
};
use chladni_rfp::Method;

/// Width of the picture, px.
pub(crate) const WIDTH_PX: f64 = 720.0;
/// Height of the plotted box, px.
const HEIGHT_PX: f64 = 360.0;
/// Signs of series for methods; those of the curves follow them.
const ON_FRONT: usize = 0;
/// See [`ON_FRONT`].
const DEFAULT: usize = 1;
/// See [`ON_FRONT`].
const DOMINATED: usize = 2;
/// See [`ON_FRONT`].
const FIRST_OF_CURVES: usize = 3;
/// Distance of two names, part of the plotted box's height.
const NAME_STEP: f64 = 0.055;
/// From a mark to its name, part of the plotted box's width.
const NAME_GAP: f64 = 0.014;
/// Width of a letter of a name, part of the plotted box's width.
const LETTER: f64 = 0.0115;

/// True for each point that no other beats in one coordinate without losing in the other
/// (smaller is better; NaN never counts).
pub fn front(points: &[Place]) -> Vec<bool> {
    let beats = |a: &Place, b: &Place| a[0] <= b[0] && a[1] <= b[1] && a != b;
    points
        .iter()
        .map(|point| {
            point.iter().all(|v| v.is_finite()) && !points.iter().any(|other| beats(other, point))
        })
        .collect()
}

/// A method on a chart of error against time.
pub(crate) struct Entry {
    /// Seconds, error.
    pub(crate) at: Place,
    /// The text beside the mark.
    pub(crate) label: String,
    /// True for what runs unless told otherwise.
    pub(crate) default: bool,
}

/// A method as it is, or with one knob turned, on a chart.
pub(crate) struct Point {
    pub(crate) method: Method,
    pub(crate) setting: Option<Setting>,
    /// Seconds, error.
    pub(crate) at: Place,
}

/// Points joined by a line: one knob turned.
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<Place>,
}

/// Error against time: the front drawn and named, what it dominates in grey, the default
/// marked. `None` where nothing can be shown.
pub(crate) fn pareto_chart(
    x: Axis,
    y: Axis,
    entries: &[Entry],
    limits: Vec<(f64, Layer)>,
    curves: &[Curve],
) -> Option<Chart> {
    let shown: Vec<&Entry> = entries
        .iter()
        .filter(|entry| {
            entry
                .at
                .iter()
                .all(|value| value.is_finite() && *value > 0.0)
        })
        .collect();
    if shown.is_empty() {
        return None;
    }
    let points: Vec<Place> = shown.iter().map(|entry| entry.at).collect();
    let on_front = front(&points);
    let limits_at = limits.iter().map(|(at, _)| *at);
    let all = || {
        points
            .iter()
            .chain(curves.iter().flat_map(|curve| &curve.points))
            .filter(|p| p.iter().all(|v| *v > 0.0))
    };
    let ends = [
        window(all().map(|p| p[0])),
        window(all().map(|p| p[1]).chain(limits_at)),
    ];
    let mut chart = Chart::new(x.range(ends[0]), y.range(ends[1])).height(Height::Px(HEIGHT_PX));
    for (_, layer) in limits {
        chart = chart.with(layer);
    }
    chart = with_curves(with_front(chart, &points, &on_front), curves);
    chart = with_entries(chart, &shown, &on_front);
    Some(with_names(chart, &shown, curves, &on_front, ends))
}

fn with_front(chart: Chart, points: &[Place], on_front: &[bool]) -> Chart {
    let mut best: Vec<Place> = points
        .iter()
        .zip(on_front)
        .filter(|(_, on)| **on)
        .map(|(point, _)| *point)
        .collect();
    best.sort_by(|a, b| a[0].total_cmp(&b[0]));
    chart.line("Pareto front", best, Stroke::new(Colour::Series(0), 2.0))
}

/// A mark for each entry: on the front or not, the default or not.
fn with_entries(mut chart: Chart, shown: &[&Entry], on_front: &[bool]) -> Chart {
    let place = |on: bool, default: bool| {
        let wanted = |(k, entry): &(usize, &&Entry)| on_front[*k] == on && entry.default == default;
        shown
            .iter()
            .enumerate()
            .filter(wanted)
            .map(|(_, entry)| entry.at)
            .collect::<Vec<_>>()
    };
    for (name, on, mark, colour, size) in [
        ("on the front", true, ON_FRONT, Colour::Series(0), 10.0),
        ("dominated", false, DOMINATED, Colour::Muted, 9.0),
    ] {
        chart = chart.marks(name, place(on, false), Mark::of_series(mark), colour, size);
        let defaults = place(on, true);
        if !defaults.is_empty() {
            chart = chart.marks(
                &format!("default, {name}"),
                defaults,
                Mark::of_series(DEFAULT),
                colour,
                11.0,
            );
        }
    }
    chart
}

/// The name of each entry beside its mark, bold on the front.
fn with_names(
    chart: Chart,
    shown: &[&Entry],
    curves: &[Curve],
    on_front: &[bool],
    [x, y]: [[f64; 2]; 2],
) -> Chart {
    let points: Vec<Place> = shown.iter().map(|entry| entry.at).collect();
    let labels: Vec<String> = shown.iter().map(|entry| entry.label.clone()).collect();
    let others: Vec<Place> = curves
        .iter()
        .flat_map(|curve| curve.points.clone())
        .collect();
    let places = names(&points, &others, &labels, x, y);
    let mut chart = chart.with(ties(&places, &points));
    for ((text, (at, anchor)), &bold) in labels.into_iter().zip(places).zip(on_front) {
        chart = chart.with(Layer::Words {
            at,
            text,
            anchor,
            bold,
        });
    }
    chart
}

fn with_curves(mut chart: Chart, curves: &[Curve]) -> Chart {
    for (k, curve) in curves.iter().enumerate() {
        let colour = Colour::Series(1 + k as u8 % (SERIES - 1));
        let dash = [Dash::Dashed, Dash::Dotted][k % 2];
        let mark = Mark::of_series(FIRST_OF_CURVES + k);
        let stroke = Stroke::new(colour, 1.6).dashed(dash);
        chart = chart.line("", curve.points.clone(), stroke).marks(
            &curve.name,
            curve.points.clone(),
            mark,
            colour,
            7.0,
        );
    }
    chart
}

/// Lines from marks to their names, where these found no room at the height of the mark.
fn ties(places: &[(Place, Anchor)], points: &[Place]) -> Layer {
    let tied = places
        .iter()
        .zip(points)
        .filter(|((at, _), point)| (at[1] / point[1]).ln().abs() > 1e-9);
    Layer::Lines {
        name: None,
        lines: tied.map(|((at, _), point)| vec![*point, *at]).collect(),
        stroke: Stroke::new(Colour::Muted, 0.8),
    }
}

/// The curves of each method whose knobs were turned: one for each knob, through the
/// method as it is where that is one of the settings.
pub(crate) fn curves(points: &[Point]) -> Vec<Vec<Curve>> {
    let methods = distinct(points.iter().map(|point| point.method));
    let of_method = |method: Method| {
        let knobs = KNOBS.iter().filter(|knob| knob.method == method);
        knobs
            .filter_map(|knob| curve(points, knob))
            .collect::<Vec<Curve>>()
    };
    methods
        .into_iter()
        .map(of_method)
        .filter(|curves| !curves.is_empty())
        .collect()
}

/// One knob turned; `None` where it was not.
pub(crate) fn curve(points: &[Point], knob: &Knob) -> Option<Curve> {
    let own = || points.iter().filter(|point| point.method == knob.method);
    let mut places: Vec<(f64, Place)> = own()
        .filter_map(|point| Some((knob.position(point.setting?)?, point.at)))
        .collect();
    if places.is_empty() {
        return None;
    }
    let as_it_is = own().find(|point| point.setting.is_none());
    places.extend(as_it_is.map(|point| (knob.as_it_is, point.at)));
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    (places.len() > 1).then(|| Curve {
        name: format!("{}: {}", knob.method, knob.about),
        points: places.into_iter().map(|(_, place)| place).collect(),
    })
}

/// Method, and how its count of modes is wrong.
pub(crate) fn label(method: &str, missed: f64, spurious: f64) -> String {
    let words: Vec<String> = [(missed, "missed"), (spurious, "spurious")]
        .into_iter()
        .filter(|(count, _)| *count > 0.0)
        .map(|(count, word)| {
            format!(
                "{} {word}",
                if count >= 10.0 || count.fract() == 0.0 {
                    format!("{count:.0}")
                } else {
                    format!("{count:.2}")
                }
            )
        })
        .collect();
    match words.is_empty() {
        true => method.to_owned(),
        false => format!("{method} ({})", words.join(", ")),
    }
}

/// Ends of a logarithmic axis with room around the values.
fn window(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values.fold([f64::INFINITY, 0.0f64], |[low, high], value| {
        [low.min(value), high.max(value)]
    });
    let room = (high / low).powf(0.12).max(2.0);
    [low / room, high * room]
}

/// Places of the `labels` of `points`: beside their marks, clear of other names and marks
/// and of `others` where there is room.
fn names(
    points: &[Place],
    others: &[Place],
    labels: &[String],
    x: [f64; 2],
    y: [f64; 2],
) -> Vec<(Place, Anchor)> {
    let part = |value: f64, ends: [f64; 2]| (value / ends[0]).ln() / (ends[1] / ends[0]).ln();
    let value = |part: f64, ends: [f64; 2]| ends[0] * (ends[1] / ends[0]).powf(part);
    let mark = |point: &Place| [part(point[0], x), part(point[1], y)];
    let marks: Vec<Place> = points.iter().map(mark).collect();
    // taken stretches: left and right end, height, all as parts of the box
    let stretch = |[across, up]: Place| [across - 0.5 * NAME_GAP, across + 0.5 * NAME_GAP, up];
    let mut taken: Vec<[f64; 3]> = marks
        .iter()
        .copied()
        .chain(others.iter().map(mark))
        .map(stretch)
        .collect();
    let mut placed = Vec::new();
    for ([across, up], label) in marks.iter().zip(labels) {
        let width = LETTER * label.chars().count() as f64;
        let right = (
            Anchor::Start,
            [across + NAME_GAP, across + NAME_GAP + width],
        );
        let left = (Anchor::End, [across - NAME_GAP - width, across - NAME_GAP]);
        let heights =
            [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0].map(|steps| up + steps * NAME_STEP);
        let places = heights
            .iter()
            .flat_map(|&height| [right, left].map(|(anchor, ends)| (anchor, ends, height)));
        let free = |(_, [from, to], height): &(Anchor, [f64; 2], f64)| {
            let clear = |other: &[f64; 3]| {
                (other[2] - height).abs() >= NAME_STEP || other[1] <= *from || *to <= other[0]
            };
            *from >= 0.0
                && *to <= 1.0
                && (0.5 * NAME_STEP..=1.0 - 0.5 * NAME_STEP).contains(height)
                && taken.iter().all(clear)
        };
        let (anchor, [from, to], height) = places
            .into_iter()
            .find(free)
            .unwrap_or((right.0, right.1, *up));
        taken.push([from, to, height]);
        placed.push((
            [
                value(if anchor == Anchor::Start { from } else { to }, x),
                value(height, y),
            ],
            anchor,
        ));
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [
            [1.0, 10.0],
            [2.0, 5.0],
            [3.0, 5.0],
            [4.0, 1.0],
            [5.0, 2.0],
            [0.5, f64::NAN],
        ];
        assert_eq!(front(&points), [true, true, false, true, false, false]);
        assert_eq!(
            front(&[[1.0, 1.0], [1.0, 1.0]]),
            [true, true],
            "equals do not beat each other"
        );
    }

    #[test]
    fn names_stand_beside_their_marks_and_clear_of_each_other() {
        let labels = ["auto", "lean", "circle (7.00 missed)"].map(String::from);
        let placed = names(
            &[[1.0, 1.0], [1.1, 1.0], [90.0, 50.0]],
            &[],
            &labels,
            [0.5, 100.0],
            [0.5, 100.0],
        );
        let apart = (placed[1].0[1] / placed[0].0[1]).ln().abs() > 0.9 * NAME_STEP * 200f64.ln();
        assert!(apart || placed[0].1 != placed[1].1, "{placed:?}");
        assert_eq!(
            (placed[2].1, placed[2].0[1].round()),
            (Anchor::End, 50.0),
            "no room at the right, room at its own height"
        );
    }
}
