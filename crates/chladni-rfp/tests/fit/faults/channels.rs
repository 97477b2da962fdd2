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
