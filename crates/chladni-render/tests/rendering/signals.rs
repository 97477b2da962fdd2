//! Drive signals: what is played is what the weights say.

use chladni_frf::ReferenceUnit;
use chladni_render::{
    evaluate_signal, play, render, signal_csv, Method, PlayOptions, Recorded, RenderOptions,
    Sidecar, SignalOptions, TimeEvent, Weights,
};
use num_complex::Complex64;
use std::f64::consts::TAU;

fn weights() -> Weights {
    let options = RenderOptions {
        method: Method::PressureMatching.into(),
        ..Default::default()
    };
    render(
        crate::common::truth(),
        &crate::common::cell_scene([2, 2], 1, ""),
        &options,
    )
    .unwrap()
    .weights
}

#[test]
fn each_channel_carries_the_phasor_of_its_weight() {
    let weights = weights();
    let scene = crate::common::cell_scene([2, 2], 1, "");
    let played = play(
        crate::common::truth(),
        &scene,
        Some(&weights),
        &PlayOptions::default(),
    )
    .unwrap();
    let signal = played.signal(&SignalOptions::default(), "").unwrap();
    assert_eq!(
        signal.drive.dim(),
        (96_001, 34),
        "two seconds where a scene says nothing"
    );
    // from 0.1 to 0.2 s are 30 periods of 300 Hz: the demodulated sum is the phasor
    for (k, weight) in weights.weights.iter().enumerate() {
        let phasor: Complex64 = (4800..9600)
            .map(|n| {
                signal.drive[[n, k]]
                    * Complex64::from_polar(2.0 / 4800.0, -TAU * 300.0 * n as f64 / 48_000.0)
            })
            .sum();
        let expected = weight.value();
        assert!(
            (phasor - expected).norm() < 1e-6 * expected.norm(),
            "{}: {phasor} {expected}",
            weight.reference
        );
    }
    assert!(
        signal.drive.row(0).iter().all(|&sample| sample == 0.0),
        "no click at the beginning"
    );
}

#[test]
fn the_table_lists_amplitude_and_phase() {
    let (weights, text) = (weights(), signal_csv(&weights()));
    assert_eq!(text.lines().count(), 35);
    let cells: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
    assert_eq!((cells[0], cells[1], cells[4]), ("101:+Z", "300", "N"));
    assert_eq!(
        cells[2].parse::<f64>().unwrap(),
        weights.weights[0].amplitude
    );
}

#[test]
fn the_peak_drive_is_the_peak_of_the_signal_whatever_the_tones() {
    let zones = "[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n";
    let burst = "[time]\n[[time.burst]]\nduration_s = 0.3\nramp_s = 0.02\n";
    for tones in ["300.0", "[260.0, 335.0]", "[260.0, 290.0, 335.0]"] {
        let scene = crate::common::scene(&format!("frequency_hz = {tones}\n{zones}{burst}"));
        let options = PlayOptions {
            render: RenderOptions {
                method: Method::PressureMatching.into(),
                ..Default::default()
            },
            area: false,
            ..Default::default()
        };
        let played = play(crate::common::truth(), &scene, None, &options).unwrap();
        let signal = played.signal(&SignalOptions::default(), "").unwrap();
        let peak = signal
            .drive
            .iter()
            .fold(0.0, |most: f64, v| most.max(v.abs()));
        let told = played.indices.peak_drive;
        assert!((told / peak - 1.0).abs() < 0.02, "{tones}: {told} {peak}");
        let steady = played.indices.steady_drive;
        assert!(told < 1.2 * steady, "{tones}: {told} {steady}");
    }
}

#[test]
fn a_late_event_is_judged_as_an_early_one() {
    let played = |start_s: f64| {
        let burst = format!("[time]\n[[time.burst]]\nduration_s = 0.1\nstart_s = {start_s}\n");
        let scene = crate::common::cell_scene([2, 2], 1, &burst);
        play(
            crate::common::truth(),
            &scene,
            Some(&weights()),
            &PlayOptions::default(),
        )
        .unwrap()
    };
    // whole blocks of samples
    let (early, late) = (played(0.0), played(3.2));
    let (one, other) = (early.indices.peak, late.indices.peak);
    let db = |level: Option<f64>| level.unwrap();
    assert!((db(one.worst_cold_db) - db(other.worst_cold_db)).abs() < 1e-6);
    assert!((db(one.worst_hot_db) - db(other.worst_hot_db)).abs() < 1e-6);
    assert!((db(other.worst_cold_s) - db(one.worst_cold_s) - 3.2).abs() < 1e-9);
    let (one, other) = (&early.traces, &late.traces);
    assert_eq!(other.drive.len(), other.cold_db.len());
    assert_eq!(other.drive.len() - one.drive.len(), 12_800);
    let loudest = |drive: &[f64]| drive.iter().position(|&size| size > 0.0).unwrap();
    assert_eq!(loudest(&other.drive) - loudest(&one.drive), 12_800);
}

#[test]
fn weights_of_another_panel_are_refused_and_actuators_left_out_are_named() {
    let played = |weights: &Weights, rest: &str| {
        let scene = crate::common::cell_scene([2, 2], 1, rest);
        let options = PlayOptions {
            area: false,
            ..PlayOptions::default()
        };
        play(crate::common::truth(), &scene, Some(weights), &options)
    };
    let weights = weights();
    let mut volts = weights.clone();
    for weight in &mut volts.weights {
        weight.unit = ReferenceUnit::Volt;
    }
    let error = played(&volts, "").unwrap_err();
    assert!(error.message.contains("different units"), "{error}");
    assert_eq!(error.field.as_deref(), Some("weights"), "{error}");
    let mut foreign = weights.clone();
    foreign.weights[3].reference = "4711:+Z".parse().unwrap();
    let error = played(&foreign, "").unwrap_err();
    assert!(error.message.contains("the data lack"), "{error}");
    assert_eq!(error.found.as_deref(), Some("4711:+Z"), "{error}");
    let left_out = |rest: &str| {
        let findings = played(&weights, rest).unwrap().findings;
        let mut named = findings
            .iter()
            .filter(|finding| finding.code == "actuator-not-played");
        named.next().map_or(0, |finding| finding.dofs.len())
    };
    for (rest, count) in [
        ("", 0),
        ("[actuators]\ndead = [\"110:+Z\"]\n", 1),
        ("[actuators]\nuse = [\"101:+Z\", \"102:-Z\"]\n", 32),
    ] {
        assert_eq!(left_out(rest), count, "{rest}");
    }
}

#[test]
fn a_recording_has_the_gains_and_the_steady_drive_of_what_was_played() {
    let burst = "duration_s = 0.1\nramp_s = 0.02\n";
    let scene = crate::common::cell_scene(
        [2, 2],
        1,
        &format!(
            "[time]\nlevel = \"compensated\"\n[[time.burst]]\n{burst}repeat = [2, 0.3]\n\
             [[time.burst]]\nstart_s = 0.8\nhot = [4]\n{burst}"
        ),
    );
    let options = PlayOptions {
        area: false,
        ..PlayOptions::default()
    };
    let played = play(crate::common::truth(), &scene, None, &options).unwrap();
    let signal = played.signal(&SignalOptions::default(), "").unwrap();
    let recorded = Recorded {
        rate_hz: 48_000.0,
        references: played.references.clone(),
        drive: signal.drive,
    };
    let judged = |events: &[TimeEvent]| {
        let judged = evaluate_signal(&recorded, events, &scene, crate::common::truth());
        judged.unwrap().0
    };
    let own = judged(&played.indices.events);
    assert_eq!(own.events, played.indices.events);
    assert!(own.events[0].gain > 1.1, "{:?}", own.events);
    let ratio = own.steady_drive / played.indices.steady_drive;
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    // of another program: as loud as it is
    let foreign = judged(&[]);
    assert!(foreign.events.iter().all(|event| event.gain == 1.0));
    assert!(foreign.steady_drive > own.steady_drive);
}

#[test]
fn other_files_in_place_of_a_sidecar_are_called_by_their_kind() {
    let model = serde_json::to_string(crate::common::truth()).unwrap();
    let weights = r#"{"format": "chladni.weights", "version": 1}"#;
    for (text, message) in [
        (&*model, "a model, not the sidecar of a signal"),
        (weights, "a weights file, not the sidecar of a signal"),
    ] {
        let error = Sidecar::parse(text).unwrap_err();
        assert_eq!(error.message, message);
        assert_eq!(error.field.as_deref(), Some("format"));
        assert_eq!(error.expected.as_deref(), Some("chladni.signal version 1"));
        assert!(error.help.is_some());
    }
    let own = Sidecar::parse(r#"{"format": "chladni.signal", "version": 1}"#).unwrap_err();
    assert_eq!(own.field.as_deref(), Some("rate_hz"), "{own}");
}
