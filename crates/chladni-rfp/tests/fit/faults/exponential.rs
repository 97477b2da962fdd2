//! The exponential window, taken off the poles.

use super::*;
use chladni_frf::{Damping, FrfKind};
use std::f64::consts::TAU;

/// The FRF matrix of a model at s = jω + α in the complex plane: what windowed responses
/// have on line ω.
fn at(truth: &ModalModel, s: Complex64) -> ndarray::Array2<Complex64> {
    let kind = s.powi(truth.frf_kind.omega_power());
    let mut out = ndarray::Array2::zeros((truth.responses.len(), truth.references.len()));
    for mode in &truth.modes {
        let omega = TAU * mode.frequency_hz;
        let denominator = match truth.damping {
            Damping::Structural => omega * omega * Complex64::new(1.0, mode.loss_factor) + s * s,
            Damping::Viscous => s * s + mode.loss_factor * omega * s + omega * omega,
        };
        for ((i, j), value) in out.indexed_iter_mut() {
            *value += kind * mode.shape.0[i] * mode.participation.0[j] / denominator;
        }
    }
    out
}

#[test]
fn an_exponential_window_comes_off_the_pole() {
    let viscous = Synthetic {
        damping: Damping::Viscous,
        ..easy(f64::INFINITY, 43)
    };
    let structural = easy(f64::INFINITY, 43);
    // twice the decay of the lowest mode: its damping is tripled by the window
    let alpha = 2.0;
    for synthetic in [viscous, structural] {
        for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
            let synthetic = Synthetic {
                kind,
                ..synthetic.clone()
            };
            let set = synthetic.build().unwrap();
            let mut windowed = set.frf.clone();
            let measured = values(&mut windowed);
            for (k, f) in set.frf.frequency_hz.iter().enumerate() {
                measured
                    .slice_mut(ndarray::s![.., .., k])
                    .assign(&at(&set.truth, Complex64::new(alpha, TAU * f)));
            }
            chladni_plate::add_white_noise(values(&mut windowed), 60.0, 44).unwrap();
            let options = FitOptions {
                exponential_window_per_s: Some(alpha),
                damping: Some(set.truth.damping),
                ..FitOptions::default()
            };
            let model = fitted_with(&windowed, &options);
            assert_eq!(
                missed_spurious_false(&set.truth, &model),
                (0, 0, 0),
                "{:?}",
                model.quality
            );
            for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
                let what = format!("{kind} {:?} {} Hz", model.damping, truth.frequency_hz);
                let off = (mode.frequency_hz - truth.frequency_hz).abs()
                    / (truth.frequency_hz * truth.loss_factor);
                assert!(off < 0.006, "{what}: {off} bandwidths off");
                let ratio = mode.loss_factor / truth.loss_factor;
                assert!((ratio - 1.0).abs() < 0.01, "{what}: damping ratio {ratio}");
                // ψ² at the driving point
                let scale = (mode.shape.0[0] * mode.participation.0[0]
                    / (truth.shape.0[0] * truth.participation.0[0]))
                    .norm();
                let strong = truth.shape.0[0].norm() > 0.5;
                assert!(
                    !strong || (scale - 1.0).abs() < 0.02,
                    "{what}: modal constant {scale}"
                );
            }
            assert!(says(&model, "without the exponential window"));
        }
    }
}

#[test]
fn a_window_that_decays_faster_than_the_modes_is_not_trusted() {
    let set = easy(40.0, 45).build().unwrap();
    let model = fitted_with(
        &set.frf,
        &FitOptions {
            exponential_window_per_s: Some(1000.0),
            ..FitOptions::default()
        },
    );
    assert!(
        !model.quality.trusted && says(&model, "more slowly than the exponential window"),
        "{:?}",
        model.quality.findings
    );
    assert_eq!(model.in_band_modes().count(), 0);
}
