//! Drives corrected by measured fields, on rigs that the model does not know.

use crate::common::rig::{magnitudes, Rig};
use crate::common::{cell_scene, truth};
use chladni_frf::MeasuredField;
use chladni_render::{
    calibrate, correct, render, Calibration, Finger, RenderOptions, Scene, Weights,
};
use num_complex::Complex64;
use std::sync::Arc;

/// Rigs of each kind.
const RIGS: u64 = 3;
/// What corrections reach as yet, mean of the smaller of hot and cold ratio; the goal is 0.99.
const REACHED: f64 = 0.93;
/// Noise of the scanner over the rms of its field.
const NOISE: f64 = 0.01;

fn corner() -> Scene {
    cell_scene([2, 2], 1, "")
}

fn first_drive() -> Weights {
    render(truth(), &corner(), &RenderOptions::default())
        .unwrap()
        .weights
}

/// Smaller of hot and cold ratio of what a drive truly does at the responses.
fn served(rig: &Rig, weights: &Weights) -> f64 {
    served_in(&corner(), rig, weights)
}

/// The same in another scene.
fn served_in(scene: &Scene, rig: &Rig, weights: &Weights) -> f64 {
    let field = rig.field(&rig.drive(weights));
    let limits = scene.limits().unwrap();
    let rendering =
        chladni_render::evaluate(weights, scene, chladni_render::On::Model(truth())).unwrap();
    let mut counts = [[0.0; 2]; 2];
    for (ground, value) in rendering.field.ground.iter().zip(&field) {
        let (kind, inside) = match ground {
            chladni_render::Ground::Hot => (0, limits.is_felt(value.norm())),
            chladni_render::Ground::Cold => (1, limits.is_quiet(value.norm())),
            chladni_render::Ground::Ignored => continue,
        };
        counts[kind][1] += 1.0;
        counts[kind][0] += f64::from(u8::from(inside));
    }
    (counts[0][0] / counts[0][1]).min(counts[1][0] / counts[1][1])
}

/// What is served before any field and after each of `fields`, mean over the rigs.
fn course(
    fields: usize,
    rig: impl Fn(u64) -> Rig,
    seen: impl Fn(MeasuredField) -> MeasuredField,
) -> Vec<f64> {
    let mut means = vec![0.0; fields + 1];
    for seed in 0..RIGS {
        let mut rig = rig(seed);
        let mut weights = first_drive();
        let mut played = Vec::new();
        means[0] += served(&rig, &weights) / RIGS as f64;
        for mean in &mut means[1..] {
            let field = seen(rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>()));
            played.push((weights, field, None));
            weights = correct(truth(), &corner(), &played, &RenderOptions::default()).unwrap();
            *mean += served(&rig, &weights) / RIGS as f64;
        }
    }
    eprintln!("{means:.3?}");
    means
}

/// The strongest channels of the first drive in turn.
fn channel(seed: u64) -> usize {
    let weights = first_drive().weights;
    let mut order: Vec<usize> = (0..34).collect();
    order.sort_by(|&a, &b| weights[b].amplitude.total_cmp(&weights[a].amplitude));
    order[seed as usize]
}

#[test]
fn one_field_mends_gains_and_channels() {
    for (amplitude, phase_deg) in [(0.02, 2.0), (0.05, 5.0)] {
        let rig = |seed| Rig::new(300.0, seed).scattered(amplitude, phase_deg);
        let means = course(1, rig, |field| field);
        assert!(means[1] >= REACHED, "{amplitude}: {means:?}");
    }
    for gain in [0.0, -1.0] {
        let rig = |seed| Rig::new(300.0, seed).channel(channel(seed), gain);
        let means = course(1, rig, |field| field);
        assert!(means[0] < 0.9 && means[1] >= 0.99, "{gain}: {means:?}");
    }
}

#[test]
fn two_fields_mend_most_of_a_mass_that_stays() {
    let mass = Finger::of_mass(0.5e-3);
    let rig = |seed| Rig::new(300.0, seed).loaded(&mass, [0.06 + 0.02 * seed as f64, 0.06]);
    let means = course(2, rig, |field| field);
    assert!(means[2] >= REACHED, "{means:?}");
}

#[test]
fn eight_points_or_magnitudes_alone_mend_a_dead_channel_in_two_fields() {
    let rig = |seed| Rig::new(300.0, seed).channel(channel(seed), 0.0);
    let means = course(2, rig, magnitudes);
    assert!(means[2] >= 0.99, "magnitudes: {means:?}");
    let eight = |mut field: MeasuredField| {
        let mut number = 0;
        field.points.retain(|_| {
            number += 1;
            number % 10 == 3
        });
        assert_eq!(field.points.len(), 8);
        field
    };
    let means = course(2, rig, eight);
    assert!(means[2] >= 0.99, "8 points: {means:?}");
}

#[test]
fn a_correction_tells_gains_and_keeps_what_was_best() {
    let mut rig = Rig::new(300.0, 1).channel(channel(0), 0.0);
    rig.gains[5] *= Complex64::from_polar(1.05, 0.02);
    let weights = first_drive();
    let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
    let played = [(weights, field, None)];
    let corrected = correct(truth(), &corner(), &played, &RenderOptions::default()).unwrap();
    let told = corrected.correction.as_ref().unwrap();
    let dead = &told.gains[channel(0)];
    assert!(
        dead.odd && dead.re.abs() < 0.1 && dead.im.abs() < 0.1,
        "{dead:?}"
    );
    assert_eq!(
        (told.iteration, told.best_measured, told.kept),
        (1, Some(1), false)
    );
    assert!(told.fields[0].nis > 3.0 && told.fields[0].min_ratio.unwrap() < 0.9);
    assert!(!told.scan_due && told.predicted > 0.99, "{told:?}");
    // the file carries it
    let again = Weights::parse(&corrected.to_json().unwrap()).unwrap();
    assert_eq!(again, corrected);

    let error = correct(truth(), &corner(), &[], &RenderOptions::default()).unwrap_err();
    assert!(error.to_string().contains("at least one pair"), "{error}");
}

/// The scene with a calibration.
fn with(calibration: &Calibration, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.actuators.calibration = Some(Arc::new(calibration.clone()));
    scene
}

fn rendered(scene: &Scene) -> Weights {
    render(truth(), scene, &RenderOptions::default())
        .unwrap()
        .weights
}

/// What one measured field of the corner scene teaches.
fn taught(rig: &mut Rig) -> (Weights, Calibration) {
    let weights = first_drive();
    let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
    let played = [(weights, field, None)];
    calibrate(truth(), &corner(), &played, &RenderOptions::default()).unwrap()
}

#[test]
fn one_field_calibrates_the_next_scenes() {
    let other_corner = cell_scene([2, 2], 3, "");
    let mut elsewhere = cell_scene([3, 3], 1, "");
    elsewhere.frequency_hz = 330.0;
    let mut means = [[0.0; 2]; 2];
    for seed in 0..RIGS {
        let rig = |hz| Rig::new(hz, seed).scattered(0.02, 2.0);
        let (corrected, calibration) = taught(&mut rig(300.0));
        for (scene, mean) in [&other_corner, &elsewhere].into_iter().zip(&mut means) {
            let rig = rig(scene.frequency_hz);
            let plain = served_in(scene, &rig, &rendered(scene));
            let calibrated = served_in(scene, &rig, &rendered(&with(&calibration, scene)));
            mean[0] += plain / RIGS as f64;
            mean[1] += calibrated / RIGS as f64;
        }
        // the same scene again is what the correction gave
        let again = rendered(&with(&calibration, &corner()));
        for (a, b) in again.weights.iter().zip(&corrected.weights) {
            assert!((a.value() - b.value()).norm() < 1e-6 * a.amplitude.max(1e-4));
        }
    }
    eprintln!("{means:.4?}");
    assert!(means[0][0] < 0.95, "{means:?}");
    assert!(means[0][1] >= 0.99 && means[1][1] >= 0.99, "{means:?}");
}

#[test]
fn a_dead_channel_is_not_driven_again() {
    let dead = channel(0);
    let mut rig = Rig::new(300.0, 1).channel(dead, 0.0);
    let (_, calibration) = taught(&mut rig);
    let reference = truth().references[dead];
    assert_eq!(calibration.dead, [reference]);
    let scene = with(&calibration, &cell_scene([2, 2], 3, ""));
    let weights = rendered(&scene);
    assert!(weights
        .weights
        .iter()
        .all(|weight| weight.reference != reference));
    assert!(served_in(&scene, &rig, &weights) >= 0.99);
    // the next correction begins where this one ended
    let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
    let played = [(weights, field, None)];
    let (again, calibration) =
        calibrate(truth(), &scene, &played, &RenderOptions::default()).unwrap();
    let told = again.correction.unwrap();
    assert!(told.fields[0].nis < 3.0, "{told:?}");
    assert_eq!(
        (calibration.fields, calibration.operators[0].fields),
        (2, 2)
    );
    assert_eq!(calibration.dead, [reference]);
    // its file is the same again
    let file = Calibration::parse(&calibration.to_json().unwrap()).unwrap();
    assert_eq!(file, calibration);
    // what the scene calls dead needs no calibration
    let mut scene = cell_scene([2, 2], 3, "");
    scene.actuators.dead = vec![reference];
    assert!(served_in(&scene, &rig, &rendered(&scene)) >= 0.99);
}

#[test]
fn a_calibration_of_another_rig_or_model_is_named() {
    let (_, calibration) = taught(&mut Rig::new(300.0, 1).scattered(0.02, 2.0));
    let of = |calibration: &Calibration| {
        render(
            truth(),
            &with(calibration, &corner()),
            &RenderOptions::default(),
        )
    };
    let codes = |calibration: &Calibration| -> Vec<String> {
        let findings = of(calibration).unwrap().weights.findings;
        findings
            .iter()
            .map(|finding| finding.code.to_string())
            .collect()
    };
    assert!(codes(&calibration).contains(&"calibrated".to_owned()));
    let mut other = calibration.clone();
    other.modes[3].model_hz *= 1.001;
    assert!(codes(&other).contains(&"calibration-of-another-model".to_owned()));
    let mut due = calibration.clone();
    (due.scan_due, due.scan_reason) = (true, Some("of a test".into()));
    assert!(codes(&due).contains(&"scan-due".to_owned()));
    let mut stranger = calibration.clone();
    stranger.gains[0].reference = "4711:+Z".parse().unwrap();
    assert!(of(&stranger)
        .unwrap_err()
        .to_string()
        .contains("no such actuator"));
    let mut volts = calibration;
    volts.unit = chladni_frf::ReferenceUnit::Volt;
    assert!(of(&volts).unwrap_err().to_string().contains("another unit"));
}
