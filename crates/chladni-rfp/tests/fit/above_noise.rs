//! A model that leaves a little more than the noise says so, and only that model.

use crate::common::fitted;
use crate::law::OnOneDashpot;
use chladni_frf::{Damping, FrfSet};
use chladni_rfp::{FitOptions, ShapeModel};

/// χ² per degree of freedom of a fit with these shapes, and the value that the finding tells.
fn told(frf: &FrfSet, shapes: ShapeModel) -> (f64, Option<f64>) {
    let options = FitOptions {
        damping: Some(Damping::Viscous),
        shapes,
        ..FitOptions::default()
    };
    let quality = fitted(frf, &options).quality;
    let mut findings = quality.findings.iter();
    let told = findings.find(|told| told.code == "above-noise");
    let told = told.map(|told| told.values["chi2_per_dof"].as_slice()[0]);
    (quality.chi2_per_dof, told)
}

/// One dashpot is no proportional damping: shapes are a little complex. Real ones are asked for.
/// With noise 35 dB below the data their misfit is 18 % of it.
#[test]
fn shapes_that_are_not_quite_real_leave_more_than_the_noise() {
    let masses = OnOneDashpot { dashpot: 10.0 };
    let frf = masses.set(35.0, 1);
    let (chi2, said) = told(&frf, ShapeModel::Real);
    assert!((1.1..1.5).contains(&chi2), "{chi2}");
    assert_eq!(said, Some(chi2));
    // complex shapes are right
    for shapes in [ShapeModel::Rank1, ShapeModel::Auto] {
        let (chi2, said) = told(&frf, shapes);
        assert!((0.95..1.05).contains(&chi2), "{shapes:?}: {chi2}");
        assert_eq!(said, None, "{shapes:?}");
    }
    // more noise hides the misfit; less has a finding of its own
    for snr_db in [25.0, 45.0] {
        let frf = masses.set(snr_db, 1);
        let (chi2, said) = told(&frf, ShapeModel::Real);
        assert!(!(1.1..1.5).contains(&chi2), "{snr_db} dB: {chi2}");
        assert_eq!(said, None, "{snr_db} dB");
    }
}

/// Real shapes that are asked for leave what they leave: no poles beside the band make that good,
/// each of them large and against the others.
#[test]
fn misfit_of_shapes_that_were_asked_for_grows_as_the_noise_falls() {
    let masses = OnOneDashpot { dashpot: 30.0 };
    let excess = |snr_db: f64| told(&masses.set(snr_db, 1), ShapeModel::Real).0 - 1.0;
    let at_25_db = excess(25.0);
    for snr_db in [30.0, 34.0, 35.0, 40.0] {
        let expected = at_25_db * 10_f64.powf((snr_db - 25.0) / 10.0);
        let ratio = excess(snr_db) / expected;
        assert!((0.8..1.25).contains(&ratio), "{snr_db} dB: {ratio}");
    }
}
