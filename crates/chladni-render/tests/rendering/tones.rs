//! Drives of several frequencies: what each tone owes, and what all together may do.

use crate::common::{scene, truth};
use chladni_render::{
    correct, evaluate, needed_band, play, render, signal_csv, sweep, Count, Ground, Method,
    MethodChoice, On, PlayOptions, RenderOptions, Scene, SignalOptions, Weights,
};
use num_complex::Complex64;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

fn quarter(frequency_hz: &str) -> Scene {
    scene(&format!(
        "frequency_hz = {frequency_hz}\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = \
                    [0.0, 0.0, 0.268, 0.170]\n"
    ))
}

fn frequencies(scene: &Scene) -> Vec<f64> {
    scene.tones().iter().map(|tone| tone.frequency_hz).collect()
}

/// Velocities at the responses over the threshold, tone by tone.
fn over_threshold(weights: &Weights, scene: &Scene) -> Vec<Vec<f64>> {
    let judged = evaluate(weights, scene, On::Model(truth())).unwrap();
    let tones = std::iter::once(&judged).chain(&judged.other_tones);
    tones
        .map(|tone| {
            tone.field
                .velocity_m_per_s
                .iter()
                .map(|v| v.norm() / tone.limits.threshold_m_per_s)
                .collect()
        })
        .collect()
}

#[test]
fn what_is_said_of_another_tone_is_not_said_of_the_first() {
    let options = RenderOptions {
        method: Method::PressureMatching.into(),
        ..RenderOptions::default()
    };
    // a mode lies at 299.4 Hz
    for (frequencies, of_the_first) in [("[335.0, 300.0]", false), ("[300.0, 335.0]", true)] {
        let weights = render(truth(), &quarter(frequencies), &options)
            .unwrap()
            .weights;
        let said = |finding: &&chladni_frf::Finding| finding.code == "mode-on-drive";
        assert_eq!(weights.findings.iter().filter(said).count(), 1);
        let own = weights.own_finding("mode-on-drive").is_some();
        assert_eq!(own, of_the_first, "{frequencies}");
    }
}

#[test]
fn a_list_holds_tones_and_bands() {
    assert_eq!(frequencies(&quarter("[300.0]")), [300.0]);
    assert_eq!(
        quarter("[300.0]").limits().unwrap(),
        quarter("300.0").limits().unwrap()
    );
    assert_eq!(frequencies(&quarter("[260, 335.0]")), [260.0, 335.0]);
    let band = quarter("[260.0, [300.0, 305.0]]");
    assert_eq!(
        frequencies(&band).len(),
        5,
        "every 2 Hz or closer, both ends"
    );
    assert_eq!(band.other_tones.last().unwrap().frequency_hz, 305.0);
    // the tone owes all of its own loudness, each of four lines a quarter; of what skin
    // adds up each has a fifth
    let shares: Vec<[f64; 3]> = band
        .tones()
        .iter()
        .map(|tone| [tone.share.hot, tone.share.cold, tone.share.peak])
        .collect();
    assert_eq!((shares[0], shares[4]), ([1.0, 0.2, 0.2], [0.25, 0.2, 0.2]));
    for (frequencies, message) in [
        ("[]", "no drive frequency"),
        ("[300.0, 300.0]", "occurs twice"),
        ("[301.0, [300.0, 304.0], 302.0]", "occurs twice"),
        ("[[310.0, 300.0]]", "not a band"),
        ("[[300.0]]", "wrong number of entries"),
        ("[0.0, 300.0]", "greater than zero"),
        ("[[1.0, 1e9]]", "too many tones"),
        ("[\"300\"]", "not a number"),
    ] {
        let text = format!("frequency_hz = {frequencies}\n[zones]\ngrid = [2, 2]\nhot = [1]\n");
        let error = Scene::parse(&text, std::path::Path::new("")).expect_err(frequencies);
        assert!(
            error.to_string().contains(message) && error.line == Some(1),
            "{frequencies}: {error}"
        );
    }
}

#[test]
fn each_tone_is_felt_and_quiet_ground_is_quiet_under_all_together() {
    let scene = quarter("[260.0, 335.0]");
    let weights = render(truth(), &scene, &RenderOptions::default())
        .unwrap()
        .weights;
    assert_eq!(
        weights
            .tones()
            .map(|tone| tone.frequency_hz)
            .collect::<Vec<_>>(),
        [260.0, 335.0]
    );
    assert!(weights.feasible, "{:?}", weights.findings);
    let limen = 10f64.powf(2.0 / 20.0);
    let field = over_threshold(&weights, &scene);
    let judged = evaluate(&weights, &scene, On::Model(truth())).unwrap();
    let (mut felt, mut quiet) = (0, 0);
    for (k, ground) in judged.field.ground.iter().enumerate() {
        match ground {
            Ground::Hot => {
                assert!(
                    field.iter().all(|tone| tone[k] >= limen * (1.0 - 1e-9)),
                    "response {k}"
                );
                felt += 1;
            }
            Ground::Cold => {
                assert!(
                    field.iter().map(|tone| tone[k].powi(2)).sum::<f64>().sqrt()
                        <= (1.0 + 1e-9) / limen,
                    "response {k}"
                );
                quiet += 1;
            }
            Ground::Ignored => {}
        }
    }
    assert!(felt > 10 && quiet > 40);
    // the file holds both, and a file with the same frequency twice is none
    let text = weights.to_json().unwrap();
    assert_eq!(Weights::parse(&text).unwrap(), weights);
    let twice = text.replacen("\"frequency_hz\": 335.0", "\"frequency_hz\": 260.0", 1);
    assert!(Weights::parse(&twice)
        .unwrap_err()
        .to_string()
        .contains("cannot sound together"));
}

#[test]
fn the_lines_of_a_band_add_up_to_what_a_tone_owes() {
    let scene = quarter("[[333.0, 337.0]]");
    let weights = render(truth(), &scene, &RenderOptions::default())
        .unwrap()
        .weights;
    assert!(
        weights.feasible && weights.tones().count() == 3,
        "{:?}",
        weights.findings
    );
    let field = over_threshold(&weights, &scene);
    let judged = evaluate(&weights, &scene, On::Model(truth())).unwrap();
    let energy = |k: usize| field.iter().map(|tone| tone[k].powi(2)).sum::<f64>().sqrt();
    let hot = (0..77).filter(|&k| judged.field.ground[k] == Ground::Hot);
    let loudness: Vec<f64> = hot.map(energy).collect();
    assert!(
        loudness
            .iter()
            .all(|&v| v >= 10f64.powf(0.1) * (1.0 - 1e-9)),
        "{loudness:?}"
    );
    assert!(
        loudness.iter().any(|&v| v < 2.5),
        "no line was asked to be felt alone: {loudness:?}"
    );
}

#[test]
fn peaks_of_all_tones_keep_the_limit_of_each_actuator_and_one_subset_plays_them() {
    let free = render(
        truth(),
        &quarter("[260.0, 335.0]"),
        &RenderOptions::default(),
    )
    .unwrap()
    .weights;
    let sum = |weights: &Weights| -> Vec<f64> {
        (0..34)
            .map(|i| {
                weights
                    .tones()
                    .map(|tone| tone.weights[i].amplitude)
                    .sum::<f64>()
            })
            .collect()
    };
    let limit = 0.8 * sum(&free).into_iter().fold(0.0, f64::max);
    let mut limited = quarter("[260.0, 335.0]");
    limited.actuators.max_force_n = Some(limit);
    let options = RenderOptions {
        actuators: Count::Number(20),
        method: Method::Mls.into(),
        ..Default::default()
    };
    let weights = render(truth(), &limited, &options).unwrap().weights;
    assert!(sum(&weights)
        .iter()
        .all(|&peak| peak <= limit * (1.0 + 1e-9)));
    let used = |tone: &Weights| -> BTreeSet<String> {
        tone.weights
            .iter()
            .filter(|weight| weight.amplitude > 0.0)
            .map(|weight| weight.reference.to_string())
            .collect()
    };
    let sets: Vec<BTreeSet<String>> = weights.tones().map(used).collect();
    assert!(sets[0] == sets[1] && sets[0].len() == 20, "{sets:?}");
}

#[test]
fn what_is_played_holds_every_tone() {
    let options = RenderOptions {
        method: Method::PressureMatching.into(),
        ..Default::default()
    };
    let weights = render(truth(), &quarter("[250.0, [330.0, 334.0]]"), &options)
        .unwrap()
        .weights;
    let scene = quarter("[250.0, [330.0, 334.0]]");
    let played = play(truth(), &scene, Some(&weights), &PlayOptions::default()).unwrap();
    let signal = played.signal(&SignalOptions::default(), "").unwrap();
    // from 0.1 to 1.1 s are whole periods of each tone
    for tone in weights.tones() {
        let phasor = |k: usize| -> Complex64 {
            let turn = |n: usize| {
                Complex64::from_polar(
                    2.0 / 48_000.0,
                    -TAU * tone.frequency_hz * n as f64 / 48_000.0,
                )
            };
            (4800..52_800).map(|n| signal.drive[[n, k]] * turn(n)).sum()
        };
        // a turn that all channels of a tone share is free
        let common = phasor(0) / tone.weights[0].value();
        assert!(
            (common.norm() - 1.0).abs() < 1e-5,
            "{} Hz: {common}",
            tone.frequency_hz
        );
        for k in [1, 17, 33] {
            let expected = tone.weights[k].value() * common;
            assert!(
                (phasor(k) - expected).norm() < 1e-5 * expected.norm() + 1e-9,
                "{} Hz, channel {k}",
                tone.frequency_hz
            );
        }
    }
    assert_eq!(signal_csv(&weights).lines().count(), 1 + 4 * 34);
    let slow = SignalOptions {
        rate_hz: 600,
        ..Default::default()
    };
    assert_eq!(
        played.signal(&slow, "").unwrap_err().field.as_deref(),
        Some("rate_hz"),
        "334 Hz need more than 668"
    );
}

#[test]
fn a_band_for_a_fit_holds_what_every_tone_needs_and_a_sweep_needs_one() {
    let of =
        |frequencies: &str| needed_band(truth(), &quarter(frequencies), [2.0, 1000.0]).unwrap();
    let (low, high, both) = (of("150.0"), of("335.0"), of("[150.0, 335.0]"));
    assert_eq!(
        both.band_hz,
        [
            low.band_hz[0].min(high.band_hz[0]),
            low.band_hz[1].max(high.band_hz[1])
        ]
    );
    assert_eq!(
        both.inside_hz.len() + both.left_out_hz.len(),
        low.inside_hz.len() + low.left_out_hz.len()
    );
    assert!(both
        .inside_hz
        .iter()
        .all(|hz| (both.band_hz[0]..=both.band_hz[1]).contains(hz)));
    let mut scene = quarter("[150.0, 335.0]");
    scene.file = Some("two.toml".into());
    let options = RenderOptions::default();
    for error in [
        sweep(truth(), &scene, &options, [290.0, 310.0]).unwrap_err(),
        correct(truth(), &scene, &[], &options).unwrap_err(),
    ] {
        assert!(error.to_string().contains("one frequency"), "{error}");
        assert_eq!(error.file, scene.file, "{error}");
    }
}

#[test]
fn tones_that_are_proven_far_out_of_reach_are_told_no_cases_apart() {
    let hot = "[zones]\ngrid = [2, 2]\nhot = [1, 4]\ncells_m = [0.0, 0.0, 0.268, 0.170]\n";
    let limit = "[actuators]\nmax_force_n = 1e-4\n";
    let text = format!("frequency_hz = [200.0, 300.0]\n{hot}{limit}");
    let scene = crate::common::scene(&text);
    let ceilings = |method: MethodChoice| -> Vec<f64> {
        let options = RenderOptions {
            method,
            ..RenderOptions::default()
        };
        let weights = render(truth(), &scene, &options).unwrap().weights;
        let ceilings = weights.tones().map(|tone| tone.ceiling.unwrap());
        ceilings
            .map(|ceiling| {
                assert!(ceiling.forbids(), "{ceiling:?}");
                ceiling.possible_db
            })
            .collect()
    };
    assert_eq!(
        ceilings(Method::Robust.into()),
        ceilings(MethodChoice::Best)
    );
}
