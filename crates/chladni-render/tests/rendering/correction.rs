//! Drives corrected by measured fields, on rigs that the model does not know.

use crate::common::rig::{magnitudes, Rig};
use crate::common::{cell_scene, truth};
use chladni_frf::MeasuredField;
use chladni_render::{
    calibrate, correct, poles_of_fields, render, Calibration, Finger, PlayedField, RenderOptions,
    Scene, Weights,
};
use num_complex::Complex64;
use std::sync::Arc;

/// Rigs of each kind.
const RIGS: u64 = 6;
/// Share that corrections must reach, mean of the smaller of hot and cold ratio.
const REACHED: f64 = 0.99;
/// Noise of the scanner over the rms of its field.
const NOISE: f64 = 0.01;

pub fn corner() -> Scene {
    cell_scene([2, 2], 1, "")
}

pub fn first_drive() -> Weights {
    render(truth(), &corner(), &RenderOptions::default())
        .unwrap()
        .weights
}

/// Smaller of hot and cold ratio of what a drive truly does at the responses.
pub fn served(rig: &Rig, weights: &Weights) -> f64 {
    served_in(&corner(), rig, weights)
}

/// The same in another scene.
pub fn served_in(scene: &Scene, rig: &Rig, weights: &Weights) -> f64 {
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

/// The share served before any field and after each of `fields`, mean over the rigs.
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
            played.push(PlayedField::new(weights, field));
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

/// Behind amplifiers that nobody has measured one field tells the shift that all natural
/// frequencies share to some 1e-3, and no better: the bars must say so.
#[test]
fn one_field_tells_a_common_shift_within_its_bars() {
    let weights = first_drive();
    let mut offs = Vec::new();
    for shift in [-2e-3, 0.0, 1e-3] {
        for seed in 0..12 {
            let mut rig = Rig::new(300.0, seed).shifted(shift).scattered(0.02, 2.0);
            let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
            let found =
                poles_of_fields(truth(), &[PlayedField::new(weights.clone(), field)]).unwrap();
            assert!(found.common_shift_std < 4e-3, "{}", found.common_shift_std);
            for (before, after) in truth().modes.iter().zip(&found.model.modes) {
                assert_eq!(before.shape, after.shape);
                assert!(after.frequency_std_hz.is_finite() && after.loss_factor_std.is_finite());
            }
            let off = found.common_shift - shift;
            offs.push((off, off / found.common_shift_std));
        }
    }
    let count = offs.len() as f64;
    let rms = (offs.iter().map(|off| off.0 * off.0).sum::<f64>() / count).sqrt();
    let held = offs.iter().filter(|off| off.1.abs() < 1.96).count() as f64 / count;
    eprintln!("common shift: off by {rms:.1e} rms, bars of 95 % hold in {held:.2} of {count}");
    assert!(rms < 4e-3 && held >= 0.85, "{rms:.1e}, {held}");
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
        assert!(means[0] < 0.9 && means[1] >= REACHED, "{gain}: {means:?}");
    }
}

#[test]
fn two_fields_mend_a_mass_or_a_finger_that_stays() {
    for load in [Finger::of_mass(0.5e-3), Finger::default()] {
        let rig = |seed| Rig::new(300.0, seed).loaded(&load, [0.06 + 0.02 * seed as f64, 0.06]);
        let means = course(2, rig, |field| field);
        assert!(means[2] >= REACHED, "{load:?}: {means:?}");
    }
}

#[test]
fn eight_points_or_magnitudes_alone_mend_a_dead_channel_in_two_fields() {
    let rig = |seed| Rig::new(300.0, seed).channel(channel(seed), 0.0);
    let means = course(2, rig, magnitudes);
    assert!(means[2] >= REACHED, "magnitudes: {means:?}");
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
    assert!(means[2] >= REACHED, "8 points: {means:?}");
}

#[test]
fn a_correction_tells_gains_and_keeps_what_was_best() {
    let mut rig = Rig::new(300.0, 1).channel(channel(0), 0.0);
    rig.gains[5] *= Complex64::from_polar(1.05, 0.02);
    let weights = first_drive();
    let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
    let played = [PlayedField::new(weights, field)];
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

/// From the third field on a measurement is worth more than any promise.
#[test]
fn a_drive_that_served_as_measured_is_given_again_after_three_fields() {
    let mut given_again = 0;
    for seed in 0..RIGS {
        let mut rig = Rig::new(300.0, seed)
            .scattered(0.05, 5.0)
            .loaded(&Finger::MID, [0.061, 0.052]);
        let mut weights = first_drive();
        let mut played = Vec::new();
        for fields in 1..=3 {
            let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
            played.push(PlayedField::new(weights, field));
            weights = correct(truth(), &corner(), &played, &RenderOptions::default()).unwrap();
            let told = weights.correction.as_ref().unwrap();
            let ratios = told.fields.iter().map(|field| field.min_ratio.unwrap());
            let served = ratios.fold(0.0, f64::max) >= REACHED;
            if fields < 3 || !served {
                continue;
            }
            let best = told.best_measured.unwrap() - 1;
            assert!(told.kept, "{seed}: {told:?}");
            assert_eq!(played[best].weights.weights, weights.weights);
            assert!(told.fields[best].min_ratio.unwrap() >= REACHED);
            given_again += 1;
        }
    }
    assert!(given_again >= 3, "{given_again}");
}

/// The scene with a calibration.
pub fn with(calibration: &Calibration, scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.actuators.calibration = Some(Arc::new(calibration.clone()));
    scene
}

pub fn rendered(scene: &Scene) -> Weights {
    render(truth(), scene, &RenderOptions::default())
        .unwrap()
        .weights
}

/// The calibration by one measured field of a scene.
fn taught_in(scene: &Scene, rig: &mut Rig) -> (Weights, Calibration) {
    let weights = rendered(scene);
    let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
    let played = [PlayedField::new(weights, field)];
    calibrate(truth(), scene, &played, &RenderOptions::default()).unwrap()
}

fn taught(rig: &mut Rig) -> (Weights, Calibration) {
    taught_in(&corner(), rig)
}

fn at(frequency_hz: f64, grid: [usize; 2], hot: usize) -> Scene {
    let mut scene = cell_scene(grid, hot, "");
    scene.frequency_hz = frequency_hz;
    scene
}

#[test]
fn one_field_calibrates_the_next_scenes() {
    // of a rig, its first scene and the next one: plain, calibrated, after a field of its own
    let course = |errors: [f64; 2], first: &Scene, next: &Scene| {
        let mut means = [0.0; 3];
        for seed in 0..RIGS {
            let rig = |hz| Rig::new(hz, seed).scattered(errors[0], errors[1]);
            let (_, calibration) = taught_in(first, &mut rig(first.frequency_hz));
            let mut rig = rig(next.frequency_hz);
            let calibrated = with(&calibration, next);
            let (own, _) = taught_in(&calibrated, &mut rig);
            let drives = [rendered(next), rendered(&calibrated), own];
            for (mean, drive) in means.iter_mut().zip(&drives) {
                *mean += served_in(next, &rig, drive) / RIGS as f64;
            }
        }
        eprintln!("{errors:?} {} Hz: {means:.4?}", next.frequency_hz);
        means
    };
    let off = course([0.02, 2.0], &at(330.0, [2, 2], 1), &at(330.0, [3, 3], 5));
    assert!(
        off[1] >= 0.99 && off[1] >= off[0] && off[2] >= 0.99,
        "{off:?}"
    );
    // on the mode at 299.4 Hz a field tells some dozen of 34 gains: better, not all
    let on = course([0.02, 2.0], &corner(), &at(300.0, [2, 2], 3));
    assert!(on[1] > on[0] + 0.1 && on[2] >= 0.99, "{on:?}");
}

#[test]
fn a_calibrated_scene_again_is_what_the_correction_gave() {
    let (corrected, calibration) = taught(&mut Rig::new(300.0, 2).scattered(0.02, 2.0));
    let again = rendered(&with(&calibration, &corner()));
    for (a, b) in again.weights.iter().zip(&corrected.weights) {
        assert!((a.value() - b.value()).norm() < 1e-6 * a.amplitude.max(1e-4));
    }
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
    let played = [PlayedField::new(weights, field)];
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
    volts.unit = Some(chladni_frf::ReferenceUnit::Volt);
    assert!(of(&volts).unwrap_err().to_string().contains("another unit"));
}

#[test]
fn a_correction_by_a_few_responses_carries_a_caution() {
    let mut rig = Rig::new(300.0, 1);
    let weights = first_drive();
    for (rows, is_few) in [
        (vec![20], true),
        (vec![3, 20, 40], true),
        ((0..8).collect(), false),
    ] {
        let field = rig.measured(&weights, NOISE, &rows);
        let played = [PlayedField::new(weights.clone(), field)];
        let corrected = correct(truth(), &corner(), &played, &RenderOptions::default()).unwrap();
        let mut findings = corrected.findings.iter();
        let swapped = findings
            .clone()
            .any(|finding| finding.code == "channels-swapped");
        assert!(!swapped, "{rows:?}");
        let said = findings.any(|finding| finding.code == "field-few-responses");
        assert_eq!(said, is_few, "{rows:?}");
    }
}

#[test]
fn a_correction_says_whether_the_fingers_of_the_scene_are_borne() {
    // amplifiers of 2 % and 2° leave too little for fingers after one field
    for (frequency_hz, scatter, borne) in [(330.0, 0.0, true), (330.0, 0.02, false)] {
        let mut scene = cell_scene([2, 2], 1, "[touch]\n");
        scene.frequency_hz = frequency_hz;
        let weights = rendered(&scene);
        let mut rig = Rig::new(frequency_hz, 2).scattered(scatter, 100.0 * scatter);
        let field = rig.measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
        let played = [PlayedField::new(weights, field)];
        let corrected = correct(truth(), &scene, &played, &RenderOptions::default()).unwrap();
        let told = corrected.touch.as_ref().expect("touched indices");
        assert_eq!(told.firmest.as_deref() == Some("mid"), borne, "{told:?}");
        let mut findings = corrected.findings.iter();
        let finding = findings.find(|finding| finding.code == "touch-corrected");
        let words = &finding.expect("a finding").text;
        assert_eq!(
            words.contains("does not tolerate a mid finger"),
            !borne,
            "{words}"
        );
    }
    let weights = first_drive();
    let field = Rig::new(300.0, 1).measured(&weights, NOISE, &(0..77).collect::<Vec<_>>());
    let played = [PlayedField::new(weights, field)];
    let plain = correct(truth(), &corner(), &played, &RenderOptions::default()).unwrap();
    assert!(plain.touch.is_none());
}
