//! Scenes in time: what is simulated is what happens, and cold ground stays quiet.

use crate::common::{cell_scene, disturbed, scene, DRIFT, FIT_40_DB};
use chladni_frf::{ErrorKind, ModalModel};
use chladni_plate::{simulate, Panel};
use chladni_render::{
    evaluate_signal, play, render, ChannelMap, Ground, Measure, PlayOptions, Played, Ramps,
    Recorded, RenderOptions, SampleFormat, Scene, SignalOptions, TimeIndices,
};
use ndarray::Array2;
use std::sync::OnceLock;

/// The panel, measured from below its lowest mode on.
pub(crate) fn truth() -> &'static ModalModel {
    static TRUTH: OnceLock<ModalModel> = OnceLock::new();
    TRUTH.get_or_init(|| {
        let mut panel = Panel::default();
        panel.frf.step_hz = 99.8;
        simulate(&panel, None, None).unwrap().truth
    })
}

pub(crate) const BURST: &str = "[time]\n[[time.burst]]\nduration_s = 0.1\nramp_s = 0.015\n";

pub(crate) fn played(model: &ModalModel, scene: &Scene, ramps: Ramps) -> Played {
    let options = PlayOptions {
        ramps: Some(ramps),
        ..PlayOptions::default()
    };
    play(model, scene, None, &options).unwrap()
}

/// The panel measured every 4 mm.
fn closely(loss_factor: Option<f64>) -> ModalModel {
    let mut panel = Panel::default();
    panel.frf.step_hz = 499.0;
    (panel.responses.grid, panel.responses.spacing_m) = ([51, 31], 0.004);
    if let Some(loss_factor) = loss_factor {
        panel.plate.loss_factor = chladni_plate::LossFactor::Common(loss_factor);
    }
    simulate(&panel, None, None).unwrap().truth
}

/// The drive as it would be recorded, on another panel.
fn on(model: &ModalModel, scene: &Scene, played: &Played) -> TimeIndices {
    let signal = played.signal(&SignalOptions::default(), "").unwrap();
    let recorded = Recorded {
        rate_hz: 48_000.0,
        // the same actuators, whatever numbers their nodes have
        references: model.references.clone(),
        drive: signal.drive,
    };
    evaluate_signal(&recorded, &played.indices.events, scene, model)
        .unwrap()
        .0
}

#[test]
fn the_plateau_is_what_render_says() {
    let scene = cell_scene(
        [2, 2],
        1,
        "[time]\n[[time.burst]]\nduration_s = 2.5\nramp_s = 0.02\n",
    );
    let rendering = render(truth(), &scene, &RenderOptions::default()).unwrap();
    let hot = rendering
        .field
        .velocity_m_per_s
        .iter()
        .zip(&rendering.field.ground)
        .filter(|(_, ground)| **ground == Ground::Hot)
        .map(|(v, _)| v.norm())
        .fold(f64::INFINITY, f64::min);
    let expected_db = 20.0 * (hot / rendering.limits.hot_m_per_s).log10();
    // a long tone ends at its own level
    let summed = played(truth(), &scene, Ramps::Modal).indices.summed;
    let found_db = summed.worst_hot_db.unwrap();
    assert!(
        (found_db - expected_db).abs() < 0.01,
        "{found_db} {expected_db}"
    );
}

#[test]
fn a_burst_from_a_fitted_model_stays_quiet_on_the_true_plate_with_modal_ramps_only() {
    let scene = cell_scene([2, 2], 1, BURST);
    let fitted = disturbed(truth(), FIT_40_DB, 1);
    let plate = closely(None);
    let [modal, plain] = [Ramps::Modal, Ramps::Plain].map(|ramps| {
        let played = played(&fitted, &scene, ramps);
        (on(&plate, &scene, &played), played)
    });
    let (indices, made) = modal;
    assert!(indices.peak.hot_held_ratio >= 0.98, "{:?}", indices.peak);
    assert!(
        1.0 - indices.peak.ever_over_ratio >= 0.98,
        "{:?}",
        indices.peak
    );
    assert!(
        made.indices.peak_drive <= 1.05 * made.indices.steady_drive,
        "{:?}",
        made.indices
    );
    let (indices, _) = plain;
    assert!(indices.peak.hot_held_ratio < 0.95, "{:?}", indices.peak);
    assert!(
        1.0 - indices.peak.ever_over_ratio < 0.95,
        "{:?}",
        indices.peak
    );
}

#[test]
fn drift_costs_half_a_decibel() {
    let scene = cell_scene([2, 2], 1, BURST);
    let fitted = disturbed(truth(), FIT_40_DB, 1);
    let made = played(&fitted, &scene, Ramps::Modal);
    let own = on(truth(), &scene, &made).peak;
    for seed in 0..8 {
        let drifted = on(&disturbed(truth(), DRIFT, seed), &scene, &made).peak;
        assert!(
            drifted.worst_cold_db.unwrap() <= own.worst_cold_db.unwrap() + 0.5
                && drifted.worst_hot_db.unwrap() >= own.worst_hot_db.unwrap() - 0.5,
            "seed {seed}: {drifted:?} for {own:?}"
        );
    }
}

#[test]
fn a_recorded_drive_is_judged_as_the_drive_itself() {
    let scene = cell_scene([2, 2], 1, BURST);
    let made = played(truth(), &scene, Ramps::Modal);
    let again = on(truth(), &scene, &made);
    for measure in Measure::ALL {
        let (a, b) = (made.indices.by(measure), again.by(measure));
        let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs() < 0.05;
        assert!(
            near(a.worst_cold_db, b.worst_cold_db) && near(a.worst_hot_db, b.worst_hot_db),
            "{measure:?}: {a:?} {b:?}"
        );
    }
}

#[test]
fn two_tones_have_a_matrix_each_and_their_signal_is_judged_tone_by_tone() {
    let with_ramps = |ramp_s: f64| {
        scene(&format!(
            "frequency_hz = [260.0, 335.0]\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, \
             0.0, 0.268, 0.170]\n[time]\n[[time.burst]]\nduration_s = 0.2\nramp_s = {ramp_s}\n"
        ))
    };
    let weights = render(truth(), &with_ramps(0.05), &RenderOptions::default())
        .unwrap()
        .weights;
    let made = |ramp_s: f64, ramps: Ramps| {
        let options = PlayOptions {
            ramps: Some(ramps),
            area: false,
            ..PlayOptions::default()
        };
        play(truth(), &with_ramps(ramp_s), Some(&weights), &options).unwrap()
    };
    let cold_db = |ramps: Ramps| made(0.015, ramps).indices.peak.worst_cold_db.unwrap();
    let [modal_db, plain_db] = [Ramps::Modal, Ramps::Plain].map(cold_db);
    assert!(modal_db < plain_db - 2.0, "{modal_db} {plain_db}");
    let slow = made(0.05, Ramps::Modal);
    let signal = slow.signal(&SignalOptions::default(), "").unwrap();
    let recorded = Recorded {
        rate_hz: 48_000.0,
        references: truth().references.clone(),
        drive: signal.drive,
    };
    let judged = |ramp_s: f64| {
        let events = &slow.indices.events;
        evaluate_signal(&recorded, events, &with_ramps(ramp_s), truth()).unwrap()
    };
    let (again, findings) = judged(0.05);
    assert!(findings.is_empty(), "{findings:?}");
    let (a, b) = (slow.indices.peak, again.peak);
    let near = |a: Option<f64>, b: Option<f64>| (a.unwrap() - b.unwrap()).abs() < 0.2;
    assert!(
        near(a.worst_cold_db, b.worst_cold_db) && near(a.worst_hot_db, b.worst_hot_db),
        "{a:?} {b:?}"
    );
    let close = judged(0.015).1;
    assert!(close.iter().any(|f| f.code == "time-tones-close"));
}

#[test]
fn a_tone_of_the_weights_that_the_scene_lacks_is_named() {
    let of = |frequencies_hz: &str| {
        scene(&format!(
            "frequency_hz = {frequencies_hz}\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, \
             0.0, 0.268, 0.170]\n[time]\n[[time.burst]]\nduration_s = 0.2\nramp_s = 0.05\n"
        ))
    };
    let both = of("[260.0, 335.0]");
    let weights = render(truth(), &both, &RenderOptions::default())
        .unwrap()
        .weights;
    let not_played = |scene: &Scene| {
        let options = PlayOptions {
            area: false,
            ..PlayOptions::default()
        };
        let played = play(truth(), scene, Some(&weights), &options).unwrap();
        let mut findings = played.findings.into_iter();
        findings.find(|finding| finding.code == "tone-not-played")
    };
    let said = not_played(&of("260.0")).unwrap().text;
    assert!(said.contains("335 Hz") && !said.contains("260"), "{said}");
    assert!(not_played(&both).is_none());
}

#[test]
fn a_ramp_is_found_that_keeps_every_limit() {
    for cell in [1, 4] {
        let scene = cell_scene([2, 2], cell, "[time]\n[[time.burst]]\nduration_s = 0.1\n");
        let made = played(truth(), &scene, Ramps::Modal);
        let indices = &made.indices;
        assert!(
            indices.ramp_s <= 0.0101 && indices.peak.ever_over_ratio == 0.0,
            "cell {cell}: {indices:?}"
        );
        assert!(indices.peak.hot_held_ratio == 1.0 && made.feasible);
    }
}

#[test]
fn ramps_of_the_ninth_in_the_middle_are_quick_at_a_slightly_lower_level() {
    for loss_factor in [0.005, 0.01, 0.03] {
        let mut panel = Panel::default();
        panel.frf.step_hz = 99.8;
        panel.plate.loss_factor = chladni_plate::LossFactor::Common(loss_factor);
        let model = simulate(&panel, None, None).unwrap().truth;
        for frequency_hz in [300.0, 330.0] {
            let case = format!("{frequency_hz} Hz, {loss_factor}");
            let made = played(
                &model,
                &scene(&format!(
                    "frequency_hz = {frequency_hz:?}\n[zones]\ngrid = [3, 3]\nhot = [5]\ncells_m = \
                     [0.0, 0.0, 0.268, 0.170]\n[time]\n[[time.burst]]\nduration_s = 0.1\n"
                )),
                Ramps::Modal,
            );
            let (peak, event) = (made.indices.peak, &made.indices.events[0]);
            assert!(event.ramp_s <= 0.0101, "{case}: {event:?}");
            assert!(
                peak.ever_over_ratio == 0.0 && peak.hot_held_ratio == 1.0,
                "{case}: {peak:?}"
            );
            let lower_db = -20.0 * event.gain.log10();
            assert!((0.0..=0.6).contains(&lower_db), "{case}: {lower_db} dB");
            let told = made.findings.iter().any(|f| f.code == "time-lowered");
            assert_eq!(told, lower_db > 0.0, "{case}: {:?}", made.findings);
        }
    }
}

#[test]
fn an_envelope_program_keeps_every_limit_at_5_ms_within_2_mn() {
    let scene = cell_scene(
        [2, 2],
        1,
        "[actuators]\nmax_force_n = 0.002\n[time]\n[[time.burst]]\nduration_s = 0.1\nramp_s = \
         0.005\n",
    );
    let made = played(truth(), &scene, Ramps::Program);
    let peak = made.indices.peak;
    assert!(
        peak.ever_over_ratio == 0.0 && peak.hot_held_ratio == 1.0,
        "{peak:?}"
    );
    assert!(made.indices.peak_drive <= 0.002 * (1.0 + 1e-9));
    let plain = played(truth(), &scene, Ramps::Plain).indices.peak;
    assert!(plain.worst_cold_db.unwrap() > 4.0, "{plain:?}");
}

#[test]
fn a_moving_spot_keeps_every_limit() {
    let scene = cell_scene(
        [2, 2],
        1,
        "[time]\n[[time.move]]\npath_m = [[0.070, 0.085], [0.198, 0.085]]\nspeed_m_per_s = \
         0.2\nhot_radius_m = 0.025\nquiet_from_m = 0.060\nramp_s = 0.015\n",
    );
    let made = played(truth(), &scene, Ramps::Modal);
    let peak = made.indices.peak;
    assert!(
        peak.ever_over_ratio == 0.0 && peak.hot_held_ratio == 1.0 && made.feasible,
        "{peak:?} {:?}",
        made.findings
    );
    // the ground at the end of the path is hot when the spot comes, not late
    assert!(peak.hot_reached_s.unwrap() <= 0.015, "{peak:?}");
}

#[test]
fn fades_keep_common_cold_ground_quiet() {
    for fade_s in [0.02, 0.05, 0.1] {
        let scene = cell_scene(
            [2, 2],
            1,
            &format!(
                "[time]\n[[time.burst]]\nduration_s = 0.4\nramp_s = 0.02\n[[time.fade]]\nfrom = \
                 [1]\nto = [2]\nstart_s = 0.12\nfade_s = {fade_s}\n"
            ),
        );
        let peak = played(truth(), &scene, Ramps::Modal).indices.peak;
        assert!(peak.worst_cold_db.unwrap() <= -1.0, "{fade_s}: {peak:?}");
        assert_eq!(peak.hot_held_ratio, 1.0, "{fade_s}: {peak:?}");
    }
}

#[test]
fn short_bursts_are_compensated_for_the_sense_of_touch() {
    let scene = |level: &str| {
        cell_scene(
            [2, 2],
            1,
            &format!(
                "[time]\nlevel = \"{level}\"\n[[time.burst]]\nduration_s = 0.1\nramp_s = 0.01\n"
            ),
        )
    };
    let steady = played(truth(), &scene("steady"), Ramps::Modal);
    let louder = played(truth(), &scene("compensated"), Ramps::Modal);
    let level = steady.indices.summed.worst_hot_db.unwrap();
    assert!((-4.6..-3.0).contains(&level), "{level}");
    assert!(louder.indices.summed.worst_hot_db.unwrap().abs() < 1e-3);
    let gain = 20.0 * louder.indices.events[0].gain.log10();
    assert!((gain + level).abs() < 1e-6, "{gain} {level}");
    assert!(steady.findings.iter().any(|f| f.code == "time-burst-short"));
}

#[test]
fn signals_have_the_stated_rate_channels_and_values() {
    let scene = cell_scene([2, 2], 1, BURST);
    let made = played(truth(), &scene, Ramps::Modal);
    let exact = made
        .signal(&SignalOptions::default(), "scene.toml")
        .unwrap();
    for (format, bits, error) in [
        (SampleFormat::F32, 32, 1e-7),
        (SampleFormat::I24, 24, 1.0 / (1 << 23) as f64),
        (SampleFormat::I16, 16, 1.0 / (1 << 15) as f64),
    ] {
        let bytes = exact.wav(format).unwrap();
        let mut reader = hound::WavReader::new(std::io::Cursor::new(bytes)).unwrap();
        let spec = reader.spec();
        assert_eq!(
            (spec.channels, spec.sample_rate, spec.bits_per_sample),
            (34, 48_000, bits)
        );
        let values: Vec<f64> = match format {
            SampleFormat::F32 => reader
                .samples::<f32>()
                .map(|v| f64::from(v.unwrap()))
                .collect(),
            _ => {
                let scale = f64::from(1u32 << (bits - 1));
                reader
                    .samples::<i32>()
                    .map(|v| f64::from(v.unwrap()) / scale)
                    .collect()
            }
        };
        let full_scale = exact.sidecar.channels[0].full_scale;
        assert_eq!(values.len(), exact.drive.len());
        for (value, drive) in values.iter().zip(&exact.drive) {
            assert!((value * full_scale - drive).abs() <= 0.51 * error * full_scale);
        }
    }
    let peak = exact
        .drive
        .iter()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    assert!(exact.peak <= 1.0 && exact.peak > 0.3 && peak > 0.0);
}

#[test]
fn sixteen_bits_err_by_less_than_a_thousandth_of_the_cold_limit() {
    let scene = cell_scene([2, 2], 1, BURST);
    let made = played(truth(), &scene, Ramps::Modal);
    let exact = made.signal(&SignalOptions::default(), "").unwrap();
    let bytes = exact.wav(SampleFormat::I16).unwrap();
    let mut reader = hound::WavReader::new(std::io::Cursor::new(bytes)).unwrap();
    let values: Vec<f64> = reader
        .samples::<i32>()
        .map(|value| f64::from(value.unwrap()) / 32_768.0)
        .collect();
    let samples = Array2::from_shape_vec(exact.drive.dim(), values).unwrap();
    let coarse = Recorded::from_samples(&samples, 48_000.0, &exact.sidecar).unwrap();
    let error = Recorded {
        drive: &coarse.drive - &exact.drive,
        ..coarse
    };
    let moved = evaluate_signal(&error, &made.indices.events, &scene, truth())
        .unwrap()
        .0;
    let level = moved.peak.worst_cold_db.unwrap();
    assert!(level <= -60.0, "{level} dB of the cold limit");
}

#[test]
fn a_channel_map_says_where_an_actuator_is() {
    let scene = cell_scene(
        [2, 2],
        1,
        &format!("[actuators]\nuse = [\"101:+Z\", \"110:+Z\", \"120:+Z\"]\n{BURST}"),
    );
    let made = played(truth(), &scene, Ramps::Plain);
    let with = |text: &str, full_scale| {
        let options = SignalOptions {
            channels: Some(ChannelMap::parse(text).unwrap()),
            full_scale,
            ..SignalOptions::default()
        };
        made.signal(&options, "")
    };
    let map = "channel,reference,gain\n5,110:+Z,2.0\n1,101:+Z,1.0\n2,120:-Z,1.0\n";
    let signal = with(map, None).unwrap();
    let plain = made.signal(&SignalOptions::default(), "").unwrap();
    assert_eq!(signal.drive.ncols(), 5);
    assert_eq!(signal.drive.column(4), plain.drive.column(1));
    assert_eq!(signal.drive.column(1), plain.drive.column(2).mapv(|v| -v));
    assert!(signal.drive.column(2).iter().all(|&v| v == 0.0));
    let of = |channel: usize| {
        let found = signal
            .sidecar
            .channels
            .iter()
            .find(|c| c.channel == channel);
        found.unwrap().full_scale
    };
    assert_eq!(
        of(1),
        2.0 * of(5),
        "twice the gain, half the force at full scale"
    );
    let field = |result: chladni_frf::Result<_>| {
        result
            .map(|_: chladni_render::Signal| ())
            .unwrap_err()
            .field
            .unwrap()
    };
    assert_eq!(
        field(with("channel,reference\n1,101:+Z\n2,110:+Z\n", None)),
        "reference"
    );
    assert_eq!(
        field(with(map, Some(1e-9))),
        "full_scale",
        "clipping is refused"
    );
    for (text, named) in [
        ("channel,reference,gain\n1,101:+Z,0\n", "gain"),
        ("channel,reference,gain\n0,101:+Z,1\n", "channel"),
        (
            "channel,reference,gain\n1,101:+Z,1\n1,102:+Z,1\n",
            "channel",
        ),
        (
            "channel,reference,gain\n1,101:+Z,1\n2,101:-Z,1\n",
            "reference",
        ),
        ("kanal,reference\n", "header"),
        ("channel,reference\n1,nonsense\n", "reference"),
    ] {
        let error = ChannelMap::parse(text).unwrap_err();
        assert_eq!(error.field.as_deref(), Some(named), "{text}: {error}");
        assert_eq!(error.kind, ErrorKind::BadData);
    }
}
