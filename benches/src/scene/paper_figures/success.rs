//! Success over the number of modes and over the place of the hot zone.

use super::{CHART_PX, WIDTH_PX};
use crate::scene::paper::{places, PaperModes, PaperRow, PaperRun, PAPER_CUTS, PAPER_MODES};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Height, Layer, Mark, Place, Stroke};

/// Success that the paper states, of its own rig.
const STATED: f64 = 0.902;
/// Range of the axis of shares.
const SHARES: [f64; 2] = [0.0, 1.04];

/// Share served over the number of modes, exact and fitted, and what the drive costs.
pub(super) fn over_modes(run: &PaperRun, ours: &PaperRow) -> Figure {
    let curve =
        |modes_of, value: &dyn Fn(&PaperRow) -> f64| curve(run, ours, (modes_of, None), value);
    let two = |chart: Chart, value: &dyn Fn(&PaperRow) -> f64| {
        let of_modes = |modes_of| curve(modes_of, value);
        with_both(chart, [PaperModes::Exact, PaperModes::Fitted].map(of_modes))
    };
    let force = |row: &PaperRow| row.weights.indices.points.max_force_n.unwrap_or(f64::NAN);
    let cost = |label: &str, unit: &str| {
        Chart::new(modes_axis(), Axis::log(label, unit).padded(0.05)).height(Height::Px(CHART_PX))
    };
    let of_default = level(
        "default method",
        force(ours),
        Stroke::new(Colour::Series(2), 2.4),
    );
    let condition = |row: &PaperRow| row.steps().map_or(f64::NAN, |steps| steps.psi.condition());
    Figure {
        name: "paper-modes".into(),
        title: "Responses served by the two steps over the number of modes, quarter 1".into(),
        caption: "Exact modes are those of the plate, three of them of the rigid body; fitted \
                  ones come from FRFs with 40 dB of noise. The condition of Ψ is infinite, and \
                  not drawn, where its rank is short."
            .into(),
        width: WIDTH_PX,
        charts: vec![
            shares(run, ours, PaperModes::Exact),
            shares(run, ours, PaperModes::Fitted),
            two(cost("Largest force", "N").with(of_default), &force),
            two(cost("Condition of Ψ", "–"), &condition),
        ],
    }
}

/// Share served over the number of modes.
fn shares(run: &PaperRun, ours: &PaperRow, modes_of: PaperModes) -> Chart {
    let total = |row: &PaperRow| row.points.total;
    let with_cut = curve(run, ours, (modes_of, Some(PAPER_CUTS[1])), &total);
    let curve = |value: &dyn Fn(&PaperRow) -> f64| curve(run, ours, (modes_of, None), value);
    let label = format!("Share, {} modes", modes_of.as_str());
    let both = curve(&total);
    let alone = curve(&|row| row.alone.map_or(f64::NAN, |alone| alone.success_ratio));
    Chart::new(
        modes_axis(),
        Axis::linear(&label, "–").range(SHARES).step(0.25),
    )
    .height(Height::Px(1.3 * CHART_PX))
    .with(level(
        "default method",
        ours.points.total,
        Stroke::new(Colour::Series(2), 2.4),
    ))
    .with(level(
        "stated in the paper",
        STATED,
        Stroke::new(Colour::Muted, 1.6).dashed(Dash::Dashed),
    ))
    .with(level(
        "silence",
        ours.weights.indices.points.silence_ratio,
        Stroke::new(Colour::Muted, 1.6).dashed(Dash::Dotted),
    ))
    .line(
        "hot",
        curve(&|row| row.points.hot),
        Stroke::new(Colour::Series(1), 1.6),
    )
    .line(
        "cold",
        curve(&|row| row.points.cold),
        Stroke::new(Colour::Series(0), 1.6).dashed(Dash::Dashed),
    )
    .line("", alone.clone(), Stroke::new(Colour::Series(4), 1.2))
    .marks(
        "both, were there no other modes",
        alone,
        Mark::Ring,
        Colour::Series(4),
        6.0,
    )
    .line(
        "both, the two steps as one with a cut",
        with_cut,
        Stroke::new(Colour::Ink, 1.6).dashed(Dash::Dotted),
    )
    .line("both", both.clone(), Stroke::new(Colour::Ink, 2.0))
    .marks("", both, Mark::Dot, Colour::Ink, 4.0)
}

fn modes_axis() -> Axis {
    Axis::linear("Modes summed, from the lowest", "number")
        .range([0.0, PAPER_MODES as f64 + 1.0])
        .step(2.0)
}

fn level(name: &str, value: f64, stroke: Stroke) -> Layer {
    Layer::Horizontals {
        name: Some(name.into()),
        at: vec![value],
        stroke,
    }
}

/// A value of the two steps at the place of `ours` over the number of modes, with these
/// modes and this cut.
fn curve(
    run: &PaperRun,
    ours: &PaperRow,
    (modes_of, cut): (PaperModes, Option<f64>),
    value: &dyn Fn(&PaperRow) -> f64,
) -> Vec<Place> {
    let rows = run
        .two_steps(ours.case.name, modes_of, cut)
        .filter(|row| row.weights.modes_used <= PAPER_MODES);
    rows.map(|row| [row.weights.modes_used as f64, value(row)])
        .collect()
}

/// Curves of exact and of fitted modes.
fn with_both(chart: Chart, [exact, fitted]: [Vec<Place>; 2]) -> Chart {
    let dashed = Stroke::new(Colour::Series(1), 1.6).dashed(Dash::Dashed);
    chart
        .line("exact modes", exact.clone(), Stroke::new(Colour::Ink, 1.6))
        .marks("", exact, Mark::Dot, Colour::Ink, 5.0)
        .line("fitted modes", fitted.clone(), dashed)
        .marks("", fitted, Mark::Square, Colour::Series(1), 5.0)
}

/// A place of the hot zone, and its rows: two steps with exact modes, with fitted ones,
/// the default method, both steps as one.
type PlaceRows<'a> = (f64, [Option<&'a PaperRow>; 4]);

/// All places with their names.
fn at_places(run: &PaperRun) -> (Vec<(f64, String)>, Vec<PlaceRows<'_>>) {
    let mut names: Vec<(f64, String)> = Vec::new();
    let mut rows: Vec<PlaceRows<'_>> = Vec::new();
    for case in places() {
        // a gap between quarters and ninths
        let at = (rows.len() + 1 + usize::from(case.grid != [2, 2])) as f64;
        names.push((at, format!("{}/{}", case.hot, case.grid[0] * case.grid[1])));
        let paper = |modes_of, cut| {
            run.two_steps(case.name, modes_of, cut)
                .find(|row| row.weights.modes_used == PAPER_MODES)
        };
        let of_case = [
            paper(PaperModes::Exact, None),
            paper(PaperModes::Fitted, None),
            run.ours(case.name),
            paper(PaperModes::Fitted, Some(PAPER_CUTS[1])),
        ];
        rows.push((at, of_case));
    }
    (names, rows)
}

/// Share served at every place of the hot zone.
pub(super) fn over_places(run: &PaperRun) -> Figure {
    let (names, rows) = at_places(run);
    let chart = |label: &str, share: fn(&PaperRow) -> f64| {
        with_places(place_chart(label, &names, &rows), &rows, share)
    };
    let both = with_silence(place_chart("Both", &names, &rows), &rows);
    Figure {
        name: "paper-places".into(),
        title: "Responses served over the place of the hot zone".into(),
        caption: "Four quarters, then nine ninths of the panel. By its symmetry the exact panel \
                  has one kind of quarter and four kinds of ninths."
            .into(),
        width: WIDTH_PX,
        charts: vec![
            with_places(both, &rows, |row| row.points.total),
            chart("Hot", |row| row.points.hot),
            chart("Cold", |row| row.points.cold),
        ],
    }
}

/// An empty chart over the places.
fn place_chart(label: &str, names: &[(f64, String)], rows: &[PlaceRows]) -> Chart {
    let last = rows.last().map_or(0.0, |row| row.0);
    let x = Axis::linear("Place of the hot zone, cell/cells", "row by row")
        .range([0.0, last + 1.0])
        .names(names.to_vec());
    let y = Axis::linear(label, "–").range([-0.04, 1.06]).step(0.25);
    Chart::new(x, y).height(Height::Px(CHART_PX))
}

/// A value of the rows of one kind over the places.
fn over(rows: &[PlaceRows], which: usize, value: fn(&PaperRow) -> f64) -> Vec<Place> {
    rows.iter()
        .filter_map(|(at, all)| Some([*at, value(all[which]?)]))
        .collect()
}

/// The share that the paper states, and that of silence.
fn with_silence(chart: Chart, rows: &[PlaceRows]) -> Chart {
    let stroke = Stroke::new(Colour::Muted, 1.6).dashed(Dash::Dashed);
    chart
        .with(level("stated in the paper, quarter 1", STATED, stroke))
        .marks(
            "silence",
            over(rows, 2, |row| row.weights.indices.points.silence_ratio),
            Mark::Bar,
            Colour::Muted,
            9.0,
        )
}

/// The share of each kind of rows.
fn with_places(mut chart: Chart, rows: &[PlaceRows], share: fn(&PaperRow) -> f64) -> Chart {
    for (name, which, mark, colour, size) in [
        (
            "two steps, 34 exact modes",
            0,
            Mark::Ring,
            Colour::Ink,
            11.0,
        ),
        (
            "two steps, 34 fitted modes",
            1,
            Mark::Cross,
            Colour::Series(1),
            8.0,
        ),
        (
            "both as one with a cut, 34 fitted modes",
            3,
            Mark::Diamond,
            Colour::Series(2),
            8.0,
        ),
        ("default method", 2, Mark::Triangle, Colour::Series(0), 8.0),
    ] {
        chart = chart.marks(name, over(rows, which, share), mark, colour, size);
    }
    chart
}
