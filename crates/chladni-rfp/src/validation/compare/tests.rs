//! Shapes with known errors, spoiled on purpose.

use super::*;
use chladni_frf::{Dof, Node};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

const COLUMNS: usize = 8;
const ROWS: usize = 5;
/// Waves along x and y of the modes of the panel.
const WAVES: [(f64, f64); 6] = [
    (1.0, 1.0),
    (2.0, 1.0),
    (1.0, 2.0),
    (3.0, 1.0),
    (2.0, 2.0),
    (3.0, 2.0),
];

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random::<f64>().max(1e-300), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// Shapes on a grid of 20 mm, without error.
fn exact() -> ShapeSet {
    let place = |k: usize| [(k % COLUMNS) as f64, (k / COLUMNS) as f64];
    let count = COLUMNS * ROWS;
    let node = |k: usize| Node {
        label: k as u64 + 1,
        xyz_m: [0.02 * place(k)[0], 0.02 * place(k)[1], 0.0],
    };
    let mode = |(n, &(p, q)): (usize, &(f64, f64))| {
        let value = |k: usize| {
            let [x, y] = place(k);
            let (x, y) = ((x + 0.5) / COLUMNS as f64, (y + 0.5) / ROWS as f64);
            Complex64::new((p * PI * x).cos() * (q * PI * y).cos(), 0.02 * x)
        };
        ShapeMode {
            frequency_hz: 50.0 + 31.0 * n as f64,
            loss_factor: Some(0.01),
            shape: (0..count).map(value).collect(),
            shape_std: vec![0.0; count],
            ..ShapeMode::default()
        }
    };
    ShapeSet {
        dofs: (1..=count as u64)
            .map(|node| format!("{node}:+Z").parse().unwrap())
            .collect(),
        nodes: (0..count).map(node).collect(),
        modes: WAVES.iter().enumerate().map(mode).collect(),
    }
}

/// The same as a measurement would give it: errors of the size that it states, any phase.
fn measured(exact: &ShapeSet, relative_std: f64, seed: u64) -> ShapeSet {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut set = exact.clone();
    for mode in &mut set.modes {
        let turn = Complex64::from_polar(1.0 + rng.random::<f64>(), TAU * rng.random::<f64>());
        for (value, std) in mode.shape.iter_mut().zip(&mut mode.shape_std) {
            *std = relative_std * (0.5 + rng.random::<f64>());
            let error = Complex64::new(normal(&mut rng), normal(&mut rng)) * (*std / 2f64.sqrt());
            *value = (*value + error) * turn;
            *std *= turn.norm();
        }
        mode.frequency_std_hz = 0.01;
        mode.frequency_hz += 0.01 * normal(&mut rng);
        mode.loss_factor_std = 1e-5;
        mode.loss_factor = mode.loss_factor.map(|loss| loss + 1e-5 * normal(&mut rng));
    }
    set
}

fn numbers(comparison: &Comparison) -> Vec<(usize, usize)> {
    comparison
        .pairs
        .iter()
        .map(|pair| (pair.a, pair.b))
        .collect()
}

fn compared(a: &ShapeSet, b: &ShapeSet) -> Comparison {
    compare(a, b, &CompareOptions::default()).unwrap()
}

fn same(count: usize) -> Vec<(usize, usize)> {
    (1..=count).map(|n| (n, n)).collect()
}

#[test]
fn the_exact_mac_lies_within_its_stated_uncertainty() {
    let truth = exact();
    for relative_std in [0.003, 0.03, 0.1] {
        let (mut like, mut unlike, mut within) = (0, 0, [0, 0]);
        for seed in 0..150 {
            let (a, b) = (
                measured(&truth, relative_std, 2 * seed),
                measured(&truth, relative_std, 2 * seed + 1),
            );
            let (found, known) = (compared(&a, &b), compared(&truth, &truth));
            assert_eq!(numbers(&found), same(WAVES.len()));
            for ((n, m), mac) in found.mac.indexed_iter() {
                let error = mac.value - mac.noise_bias - known.mac[[n, m]].value;
                let inside = usize::from(error.abs() <= 1.96 * mac.std);
                if n == m {
                    like += 1;
                    within[0] += inside;
                } else {
                    unlike += 1;
                    within[1] += inside;
                }
            }
        }
        let parts = [
            within[0] as f64 / like as f64,
            within[1] as f64 / unlike as f64,
        ];
        println!("{relative_std}: {parts:?}");
        // 900 like pairs: three standard errors of 95 % are 2.2 %
        assert!(
            parts[0] > 0.925 && parts[1] > 0.925,
            "{relative_std}: {parts:?}"
        );
        // bars that are far too wide would say nothing
        assert!(parts[0] < 0.995, "{relative_std}: {parts:?}");
    }
}

/// The same scaled to 1 at its largest value, as a model without a driving point is, and
/// with the error bars that this model states: none there, but `rounding` of the others'.
fn scaled_to_largest(set: &ShapeSet, rounding: f64) -> ShapeSet {
    let mut out = set.clone();
    for mode in &mut out.modes {
        let size = |k: &usize| mode.shape[*k].norm();
        let largest = (0..mode.shape.len())
            .max_by(|a, b| size(a).total_cmp(&size(b)))
            .unwrap();
        let (peak, noise) = (mode.shape[largest], mode.shape_std[largest]);
        let std = |k: usize| {
            let own = mode.shape_std[k] / peak.norm();
            own.hypot((mode.shape[k] / peak).norm() * noise / peak.norm())
        };
        let mut stated: Vec<f64> = (0..mode.shape.len()).map(std).collect();
        stated[largest] = rounding * stated[0];
        let model = chladni_frf::Mode {
            frequency_hz: mode.frequency_hz,
            frequency_std_hz: 0.0,
            loss_factor: 0.01,
            loss_factor_std: 0.0,
            damping_ratio: 0.005,
            in_band: true,
            trust: chladni_frf::Trust::Sure,
            reasons: chladni_frf::Reasons::default(),
            mpc: 1.0,
            shape: chladni_frf::ComplexVector(mode.shape.iter().map(|v| v / peak).collect()),
            shape_std: stated,
            scale_std: None,
            participation: chladni_frf::ComplexVector::default(),
        };
        mode.shape_std = model.shape_std_up_to_scale();
        mode.shape = model.shape.0;
    }
    out
}

#[test]
fn the_error_of_the_scale_is_none_of_the_mac() {
    let truth = exact();
    let (mut all, mut within) = (0, 0);
    for seed in 0..150 {
        // the sum of squares that cancel is rarely nothing
        let rounding = if seed % 2 == 0 { 0.0 } else { 1e-8 };
        let scaled = [2 * seed, 2 * seed + 1]
            .map(|seed| scaled_to_largest(&measured(&truth, 0.03, seed), rounding));
        for pair in compared(&scaled[0], &scaled[1]).pairs {
            all += 1;
            let error = pair.mac - pair.mac_noise_bias - 1.0;
            within += usize::from(error.abs() <= 1.96 * pair.mac_std);
        }
    }
    let part = within as f64 / all as f64;
    println!("scaled to the largest: {part}");
    assert!((0.925..0.995).contains(&part), "{part}");
}

#[test]
fn shifts_are_counted_in_their_own_standard_deviations() {
    let truth = exact();
    let mut shifted = measured(&truth, 0.01, 4);
    shifted.modes[2].frequency_hz += 1.0;
    let found = compared(&measured(&truth, 0.01, 3), &shifted);
    for (n, pair) in found.pairs.iter().enumerate() {
        let sigmas = pair.frequency_shift_sigmas.unwrap();
        // 1 Hz over √2·0.01 Hz
        let expected = if n == 2 {
            1.0 / (0.01 * 2f64.sqrt())
        } else {
            0.0
        };
        assert!((sigmas - expected).abs() < 4.0, "{pair:?}");
        assert!(pair.loss_factor_shift_sigmas.unwrap().abs() < 4.0);
    }
    // a truth beside itself has no standard deviation to count in
    assert_eq!(
        compared(&truth, &truth).pairs[0].frequency_shift_sigmas,
        None
    );
}

#[test]
fn shapes_decide_where_frequencies_have_changed_places() {
    let a = measured(&exact(), 0.02, 1);
    let mut b = measured(&exact(), 0.02, 2);
    let (third, fourth) = (b.modes[2].frequency_hz, b.modes[3].frequency_hz);
    (b.modes[2].frequency_hz, b.modes[3].frequency_hz) = (fourth, third);
    b.modes.swap(2, 3);
    let pairs = [(1, 1), (2, 2), (3, 4), (4, 3), (5, 5), (6, 6)];
    assert_eq!(numbers(&compared(&a, &b)), pairs);
}

#[test]
fn a_missing_mode_is_named_on_the_side_that_has_it() {
    let a = measured(&exact(), 0.02, 1);
    let mut b = measured(&exact(), 0.02, 2);
    b.modes.remove(1);
    let found = compared(&a, &b);
    assert_eq!(numbers(&found), [(1, 1), (3, 2), (4, 3), (5, 4), (6, 5)]);
    let lone: Vec<usize> = found.only_in_a.iter().map(|mode| mode.mode).collect();
    assert_eq!(lone, [2]);
    assert!(found.only_in_b.is_empty());
    let turned = compared(&b, &a);
    assert_eq!(turned.only_in_b[0].mode, 2);
    assert!(turned.only_in_a.is_empty());
    let empty = ShapeSet {
        modes: Vec::new(),
        ..b
    };
    assert_eq!(compared(&a, &empty).only_in_a.len(), 6);
}

/// Some DOFs of a set in a new order, some with the other sense of their axis.
fn rearranged(set: &ShapeSet, places: &[usize]) -> ShapeSet {
    let mut out = set.clone();
    let turned = |place: usize| place.is_multiple_of(3);
    out.dofs = (places.iter())
        .map(|&place| {
            let dof = set.dofs[place];
            let text = format!("{}:{}Z", dof.node, if turned(place) { '-' } else { '+' });
            text.parse::<Dof>().unwrap()
        })
        .collect();
    for (mode, whole) in out.modes.iter_mut().zip(&set.modes) {
        let sign = |place: usize| if turned(place) { -1.0 } else { 1.0 };
        mode.shape = places.iter().map(|&k| whole.shape[k] * sign(k)).collect();
        mode.shape_std = places.iter().map(|&k| whole.shape_std[k]).collect();
    }
    out
}

#[test]
fn dofs_are_paired_by_name_in_any_order_and_sense() {
    let (a, b) = (measured(&exact(), 0.02, 1), measured(&exact(), 0.02, 2));
    let plain = compared(&a, &b);
    let places: Vec<usize> = (0..40).map(|k| (k * 17 + 5) % 40).collect();
    let found = compared(&a, &rearranged(&b, &places));
    assert_eq!(numbers(&found), same(6));
    assert_eq!((found.common_dofs, found.paired_by), (40, PairDofs::Name));
    for (one, other) in plain.mac.iter().zip(&found.mac) {
        assert!((one.value - other.value).abs() < 1e-12);
    }
}

#[test]
fn half_of_the_dofs_are_enough() {
    let (a, b) = (measured(&exact(), 0.02, 1), measured(&exact(), 0.02, 2));
    let half: Vec<usize> = (0..40).filter(|k| k % 2 == 1).rev().collect();
    let found = compared(&a, &rearranged(&b, &half));
    assert_eq!((numbers(&found), found.common_dofs), (same(6), 20));
    assert!(found.pairs.iter().all(|pair| pair.mac > 0.99));
    let few = compared(&a, &rearranged(&b, &[0, 13, 22, 30]));
    assert!(few.findings[0].contains("4 DOFs in common for up to 6 modes"));
}

#[test]
fn a_finite_element_program_numbers_its_nodes_in_its_own_way() {
    let a = measured(&exact(), 0.02, 1);
    let mut b = exact();
    // the same labels for other places, 1 mm off the measured grid
    for node in &mut b.nodes {
        node.label = 41 - node.label;
        node.xyz_m[0] += 0.001;
    }
    for dof in &mut b.dofs {
        *dof = Dof::new(41 - dof.node, dof.direction);
    }
    let found = compared(&a, &b);
    assert_eq!(numbers(&found), same(6));
    assert_eq!(
        (found.common_dofs, found.paired_by),
        (40, PairDofs::Nearest)
    );
    assert!((found.largest_distance_m.unwrap() - 0.001).abs() < 1e-9);
    assert!(found.findings[0].contains("names of nodes are shared"));
    // without any label in common there is nothing to warn of
    let mut other = b.clone();
    other.nodes.iter_mut().for_each(|node| node.label += 1000);
    for dof in &mut other.dofs {
        *dof = Dof::new(dof.node + 1000, dof.direction);
    }
    assert!(compared(&a, &other).findings.is_empty());
    // half the spacing away it is another point
    other.nodes.iter_mut().for_each(|node| node.xyz_m[2] += 0.5);
    let error = compare(&a, &other, &CompareOptions::default()).unwrap_err();
    assert!(error.message.contains("no DOF in common"), "{error}");
}

/// The same set with every position moved and scaled.
fn placed(set: &ShapeSet, scale: f64, offset_m: [f64; 3]) -> ShapeSet {
    let mut out = set.clone();
    for node in &mut out.nodes {
        for (at, offset) in node.xyz_m.iter_mut().zip(offset_m) {
            *at = *at * scale + offset;
        }
    }
    out
}

#[test]
fn another_origin_is_told_from_other_numbers() {
    let (a, b) = (measured(&exact(), 0.02, 1), measured(&exact(), 0.02, 2));
    // a column and a row of points further on, so that most points still fall on others
    for offset_m in [[0.02, 0.02, 0.0], [-0.3, 0.0, 0.1]] {
        let found = compared(&a, &placed(&b, 1.0, offset_m));
        assert_eq!((found.paired_by, found.common_dofs), (PairDofs::Name, 40));
        assert_eq!(numbers(&found), same(6));
        let codes: Vec<&str> = found.findings.iter().map(|f| &*f.code).collect();
        assert_eq!(codes, ["origin-differs"], "{:?}", found.findings);
        let told = found.findings[0].values["offset_m"].as_slice();
        for (told, offset) in told.iter().zip(offset_m) {
            assert!((told - offset).abs() < 1e-9, "{told} {offset}");
        }
    }
    // a line of points that counts from 0: its places are the same, not its names
    let mut line = a.clone();
    let mut renumbered = b.clone();
    for (set, first) in [(&mut line, 1), (&mut renumbered, 0)] {
        let shape = |mode: &mut ShapeMode| {
            mode.shape.truncate(COLUMNS);
            mode.shape_std.truncate(COLUMNS);
        };
        set.modes.iter_mut().for_each(shape);
        set.dofs.truncate(COLUMNS);
        set.nodes.truncate(COLUMNS);
        for (k, (node, dof)) in set.nodes.iter_mut().zip(&mut set.dofs).enumerate() {
            node.label = k as u64 + first;
            *dof = Dof::new(node.label, dof.direction);
        }
    }
    let found = compared(&line, &renumbered);
    assert_eq!((found.paired_by, found.common_dofs), (PairDofs::Nearest, 8));
}

#[test]
fn points_that_do_not_meet_are_named_with_the_unit_and_the_origin() {
    let (a, b) = (measured(&exact(), 0.02, 1), measured(&exact(), 0.02, 2));
    let millimetres = placed(&b, 1000.0, [0.0; 3]);
    let found = compared(&a, &millimetres);
    let told = found.findings.iter().find(|f| f.code == "points-apart");
    let told = told.unwrap();
    assert!(told.help.contains("1000 times"), "{told:?}");
    let far = |set: &ShapeSet| compare(&a, set, &CompareOptions::default()).unwrap_err();
    let error = far(&placed(&b, 1000.0, [1e6, 0.0, 0.0])).to_string();
    assert!(
        error.contains("1000 times") && error.contains("by name"),
        "{error}"
    );
    // neither a unit nor an origin
    let mut turned = b.clone();
    let turn = |node: &mut Node| node.xyz_m = [0.0, 0.0, 1.0 + node.xyz_m[0]];
    turned.nodes.iter_mut().for_each(turn);
    let error = far(&turned).to_string();
    assert!(
        error.contains("from one origin") && error.contains("by name"),
        "{error}"
    );
    assert!(!error.contains("1:+Z"), "{error}");
}

#[test]
fn a_mode_is_followed_through_many_models() {
    let mut sets: Vec<ShapeSet> = (0..4).map(|k| measured(&exact(), 0.02, k)).collect();
    sets[1].modes.remove(2);
    sets[0].modes.remove(5);
    let tracked = |against| {
        let tracking = track(&sets, against, &CompareOptions::default()).unwrap();
        let tracks = tracking.tracks.into_iter().map(|track| track.modes);
        tracks.collect::<Vec<_>>()
    };
    let all = |n: [usize; 4]| n.map(|n| (n > 0).then_some(n)).to_vec();
    let common = [
        all([1, 1, 1, 1]),
        all([2, 2, 2, 2]),
        all([3, 0, 3, 3]),
        all([4, 3, 4, 4]),
        all([5, 4, 5, 5]),
    ];
    let by_first = tracked(TrackAgainst::First);
    assert_eq!(by_first[..5], common);
    // the sixth mode is unknown to the first model
    assert_eq!(by_first.len(), 8);
    let by_previous = tracked(TrackAgainst::Previous);
    assert_eq!(by_previous[2], all([3, 0, 0, 0]));
    assert_eq!(by_previous[5], all([0, 5, 6, 6]));
    assert_eq!(by_previous[6], all([0, 0, 3, 3]));
}
