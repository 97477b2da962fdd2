//! A panel that is mirrored, turned, moved or listed in another order is the same panel:
//! its drive is the same drive.

use crate::common::{disturbed, FIT_40_DB};
use chladni_frf::ModalModel;
use chladni_plate::{simulate, Panel};
use chladni_render::{render, Method, MethodChoice, RenderOptions, Scene};
use num_complex::Complex64;
use std::path::Path;

const LENGTH_M: f64 = 0.268;
const WIDTH_M: f64 = 0.170;
/// Largest difference of two equal drives over their norm.
const SAME: f64 = 1e-6;
/// The same where rows and columns stand in another order: conic programs take other
/// pivots then, and end elsewhere within their gap.
const SAME_BUT_FOR_PIVOTS: f64 = 1e-4;

/// A panel with few responses and actuators, and errors that leave it no symmetry.
fn model(grid: [usize; 2], spacing_m: f64) -> ModalModel {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 300.0);
    (panel.responses.grid, panel.responses.spacing_m) = (grid, spacing_m);
    (panel.references.edge_count, panel.references.spacing_m) = ([3, 2], 0.070);
    disturbed(&simulate(&panel, None, None).unwrap().truth, FIT_40_DB, 5)
}

/// A change that leaves the panel what it is.
#[derive(Clone, Copy)]
struct Change {
    name: &'static str,
    /// The image of a point, m.
    point: fn([f64; 2]) -> [f64; 2],
    /// The image of a cell, of so many columns and rows, all counted from 0.
    cell: fn([usize; 2], [usize; 2]) -> [usize; 2],
    /// x becomes y.
    swaps: bool,
    moved_m: f64,
}

const CHANGES: [Change; 8] = {
    const SAME: Change = Change {
        name: "the panel itself",
        point: |p| p,
        cell: |c, _| c,
        swaps: false,
        moved_m: 0.0,
    };
    [
        SAME,
        Change {
            name: "mirrored in x",
            point: |[x, y]| [LENGTH_M - x, y],
            cell: |[i, j], [columns, _]| [columns - 1 - i, j],
            ..SAME
        },
        Change {
            name: "mirrored in y",
            point: |[x, y]| [x, WIDTH_M - y],
            cell: |[i, j], [_, rows]| [i, rows - 1 - j],
            ..SAME
        },
        Change {
            name: "turned by 180 degrees",
            point: |[x, y]| [LENGTH_M - x, WIDTH_M - y],
            cell: |[i, j], [columns, rows]| [columns - 1 - i, rows - 1 - j],
            ..SAME
        },
        Change {
            name: "axes exchanged",
            point: |[x, y]| [y, x],
            cell: |[i, j], _| [j, i],
            swaps: true,
            ..SAME
        },
        Change {
            name: "turned by 90 degrees",
            point: |[x, y]| [WIDTH_M - y, x],
            cell: |[i, j], [_, rows]| [rows - 1 - j, i],
            swaps: true,
            ..SAME
        },
        Change {
            name: "turned by 270 degrees",
            point: |[x, y]| [y, LENGTH_M - x],
            cell: |[i, j], [columns, _]| [j, columns - 1 - i],
            swaps: true,
            ..SAME
        },
        Change {
            name: "moved",
            point: |[x, y]| [x + 0.5, y + 0.5],
            moved_m: 0.5,
            ..SAME
        },
    ]
};

impl Change {
    fn model(&self, model: &ModalModel) -> ModalModel {
        let mut changed = model.clone();
        for node in &mut changed.nodes {
            let [x, y, z] = node.xyz_m;
            let [x, y] = (self.point)([x, y]);
            node.xyz_m = [x, y, z];
        }
        changed
    }

    /// The scene with one hot cell, counted from 0.
    fn scene(&self, grid: [usize; 2], hot: [usize; 2], rest: &str) -> Scene {
        let [i, j] = (self.cell)(hot, grid);
        let exchanged = |[a, b]: [f64; 2]| if self.swaps { [b, a] } else { [a, b] };
        let [length, width] = exchanged([LENGTH_M, WIDTH_M]);
        let [columns, rows] = exchanged(grid.map(|n| n as f64)).map(|n| n as usize);
        let at = self.moved_m;
        let text = format!(
            "frequency_hz = 310.0\n[zones]\ngrid = [{columns}, {rows}]\nhot = [{}]\n\
             cells_m = [{at:?}, {at:?}, {:?}, {:?}]\n{rest}",
            j * columns + i + 1,
            at + length,
            at + width
        );
        Scene::parse(&text, Path::new("")).unwrap()
    }
}

fn drive(model: &ModalModel, scene: &Scene, method: MethodChoice) -> (Vec<Complex64>, Option<f64>) {
    let options = RenderOptions {
        method,
        ..Default::default()
    };
    let weights = render(model, scene, &options).unwrap().weights;
    let drive = weights.weights.iter().map(|weight| weight.value());
    (drive.collect(), weights.kappa)
}

fn difference(a: &[Complex64], b: &[Complex64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = Complex64>| v.map(|z| z.norm_sqr()).sum::<f64>();
    (norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut a.iter().copied())).sqrt()
}

fn choices() -> Vec<MethodChoice> {
    let words = [
        MethodChoice::Default,
        MethodChoice::Fast,
        MethodChoice::Best,
    ];
    words
        .into_iter()
        .chain(Method::ALL.map(MethodChoice::Only))
        .collect()
}

#[test]
fn a_mirrored_or_turned_panel_gets_the_same_drive_from_every_method() {
    let model = model([7, 5], 0.030);
    let mut differ = Vec::new();
    for (grid, hot, rest) in [
        ([2, 2], [0, 0], ""),
        ([3, 2], [2, 1], "transition_m = 0.005\n"),
        // one that cannot be met
        ([3, 1], [1, 0], "[threshold]\nlimen_db = 5.0\n"),
    ] {
        for method in choices() {
            let (expected, expected_kappa) =
                drive(&model, &CHANGES[0].scene(grid, hot, rest), method);
            for change in &CHANGES[1..] {
                let scene = change.scene(grid, hot, rest);
                let (found, kappa) = drive(&change.model(&model), &scene, method);
                let error = difference(&expected, &found);
                if error.is_nan() || error >= SAME {
                    differ.push(format!(
                        "{method}, cell {hot:?} of {grid:?}, {}: {error:.1e}, kappa {kappa:?} for \
                         {expected_kappa:?}",
                        change.name
                    ));
                }
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

#[test]
fn many_responses_are_no_exception() {
    // more than one spline interpolates, so that patches of neighbours do
    let model = model([15, 11], 0.012);
    let scene = |change: &Change| change.scene([2, 2], [0, 0], "");
    let (expected, _) = drive(&model, &scene(&CHANGES[0]), Method::Mls.into());
    for change in &CHANGES[1..] {
        let (found, _) = drive(&change.model(&model), &scene(change), Method::Mls.into());
        let error = difference(&expected, &found);
        assert!(error < SAME, "{}: {error:.1e}", change.name);
    }
}

#[test]
fn the_order_of_responses_and_actuators_does_not_matter() {
    let model = model([7, 5], 0.030);
    let (responses, actuators) = (model.responses.len(), model.references.len());
    // steps without a common divisor with the numbers: every place once
    let rows: Vec<usize> = (0..responses).map(|k| (k * 13 + 4) % responses).collect();
    let columns: Vec<usize> = (0..actuators).map(|k| (k * 3 + 1) % actuators).collect();
    let listed = model.at_dofs(&rows, &columns);
    let scene = CHANGES[0].scene([2, 2], [0, 0], "");
    let mut differ = Vec::new();
    for method in choices() {
        let (expected, _) = drive(&model, &scene, method);
        let (found, _) = drive(&listed, &scene, method);
        let expected: Vec<Complex64> = columns.iter().map(|&k| expected[k]).collect();
        let error = difference(&expected, &found);
        if error.is_nan() || error >= SAME_BUT_FOR_PIVOTS {
            differ.push(format!("{method}: {error:.1e}"));
        }
    }
    assert!(differ.is_empty(), "{differ:?}");
}
