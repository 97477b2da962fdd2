//! Gains over frequency: a calibration that holds a table for each channel.

use crate::common::rig::Rig;
use crate::common::{cell_scene, truth};
use chladni_frf::{Error, Finding};
use chladni_render::{
    calibrate, evaluate, play, render, sweep, Calibration, ChannelGain, On, PlayOptions,
    PlayedField, RenderOptions, Scene, Weights,
};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A voltage amplifier with a coil: corner of the k-th channel at 400 Hz and more, its level
/// 4 % about 1, a delay of 0.1 ms.
fn gain(channel: usize, hz: f64) -> Complex64 {
    let corner_hz = 400.0 + 20.0 * channel as f64;
    let level = 1.0 + 0.04 * (1.7 * channel as f64).sin();
    Complex64::from_polar(level, -TAU * hz * 1e-4) / Complex64::new(1.0, hz / corner_hz)
}

/// The table of all channels, 240 to 360 Hz in steps of 10 Hz.
fn table() -> Calibration {
    let mut text = "reference,frequency_hz,re,im\n".to_owned();
    for (k, reference) in truth().references.iter().enumerate() {
        for step in 0..=12 {
            let hz = 240.0 + 10.0 * f64::from(step);
            let value = gain(k, hz);
            text += &format!("{reference},{hz},{:e},{:e}\n", value.re, value.im);
        }
    }
    Calibration::parse(&text).unwrap()
}

/// The same gains as constants that hold at one frequency.
fn constants(hz: f64) -> Calibration {
    let mut calibration = Calibration::of_tables(Vec::new());
    let references = truth().references.iter().enumerate();
    calibration.gains = references
        .map(|(k, &reference)| ChannelGain {
            reference,
            re: gain(k, hz).re,
            im: gain(k, hz).im,
            std: 0.0,
            odd: false,
        })
        .collect();
    calibration
}

fn with(calibration: Calibration, hz: f64) -> Scene {
    // the same errors to bear, whatever the calibration says of them
    let mut scene = cell_scene([2, 2], 1, "[drift]\ndrive_relative = 0.0\n");
    scene.frequency_hz = hz;
    scene.actuators.calibration = Some(Arc::new(calibration));
    scene
}

fn rendered(scene: &Scene) -> Weights {
    let rendering = render(truth(), scene, &RenderOptions::default());
    rendering.unwrap().weights
}

/// Largest difference of two fields of one drive, over the largest velocity.
fn distance(drive: &Weights, [one, other]: [&Scene; 2]) -> f64 {
    let field = |scene: &Scene| {
        let evaluation = evaluate(drive, scene, On::Model(truth())).unwrap();
        evaluation.field.velocity_m_per_s
    };
    let [one, other] = [field(one), field(other)];
    let largest = one.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let differences = one.iter().zip(&other).map(|(a, b)| (a - b).norm());
    differences.fold(0.0, f64::max) / largest
}

#[test]
fn each_frequency_takes_the_gain_of_its_own() {
    // at an entry of the table, and between two: h²/8 of the curvature is (10/400)²/8
    for (hz, within) in [(300.0, 1e-12), (304.0, 1e-3)] {
        let own = with(table(), hz);
        let drive = rendered(&own);
        let error = distance(&drive, [&own, &with(constants(hz), hz)]);
        assert!(error < within, "{hz} Hz: {error}");
        // the gains of 30 Hz beside make another field
        let beside = distance(&drive, [&own, &with(constants(hz + 30.0), hz)]);
        assert!(beside > 0.02, "{hz} Hz: {beside}");
    }
    // each line of a sweep, too
    let options = RenderOptions::default();
    let swept = sweep(truth(), &with(table(), 300.0), &options, [310.0, 330.0]).unwrap();
    for hz in [310.0, 330.0] {
        let one = sweep(truth(), &with(constants(hz), hz), &options, [hz, hz + 1.0]).unwrap();
        let drive = swept.frequencies.iter().find(|f| f.frequency_hz == hz);
        let [own, other] = [drive.unwrap(), &one.frequencies[0]].map(|f| f.largest_drive);
        assert!((own / other - 1.0).abs() < 1e-3, "{hz} Hz: {own} {other}");
    }
}

#[test]
fn a_table_serves_the_rig_that_it_describes() {
    let mut rig = Rig::new(300.0, 1);
    for (k, value) in rig.gains.iter_mut().enumerate() {
        *value = gain(k, 300.0);
    }
    let scene = with(table(), 300.0);
    let [known, unknown] = [scene.clone(), cell_scene([2, 2], 1, "")].map(|s| rendered(&s));
    let limits = scene.limits().unwrap();
    let served = |weights: &Weights| {
        let field = rig.field(&rig.drive(weights));
        let judged = evaluate(weights, &scene, On::Model(truth())).unwrap();
        let inside = judged
            .field
            .ground
            .iter()
            .zip(&field)
            .map(|(ground, v)| match ground {
                chladni_render::Ground::Hot => limits.is_felt(v.norm()),
                chladni_render::Ground::Cold => limits.is_quiet(v.norm()),
                chladni_render::Ground::Ignored => true,
            });
        inside.filter(|inside| *inside).count()
    };
    assert_eq!(served(&known), 77);
    assert!(served(&unknown) < 70, "{}", served(&unknown));
}

#[test]
fn every_tone_plays_with_the_gain_at_its_own_frequency() {
    let uniform = "frequency_hz,gain,phase_deg\n260,2,30\n335,0.5,-40\n";
    let scene = |calibration: Option<Calibration>| {
        let mut scene = cell_scene(
            [2, 2],
            1,
            "[time]\n[[time.burst]]\nduration_s = 0.1\n\
                                              ramp_s = 0.03\n",
        );
        let two = Scene::parse(
            "frequency_hz = [260.0, 335.0]\n[zones]\ngrid = [2, 2]\nhot = [1]\n",
            std::path::Path::new(""),
        );
        let two = two.unwrap();
        (scene.frequency_hz, scene.share) = (two.frequency_hz, two.share);
        scene.other_tones = two.other_tones;
        scene.actuators.calibration = calibration.map(Arc::new);
        scene
    };
    let [plain, tables] = [
        scene(None),
        scene(Some(Calibration::parse(uniform).unwrap())),
    ];
    let [own, other] = [&plain, &tables].map(rendered);
    for (factor, (a, b)) in [2.0, 0.5].into_iter().zip(own.tones().zip(other.tones())) {
        let amplitude = |weights: &Weights| weights.weights[0].amplitude;
        let ratio = amplitude(a) / amplitude(b) / factor;
        // the solver rounds differently
        assert!((ratio - 1.0).abs() < 1e-3, "{factor}: {ratio}");
    }
    let played = |scene: &Scene| {
        let options = PlayOptions {
            area: false,
            ..PlayOptions::default()
        };
        let played = play(truth(), scene, None, &options).unwrap();
        [
            played.indices.peak.worst_cold_db,
            played.indices.peak.worst_hot_db,
        ]
        .map(Option::unwrap)
    };
    for (own, other) in played(&plain).into_iter().zip(played(&tables)) {
        assert!((own - other).abs() < 0.02, "{own} {other} dB");
    }
}

#[test]
fn what_fields_teach_comes_on_top_of_a_table() {
    let mut rig = Rig::new(300.0, 2);
    for (k, value) in rig.gains.iter_mut().enumerate() {
        *value = gain(k, 300.0);
    }
    rig.gains[7] *= 0.8;
    let mut scene = cell_scene([2, 2], 1, "");
    scene.actuators.calibration = Some(Arc::new(table()));
    let weights = rendered(&scene);
    let field = rig.measured(&weights, 0.01, &(0..77).collect::<Vec<_>>());
    let played = [PlayedField::new(weights, field)];
    let (_, learned) = calibrate(truth(), &scene, &played, &RenderOptions::default()).unwrap();
    assert_eq!(learned.gain_tables, table().gain_tables);
    let again = Calibration::parse(&learned.to_json().unwrap()).unwrap();
    assert_eq!(again, learned);
    let odd = learned.gain_of(truth().references[7]);
    assert!((odd - 0.8).norm() < 0.05, "{odd}");
    let others = learned.gains.iter().enumerate().filter(|(k, _)| *k != 7);
    for (k, gain) in others {
        assert!(
            (gain.re - 1.0).hypot(gain.im) < 0.05,
            "channel {k}: {gain:?}"
        );
    }
}

#[test]
fn a_table_whose_error_nobody_stated_leaves_the_usual_one() {
    let gain_error = |text: &str| {
        let scene = with(Calibration::parse(text).unwrap(), 330.0);
        rendered(&scene).endurance.unwrap().gain_error
    };
    let plain = {
        let mut scene = cell_scene([2, 2], 1, "");
        scene.frequency_hz = 330.0;
        rendered(&scene).endurance.unwrap().gain_error
    };
    assert_eq!(gain_error("gain\n1.0\n"), plain);
    let stated = gain_error("gain,std\n2.0,0.02\n");
    assert!((stated - 0.01).abs() < 1e-12, "{stated}");
}

#[test]
fn outside_of_its_table_a_channel_is_refused_by_name() {
    let options = RenderOptions::default();
    let refused = |scene: &Scene| render(truth(), scene, &options).unwrap_err().to_string();
    let message = refused(&with(table(), 200.0));
    assert!(
        message.contains("240 to 360 Hz") && message.contains("200 Hz, 101:+Z"),
        "{message}"
    );
    let stranger = Calibration::parse("reference,gain\n4711:+Z,1\n").unwrap();
    let message = refused(&with(stranger, 300.0));
    assert!(message.contains("no such actuator"), "{message}");
    let applied = rendered(&with(table(), 300.0)).findings;
    let is_said = |finding: &Finding| finding.code == "calibrated";
    assert!(applied.iter().any(is_said));
}

#[test]
fn the_table_of_the_page_is_read() {
    const PAGE: &str = include_str!("../../../../docs/formats.md");
    let tables = PAGE.split("```csv\n").skip(1);
    let text = tables
        .filter_map(|rest| rest.split("```").next())
        .find(|table| table.starts_with("reference,"))
        .unwrap();
    let tables = Calibration::parse(text).unwrap().gain_tables;
    let shape: Vec<_> = tables
        .iter()
        .map(|table| (table.reference.unwrap().to_string(), &table.gain[..]))
        .collect();
    assert_eq!(
        shape,
        [
            ("101:+Z".to_owned(), &[0.98, 0.91][..]),
            ("102:+Z".to_owned(), &[0.97, 0.90][..]),
        ]
    );
}

#[test]
fn a_channel_named_twice_in_gains_is_refused() {
    let mut twice = constants(300.0);
    twice.gains.push(twice.gains[0]);
    let error = Calibration::parse(&twice.to_json().unwrap()).unwrap_err();
    assert_eq!(
        error.found,
        Some(truth().references[0].to_string()),
        "{error}"
    );
}

#[test]
fn a_misspelt_key_is_refused_and_a_file_without_gains_says_nothing_of_them() {
    let misspelt = r#"{"format": "chladni.calibration", "version": 1, "gain": []}"#;
    let error = Calibration::parse(misspelt).unwrap_err().to_string();
    assert!(error.contains("unknown field `gain`"), "{error}");
    let empty = Calibration::parse(&misspelt.replace("gain", "gains")).unwrap();
    let findings = rendered(&with(empty, 300.0)).findings;
    assert!(findings.iter().all(|finding| finding.code != "calibrated"));
}

#[test]
fn a_misspelt_key_inside_a_list_is_refused_with_the_known_ones() {
    let dof = truth().references[0];
    let gain = format!(
        "{{\"reference\": \"{dof}\", \"re\": 1, \"im\": 0, \"std\": 0.01, \"odd\": false}}"
    );
    let mode = "{\"model_hz\": 100, \"frequency_hz\": 101, \"loss_factor\": 0.02, \"std\": 1e-3}";
    let mut operator = String::from("{\"frequency_hz\": 300, \"fields\": 1, ");
    operator += "\"estimator\": \"kalman\", \"responses\": [\"1:+Z\"], ";
    operator += &format!("\"references\": [\"{dof}\"], ");
    operator += "\"mobility\": {\"re\": [[1]], \"im\": [[0]]}, ";
    operator += "\"covariance\": {\"re\": [[1]], \"im\": [[0]]}}";
    for (list, entry) in [
        ("gains", &*gain),
        ("modes", mode),
        ("operators", &*operator),
    ] {
        let parse = |entry: &str| {
            Calibration::parse(&format!(
                "{{\"format\": \"chladni.calibration\", \"version\": 1, \"{list}\": [{entry}]}}"
            ))
        };
        parse(entry).unwrap();
        let misspelt = entry.replacen('{', "{\"frequncy_hz\": 300, ", 1);
        let error = parse(&misspelt).unwrap_err();
        assert_eq!(error.found.as_deref(), Some("frequncy_hz"), "{error}");
        let known = error.expected.as_deref().unwrap();
        assert!(known.contains("one of"), "{error}");
        assert!(error.line.is_some() && error.help.is_some(), "{error}");
    }
}

#[test]
fn a_misspelt_key_inside_sources_is_refused_with_the_known_ones() {
    let parse = |source: &str| {
        let head = "{\"format\": \"chladni.calibration\", \"version\": 1,\n";
        Calibration::parse(&format!("{head}\"source\": [{source}]}}"))
    };
    parse("{\"file\": \"model.json\", \"sha256\": \"ab\"}").unwrap();
    let refused = parse("{\"file\": \"model.json\", \"sha265\": \"ab\", \"sha256\": \"ab\"}");
    let error = refused.unwrap_err();
    assert_eq!(error.found.as_deref(), Some("sha265"), "{error}");
    let expected = error.expected.as_deref();
    assert!(expected.unwrap().contains("sha256"), "{error}");
    assert_eq!(error.line, Some(2), "{error}");
    assert!(error.help.is_some(), "{error}");
}

#[test]
fn a_gain_beyond_30_db_is_refused_in_every_list() {
    let mut loud = constants(300.0);
    loud.gains[4].im = 1e9;
    // by whomever it was written
    for author in ["", "chladni 0.1.0"] {
        loud.created_by = author.into();
        let error = Calibration::parse(&loud.to_json().unwrap()).unwrap_err();
        assert_eq!(error.field.as_deref(), Some("gains[5]"), "{error}");
        let found = error.found.as_deref().unwrap();
        let named = truth().references[4].to_string();
        assert!(
            found.contains("1.000e9") && found.contains(&named),
            "{error}"
        );
        assert_has_advice(&error);
    }
    let table =
        r#"{"format": "chladni.calibration", "version": 1, "gain_tables": [{"gain": [1e9]}]}"#;
    let other = Calibration::parse(table).unwrap_err();
    assert_eq!(
        other.field.as_deref(),
        Some("gain_tables[1].gain"),
        "{other}"
    );
    assert_has_advice(&other);
    loud.gains[4].im = 0.0;
    loud.gains[4].re = -31.6;
    assert!(Calibration::parse(&loud.to_json().unwrap()).is_ok());
}

/// The error says how large a gain may be, and what to do.
fn assert_has_advice(error: &Error) {
    assert!(error.to_string().contains("at most 30 dB"), "{error}");
    let help = error.help.as_deref().unwrap();
    assert!(help.contains("divide percents by 100"), "{error}");
}

#[test]
fn a_gain_beyond_30_db_is_not_learned_and_what_is_learned_is_read_again() {
    let mut before = Calibration::of_tables(Vec::new());
    let references = truth().references.iter();
    before.gains = references
        .map(|&reference| ChannelGain {
            reference,
            re: 20.0,
            im: 0.0,
            std: 0.0,
            odd: false,
        })
        .collect();
    let mut scene = cell_scene([2, 2], 1, "");
    scene.actuators.calibration = Some(Arc::new(before));
    let weights = rendered(&scene);
    // fields of a rig with one gain, which the calibration before has as 20
    let taught = |gain: f64| {
        let mut rig = Rig::new(300.0, 4);
        rig.gains.mapv_inplace(|own| own * gain);
        let field = rig.measured(&weights, 0.01, &(0..77).collect::<Vec<_>>());
        let played = [PlayedField::new(weights.clone(), field)];
        calibrate(truth(), &scene, &played, &RenderOptions::default())
    };
    let (_, learned) = taught(26.0).unwrap();
    for gain in &learned.gains {
        assert!((gain.re / 26.0 - 1.0).abs() < 0.1, "{gain:?}");
    }
    let again = Calibration::parse(&learned.to_json().unwrap()).unwrap();
    assert_eq!(again, learned);
    // +14 dB against the prediction, +40 dB against the model
    let error = taught(100.0).unwrap_err();
    assert_eq!(error.field.as_deref(), Some("gains"), "{error}");
    let found = error.found.as_deref().unwrap();
    assert!(found.contains("dB") && found.contains("101:+Z"), "{error}");
    assert!(error.to_string().contains("at most 30 dB"), "{error}");
    let help = error.help.as_deref().unwrap();
    assert!(help.contains("unit of the field"), "{error}");
}

#[test]
fn a_model_in_place_of_a_calibration_is_called_a_model() {
    let text = serde_json::to_string(truth()).unwrap();
    let error = Calibration::parse(&text).unwrap_err();
    assert_eq!(error.message, "a model, not a calibration file");
    assert_eq!(error.found.as_deref(), Some("chladni.model"));
    assert_eq!(
        error.expected.as_deref(),
        Some("chladni.calibration version 1")
    );
    assert!(error.help.is_some());
}
