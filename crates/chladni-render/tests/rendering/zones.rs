//! Places of zones: cells, transition, borders and polygons, against cases worked out by
//! hand.

use chladni_render::{Ground, Rectangle, Scene, ZoneMap};
use std::path::Path;
use Ground::{Cold, Hot, Ignored};

/// 11 × 7 responses, 20 mm apart, as on the panel.
fn responses() -> Vec<[f64; 2]> {
    (0..77)
        .map(|k| {
            [
                0.034 + 0.020 * (k % 11) as f64,
                0.025 + 0.020 * (k / 11) as f64,
            ]
        })
        .collect()
}

fn zones(text: &str) -> ZoneMap {
    let scene = Scene::parse(
        &format!("frequency_hz = 300\n[zones]\n{text}"),
        Path::new(""),
    )
    .unwrap();
    scene.zones.over(Rectangle::around(&responses()).unwrap())
}

fn counts(map: &ZoneMap) -> (usize, usize, usize) {
    let count = |ground| {
        responses()
            .into_iter()
            .filter(|&point| map.classify(point) == ground)
            .count()
    };
    (count(Hot), count(Cold), count(Ignored))
}

const WHOLE_PANEL: &str = "cells_m = [0, 0, 0.268, 0.170]\n";

#[test]
fn one_cell_of_four_leaves_fifteen_hot_and_fifty_three_cold_responses() {
    // Border at x = 134, y = 85 mm; shrunk to 124, 75 mm: columns 34..114, rows 25..65;
    // grown to 144, 95 mm.
    for hot in 1..=4 {
        let map = zones(&format!("grid = [2, 2]\nhot = [{hot}]\n{WHOLE_PANEL}"));
        assert_eq!(counts(&map), (15, 53, 9), "cell {hot}");
    }
}

#[test]
fn silence_serves_77_9_percent_of_a_corner_scene() {
    let scene = crate::common::cell_scene([2, 2], 1, "");
    let options = chladni_render::RenderOptions {
        method: chladni_render::Method::PressureMatching.into(),
        ..Default::default()
    };
    let rendering = chladni_render::render(crate::common::truth(), &scene, &options).unwrap();
    let silence = rendering.weights.indices.points.silence_ratio;
    assert_eq!(silence, 53.0 / 68.0);
    assert_eq!((1000.0 * silence).round(), 779.0);
}

#[test]
fn cells_are_counted_row_by_row_from_the_smallest_corner() {
    let map = zones(&format!(
        "grid = [3, 2]\nhot = [5]\ntransition_m = 0\n{WHOLE_PANEL}"
    ));
    // Cell 5: second column (89.3 to 178.7 mm), second row (85 to 170 mm).
    assert_eq!(map.classify([0.134, 0.125]), Hot);
    for cold in [[0.034, 0.125], [0.234, 0.125], [0.134, 0.045]] {
        assert_eq!(map.classify(cold), Cold, "{cold:?}");
    }
}

#[test]
fn the_transition_is_as_wide_on_both_sides_and_its_borders_are_judged() {
    let map = zones(&format!("grid = [2, 2]\nhot = [1]\n{WHOLE_PANEL}"));
    let y = 0.045;
    for (x, ground) in [
        (0.124, Hot),
        (0.1241, Ignored),
        (0.134, Ignored),
        (0.1439, Ignored),
        (0.144, Cold),
    ] {
        assert_eq!(map.classify([x, y]), ground, "x = {x}");
    }
    // A micrometre beyond is the same place; two are not.
    assert_eq!(map.classify([0.124_000_9, y]), Hot);
    assert_eq!(map.classify([0.124_002, y]), Ignored);
}

#[test]
fn grown_rectangles_keep_square_corners() {
    let map = zones(&format!("grid = [2, 2]\nhot = [1]\n{WHOLE_PANEL}"));
    // 9 mm and 9 mm beyond the corner: 12.7 mm away, but inside the grown rectangle.
    assert_eq!(map.classify([0.143, 0.094]), Ignored);
    assert_eq!(map.classify([0.143, 0.0951]), Cold);
}

#[test]
fn a_side_without_ground_beyond_it_has_no_transition() {
    // Cells over the area itself: the outer sides of cell 1 are those of the area.
    let map = zones("grid = [2, 2]\nhot = [1]\n");
    assert_eq!(map.classify([0.034, 0.025]), Hot);
    // The area goes on beyond cells_m on the left: now that side counts.
    let map = zones("grid = [2, 2]\nhot = [1]\ncells_m = [0.044, 0.025, 0.234, 0.145]\n");
    assert_eq!(map.classify([0.034, 0.045]), Cold);
    assert_eq!(map.classify([0.0445, 0.045]), Ignored);
    assert_eq!(map.classify([0.054, 0.026]), Hot);
}

#[test]
fn hot_cells_that_touch_are_one_zone() {
    let map = zones(&format!("grid = [2, 2]\nhot = [1, 2]\n{WHOLE_PANEL}"));
    assert_eq!(
        map.classify([0.134, 0.045]),
        Hot,
        "no transition between two hot cells"
    );
    assert_eq!(counts(&map), (33, 33, 11));
    let l_shape = zones(&format!("grid = [2, 2]\nhot = [1, 2, 3]\n{WHOLE_PANEL}"));
    assert_eq!(
        l_shape.classify([0.134, 0.085]),
        Ignored,
        "the inner corner touches the cold cell"
    );
    assert_eq!(l_shape.classify([0.120, 0.120]), Hot);
}

#[test]
fn without_transition_a_point_on_a_hot_border_is_hot() {
    let map = zones(&format!(
        "grid = [2, 2]\nhot = [1]\ntransition_m = 0.0\n{WHOLE_PANEL}"
    ));
    assert_eq!(counts(&map), (24, 53, 0));
}

#[test]
fn borders_of_the_area_are_judged_and_nothing_outside() {
    let map = zones(&format!(
        "grid = [2, 2]\nhot = [1]\narea_m = [0.054, 0.025, 0.234, 0.145]\n{WHOLE_PANEL}"
    ));
    assert_eq!(map.classify([0.0539995, 0.025]), Hot);
    assert_eq!(map.classify([0.053, 0.045]), Ignored);
    assert_eq!(map.classify([0.234, 0.145]), Cold);
    assert_eq!(
        map.area(),
        Rectangle {
            x_min: 0.054,
            y_min: 0.025,
            x_max: 0.234,
            y_max: 0.145
        }
    );
}

#[test]
fn a_rectangle_drawn_as_a_polygon_judges_the_same_responses() {
    for corners in [
        "[0, 0], [0.134, 0], [0.134, 0.085], [0, 0.085]",
        "[0, 0], [0, 0.085], [0.134, 0.085], [0.134, 0]",
    ] {
        let map = zones(&format!(
            "[[zones.polygon]]\nkind = \"hot\"\npoints_m = [{corners}]\n"
        ));
        assert_eq!(counts(&map), (15, 53, 9), "{corners}");
        // The ordinary distance rounds the corner.
        assert_eq!(map.classify([0.143, 0.094]), Cold);
    }
}

#[test]
fn polygons_that_touch_are_one_zone_and_those_that_overlap_too() {
    let two = |x: f64| {
        zones(&format!(
            "[[zones.polygon]]\nkind = \"hot\"\npoints_m = [[0, 0], [{x}, 0], [{x}, 0.085], [0, 0.085]]\n\
             [[zones.polygon]]\nkind = \"hot\"\npoints_m = [[0.134, -0.1], [0.3, -0.1], [0.3, 0.085], [0.134, 0.085]]\n"
        ))
    };
    for x in [0.134, 0.150] {
        assert_eq!(two(x).classify([0.134, 0.045]), Hot, "x = {x}");
        assert_eq!(counts(&two(x)), (33, 33, 11), "x = {x}");
    }
}

#[test]
fn ignored_polygons_win_over_hot_and_hot_over_cold() {
    let map = zones(
        "transition_m = 0.0\n\
         [[zones.polygon]]\nkind = \"hot\"\npoints_m = [[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]]\n\
         [[zones.polygon]]\nkind = \"cold\"\npoints_m = [[0, 0], [0.2, 0], [0.2, 0.2], [0, 0.2]]\n\
         [[zones.polygon]]\nkind = \"ignore\"\npoints_m = [[0, 0], [0.05, 0], [0.05, 0.05], [0, 0.05]]\n",
    );
    assert_eq!(map.classify([0.04, 0.04]), Ignored);
    assert_eq!(map.classify([0.08, 0.08]), Hot);
    assert_eq!(map.classify([0.15, 0.08]), Cold);
    assert_eq!(
        map.classify([0.22, 0.08]),
        Ignored,
        "with a cold polygon, the rest is not judged"
    );
}

#[test]
fn a_triangle_has_a_slanted_transition() {
    let map = zones("[[zones.polygon]]\nkind = \"hot\"\npoints_m = [[0, 0], [0.2, 0], [0, 0.2]]\n");
    // The slanted side x + y = 0.2; distance (0.2 − x − y)/√2.
    assert_eq!(map.classify([0.092, 0.092]), Hot);
    assert_eq!(map.classify([0.094, 0.094]), Ignored);
    assert_eq!(map.classify([0.106, 0.106]), Ignored);
    assert_eq!(map.classify([0.108, 0.108]), Cold);
}
