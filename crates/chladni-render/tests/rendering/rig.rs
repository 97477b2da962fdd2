//! Measured fields of rigs that are not their model: what is said of them.

use crate::common::rig::{magnitudes, Rig};
use crate::common::{cell_scene, truth};
use chladni_frf::{Direction, Dof};
use chladni_render::{
    correct, evaluate_field, poles_of_fields, render, FieldEvaluation, Finger, Hypothesis, Place,
    PlayedField, RenderOptions, Scene, Weights,
};

/// Trials of each cause.
const TRIALS: u64 = 10;

fn corner() -> Scene {
    cell_scene([2, 2], 1, "")
}

/// The robust drive of the corner scene at 300 Hz.
fn drive() -> Weights {
    render(truth(), &corner(), &RenderOptions::default())
        .unwrap()
        .weights
}

fn all() -> Vec<usize> {
    (0..77).collect()
}

fn judged(weights: &Weights, mut rig: Rig, noise: f64) -> FieldEvaluation {
    let field = rig.measured(weights, noise, &all());
    evaluate_field(weights, &corner(), truth(), &field, None).unwrap()
}

/// Number of rigs for which the likeliest cause is the right one.
fn right(noise: f64, rig: impl Fn(u64) -> Rig, is_right: impl Fn(u64, &Hypothesis) -> bool) -> u64 {
    let weights = drive();
    let told = |seed: &u64| {
        let agreement = judged(&weights, rig(*seed), noise).agreement;
        let right = is_right(*seed, &agreement.hypotheses[0]);
        if !right {
            eprintln!("{seed}: {:?}", &agreement.hypotheses[..3]);
        }
        right
    };
    (0..TRIALS).filter(told).count() as u64
}

/// A channel that is driven at all: the strongest ones in turn.
fn channel(seed: u64) -> usize {
    let weights = drive();
    let mut order: Vec<usize> = (0..34).collect();
    order.sort_by(|&a, &b| {
        weights.weights[b]
            .amplitude
            .total_cmp(&weights.weights[a].amplitude)
    });
    order[seed as usize]
}

fn is_channel(hypothesis: &Hypothesis, channel: usize) -> bool {
    hypothesis.place == Some(Place::Channel(truth().references[channel]))
}

#[test]
fn at_five_percent_of_noise_nothing_global_dead_and_reversed_are_told() {
    let noise = 0.05;
    let nothing = right(
        noise,
        |seed| Rig::new(300.0, seed),
        |_, told| told.kind == "nothing",
    );
    let global = right(
        noise,
        |seed| {
            let mut rig = Rig::new(300.0, seed);
            rig.gains
                .mapv_inplace(|gain| gain * num_complex::Complex64::from_polar(1.1, 0.2));
            rig
        },
        |_, told| told.kind == "gain" && (told.value.unwrap()[0] - 0.078).abs() < 0.05,
    );
    let dead = right(
        noise,
        |seed| Rig::new(300.0, seed).channel(channel(seed), 0.0),
        |seed, told| told.kind == "dead" && is_channel(told, channel(seed)),
    );
    let reversed = right(
        noise,
        |seed| Rig::new(300.0, seed).channel(channel(seed), -1.0),
        |seed, told| told.kind == "reversed" && is_channel(told, channel(seed)),
    );
    assert_eq!([nothing, global, dead, reversed], [TRIALS; 4]);
}

#[test]
fn fingers_and_masses_are_found_where_they_are() {
    let places = |seed: u64| {
        [
            0.054 + 0.02 * (seed % 4) as f64 + 0.003,
            0.045 + 0.015 * (seed % 3) as f64,
        ]
    };
    let near = |seed: u64, told: &Hypothesis| match told.place {
        Some(Place::Point([x, y])) => {
            let [x0, y0] = places(seed);
            told.kind == "load" && (x - x0).hypot(y - y0) <= 0.010
        }
        _ => false,
    };
    for load in [Finger::default(), Finger::of_mass(0.5e-3)] {
        let found = right(
            0.01,
            |seed| Rig::new(300.0, seed).loaded(&load, places(seed)),
            near,
        );
        assert!(found >= 9, "{found} of {TRIALS} of {load:?}");
    }
    // its impedance, where it stands on the grid of places
    let finger = Finger::default();
    let rig = Rig::new(300.0, 1).loaded(&finger, [0.094, 0.065]);
    let told = &judged(&drive(), rig, 0.01).agreement.hypotheses[0];
    let ([re, im], true_z) = (told.value.unwrap(), finger.impedance(300.0));
    assert!(
        (re - true_z.re).abs() < 0.5 && (im - true_z.im).abs() < 0.5,
        "{told:?} for {true_z}"
    );
}

#[test]
fn what_feeds_the_panel_is_not_called_a_touch() {
    let feeding = Finger {
        damping_n_s_per_m: -1.0,
        mass_kg: 0.0,
        stiffness_n_per_m: 0.0,
    };
    let rig = Rig::new(300.0, 1).loaded(&feeding, [0.094, 0.065]);
    let causes = judged(&drive(), rig, 0.01).agreement.hypotheses;
    let touch = causes.iter().find(|cause| cause.kind == "load");
    assert!(touch.is_none(), "{touch:?}");
    assert_ne!(causes[0].kind, "nothing", "{causes:?}");
}

#[test]
fn scattered_gains_are_told_and_the_prediction_no_longer_explains_the_field() {
    let found = right(
        0.01,
        |seed| Rig::new(300.0, seed).scattered(0.02, 2.0),
        |_, told| told.kind == "channels",
    );
    assert!(found >= 9, "{found}");
    let weights = drive();
    let sound = judged(&weights, Rig::new(300.0, 3), 0.01);
    assert!(sound.agreement.nis < 0.3 && sound.agreement.coefficient > 0.999);
    assert_eq!(sound.indices.points.min_ratio, 1.0);
    let dead = judged(&weights, Rig::new(300.0, 3).channel(channel(0), 0.0), 0.01);
    assert!(
        dead.agreement.nis > 3.0 && dead.agreement.coefficient < 0.99,
        "{:?}",
        dead.agreement
    );
    assert!(dead.indices.points.min_ratio < 0.9);
}

#[test]
fn magnitudes_alone_tell_a_dead_channel() {
    let weights = drive();
    for seed in 0..4 {
        let mut rig = Rig::new(300.0, seed).channel(channel(seed), 0.0);
        let field = magnitudes(rig.measured(&weights, 0.01, &all()));
        let judged = evaluate_field(&weights, &corner(), truth(), &field, None).unwrap();
        let told = &judged.agreement.hypotheses[0];
        assert!(
            told.kind == "dead" && is_channel(told, channel(seed)),
            "{told:?}"
        );
        assert_eq!(judged.agreement.phase_deg, None);
    }
}

#[test]
fn rows_in_any_order_and_sense_are_the_same_field_and_strangers_are_refused_by_name() {
    let weights = drive();
    let field = Rig::new(300.0, 5).measured(&weights, 0.01, &all());
    let evaluated = |field| evaluate_field(&weights, &corner(), truth(), field, None);
    let mut permuted = field.clone();
    permuted.points.reverse();
    for point in &mut permuted.points[..9] {
        point.response.direction = Direction::from_code(-3).unwrap();
        point.velocity_m_per_s = -point.velocity_m_per_s;
    }
    assert_eq!(evaluated(&permuted).unwrap(), evaluated(&field).unwrap());

    let mut half = field.clone();
    half.points.retain(|point| point.response.node % 2 == 1);
    let judged = evaluated(&half).unwrap();
    assert_eq!(judged.measured.responses.len(), 39);
    assert!(judged
        .findings
        .iter()
        .any(|words| words.contains("39 of the 77 responses")));

    let mut unknown = field.clone();
    unknown.points[7].response = Dof::new(4711, Direction::PLUS_Z);
    assert!(evaluated(&unknown)
        .unwrap_err()
        .to_string()
        .contains("4711:+Z"));
    let mut elsewhere = field.clone();
    elsewhere.frequency_hz = 301.0;
    assert!(evaluated(&elsewhere)
        .unwrap_err()
        .to_string()
        .contains("301 Hz"));
    let mut other = field;
    other.weights_sha256 = Some("00".repeat(32));
    let error = evaluate_field(&weights, &corner(), truth(), &other, Some(&"11".repeat(32)));
    assert!(error.unwrap_err().to_string().contains("other weights"));
}

#[test]
fn a_field_in_the_wrong_unit_is_said_first_and_teaches_nothing() {
    let (weights, scene) = (drive(), corner());
    let mut rig = Rig::new(300.0, 5).scattered(0.02, 2.0);
    let right = rig.measured(&weights, 0.01, &all());
    for factor in [1e3, 1e-3] {
        let mut field = right.clone();
        for point in &mut field.points {
            point.velocity_m_per_s *= factor;
            point.std_m_per_s = point.std_m_per_s.map(|std| factor * std);
        }
        for field in [field.clone(), magnitudes(field)] {
            let judged = evaluate_field(&weights, &scene, truth(), &field, None).unwrap();
            assert_eq!(judged.findings[0].code, "field-level-off");
            let played = [PlayedField::new(weights.clone(), field)];
            let error = correct(truth(), &scene, &played, &RenderOptions::default()).unwrap_err();
            assert_eq!(error.field.as_deref(), Some("unit"), "{error}");
            let error = poles_of_fields(truth(), &played).unwrap_err();
            assert_eq!(error.field.as_deref(), Some("unit"), "{error}");
        }
    }
    let mut still = weights.clone();
    for weight in &mut still.weights {
        (weight.re, weight.im, weight.amplitude) = (0.0, 0.0, 0.0);
    }
    let played = [PlayedField::new(still, right.clone())];
    let error = correct(truth(), &scene, &played, &RenderOptions::default()).unwrap_err();
    assert_eq!(error.found.as_deref(), Some("weights of zero"), "{error}");
    let judged = evaluate_field(&weights, &scene, truth(), &right, None).unwrap();
    assert!(judged
        .findings
        .iter()
        .all(|one| one.code != "field-level-off"));
}

#[test]
fn two_swapped_cables_are_named_and_no_other_fault_is_called_so() {
    let weights = drive();
    let swapped = |seed: u64| {
        let pair = [channel(seed), channel(seed + 3)];
        let mut rig = Rig::new(300.0, seed).scattered(0.02, 2.0);
        let plain = rig.mobility.clone();
        for (to, from) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            rig.mobility.column_mut(to).assign(&plain.column(from));
        }
        let told = judged(&weights, rig, 0.01);
        let finding = told.findings.iter().find(|f| f.code == "channels-swapped");
        let named = finding.is_some_and(|finding| {
            pair.iter()
                .all(|&k| finding.dofs.contains(&truth().references[k]))
        });
        if !named {
            eprintln!("{seed}: {pair:?} {:?}", finding.map(|f| &f.text));
        }
        named
    };
    let right = (0..TRIALS).filter(|&seed| swapped(seed)).count() as u64;
    assert!(right >= TRIALS - 1, "{right} of {TRIALS}");
    for seed in 0..TRIALS {
        let scattered = || Rig::new(300.0, seed).scattered(0.02, 2.0);
        for rig in [
            Rig::new(300.0, seed),
            scattered(),
            Rig::new(300.0, seed).channel(channel(seed), 0.0),
            scattered().channel(channel(seed), 0.0),
            scattered().channel(channel(seed), -1.0),
            scattered().loaded(&Finger::MID, [0.061, 0.052]),
        ] {
            let told = judged(&weights, rig, 0.01);
            let none = told.findings.iter().all(|f| f.code != "channels-swapped");
            assert!(none, "{seed}: {:?}", told.findings);
        }
    }
}

/// Exchanged cables explain a part of nearly any field with several faults.
#[test]
fn several_faults_at_once_are_not_called_a_swap() {
    for seed in 0..2 * TRIALS {
        let rig = Rig::new(300.0, seed)
            .scattered(0.03, 3.0)
            .channel(channel(seed), -1.0)
            .channel(channel(seed + 5), 0.0)
            .loaded(&Finger::MID, [0.061, 0.052]);
        let told = judged(&drive(), rig, 0.01);
        let none = told.findings.iter().all(|f| f.code != "channels-swapped");
        assert!(none, "{seed}: {:?}", told.findings);
    }
}

/// A channel that is still plays the weight of the other, whichever of both comes first.
#[test]
fn a_swap_with_a_silent_channel_is_named() {
    for pair in [[channel(9), channel(0)], [channel(8), channel(1)]] {
        let mut weights = drive();
        (weights.weights[pair[0]].re, weights.weights[pair[0]].im) = (0.0, 0.0);
        let mut rig = Rig::new(300.0, 3);
        let plain = rig.mobility.clone();
        for (to, from) in [(pair[0], pair[1]), (pair[1], pair[0])] {
            rig.mobility.column_mut(to).assign(&plain.column(from));
        }
        let field = rig.measured(&weights, 0.01, &(0..77).collect::<Vec<_>>());
        let played = [PlayedField::new(weights, field)];
        let scene = cell_scene([2, 2], 1, "");
        let told = correct(truth(), &scene, &played, &RenderOptions::default()).unwrap();
        let finding = told.findings.iter().find(|f| f.code == "channels-swapped");
        let dofs = &finding.expect("a swap").dofs;
        assert!(
            pair.iter().all(|&k| dofs.contains(&truth().references[k])),
            "{pair:?}: {dofs:?}"
        );
    }
}
