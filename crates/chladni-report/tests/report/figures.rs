//! Figures and the files that they are drawn into.

use crate::inputs::{f32s, input, rendering, scene, small, ALL_FORMATS};
use chladni_render::{stress, sweep, StressOptions};
use chladni_report::{
    charts, data, figures, CurvePoint, Curves, Figure, Layer, ReportInput, Table,
};
use serde_json::Value;
use std::sync::OnceLock;

#[test]
fn chart_files_are_sound_and_have_their_own_names() {
    let mut model = small().truth.clone();
    model.modes.truncate(3);
    let rendering = rendering(&model);
    let files = charts(&input(&model, Some(&small().frf), &rendering), ALL_FORMATS).unwrap();
    let of = |ending: &str| {
        let files = files.iter().filter(|file| file.0.ends_with(ending));
        files.collect::<Vec<_>>()
    };
    let (pngs, svgs, gifs) = (of(".png"), of(".svg"), of(".gif"));
    assert_eq!((pngs.len(), svgs.len(), gifs.len()), (25, 25, 4));
    for (name, bytes) in gifs {
        assert!(
            bytes.starts_with(b"GIF89a") && bytes.ends_with(b"\x3b"),
            "{name}"
        );
    }
    for (name, bytes) in pngs {
        assert!(
            bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82"),
            "{name}"
        );
    }
    for (name, bytes) in svgs {
        let text = std::str::from_utf8(bytes).unwrap();
        assert!(
            text.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\"")
                && text.ends_with("</svg>\n"),
            "{name}"
        );
        let drawn = |line: &&str| !line.starts_with("<image");
        assert!(
            text.lines()
                .filter(drawn)
                .all(|line| !line.contains("NaN") && !line.contains("inf,")),
            "{name}"
        );
    }
    let names: std::collections::BTreeSet<&String> = files.iter().map(|file| &file.0).collect();
    assert_eq!(names.len(), files.len());
}

/// Data and figures of a report that has all of them.
struct Everything {
    data: Value,
    figures: Vec<Figure>,
}

fn everything() -> &'static Everything {
    static EVERYTHING: OnceLock<Everything> = OnceLock::new();
    EVERYTHING.get_or_init(|| {
        let truth = &small().truth;
        let mut rendering = rendering(truth);
        let options = StressOptions {
            draws: 5,
            ..Default::default()
        };
        let (rows, _) = stress(&rendering.weights, &scene(), truth, &options).unwrap();
        rendering.weights.stress = Some(rows);
        let swept = sweep(truth, &scene(), &Default::default(), [295.0, 305.0]).unwrap();
        rendering.weights.sweep = Some(swept);
        let header = ["case", "method", "time_s", "frequency_rmse_over_crlb"]
            .map(String::from)
            .to_vec();
        let rows = vec![["panel", "auto", "1.5", "1.02"].map(String::from).to_vec()];
        let tables = vec![Table {
            name: "accuracy.csv".into(),
            header,
            rows,
        }];
        let points = [(1, 0.2), (2, 0.9)].map(|(count, ratio)| CurvePoint {
            count,
            hot_ratio: ratio,
            cold_ratio: ratio,
            success_ratio: ratio,
        });
        let curves = Curves {
            method: "fast".into(),
            modes: points.to_vec(),
            actuators: points.to_vec(),
        };
        let mut input = ReportInput {
            tables,
            ..input(truth, Some(&small().frf), &rendering)
        };
        input.scenes = input
            .scenes
            .into_iter()
            .map(|scene| scene.with_curves(Some(&curves)))
            .collect();
        Everything {
            data: data(&input).unwrap(),
            figures: figures(&input).unwrap(),
        }
    })
}

#[test]
fn both_kinds_of_ground_are_served_by_as_much_as_the_curve_says() {
    let shown = &everything().data;
    let layers = shown["scenes"][0]["curves"][0]["charts"][0]["layers"].as_array();
    let both = layers.unwrap().iter().find(|layer| layer["name"] == "both");
    assert_eq!(f32s(&both.unwrap()["lines"][0][1])[1], 90.0);
}

#[test]
fn the_stabilization_diagram_has_the_order_on_the_right() {
    let figures = &everything().figures;
    let diagram = figures
        .iter()
        .find(|figure| figure.name == "stabilization")
        .unwrap();
    assert_eq!(
        diagram.charts[0]
            .right
            .as_ref()
            .map(|right| right.axis.label.as_str()),
        Some("Order of the denominator")
    );
}

#[test]
fn a_report_with_everything_has_every_figure() {
    let figures = &everything().figures;
    for name in [
        "frf-sum",
        "frf-12",
        "cmif",
        "stabilization",
        "poles",
        "auto-mac",
        "mode-01",
        "complexity",
        "zones-1",
        "field-1",
        "fewer-modes-1",
        "fewer-actuators-1",
        "weights-1-panel",
        "weights-1-list",
        "sweep-1",
        "stress-1",
        "speed-1",
    ] {
        assert!(figures.iter().any(|figure| figure.name == name), "{name}");
    }
}

#[test]
fn every_axis_of_every_figure_has_a_label_and_a_unit() {
    for figure in &everything().figures {
        assert!(!figure.title.is_empty(), "{}", figure.name);
        for chart in &figure.charts {
            let right = chart.right.as_ref().map(|right| &right.axis);
            for axis in [&chart.x, &chart.y]
                .into_iter()
                .chain(right)
                .chain(chart.colour_bar.as_ref().map(|bar| &bar.axis))
            {
                assert!(
                    !axis.label.is_empty() && !axis.unit.is_empty(),
                    "{}: {axis:?}",
                    figure.name
                );
            }
        }
    }
}

#[test]
fn the_words_of_a_trial_stand_off_its_marks() {
    let figures = &everything().figures;
    let figure = figures
        .iter()
        .find(|figure| figure.name == "stress-1")
        .unwrap();
    let mut words = 0;
    for layer in &figure.charts[0].layers {
        if let Layer::Words { at, .. } = layer {
            words += 1;
            assert!(
                (at[1] - at[1].round()).abs() > 0.3,
                "{at:?}: marks stand at whole numbers"
            );
        }
    }
    assert!(words > 0);
}
