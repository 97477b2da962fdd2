//! Charts of scenes: ground lost against time, and what each mode, residual term and
//! actuator buys.

use super::knobs::{SceneKnob, SCENE_KNOBS, SEARCHES};
use super::{Means, SceneRow};
use crate::pareto::{front, pareto_chart, Curve, Entry};
use crate::solver::Solver;
use crate::statistics::{distinct, mean};
use chladni_render::{Count, Effort, MethodChoice};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Height, Mark, Place, Stroke};

/// Width of a picture, px.
const WIDTH_PX: f64 = 720.0;
/// Height of a chart of means, px.
const CHART_PX: f64 = 120.0;
/// Ground lost that is drawn as nothing: half a place of the 4 mm grid.
const NOTHING_LOST: f64 = 1e-3;

/// For each scene one figure of its methods, and one more where the search for κ and
/// where means were turned.
pub fn scene_figures(rows: &[SceneRow]) -> Vec<Figure> {
    let names = distinct(rows.iter().map(|row| row.case.name));
    let of = |name: &str| {
        rows.iter()
            .filter(|row| row.case.name == name)
            .collect::<Vec<_>>()
    };
    names
        .into_iter()
        .flat_map(|name| {
            [
                methods(&of(name), false),
                methods(&of(name), true),
                means(&of(name)),
            ]
        })
        .flatten()
        .collect()
}

/// Time, and ground lost.
fn place(row: &SceneRow) -> Place {
    [
        row.drive.time_s[0],
        (1.0 - row.drive.window.least()).max(NOTHING_LOST),
    ]
}

/// The method by name that a word like `default` stood for in a row.
fn stands_for(row: &SceneRow) -> Option<&str> {
    matches!(row.asked, MethodChoice::Default | MethodChoice::Fast)
        .then_some(row.drive.method.as_str())
}

/// True for two rows of one method under its name and under a word: their times differ by
/// chance.
fn same_method(a: &SceneRow, b: &SceneRow) -> bool {
    let named = |word: &SceneRow, other: &SceneRow| {
        stands_for(word).is_some_and(|method| other.asked.to_string() == method)
    };
    a.case.name == b.case.name && a.means == b.means && (named(a, b) || named(b, a))
}

/// The place of a row with the mean time of all rows of its method.
fn common_place<'a>(row: &SceneRow, rows: impl Iterator<Item = &'a SceneRow>) -> Place {
    let times = rows
        .filter(|other| same_method(row, other))
        .map(|other| other.drive.time_s[0]);
    [mean(times.chain([row.drive.time_s[0]])), place(row)[1]]
}

/// True where no other method beats a row on its scene in time and ground together;
/// `None` where it turns a knob.
pub(crate) fn scenes_on_front(rows: &[SceneRow]) -> Vec<Option<bool>> {
    let takes_part = |row: &SceneRow| row.means.effort == Effort::default();
    let place = |row: &SceneRow| common_place(row, rows.iter());
    let on = |row: &SceneRow| {
        let others = rows
            .iter()
            .filter(|other| other.case.name == row.case.name && takes_part(other))
            .map(place);
        front(
            &std::iter::once(place(row))
                .chain(others)
                .collect::<Vec<_>>(),
        )[0]
    };
    rows.iter()
        .map(|row| takes_part(row).then(|| on(row)))
        .collect()
}

/// Ground lost against time of every method, or of the knobs of the search beside them.
fn methods(rows: &[&SceneRow], knobs: bool) -> Option<Figure> {
    let curves = if knobs { curves(rows) } else { Vec::new() };
    if knobs && curves.is_empty() {
        return None;
    }
    let whole: Vec<&&SceneRow> = rows
        .iter()
        .filter(|row| row.means == Means::default())
        .collect();
    // a method that also ran under a word stands there once
    let drawn = whole.iter().filter(|row| {
        stands_for(row).is_some() || !whole.iter().any(|other| same_method(row, other))
    });
    let entries: Vec<Entry> = drawn
        .map(|row| Entry {
            at: common_place(row, whole.iter().map(|row| **row)),
            label: stands_for(row).map_or_else(
                || row.asked.to_string(),
                |method| format!("{} ({method})", row.asked),
            ),
            default: Solver::Render(row.asked).is_default(),
        })
        .collect();
    let case = whole.first().filter(|_| knobs || entries.len() > 1)?.case;
    let words = if knobs {
        " Dashed: how far the largest κ is searched for."
    } else {
        ""
    };
    let axes = [
        Axis::log("Time of a rendering, median", "s"),
        Axis::log("Ground lost, the larger of hot and cold", "share"),
    ];
    let [x, y] = axes;
    Some(Figure {
        name: format!("scene-{}{}", case.name, if knobs { "-knobs" } else { "" }),
        title: format!("Ground lost against time: {}", case.name),
        caption: format!(
            "From 40 dB FRFs through the fit to the drive, judged on a 4 mm grid of the true \
             plate. Lower left is better.{words}"
        ),
        width: WIDTH_PX,
        charts: vec![pareto_chart(x, y, &entries, Vec::new(), &curves)?],
    })
}

/// One curve for each knob of the search, through the method as it is.
fn curves(rows: &[&SceneRow]) -> Vec<Curve> {
    let searched = || {
        rows.iter().filter(|row| {
            row.asked == SEARCHES
                && Means {
                    effort: Effort::default(),
                    ..row.means
                } == Means::default()
        })
    };
    if searched().all(|row| row.means.effort == Effort::default()) {
        return Vec::new();
    }
    let curve = |knob: &SceneKnob| {
        let mut points: Vec<(f64, Place)> = searched()
            .filter_map(|row| Some((knob.position(&row.means.effort)?, place(row))))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = format!("{SEARCHES}: {}", knob.about);
        (points.len() > 1).then(|| Curve {
            name,
            points: points.into_iter().map(|(_, point)| point).collect(),
        })
    };
    SCENE_KNOBS.iter().filter_map(curve).collect()
}

/// One thing that is turned: its axis, the number that a row has of it, and whether it is
/// the only thing turned in the row.
type Turned = (&'static str, fn(&SceneRow) -> f64, fn(&SceneRow) -> bool);

const TURNED: [Turned; 3] = [
    (
        "Explicit modes",
        |row| row.drive.modes as f64,
        |row| row.means.actuators == Count::All && row.means.residual_terms.is_none(),
    ),
    (
        "Actuators",
        |row| row.drive.actuators as f64,
        |row| row.means.modes == Count::All && row.means.residual_terms.is_none(),
    ),
    (
        "Residual terms",
        |row| row.drive.residual_terms as f64,
        |row| row.means.modes == Count::All && row.means.actuators == Count::All,
    ),
];

/// Two charts for each thing that was turned, for the first method with several settings.
fn means(rows: &[&SceneRow]) -> Option<Figure> {
    let method = rows
        .iter()
        .find(|row| rows.iter().filter(|other| other.asked == row.asked).count() > 1)?
        .asked;
    let own: Vec<&&SceneRow> = rows.iter().filter(|row| row.asked == method).collect();
    let charts: Vec<Chart> = TURNED
        .iter()
        .filter_map(|(name, count, only)| {
            let mut along: Vec<(f64, &SceneRow)> = own
                .iter()
                .filter(|row| only(row))
                .map(|row| (count(row), **row))
                .collect();
            along.sort_by(|a, b| a.0.total_cmp(&b.0));
            along.dedup_by(|a, b| a.0 == b.0);
            (along.len() > 1).then(|| charts(name, &along))
        })
        .flatten()
        .collect();
    (!charts.is_empty()).then(|| Figure {
        name: format!("scene-{}-means", rows[0].case.name),
        title: format!(
            "What each mode, residual term and actuator buys: {}, \
                        {method}",
            rows[0].case.name
        ),
        caption: "Shares on a 4 mm grid of the true plate; largest force, condition of the \
                  mobility and time over those with all."
            .into(),
        width: WIDTH_PX,
        charts,
    })
}

/// Charts of what is served, and of its cost over the cost with all means.
fn charts(name: &str, along: &[(f64, &SceneRow)]) -> [Chart; 2] {
    let x = || Axis::linear(name, "–").padded(0.03);
    [served(x(), along), cost(x(), along)]
}

fn curve(along: &[(f64, &SceneRow)], value: &dyn Fn(&SceneRow) -> f64) -> Vec<Place> {
    along
        .iter()
        .map(|(count, row)| [*count, value(row)])
        .collect()
}

fn served(x: Axis, along: &[(f64, &SceneRow)]) -> Chart {
    let least = curve(along, &|row| row.drive.window.least());
    Chart::new(
        x,
        Axis::linear("Share served", "–")
            .range([0.0, 1.05])
            .step(0.25),
    )
    .height(Height::Px(CHART_PX))
    .line(
        "ground, the smaller of hot and cold",
        least.clone(),
        Stroke::new(Colour::Series(0), 2.0),
    )
    .marks("", least, Mark::Dot, Colour::Series(0), 7.0)
    .line(
        "after drift, mean",
        curve(along, &|row| row.drive.drifted[0]),
        Stroke::new(Colour::Series(2), 1.6).dashed(Dash::Dashed),
    )
}

fn cost(x: Axis, along: &[(f64, &SceneRow)]) -> Chart {
    let last = along.last().map(|(_, row)| *row);
    let over = |value: fn(&SceneRow) -> f64| {
        curve(along, &|row| value(row) / last.map_or(f64::NAN, value))
    };
    Chart::new(x, Axis::log("Over that with all", "–").padded(0.1))
        .height(Height::Px(CHART_PX))
        .line(
            "largest force",
            over(|row| row.drive.max_force_n),
            Stroke::new(Colour::Series(1), 1.6),
        )
        .marks(
            "",
            over(|row| row.drive.max_force_n),
            Mark::Square,
            Colour::Series(1),
            6.0,
        )
        .line(
            "condition",
            over(|row| row.drive.condition),
            Stroke::new(Colour::Ink, 1.4).dashed(Dash::Dotted),
        )
        .line(
            "time",
            over(|row| row.drive.time_s[0]),
            Stroke::new(Colour::Muted, 1.4),
        )
        .marks(
            "",
            over(|row| row.drive.time_s[0]),
            Mark::Triangle,
            Colour::Muted,
            6.0,
        )
}
