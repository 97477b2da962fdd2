//! The panel with its first hot zone, and the levels on hot and on cold ground.

use super::{hot_zone, mm, CHART_PX, WIDTH_PX};
use crate::scene::paper::PaperRun;
use chladni_frf::Dof;
use chladni_plate::Plate;
use chladni_render::{Evaluation, Ground};
use chladni_report::{Axis, Chart, Colour, Dash, Figure, Height, Layer, Mark, Place, Stroke};

/// Fig. 1: the panel, where it is driven and where it is measured.
pub(super) fn layout(run: &PaperRun, evaluation: &Evaluation) -> Figure {
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
    let corners = [
        [0.0, 0.0],
        [length_m, 0.0],
        [length_m, width_m],
        [0.0, width_m],
    ]
    .map(mm);
    let mut chart = Chart::new(Axis::linear("x", "mm"), Axis::linear("y", "mm"))
        .height(Height::EqualScales(CHART_PX * 3.0))
        .with(Layer::Outline {
            name: Some("edge of the panel".into()),
            points: corners.to_vec(),
            stroke: Stroke::new(Colour::Muted, 1.2),
            casing: false,
        });
    for outline in evaluation.zones.hot_outlines() {
        chart = chart.with(hot_zone("hot zone, quarter 1", outline));
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

/// Fig. 2: what is asked of the level on hot and on cold ground, and what drives make of
/// it.
pub(super) fn levels(drives: [(&str, &Evaluation); 2]) -> Figure {
    Figure {
        name: "paper-levels".into(),
        title: "What is asked of the level, and what is reached, quarter 1".into(),
        caption:
            "Hot ground is to lie 2 dB above the threshold or more, cold ground 2 dB below it \
                  or less."
                .into(),
        width: WIDTH_PX,
        charts: drives.map(level_chart).to_vec(),
    }
}

/// The levels of one drive, and what is asked.
fn level_chart((name, evaluation): (&str, &Evaluation)) -> Chart {
    let limits = evaluation.limits;
    let level = |v: f64| 20.0 * (v / limits.threshold_m_per_s).log10();
    let levels = |wanted: Ground| {
        let mut levels: Vec<f64> = speeds(evaluation, wanted).map(level).collect();
        levels.sort_by(|a, b| b.total_cmp(a));
        levels
    };
    let (hot, cold) = (levels(Ground::Hot), levels(Ground::Cold));
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
}

/// Peak velocities of the responses on one kind of ground, m/s.
fn speeds(evaluation: &Evaluation, wanted: Ground) -> impl Iterator<Item = f64> + '_ {
    let field = &evaluation.field;
    let on = field.velocity_m_per_s.iter().zip(&field.ground);
    on.filter(move |(_, ground)| **ground == wanted)
        .map(|(v, _)| v.norm())
}
