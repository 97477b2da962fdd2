//! Fingers, stress tables and frequency sweeps, judged by the true plate.

use crate::common::{cell_scene, truth};
use chladni_frf::{ErrorKind, FieldPoint, MeasuredField, ModalModel, Scaling};
use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::{
    calibrate, evaluate, finger_places, play, render, stress, sweep, Drift, Finger, Ground, Method,
    On, PlayOptions, PlayedField, RenderOptions, Scene, StressOptions, StressRow, Threshold,
    ThresholdTable, Weights,
};
use ndarray::Array1;
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// The panel with driving points; few lines, the truth is what is used.
fn simulation() -> &'static Simulation {
    static PANEL: OnceLock<Simulation> = OnceLock::new();
    PANEL.get_or_init(|| {
        let mut panel = Panel::default();
        (
            panel.frf.start_hz,
            panel.frf.step_hz,
            panel.responses.at_references,
        ) = (100.0, 300.0, true);
        simulate(&panel, None, None).unwrap()
    })
}

fn corner(frequency_hz: f64) -> Scene {
    Scene {
        frequency_hz,
        ..cell_scene([2, 2], 1, "area_m = [0.034, 0.025, 0.234, 0.145]\n")
    }
}

fn weights(scene: &Scene) -> Weights {
    render(
        &simulation().truth,
        scene,
        &RenderOptions {
            method: Method::Mls.into(),
            ..Default::default()
        },
    )
    .unwrap()
    .weights
}

fn trial<'a>(rows: &'a [StressRow], name: &str) -> &'a StressRow {
    rows.iter()
        .find(|row| row.trial.contains(name))
        .unwrap_or_else(|| panic!("{name}: {rows:?}"))
}

/// Share of judged responses served on the true plate with a finger, from the plate's own
/// shapes: all modes, rigid ones too.
fn touched_on_plate(weights: &Weights, scene: &Scene, place: [f64; 2]) -> f64 {
    let (panel, plate) = (Panel::default(), &simulation().plate);
    let evaluation = evaluate(weights, scene, On::Model(&simulation().truth)).unwrap();
    let drive: Array1<Complex64> = weights
        .weights
        .iter()
        .map(|weight| weight.value())
        .collect();
    let (places, actuators) = (&evaluation.field.positions_m, panel.layout().references_m);
    let mobility = |to: &[[f64; 2]], from: &[[f64; 2]]| {
        plate.mobility_matrix(to, from, scene.frequency_hz).unwrap()
    };
    let free_here = mobility(&[place], &actuators).dot(&drive)[0];
    let force = free_here
        / (Finger::default().impedance(scene.frequency_hz).inv()
            + mobility(&[place], &[place])[[0, 0]]);
    let field = mobility(places, &actuators).dot(&drive)
        - mobility(places, &[place]).column(0).mapv(|y| y * force);
    let inside = |k: usize| match evaluation.field.ground[k] {
        Ground::Hot => Some(evaluation.limits.is_felt(field[k].norm())),
        Ground::Cold => Some(evaluation.limits.is_quiet(field[k].norm())),
        Ground::Ignored => None,
    };
    let judged: Vec<bool> = (0..places.len()).filter_map(inside).collect();
    judged.iter().filter(|&&served| served).count() as f64 / judged.len() as f64
}

#[test]
fn the_touched_field_of_the_model_is_that_of_the_plate() {
    for frequency_hz in [300.0, 330.0] {
        let scene = corner(frequency_hz);
        let weights = weights(&scene);
        let (rows, _) = stress(
            &weights,
            &scene,
            &simulation().truth,
            &StressOptions::default(),
        )
        .unwrap();
        let field = evaluate(&weights, &scene, On::Model(&simulation().truth))
            .unwrap()
            .field;
        let on_plate: Vec<f64> = finger_places(&field)
            .into_iter()
            .map(|place| touched_on_plate(&weights, &scene, place))
            .collect();
        let finger = trial(&rows, "finger");
        assert_eq!(finger.cases, on_plate.len());
        let mean = on_plate.iter().sum::<f64>() / on_plate.len() as f64;
        // one response of 68 more or less: residual terms are no part of the finger's own
        // mobility
        assert!(
            (finger.success_mean - mean).abs() < 0.03,
            "{frequency_hz} Hz: model {}, plate {mean}",
            finger.success_mean
        );
    }
}

#[test]
fn a_finger_breaks_a_drive_at_a_resonance_and_hardly_one_between_modes() {
    let touched = |frequency_hz: f64| {
        let scene = corner(frequency_hz);
        trial(
            &stress(
                &weights(&scene),
                &scene,
                &simulation().truth,
                &StressOptions::default(),
            )
            .unwrap()
            .0,
            "finger",
        )
        .success_worst_5_percent
    };
    let (at_the_mode, between) = (touched(300.0), touched(330.0));
    assert!(
        at_the_mode < 0.7 && between > 0.9,
        "{at_the_mode} {between}"
    );
}

#[test]
fn the_sweep_suggests_a_frequency_between_modes() {
    let found = sweep(
        &simulation().truth,
        &corner(300.0),
        &RenderOptions::default(),
        [290.0, 340.0],
    )
    .unwrap();
    let suggested = found.suggested_hz.expect("a suggestion");
    assert!(suggested > 310.0, "{suggested} Hz");
    let at = |hz: f64| {
        found
            .frequencies
            .iter()
            .find(|f| f.frequency_hz == hz)
            .unwrap()
    };
    assert!(
        at(suggested).touched_ratio.unwrap() >= 0.93 && at(suggested).on_mode_hz.is_none(),
        "{:?}",
        at(suggested)
    );
    assert!(
        (at(300.0).on_mode_hz.unwrap() - 299.4).abs() < 0.1
            && at(300.0).touched_ratio.unwrap() < 0.7
    );
    let warned = weights(&corner(300.0))
        .findings
        .iter()
        .any(|warning| warning.contains("299.4 Hz is 0.6 Hz from the drive"));
    assert!(
        warned
            && !weights(&corner(330.0))
                .findings
                .iter()
                .any(|warning| warning.code == "mode-on-drive")
    );
    for (range, help) in [
        ([340.0, 290.0], "the lower frequency first"),
        ([290.0, 290.0], "the lower frequency first"),
        ([0.0, 100.0], "above 0"),
        ([100.0, 1e6], "narrow the range"),
    ] {
        let error = sweep(
            &simulation().truth,
            &corner(300.0),
            &RenderOptions::default(),
            range,
        )
        .map(|_| ())
        .unwrap_err();
        assert!(
            error.kind == ErrorKind::Usage && error.to_string().starts_with("sweep: "),
            "{error}"
        );
        assert!(error.to_string().contains(help), "{help}: {error}");
    }
}

#[test]
fn a_sweep_leaves_out_what_its_threshold_does_not_cover() {
    let covered = |range| {
        let mut scene = corner(330.0);
        scene.threshold = Threshold::Table(ThresholdTable {
            file: "own.csv".into(),
            frequency_hz: vec![300.0, 340.0],
            velocity_m_per_s: vec![2e-4; 2],
        });
        sweep(
            &simulation().truth,
            &scene,
            &RenderOptions::default(),
            range,
        )
    };
    let found = covered([330.0, 350.0]).unwrap();
    let last = found.frequencies.last().unwrap();
    assert_eq!((found.frequencies.len(), last.frequency_hz), (6, 340.0));
    assert!(covered([350.0, 360.0]).is_err());
    // as wide as the refusal of wider ones says
    assert!(covered([300.0, 1300.0]).is_ok());
}

#[test]
fn touch_needs_mass_scaled_modes_and_says_so() {
    let unscaled = ModalModel {
        scaling: Scaling::Unscaled,
        ..truth().clone()
    };
    let scene = corner(300.0);
    let (rows, findings) = stress(
        &weights(&scene),
        &scene,
        &unscaled,
        &StressOptions::default(),
    )
    .unwrap();
    assert!(
        rows.iter().all(|row| !row.trial.contains("finger"))
            && findings.iter().any(|f| f.contains("mass-scaled")),
        "{findings:?}"
    );
    let swept = sweep(&unscaled, &scene, &RenderOptions::default(), [300.0, 302.0]).unwrap();
    assert!(swept.frequencies.iter().all(|f| f.touched_ratio.is_none()));
}

#[test]
fn trials_do_what_they_are_called() {
    let scene = corner(330.0);
    let weights = weights(&scene);
    let of = |options: StressOptions| {
        stress(&weights, &scene, &simulation().truth, &options)
            .unwrap()
            .0
    };
    let gentle = StressOptions {
        amplitude_relative: 0.0,
        phase_deg: 0.0,
        converter_bits: 24,
        common_shift: 0.0,
        ..Default::default()
    };
    let rows = of(StressOptions {
        draws: 40,
        ..gentle
    });
    for name in [
        "none",
        "errors of the fit",
        "all frequencies",
        "amplitudes",
        "converter",
    ] {
        assert_eq!(
            (
                trial(&rows, name).success_mean,
                trial(&rows, name).min_worst_5_percent
            ),
            (1.0, 1.0),
            "{name}: the truth has no error bars"
        );
    }
    assert_eq!(
        (trial(&rows, "dead").cases, trial(&rows, "drift").cases),
        (34, 40)
    );
    assert!(trial(&rows, "dead").success_worst_5_percent < 1.0);
    let harsh = of(StressOptions {
        amplitude_relative: 0.3,
        phase_deg: 30.0,
        converter_bits: 2,
        common_shift: 0.1,
        draws: 40,
        ..Default::default()
    });
    for name in ["all frequencies", "amplitudes", "converter"] {
        assert!(
            trial(&harsh, name).success_worst_5_percent < 0.95,
            "{name}: {:?}",
            trial(&harsh, name)
        );
    }
    assert_eq!(
        of(StressOptions::default()),
        of(StressOptions::default()),
        "the same seed, the same table"
    );
}

/// True where 95 % of the hot and of the cold responses are served on a rig of a seed: gains
/// of 2 % and 2°, natural frequencies of 0.1 %, a light finger on a hot response.
fn survives(weights: &Weights, scene: &Scene, seed: u64) -> bool {
    let errors = crate::common::Errors {
        frequency: 1e-3,
        loss_factor: 0.0,
        shape: 0.0,
        residual: 0.0,
    };
    let panel = crate::common::disturbed(&simulation().truth, errors, seed);
    let mut rig = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rig) };
    let mut driven = weights.clone();
    for weight in &mut driven.weights {
        let gain = Complex64::from_polar(1.0 + 0.02 * normal(), 2f64.to_radians() * normal());
        let value = weight.value() * gain;
        (weight.re, weight.im) = (value.re, value.im);
    }
    let evaluation = evaluate(&driven, scene, On::Model(&panel)).unwrap();
    let field = &evaluation.field;
    let hot = (0..field.ground.len()).filter(|&k| field.ground[k] == Ground::Hot);
    let hot: Vec<usize> = hot.collect();
    let here = hot[seed as usize * 7 % hot.len()];
    let row = |k: usize| {
        let dof = field.responses[k];
        panel
            .responses
            .iter()
            .position(|known| *known == dof)
            .unwrap()
    };
    let omega = TAU * scene.frequency_hz;
    let from_finger = |k: usize| -> Complex64 {
        let [to, from] = [row(k), row(here)];
        let modes = panel
            .modes
            .iter()
            .map(|mode| mode.structural_factor(omega) * mode.shape.0[to] * mode.shape.0[from]);
        modes.sum::<Complex64>() * Complex64::new(0.0, omega)
    };
    let impedance = Finger::LIGHT.impedance(scene.frequency_hz);
    let force = field.velocity_m_per_s[here] / (impedance.inv() + from_finger(here));
    let mut counts = [[0.0; 2]; 2];
    for k in 0..field.ground.len() {
        let speed = (field.velocity_m_per_s[k] - from_finger(k) * force).norm();
        let (kind, inside) = match field.ground[k] {
            Ground::Hot => (0, evaluation.limits.is_felt(speed)),
            Ground::Cold => (1, evaluation.limits.is_quiet(speed)),
            Ground::Ignored => continue,
        };
        counts[kind][0] += f64::from(u8::from(inside));
        counts[kind][1] += 1.0;
    }
    counts.iter().all(|[inside, all]| inside / all >= 0.95)
}

#[test]
fn the_share_of_rigs_that_a_drive_serves_is_told_and_true() {
    const RIGS: u64 = 100;
    let default = |hz: f64| {
        let mut scene = corner(hz);
        scene.drift = Some(Drift {
            drive_relative: Some(0.02),
            ..Drift::default()
        });
        render(&simulation().truth, &scene, &RenderOptions::default())
            .unwrap()
            .weights
    };
    for (scene, weights, is_sure) in [
        (corner(300.0), default(300.0), false),
        (corner(330.0), default(330.0), true),
        (corner(318.0), weights(&corner(318.0)), false),
    ] {
        let endurance = weights.endurance.expect("a drive that is met");
        assert!(endurance.touch_is_known && endurance.rigs == 200);
        let served = (0..RIGS).filter(|&seed| survives(&weights, &scene, seed));
        let served = served.count() as f64 / RIGS as f64;
        eprintln!("{} Hz: {served} {endurance:?}", scene.frequency_hz);
        // three standard deviations of the two counts at their worst
        assert!(
            (served - endurance.survival_ratio).abs() <= 0.18,
            "{} Hz: {served} of {endurance:?}",
            scene.frequency_hz
        );
        let mut warned = weights.findings.iter();
        let warned = warned.any(|finding| finding.code == "rig-sensitive");
        assert_eq!(warned, endurance.survival_ratio < 0.95, "{endurance:?}");
        assert!(!is_sure || !warned, "{endurance:?}");
    }
}

#[test]
fn a_calibrated_rig_errs_by_what_its_calibration_left() {
    let told = |scene: &Scene| {
        let rendering = render(&simulation().truth, scene, &RenderOptions::default());
        rendering.unwrap().weights.endurance.unwrap()
    };
    let plain = told(&corner(330.0));
    assert!((plain.gain_error - 0.0402).abs() < 1e-4, "{plain:?}");
    let weights = weights(&corner(330.0));
    let field = evaluate(&weights, &corner(330.0), On::Model(&simulation().truth)).unwrap();
    let points = field
        .field
        .responses
        .iter()
        .zip(&field.field.velocity_m_per_s);
    let seen = MeasuredField {
        frequency_hz: 330.0,
        weights_sha256: None,
        magnitudes_only: false,
        points: points
            .map(|(&response, &velocity_m_per_s)| FieldPoint {
                response,
                velocity_m_per_s,
                std_m_per_s: Some(1e-6),
                repeats: 1,
            })
            .collect(),
    };
    let played = [PlayedField::new(weights, seen)];
    let options = RenderOptions::default();
    let (_, calibration) =
        calibrate(&simulation().truth, &corner(330.0), &played, &options).unwrap();
    let mut scene = corner(330.0);
    scene.actuators.calibration = Some(std::sync::Arc::new(calibration));
    let calibrated = told(&scene);
    assert!(
        calibrated.gain_error < 0.9 * plain.gain_error,
        "{calibrated:?}"
    );
}

#[test]
fn a_drive_outside_the_fitted_band_is_said_and_never_suggested() {
    let mut model = simulation().truth.clone();
    model.band_hz[1] = 315.0;
    let said = |model: &ModalModel, hz: f64| {
        let rendering = render(model, &corner(hz), &RenderOptions::default()).unwrap();
        let findings = rendering.weights.findings;
        let found = findings.iter().find(|one| one.code == "drive-outside-band");
        found.map(|one| one.text.clone())
    };
    let text = said(&model, 330.0).expect("a finding");
    assert!(text.contains("330 Hz") && text.contains("315 Hz"), "{text}");
    assert_eq!(said(&model, 315.0), None);
    let played = play(&model, &corner(330.0), None, &PlayOptions::default()).unwrap();
    let told = played.findings.iter();
    assert!(told.filter(|one| one.code == "drive-outside-band").count() == 1);
    let options = RenderOptions::default();
    let found = sweep(&model, &corner(300.0), &options, [310.0, 340.0]).unwrap();
    assert!(found.suggested_hz.unwrap() <= 315.0, "{found:?}");
    assert_eq!(found.frequencies.len(), 16);
    model.band_hz = [0.0, 0.0];
    assert_eq!(said(&model, 330.0), None);
}
