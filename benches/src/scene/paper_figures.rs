//! The figures of the seed paper, drawn from its reproduction, and its success over modes
//! and places.

use super::paper::{places, PaperModes, PaperRow, PaperRun, PAPER_CUTS, PAPER_MODES};
use chladni_frf::{ComplexVector, Dof, Result};
use chladni_plate::Plate;
use chladni_render::{Evaluation, Ground};
use chladni_report::{
    field_map, weights_around_edge, Axis, Chart, Colour, Dash, Figure, Height, Layer, Mark, Place,
    RenderedScene, Stroke,
};

/// Width of a picture, px.
const WIDTH_PX: f64 = 760.0;
/// Height of a chart, px.
const CHART_PX: f64 = 130.0;
/// Success that the paper states, of its own rig.
const STATED: f64 = 0.902;
/// Range of the axis of shares.
const SHARES: [f64; 2] = [0.0, 1.04];

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
    let mut figures = vec![layout(run, &of_paper)];
    figures.extend(coefficients(paper));
    figures.extend(weightings(run, paper, &of_paper));
    figures.push(levels([
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
    figures.push(over_modes(run, ours));
    figures.push(over_places(run));
    Ok(figures)
}

/// Fig. 3a: |W_n| and its phase.
fn coefficients(row: &PaperRow) -> Option<Figure> {
    let steps = row.steps()?;
    let x = || {
        Axis::linear("Mode, by rising natural frequency", "number")
            .range([0.0, steps.frequency_hz.len() as f64 + 1.0])
            .step(2.0)
    };
    let points =
        |values: &ComplexVector, of: fn(num_complex::Complex64) -> f64| -> Vec<(Place, String)> {
            let all = values.0.iter().zip(&steps.frequency_hz).enumerate();
            all.map(|(n, (&value, hz))| {
                (
                    [n as f64 + 1.0, of(value)],
                    format!(
                        "{hz:.1} Hz: {:.3e} N/√kg, {:.0}°",
                        value.norm(),
                        degrees(value)
                    ),
                )
            })
            .collect()
        };
    let bare = |values: &ComplexVector, of| {
        points(values, of)
            .into_iter()
            .map(|(place, _)| place)
            .collect::<Vec<_>>()
    };
    let chart = |y: Axis, of: fn(num_complex::Complex64) -> f64| {
        let asked = Layer::Stems {
            name: Some("asked of the mode".into()),
            points: points(&steps.asked, of),
            mark: Mark::Dot,
            colour: Colour::Series(0),
        };
        Chart::new(x(), y)
            .height(Height::Px(1.4 * CHART_PX))
            .with(asked)
            .marks(
                "given by the actuators",
                bare(&steps.driven, of),
                Mark::Ring,
                Colour::Series(1),
                10.0,
            )
    };
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
            chart(Axis::log("Amplitude", "N/√kg").padded(0.06), |value| {
                value.norm()
            }),
            chart(
                Axis::linear("Phase", "degrees")
                    .range([-190.0, 190.0])
                    .step(90.0),
                degrees,
            ),
        ],
    })
}

fn degrees(value: num_complex::Complex64) -> f64 {
    value.arg().to_degrees()
}

/// Fig. 1: the panel, where it is driven and where it is measured.
fn layout(run: &PaperRun, evaluation: &Evaluation) -> Figure {
    let mm = |place: [f64; 2]| place.map(|metres| 1e3 * metres);
    let places = |dofs: &[Dof]| -> Vec<Place> {
        let node = |dof: &Dof| run.exact.nodes.iter().find(|node| node.label == dof.node);
        let known = dofs.iter().filter_map(node);
        known
            .map(|node| mm([node.xyz_m[0], node.xyz_m[1]]))
            .collect()
    };
    let Plate {
        length_m, width_m, ..
    } = Plate::default();
    let outline = |name: &str, points: Vec<Place>, stroke: Stroke| Layer::Outline {
        name: Some(name.into()),
        points,
        stroke,
        casing: false,
    };
    let corners = [
        [0.0, 0.0],
        [length_m, 0.0],
        [length_m, width_m],
        [0.0, width_m],
    ]
    .map(mm);
    let mut chart = Chart::new(Axis::linear("x", "mm"), Axis::linear("y", "mm"))
        .height(Height::EqualScales(CHART_PX * 3.0))
        .with(outline(
            "edge of the panel",
            corners.to_vec(),
            Stroke::new(Colour::Muted, 1.2),
        ));
    for hot in evaluation.zones.hot_outlines() {
        let points = hot.iter().map(|&place| mm(place)).collect();
        let stroke = Stroke::new(Colour::Rgb([200, 30, 30]), 2.4);
        chart = chart.with(outline("hot zone, quarter 1", points, stroke));
    }
    let chart = chart
        .marks(
            "34 actuators",
            places(&run.exact.references),
            Mark::Square,
            Colour::Ink,
            7.0,
        )
        .marks(
            "77 responses",
            places(&run.exact.responses),
            Mark::Ring,
            Colour::Series(0),
            5.0,
        );
    Figure {
        name: "paper-layout".into(),
        title: "Layout of the panel".into(),
        caption: "As in Fig. 1 of the paper: 34 actuators along the edge, 20 mm apart; the \
                  distance from the edge, 5 mm, is a guess. Responses stand on a grid of 20 mm."
            .into(),
        width: WIDTH_PX,
        charts: vec![chart],
    }
}

/// Fig. 3b: weights around the edge, and the hot zone.
fn weightings(run: &PaperRun, row: &PaperRow, evaluation: &Evaluation) -> Option<Figure> {
    let mut figure = weights_around_edge(&row.weights, &run.exact, 1)?;
    for outline in evaluation.zones.hot_outlines() {
        let points = outline
            .iter()
            .map(|place| place.map(|metres| 1e3 * metres))
            .collect();
        let stroke = Stroke::new(Colour::Rgb([200, 30, 30]), 2.4);
        figure.charts[0].layers.insert(
            0,
            Layer::Outline {
                name: Some("hot zone".into()),
                points,
                stroke,
                casing: false,
            },
        );
    }
    Some(Figure {
        name: "paper-weightings".into(),
        ..figure
    })
}

/// Fig. 2: what is asked of the level on hot and on cold ground, and what drives make of
/// it.
fn levels(drives: [(&str, &Evaluation); 2]) -> Figure {
    let chart = |(name, evaluation): (&str, &Evaluation)| {
        let limits = evaluation.limits;
        let level = |v: f64| 20.0 * (v / limits.threshold_m_per_s).log10();
        let sorted = |wanted: Ground| {
            let field = &evaluation.field;
            let on = field
                .velocity_m_per_s
                .iter()
                .zip(&field.ground)
                .filter(|(_, ground)| **ground == wanted);
            let mut levels: Vec<f64> = on.map(|(v, _)| level(v.norm())).collect();
            levels.sort_by(|a, b| b.total_cmp(a));
            levels
        };
        let (hot, cold) = (sorted(Ground::Hot), sorted(Ground::Cold));
        let (count, all) = (hot.len() as f64, (hot.len() + cold.len()) as f64);
        let along = |levels: &[f64], after: f64| {
            levels
                .iter()
                .enumerate()
                .map(|(k, &y)| [after + k as f64 + 1.0, y])
                .collect::<Vec<Place>>()
        };
        let target = |ends: [f64; 2], limit: f64| ends.map(|x| [x, level(limit)]).to_vec();
        let at_least = Stroke::new(Colour::Ink, 2.0);
        Chart::new(
            Axis::linear(
                "Judged response, hot ones first, by falling level",
                "number",
            )
            .range([0.0, all + 1.0]),
            Axis::linear(&format!("Level, {name}"), "dB re threshold").padded(0.06),
        )
        .height(Height::Px(1.6 * CHART_PX))
        .line(
            "hot: at least",
            target([0.5, count + 0.5], limits.hot_m_per_s),
            at_least,
        )
        .line(
            "cold: at most",
            target([count + 0.5, all + 0.5], limits.cold_m_per_s),
            at_least.dashed(Dash::Dashed),
        )
        .with(Layer::Horizontals {
            name: Some("threshold of touch".into()),
            at: vec![0.0],
            stroke: Stroke::new(Colour::Muted, 1.2).dashed(Dash::Dotted),
        })
        .marks(
            "hot response",
            along(&hot, 0.0),
            Mark::Triangle,
            Colour::Series(1),
            7.0,
        )
        .marks(
            "cold response",
            along(&cold, count),
            Mark::Ring,
            Colour::Series(0),
            6.0,
        )
    };
    Figure {
        name: "paper-levels".into(),
        title: "What is asked of the level, and what is reached, quarter 1".into(),
        caption:
            "Hot ground is to lie 2 dB above the threshold or more, cold ground 2 dB below it \
                  or less."
                .into(),
        width: WIDTH_PX,
        charts: drives.map(chart).to_vec(),
    }
}

/// Share served over the number of modes, exact and fitted, and what the drive costs.
fn over_modes(run: &PaperRun, ours: &PaperRow) -> Figure {
    let name = ours.case.name;
    let x = || {
        Axis::linear("Modes summed, from the lowest", "number")
            .range([0.0, PAPER_MODES as f64 + 1.0])
            .step(2.0)
    };
    let curve_of = |modes_of, cut, value: &dyn Fn(&PaperRow) -> f64| -> Vec<Place> {
        let rows = run
            .two_steps(name, modes_of, cut)
            .filter(|row| row.weights.modes_used <= PAPER_MODES);
        rows.map(|row| [row.weights.modes_used as f64, value(row)])
            .collect()
    };
    let curve = |modes_of, value: &dyn Fn(&PaperRow) -> f64| curve_of(modes_of, None, value);
    let level = |name: &str, value: f64, stroke: Stroke| Layer::Horizontals {
        name: Some(name.into()),
        at: vec![value],
        stroke,
    };
    let shares = |modes_of: PaperModes| {
        let label = format!("Share, {} modes", modes_of.as_str());
        let both = curve(modes_of, &|row| row.points.total);
        let alone = curve(modes_of, &|row| {
            row.alone.map_or(f64::NAN, |alone| alone.success_ratio)
        });
        Chart::new(x(), Axis::linear(&label, "–").range(SHARES).step(0.25))
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
                curve(modes_of, &|row| row.points.hot),
                Stroke::new(Colour::Series(1), 1.6),
            )
            .line(
                "cold",
                curve(modes_of, &|row| row.points.cold),
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
                curve_of(modes_of, Some(PAPER_CUTS[1]), &|row| row.points.total),
                Stroke::new(Colour::Ink, 1.6).dashed(Dash::Dotted),
            )
            .line("both", both.clone(), Stroke::new(Colour::Ink, 2.0))
            .marks("", both, Mark::Dot, Colour::Ink, 4.0)
    };
    let two = |chart: Chart, value: &dyn Fn(&PaperRow) -> f64| {
        let of_modes = |modes_of| curve(modes_of, value);
        with_both(chart, [PaperModes::Exact, PaperModes::Fitted].map(of_modes))
    };
    let force = |row: &PaperRow| row.weights.indices.points.max_force_n.unwrap_or(f64::NAN);
    let cost = |label: &str, unit: &str| {
        Chart::new(x(), Axis::log(label, unit).padded(0.05)).height(Height::Px(CHART_PX))
    };
    Figure {
        name: "paper-modes".into(),
        title: "Responses served by the two steps over the number of modes, quarter 1".into(),
        caption: "Exact modes are those of the plate, three of them of the rigid body; fitted ones come from FRFs with 40 dB of noise. The condition of Ψ is \
                  infinite, and not drawn, where its rank is short."
            .into(),
        width: WIDTH_PX,
        charts: vec![
            shares(PaperModes::Exact),
            shares(PaperModes::Fitted),
            two(cost("Largest force", "N").with(level("default method", force(ours), Stroke::new(Colour::Series(2), 2.4))), &force),
            two(cost("Condition of Ψ", "–"), &|row| row.steps().map_or(f64::NAN, |steps| steps.psi.condition())),
        ],
    }
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
fn over_places(run: &PaperRun) -> Figure {
    let (names, rows) = at_places(run);
    let last = rows.last().map_or(0.0, |row| row.0);
    let chart = |label: &str, share: fn(&PaperRow) -> f64, silence: bool| {
        let x = Axis::linear("Place of the hot zone, cell/cells", "row by row")
            .range([0.0, last + 1.0])
            .names(names.clone());
        let points = |which: usize, of: &dyn Fn(&PaperRow) -> f64| {
            rows.iter()
                .filter_map(|(at, all)| Some([*at, of(all[which]?)]))
                .collect::<Vec<Place>>()
        };
        let mut chart = Chart::new(x, Axis::linear(label, "–").range([-0.04, 1.06]).step(0.25))
            .height(Height::Px(CHART_PX));
        if silence {
            chart = chart
                .with(Layer::Horizontals {
                    name: Some("stated in the paper, quarter 1".into()),
                    at: vec![STATED],
                    stroke: Stroke::new(Colour::Muted, 1.6).dashed(Dash::Dashed),
                })
                .marks(
                    "silence",
                    points(2, &|row| row.weights.indices.points.silence_ratio),
                    Mark::Bar,
                    Colour::Muted,
                    9.0,
                );
        }
        chart
            .marks(
                "two steps, 34 exact modes",
                points(0, &share),
                Mark::Ring,
                Colour::Ink,
                11.0,
            )
            .marks(
                "two steps, 34 fitted modes",
                points(1, &share),
                Mark::Cross,
                Colour::Series(1),
                8.0,
            )
            .marks(
                "both as one with a cut, 34 fitted modes",
                points(3, &share),
                Mark::Diamond,
                Colour::Series(2),
                8.0,
            )
            .marks(
                "default method",
                points(2, &share),
                Mark::Triangle,
                Colour::Series(0),
                8.0,
            )
    };
    Figure {
        name: "paper-places".into(),
        title: "Responses served over the place of the hot zone".into(),
        caption: "Four quarters, then nine ninths of the panel. By its symmetry the exact panel \
                  has one kind of quarter and four kinds of ninths."
            .into(),
        width: WIDTH_PX,
        charts: vec![
            chart("Both", |row| row.points.total, true),
            chart("Hot", |row| row.points.hot, false),
            chart("Cold", |row| row.points.cold, false),
        ],
    }
}
