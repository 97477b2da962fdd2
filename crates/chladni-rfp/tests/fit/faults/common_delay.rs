//! A delay of all FRFs: told, and no pole that stands for it is sure.

use super::*;
use chladni_frf::Damping;
use chladni_plate::SyntheticShapes;
use std::f64::consts::TAU;

/// The set with all responses late by `seconds`.
fn late(set: &Synthetic, seconds: f64) -> (FrfSet, ModalModel) {
    let built = set.build().unwrap();
    let mut frf = built.frf;
    spoil(&mut frf, |_, _, hz, value| {
        value * Complex64::from_polar(1.0, -TAU * hz * seconds)
    });
    (frf, built.truth)
}

/// The delay of all FRFs that is told, s.
fn told(model: &ModalModel) -> Option<f64> {
    let mut findings = model.quality.findings.iter();
    let told = findings.find(|told| told.code == "common-delay")?;
    Some(1e-3 * told.values["delay_ms"].as_slice()[0])
}

/// From an eighth of a turn over the band to nearly nine.
#[test]
fn a_delay_is_told_and_poles_that_stand_for_it_are_weak() {
    let delays = [6e-4, -6e-4, 1.6e-3, 3e-3, 0.01, 0.02, 0.04];
    for (seed, seconds) in (60..).zip(delays) {
        let (mut frf, truth) = late(&easy(50.0, seed), seconds);
        let model = fitted(&frf);
        let found = told(&model).unwrap_or_else(|| panic!("{seconds}: {:?}", model.quality));
        assert!((found - seconds).abs() < 3e-5, "{found}, not {seconds}");
        let (missed, _, falsely_sure) = missed_spurious_false(&truth, &model);
        assert_eq!((missed, falsely_sure), (0, 0), "{seconds}");
        assert!(!says(&model, "kind?") && !says(&model, "turned"));
        // once it is off, nothing is left of it
        frf.advance(found);
        let model = fitted(&frf);
        assert_eq!(told(&model), None, "{seconds}");
        assert_eq!(missed_spurious_false(&truth, &model), (0, 0, 0));
        assert!(worst_frequency(&truth, &model) < 1e-4);
    }
}

/// At 30 dB poles that stand for a delay decay as fast as modes; at 100 dB, or where it is long, no
/// rational function is found. Impulse responses that begin late tell it.
#[test]
fn a_long_delay_is_told_by_silence() {
    for (seed, seconds, snr_db) in [(71, 0.12, 30.0), (72, 0.12, 100.0), (73, 0.5, 60.0)] {
        let model = fitted(&late(&easy(snr_db, seed), seconds).0);
        let found = told(&model).unwrap_or_else(|| panic!("{seconds}: {:?}", model.quality));
        // lines over 220 Hz
        assert!((found - seconds).abs() < 6e-3, "{found}, not {seconds}");
        let mut findings = model.quality.findings.iter();
        assert!(findings.all(|told| told.code != "windowed"), "{seconds}");
    }
}

/// Without driving points, residues are known up to their sign.
#[test]
fn a_delay_is_told_without_driving_points() {
    let mut frf = late(&easy(50.0, 70), 2e-3).0;
    frf.references.iter_mut().for_each(|dof| dof.node += 1000);
    let found = told(&fitted(&frf)).expect("a delay");
    assert!((found - 2e-3).abs() < 1e-5, "{found}");
}

#[test]
fn phases_that_no_delay_makes_are_none() {
    for seed in 80..84 {
        for shapes in [SyntheticShapes::Real, SyntheticShapes::Complex] {
            for damping in [Damping::Structural, Damping::Viscous] {
                let set = Synthetic {
                    shapes,
                    damping,
                    ..easy(40.0, seed)
                };
                // 1.7° at the highest mode are in any signal path
                for seconds in [0.0, 2e-5] {
                    assert_eq!(told(&fitted(&late(&set, seconds).0)), None);
                }
            }
        }
    }
}

/// Phases of modes in no order, and all turned by one angle.
#[test]
fn turned_residues_are_no_delay() {
    for (seed, angle) in (90..).zip([0.4, 0.8, 1.2, 1.5]) {
        let set = easy(50.0, seed).build().unwrap();
        // 2.4, the golden angle: phases in no order
        let no_order = |n: usize| angle * (2.4 * (n as f64 + seed as f64)).sin();
        for of_mode in [&no_order as &dyn Fn(usize) -> f64, &|_| angle] {
            let mut truth = set.truth.clone();
            for (n, mode) in truth.modes.iter_mut().enumerate() {
                let turn = Complex64::from_polar(1.0, of_mode(n));
                mode.shape.0.iter_mut().for_each(|value| *value *= turn);
            }
            let mut frf = set.frf.clone();
            let axis = frf.frequency_hz.clone();
            values(&mut frf).assign(&truth.synthesise(&axis));
            chladni_plate::add_noise_of_variance(values(&mut frf), set.noise_variance, seed);
            assert_eq!(told(&fitted(&frf)), None, "{angle}");
        }
    }
}
