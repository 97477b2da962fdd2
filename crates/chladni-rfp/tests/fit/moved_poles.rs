//! Poles of a known model, followed by a few FRFs.

use chladni_frf::{Damping, FrfSet, FrfValues, ModalModel};
use chladni_plate::{add_white_noise, simulate, Panel};
use chladni_rfp::poles_of;
use ndarray::Axis;
use std::sync::OnceLock;

/// The panel of the study; 25 modes.
fn truth() -> &'static ModalModel {
    static TRUTH: OnceLock<ModalModel> = OnceLock::new();
    TRUTH.get_or_init(|| {
        let mut panel = Panel::default();
        (panel.frf.stop_hz, panel.frf.step_hz) = (800.0, 200.0);
        simulate(&panel, None, None).unwrap().truth
    })
}

/// The panel some days later: all natural frequencies and each by itself.
fn later(common: f64, own: f64) -> ModalModel {
    let mut model = truth().clone();
    for (n, mode) in model
        .modes
        .iter_mut()
        .filter(|mode| mode.in_band)
        .enumerate()
    {
        mode.frequency_hz *= 1.0 + common + own * [0.4, -1.0, 0.7, -0.1][n % 4];
        mode.loss_factor *= 1.05;
    }
    model
}

/// FRFs of a panel at some responses, from one reference, 40 dB.
fn measured(panel: &ModalModel, responses: &[usize], references: &[usize]) -> FrfSet {
    let few = panel.at_dofs(responses, references);
    let frequency_hz = ndarray::Array1::range(2.0, 800.0, 0.5);
    let mut values = few.synthesise(&frequency_hz);
    add_white_noise(&mut values, 40.0, 3).unwrap();
    FrfSet {
        frequency_hz,
        values: FrfValues::F64(values),
        responses: few.responses.clone(),
        references: few.references.clone(),
        kind: Some(few.frf_kind),
        reference_unit: few.reference_unit,
        coherence: None,
        variance: None,
        estimation: None,
        geometry: Default::default(),
    }
}

/// Rms relative error of the natural frequencies in the band.
fn error_of(model: &ModalModel, panel: &ModalModel) -> f64 {
    let pairs = model.modes.iter().zip(&panel.modes);
    let own = pairs.filter(|(mode, _)| mode.in_band);
    let own: Vec<f64> = own
        .map(|(a, b)| a.frequency_hz / b.frequency_hz - 1.0)
        .collect();
    assert!(own.len() >= 20);
    (own.iter().map(|e| e * e).sum::<f64>() / own.len() as f64).sqrt()
}

/// Responses spread over the panel.
const SIX: [usize; 6] = [0, 15, 29, 46, 60, 76];

#[test]
fn six_frfs_follow_a_drift_to_a_hundred_thousandth() {
    for (common, own) in [(0.0, 0.0), (-3e-3, 2e-4), (1.5e-2, 1e-3)] {
        let panel = later(common, own);
        let moved = poles_of(truth(), &measured(&panel, &SIX, &[4])).unwrap();
        let error = error_of(&moved.model, &panel);
        eprintln!(
            "{common} {own}: {error:.2e}, {:.2e} ± {:.1e}",
            moved.common_shift, moved.common_shift_std
        );
        assert!(error <= 3e-5, "{common} {own}: {error}");
        assert!((moved.common_shift - common).abs() <= own + 5.0 * moved.common_shift_std);
        assert!(moved.relative_error < 0.02, "{}", moved.relative_error);
        let told = &moved.model.quality.findings;
        assert!(told.iter().any(|finding| finding.code == "poles-followed"));
        assert!(!told.iter().any(|finding| finding.code == "shapes-changed"));
        // errors are those that it states
        let z: Vec<f64> = moved
            .model
            .modes
            .iter()
            .zip(&panel.modes)
            .filter(|(mode, _)| mode.in_band)
            .map(|(a, b)| (a.frequency_hz - b.frequency_hz) / a.frequency_std_hz)
            .collect();
        let chi2 = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
        assert!((0.3..2.0).contains(&chi2), "{chi2}");
        assert_eq!(moved.model.modes[7].shape, truth().modes[7].shape);
    }
}

#[test]
fn viscous_poles_are_followed_too() {
    let viscous = |model: &ModalModel| ModalModel {
        damping: Damping::Viscous,
        ..model.clone()
    };
    let panel = viscous(&later(-2e-3, 3e-4));
    let moved = poles_of(&viscous(truth()), &measured(&panel, &SIX, &[4])).unwrap();
    let error = error_of(&moved.model, &panel);
    assert!(error <= 3e-5, "{error}");
}

#[test]
fn another_shape_is_said_and_strangers_are_refused() {
    let mut panel = later(1e-3, 0.0);
    for mode in &mut panel.modes {
        mode.shape.0[15] *= 1.4;
    }
    let moved = poles_of(truth(), &measured(&panel, &SIX, &[4])).unwrap();
    let told = &moved.model.quality.findings;
    assert!(
        told.iter().any(|finding| finding.code == "shapes-changed"),
        "{told:?}"
    );
    assert!(moved.model.quality.trusted);
    // the modes of another structure in the same places
    let mut other = truth().clone();
    for mode in &mut other.modes {
        mode.shape.0.rotate_left(7);
        mode.participation.0.rotate_left(3);
    }
    let moved = poles_of(truth(), &measured(&other, &SIX, &[4])).unwrap();
    assert!(!moved.model.quality.trusted);
    let mut stranger = measured(truth(), &SIX, &[4]);
    stranger.responses[2].node = 4711;
    let said = poles_of(truth(), &stranger)
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("4711:+Z") && said.contains("response"),
        "{said}"
    );
    let mut volts = measured(truth(), &SIX, &[4]);
    volts.reference_unit = chladni_frf::ReferenceUnit::Volt;
    assert!(poles_of(truth(), &volts).is_err());
    let mut beyond = measured(truth(), &SIX, &[4]);
    beyond.frequency_hz.mapv_inplace(|hz| hz + 5000.0);
    let said = poles_of(truth(), &beyond)
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(said.contains("band of the model"), "{said}");
    // a reversed sensor is the same response
    let mut turned = measured(truth(), &SIX, &[4]);
    turned.responses[1].direction = chladni_frf::Direction::from_code(-3).unwrap();
    if let FrfValues::F64(values) = &mut turned.values {
        values.index_axis_mut(Axis(0), 1).mapv_inplace(|v| -v);
    }
    let moved = poles_of(truth(), &turned).unwrap();
    assert!(error_of(&moved.model, truth()) <= 3e-5);
}
