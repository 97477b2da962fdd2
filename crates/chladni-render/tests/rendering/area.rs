//! Between the responses: the interpolated field against the plate itself.

use crate::common::{cell_scene, true_area_field, truth};
use chladni_render::{render, Ground, Method, RenderOptions};

/// Rms of the interpolation error over the rms of the field, on the area grid.
fn relative_error(method: Method, frequency_hz: f64) -> f64 {
    let scene = chladni_render::Scene {
        frequency_hz,
        ..cell_scene([2, 2], 1, "")
    };
    let rendering = render(
        truth(),
        &scene,
        &RenderOptions {
            method: method.into(),
            ..Default::default()
        },
    )
    .unwrap();
    let exact = true_area_field(&rendering, frequency_hz);
    let area = rendering.area.unwrap();
    let error: f64 = exact
        .iter()
        .zip(&area.velocity_m_per_s)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    (error / exact.iter().map(|v| v.norm_sqr()).sum::<f64>()).sqrt()
}

#[test]
fn fields_at_an_eighth_of_a_wavelength_are_interpolated_to_a_percent_or_two() {
    for (method, bound) in [(Method::Mls, 0.01), (Method::PressureMatching, 0.02)] {
        let error = relative_error(method, 300.0);
        assert!(error < bound, "{method}: {error}");
    }
}

#[test]
fn the_grid_is_at_most_5_mm_and_ends_on_the_borders_of_the_area() {
    let rendering = render(truth(), &cell_scene([2, 2], 1, ""), &Default::default()).unwrap();
    let area = rendering.area.unwrap();
    for (axis, [start, stop]) in [(&area.x_m, [0.034, 0.234]), (&area.y_m, [0.025, 0.145])] {
        assert!((axis[0] - start).abs() < 1e-12 && (axis[axis.len() - 1] - stop).abs() < 1e-12);
        assert!(axis
            .windows(2)
            .all(|pair| pair[1] - pair[0] <= 0.005 * (1.0 + 1e-9)));
    }
    assert_eq!(area.ground.dim(), (25, 41));
    // Hot 34..124 × 25..75 mm: 19 × 11; not cold 34..139 × 25..90 mm: 22 × 14 (144 and 95
    // mm are judged).
    let count = |ground| area.ground.iter().filter(|&&g| g == ground).count();
    assert_eq!(
        (count(Ground::Hot), count(Ground::Cold)),
        (19 * 11, 41 * 25 - 22 * 14)
    );
}

#[test]
fn responses_on_one_line_carry_no_area() {
    let mut model = truth().clone();
    let row: Vec<u64> = (1..=11).collect();
    model
        .nodes
        .retain(|node| row.contains(&node.label) || node.label > 100);
    let scene = crate::common::scene(
        "frequency_hz = 300\n[zones]\n[[zones.polygon]]\nkind = \
                              \"hot\"\npoints_m = [[0, 0], [0.1, 0], [0.1, 0.1]]\n",
    );
    let rendering = render(&model, &scene, &Default::default()).unwrap();
    assert!(rendering.area.is_none() && rendering.weights.indices.area.is_none());
}

#[test]
fn nothing_outside_the_hull_of_the_responses_is_judged() {
    let mut model = truth().clone();
    // Cut the corner at (x_min, y_min) off: nodes 1 to 3, 12, 13, 23.
    model
        .nodes
        .retain(|node| ![1, 2, 3, 12, 13, 23].contains(&node.label));
    let rendering = render(
        &model,
        &cell_scene([2, 2], 1, ""),
        &RenderOptions {
            method: Method::PressureMatching.into(),
            ..Default::default()
        },
    );
    let area = rendering.unwrap().area.unwrap();
    assert_eq!(area.ground[[0, 0]], Ground::Ignored);
    assert!(area.velocity_m_per_s[[0, 0]].is_nan() && area.velocity_m_per_s[[12, 20]].is_finite());
}
