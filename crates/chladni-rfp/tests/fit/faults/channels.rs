//! Channels: delayed, of another gain, loaded by a roving sensor, of the wrong time sign.

use super::*;
use chladni_frf::Damping;
use chladni_plate::SyntheticShapes;
use std::f64::consts::TAU;

/// The number that stands before `unit` in the first warning that holds `words`.
fn number_before(model: &ModalModel, words: &str, unit: &str) -> f64 {
    let warning = model
        .quality
        .findings
        .iter()
        .find(|w| w.contains(words))
        .unwrap_or_else(|| panic!("{:?}", model.quality.findings));
    let before = warning.text.split(unit).next().unwrap_or_default();
    before
        .rsplit(' ')
        .find(|word| !word.is_empty())
        .and_then(|word| word.parse().ok())
        .unwrap_or_else(|| panic!("{warning}"))
}

#[test]
fn a_delayed_reference_is_measured_to_5_microseconds() {
    for microseconds in [50.0, 500.0] {
        let mut set = easy(40.0, 21).build().unwrap();
        spoil(&mut set.frf, |_, j, f, v| {
            if j == 1 {
                v * Complex64::from_polar(1.0, -TAU * f * microseconds * 1e-6)
            } else {
                v
            }
        });
        let model = fitted(&set.frf);
        assert_eq!(
            missed_spurious_false(&set.truth, &model),
            (0, 0, 0),
            "{:?}",
            model.quality
        );
        let found = number_before(&model, "lags by", " µs");
        assert!(
            (found - microseconds).abs() < 5.0,
            "{found} instead of {microseconds}"
        );
        assert!(worst_frequency(&set.truth, &model) < 1e-4);
    }
}

#[test]
fn a_delay_of_all_references_or_none_is_not_called_relative() {
    let mut set = easy(40.0, 22).build().unwrap();
    assert!(!says(&fitted(&set.frf), "delayed"));
    spoil(&mut set.frf, |_, _, f, v| {
        v * Complex64::from_polar(1.0, -TAU * f * 20e-6)
    });
    let model = fitted(&set.frf);
    assert_eq!(
        missed_spurious_false(&set.truth, &model),
        (0, 0, 0),
        "{:?}",
        model.quality
    );
    assert!(
        !says(&model, "delayed") && model.quality.trusted,
        "{:?}",
        model.quality.findings
    );
}

/// Delay in ms that is told of each response by its place; none where nothing is told.
fn delays_told(model: &ModalModel) -> Vec<(usize, f64)> {
    let mut findings = model.quality.findings.iter();
    let Some(told) = findings.find(|finding| finding.code == "delayed-response") else {
        return Vec::new();
    };
    let place = |dof: &chladni_frf::Dof| model.responses.iter().position(|own| own == dof);
    let places = told.dofs.iter().filter_map(place);
    let delays = told.values["delay_ms"].as_slice();
    places.zip(delays.iter().copied()).collect()
}

#[test]
fn delayed_responses_are_named_with_their_delay() {
    let late = [(3, 0.08), (4, -0.3), (0, 0.9), (5, 2.0)];
    for (seed, (response, ms)) in (40..).zip(late) {
        let mut set = easy(40.0, seed).build().unwrap();
        spoil(&mut set.frf, |i, _, f, v| {
            let late = if i == response { 1e-3 * ms } else { 0.0 };
            v * Complex64::from_polar(1.0, -TAU * f * late)
        });
        let model = fitted(&set.frf);
        let told = delays_told(&model);
        assert!(turns_told(&model).is_empty());
        assert_eq!(told.len(), 1, "{ms}: {:?}", model.quality.findings);
        assert_eq!(told[0].0, response);
        assert!(
            (told[0].1 - ms).abs() < 5e-3,
            "{} instead of {ms}",
            told[0].1
        );
        assert_eq!(missed_spurious_false(&set.truth, &model), (0, 0, 0));
    }
}

#[test]
fn two_late_responses_of_six_are_named_and_three_are_not() {
    for late in [2, 3] {
        let mut set = easy(40.0, 45).build().unwrap();
        spoil(&mut set.frf, |i, _, f, v| {
            let late = if i < late { 5e-4 } else { 0.0 };
            v * Complex64::from_polar(1.0, -TAU * f * late)
        });
        let model = fitted(&set.frf);
        let named: Vec<usize> = delays_told(&model).iter().map(|own| own.0).collect();
        let right: &[usize] = if late == 2 { &[0, 1] } else { &[] };
        assert_eq!(named, right, "{:?}", model.quality.findings);
    }
}

#[test]
fn phases_of_no_order_at_one_response_are_no_delay() {
    for (seed, size) in (50..).zip([0.05, 0.1, 0.2, 0.4, 0.8, 1.5]) {
        let mut set = easy(40.0, seed).build().unwrap();
        let mut truth = set.truth.clone();
        for (n, mode) in truth.modes.iter_mut().enumerate() {
            // 2.4, the golden angle: phases in no order
            let phase = size * (2.4 * (n as f64 + seed as f64)).sin();
            mode.shape.0[4] *= Complex64::from_polar(1.0, phase);
        }
        let axis = set.frf.frequency_hz.clone();
        values(&mut set.frf).assign(&truth.synthesise(&axis));
        chladni_plate::add_noise_of_variance(values(&mut set.frf), set.noise_variance, seed);
        let model = fitted(&set.frf);
        let told = (delays_told(&model), turns_told(&model));
        assert!(told.0.is_empty() && told.1.is_empty(), "{size}: {told:?}");
    }
}

#[test]
fn complex_shapes_are_no_delay() {
    for seed in 0..3 {
        let set = Synthetic {
            shapes: SyntheticShapes::Complex,
            ..easy(40.0, 23 + seed)
        }
        .build()
        .unwrap();
        let model = fitted(&set.frf);
        assert!(
            !says(&model, "delayed") && !says(&model, "kind?"),
            "{:?}",
            model.quality.findings
        );
        assert!(model.quality.trusted);
    }
}

#[test]
fn a_gain_error_of_a_reference_is_named_and_harmless_to_poles() {
    let mut set = easy(40.0, 26).build().unwrap();
    assert!(!says(&fitted(&set.frf), "reciprocal"));
    spoil(&mut set.frf, |_, j, _, v| if j == 1 { 1.2 * v } else { v });
    let model = fitted(&set.frf);
    assert_eq!(
        missed_spurious_false(&set.truth, &model),
        (0, 0, 0),
        "{:?}",
        model.quality
    );
    assert!(
        says(&model, "not reciprocal: 1 of 1 pairs") && says(&model, "factor 1.2"),
        "{:?}",
        model.quality.findings
    );
    assert!(model.quality.trusted);
}

#[test]
fn poles_that_move_with_a_roving_mass_are_not_trusted() {
    let set = easy(40.0, 27).build().unwrap();
    let mut moved = set.frf.clone();
    let shift = [0.9, -0.7, 0.2, -1.0, 0.6, -0.3];
    for (i, part) in shift.iter().enumerate() {
        // up to a bandwidth up or down
        let mut truth = set.truth.clone();
        truth
            .modes
            .iter_mut()
            .for_each(|mode| mode.frequency_hz *= 1.0 + 0.01 * part);
        let own = truth.synthesise(&set.frf.frequency_hz);
        let measured = values(&mut moved);
        measured
            .slice_mut(ndarray::s![i, .., ..])
            .assign(&own.slice(ndarray::s![i, .., ..]));
    }
    chladni_plate::add_noise_of_variance(values(&mut moved), set.noise_variance, 28);
    let model = fitted(&moved);
    assert!(
        says(&model, "poles differ between FRFs"),
        "{:?}",
        model.quality
    );
    assert!(!model.quality.trusted);
    // as much misfit of another kind is no movement
    let mut still = set.frf.clone();
    chladni_plate::gain_noise(&mut still, 0.1, false, 29);
    let model = fitted(&still);
    assert!(
        !says(&model, "poles differ") && model.quality.trusted,
        "{:?}",
        model.quality
    );
}

#[test]
fn the_wrong_time_sign_is_named() {
    for damping in [Damping::Structural, Damping::Viscous] {
        let mut set = Synthetic {
            damping,
            ..easy(40.0, 30)
        }
        .build()
        .unwrap();
        set.frf.conjugate();
        let model = fitted(&set.frf);
        assert!(
            !model.quality.trusted && says(&model, "the other time sign"),
            "{:?}",
            model.quality
        );
        assert_eq!(model.in_band_modes().count(), 0);
    }
}

#[test]
fn the_wrong_time_sign_of_broad_modes_is_named() {
    for seed in 0..6 {
        let mut set = Synthetic {
            loss_factor: vec![0.08],
            ..easy(45.0, 60 + seed)
        }
        .build()
        .unwrap();
        assert!(!says(&fitted(&set.frf), "the other time sign"));
        set.frf.conjugate();
        let model = fitted(&set.frf);
        assert!(
            !model.quality.trusted && says(&model, "the other time sign"),
            "{seed}: {:?}",
            model.quality
        );
    }
}

/// Angles in degrees that are told of each response by its place.
fn turns_told(model: &ModalModel) -> Vec<(usize, f64)> {
    let mut findings = model.quality.findings.iter();
    let told = findings.find(|told| told.code == "turned-response");
    let Some(told) = told else {
        return Vec::new();
    };
    let place = |dof: &chladni_frf::Dof| model.responses.iter().position(|own| own == dof);
    let angles = told.values["turn_deg"].as_slice();
    let places = told.dofs.iter().filter_map(place);
    places.zip(angles.iter().copied()).collect()
}

#[test]
fn turned_responses_are_named_with_their_angle() {
    for (seed, (response, degrees)) in (70..).zip([(3, 20.0), (4, -45.0), (0, 30.0), (5, 80.0)]) {
        let mut set = easy(40.0, seed).build().unwrap();
        assert!(turns_told(&fitted(&set.frf)).is_empty());
        spoil(&mut set.frf, |i, _, _, v| {
            let degrees: f64 = if i == response { degrees } else { 0.0 };
            v * Complex64::from_polar(1.0, degrees.to_radians())
        });
        let model = fitted(&set.frf);
        let told = turns_told(&model);
        assert_eq!(told.len(), 1, "{degrees}: {:?}", model.quality.findings);
        assert_eq!(told[0].0, response);
        assert!((told[0].1 - degrees).abs() < 2.0, "{told:?}, not {degrees}");
        assert!(delays_told(&model).is_empty());
        assert_eq!(missed_spurious_false(&set.truth, &model), (0, 0, 0));
    }
}

/// The others agree that it is the response: no kind of all FRFs is doubted.
#[test]
fn a_turned_driving_point_of_one_reference_is_no_wrong_kind() {
    let mut set = Synthetic {
        references: 1,
        ..easy(40.0, 80)
    }
    .build()
    .unwrap();
    spoil(&mut set.frf, |i, _, _, v| match i {
        0 => v * Complex64::from_polar(1.0, 88_f64.to_radians()),
        _ => v,
    });
    let model = fitted(&set.frf);
    assert_eq!(turns_told(&model).len(), 1, "{:?}", model.quality.findings);
    let mut findings = model.quality.findings.iter();
    assert!(findings.all(|told| told.code != "wrong-kind"));
}
