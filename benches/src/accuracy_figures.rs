//! The charts of `bench accuracy`: time of a fit against its error over the bound.

use crate::accuracy::AccuracyRow;
use crate::cases::Case;
use crate::knobs::FAMILY;
use crate::pareto::{curve, curves, label, pareto_chart, Entry, Point, WIDTH_PX};
use crate::peers::PeerRow;
use crate::solver::Solver;
use crate::statistics::{distinct, root_mean_square};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Layer, Place, Stroke};

/// One figure for each case with a bound: time of a fit against its error over the bound;
/// and one more where knobs were turned. `peers` stand beside our methods.
pub fn accuracy_figures(rows: &[AccuracyRow], peers: &[PeerRow]) -> Vec<Figure> {
    let names = distinct(rows.iter().map(|row| row.case.name));
    let of_case = |name: &str| {
        rows.iter()
            .filter(|row| row.case.name == name)
            .collect::<Vec<_>>()
    };
    names
        .into_iter()
        .flat_map(|name| {
            [
                figure(&of_case(name), peers, false),
                figure(&of_case(name), &[], true),
            ]
        })
        .flatten()
        .collect()
}

fn figure(rows: &[&AccuracyRow], peers: &[PeerRow], knobs: bool) -> Option<Figure> {
    let case: &Case = rows.first()?.case;
    let place = |row: &AccuracyRow| [row.time_s[0], row.with_missed];
    let entries = entries(rows, peers, place);
    let point = |row: &&AccuracyRow| Point {
        method: row.method,
        setting: row.setting,
        at: place(row),
    };
    let points: Vec<Point> = rows.iter().map(point).collect();
    let curves = if knobs {
        curves(&points)
    } else {
        vec![curve(&points, &FAMILY).into_iter().collect()]
    };
    let limits = limits(rows);
    let axes = || {
        [
            Axis::log("Time of a fit, median", "s"),
            Axis::log("Rms frequency error over the bound", "–"),
        ]
    };
    let charts = curves.iter().filter_map(|curves| {
        let [x, y] = axes();
        pareto_chart(x, y, &entries, limits.clone(), curves)
    });
    let charts: Vec<Chart> = charts.collect();
    if charts.is_empty() {
        return None;
    }
    let words = if knobs {
        " Dashed: one knob turned, from the least to the most."
    } else {
        ""
    };
    Some(Figure {
        name: format!(
            "accuracy-{}{}",
            case.name,
            if knobs { "-knobs" } else { "" }
        ),
        title: format!("Error against time: {}", case.name),
        caption: format!(
            "{}. Errors of natural frequencies over the Cramér–Rao bound of free \
                          residues; a missed mode counts as half its bandwidth. Lower left is \
                          better.{words}",
            case.about
        ),
        width: WIDTH_PX,
        charts,
    })
}

/// The methods as they are, and the other tools on the same case.
fn entries(
    rows: &[&AccuracyRow],
    peers: &[PeerRow],
    place: impl Fn(&AccuracyRow) -> Place,
) -> Vec<Entry> {
    let of_method = |row: &&AccuracyRow| {
        let [missed, sure, weak] = row.miscounts;
        Entry {
            at: place(row),
            label: label(&row.method.to_string(), missed, sure + weak),
            default: Solver::Identify(row.method).is_default(),
        }
    };
    let of_peer = |peer: &PeerRow| Entry {
        at: [peer.time_s, peer.with_missed],
        label: label(&peer.method, peer.missed, 0.0),
        default: false,
    };
    let case = rows.first().map(|row| row.case.name);
    let own = rows.iter().filter(|row| row.setting.is_none());
    let peers = peers.iter().filter(|peer| Some(peer.case.as_str()) == case);
    own.map(of_method).chain(peers.map(of_peer)).collect()
}

/// The Cramér-Rao bounds of a case, over the one of free residues.
fn limits(rows: &[&AccuracyRow]) -> Vec<(f64, Layer)> {
    let structured = root_mean_square(
        rows[0]
            .modes
            .iter()
            .map(|mode| mode.bound_real[0] / mode.bound[0]),
    );
    vec![
        (1.0, limit("bound of free residues", 1.0, Dash::Dashed)),
        (
            structured,
            limit("bound of real shapes", structured, Dash::Dotted),
        ),
    ]
}

/// A Cramér-Rao bound.
fn limit(name: &str, at: f64, dash: Dash) -> Layer {
    Layer::Horizontals {
        name: Some(name.into()),
        at: vec![at],
        stroke: Stroke::new(Colour::Ink, 1.4).dashed(dash),
    }
}
