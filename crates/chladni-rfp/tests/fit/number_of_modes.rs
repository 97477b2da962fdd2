//! A number of modes asked for, on measured data: those with most evidence stay, a tone
//! never before a mode, and what is left out is listed.

use chladni_frf::{ModalModel, Trust};
use chladni_plate::{
    add_white_noise, gain_noise, simulate, synthesise_by_products, Panel, Synthetic,
};
use chladni_rfp::{fit, FitOptions, Method};
use ndarray::Array1;

const MODES_HZ: [f64; 5] = [40.0, 70.0, 105.0, 140.0, 180.0];
/// The mode that shows least.
const FAINT_HZ: f64 = 105.0;
/// Mains hum, in all FRFs, stronger than the faint mode.
const TONE_HZ: f64 = 120.0;

/// Five modes, one of them a twentieth of the others, and a tone; gain noise of 2 %, so
/// that the residual is not white.
fn model(modes: Option<usize>) -> ModalModel {
    let loss = 0.01;
    let specification = Synthetic {
        natural_frequency_hz: [&MODES_HZ[..], &[TONE_HZ]].concat(),
        loss_factor: vec![loss, loss, loss, loss, loss, 0.06 * loss],
        responses: 6,
        references: 1,
        frequency_hz: Array1::range(20.0, 220.0, 0.1),
        seed: 11,
        ..Synthetic::default()
    };
    let mut set = specification.build().unwrap();
    let faint = set
        .truth
        .modes
        .iter_mut()
        .find(|mode| (mode.frequency_hz - FAINT_HZ).abs() < 1.0)
        .unwrap();
    faint.participation.0.iter_mut().for_each(|l| *l *= 0.05);
    let mut values = synthesise_by_products(&set.truth, &specification.frequency_hz);
    add_white_noise(&mut values, 50.0, 11).unwrap();
    set.frf.values = chladni_frf::FrfValues::F64(values);
    gain_noise(&mut set.frf, 0.02, false, 5);
    let options = FitOptions {
        modes,
        ..FitOptions::default()
    };
    let model = fit(&set.frf, &options).unwrap().model;
    let path = model.quality.path.as_deref().unwrap_or_default();
    assert!(path.starts_with("measured-data path"), "{path}");
    model
}

/// Frequencies of the modes that count, whole Hz.
fn kept(model: &ModalModel, trust: &[Trust]) -> Vec<f64> {
    model
        .in_band_modes()
        .filter(|mode| trust.contains(&mode.trust))
        .map(|mode| mode.frequency_hz.round())
        .collect()
}

/// Frequencies that the result lists as left out, whole Hz.
fn left_out(model: &ModalModel) -> Vec<f64> {
    model
        .quality
        .findings
        .iter()
        .filter(|finding| finding.code == "more-modes")
        .flat_map(|finding| finding.values["left_out_hz"].as_slice().to_vec())
        .map(f64::round)
        .collect()
}

const COUNTED: [Trust; 2] = [Trust::Sure, Trust::Weak];

#[test]
fn as_many_as_there_are_leave_the_tone_out() {
    let model = model(Some(5));
    assert_eq!(kept(&model, &COUNTED), MODES_HZ);
    assert_eq!(kept(&model, &[Trust::Sure]), MODES_HZ);
    assert_eq!(left_out(&model), [TONE_HZ]);
}

#[test]
fn fewer_leave_out_the_tone_and_the_faintest_mode() {
    let model = model(Some(4));
    assert_eq!(kept(&model, &COUNTED), [40.0, 70.0, 140.0, 180.0]);
    let mut left_out = left_out(&model);
    left_out.sort_by(f64::total_cmp);
    assert_eq!(left_out, [FAINT_HZ, TONE_HZ]);
}

#[test]
fn one_more_keeps_every_mode_beside_the_tone() {
    let model = model(Some(6));
    assert_eq!(kept(&model, &[Trust::Sure]), MODES_HZ);
    assert!(left_out(&model).is_empty());
    let without = self::model(None);
    assert_eq!(kept(&without, &[Trust::Sure]), MODES_HZ);
}

/// The rest of modes that are left out looks like a second shape at the poles beside them.
#[test]
fn fewer_than_there_are_stay_fewer() {
    let panel = simulate(&Panel::from_toml("", 2 << 30).unwrap(), None, None).unwrap();
    for modes in [1, 10] {
        for method in [Method::Auto, Method::Lean] {
            let options = FitOptions {
                modes: Some(modes),
                method,
                ..FitOptions::default()
            };
            let model = fit(&panel.frf, &options).unwrap().model;
            assert_eq!(model.in_band_modes().count(), modes, "{method}");
        }
    }
}
