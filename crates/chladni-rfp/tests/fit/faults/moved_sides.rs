//! FRFs measured one after another while the structure drifts: over responses, or references.

use super::*;
use chladni_plate::add_noise_of_variance;

/// The DOF that tells the time of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Responses,
    References,
}

/// `easy` with other DOFs.
fn panel(responses: usize, references: usize, seed: u64) -> Synthetic {
    Synthetic {
        responses,
        references,
        ..easy(40.0, seed)
    }
}

/// The fit of a set whose natural frequencies all differ by (1 + `apart`·place) from one DOF of a
/// side to the next, places within ±½.
fn drifted(set: Synthetic, side: Side, apart: f64) -> ModalModel {
    let dofs = match side {
        Side::Responses => set.responses,
        Side::References => set.references,
    };
    let set = set.build().unwrap();
    let mut frf = set.frf.clone();
    for dof in 0..dofs {
        // 0.618: places in no order
        let place = (0.618 * dof as f64).fract() - 0.5;
        let mut then = set.truth.clone();
        for mode in &mut then.modes {
            mode.frequency_hz *= 1.0 + apart * place;
        }
        let own = then.synthesise(&set.frf.frequency_hz);
        let axis = match side {
            Side::Responses => ndarray::Axis(0),
            Side::References => ndarray::Axis(1),
        };
        values(&mut frf)
            .index_axis_mut(axis, dof)
            .assign(&own.index_axis(axis, dof));
    }
    add_noise_of_variance(values(&mut frf), set.noise_variance, 5);
    fitted(&frf)
}

fn told(model: &ModalModel, code: &str) -> bool {
    let findings = &model.quality.findings;
    findings.iter().any(|finding| finding.code == code)
}

#[test]
fn drift_between_references_is_told_whichever_side_is_larger() {
    for (responses, references) in [(25, 2), (20, 4), (6, 6), (4, 20)] {
        // 0.1 bandwidths in all
        let set = panel(responses, references, 61);
        let model = drifted(set, Side::References, 1e-3);
        let what = format!("{responses} x {references}: {:?}", model.quality.findings);
        assert!(told(&model, "split-modes"), "{what}");
        for wrong in ["sensor-reversed", "delayed-reference", "scale-unknown"] {
            assert!(!told(&model, wrong), "{what}");
        }
        let sure = model.in_band_modes().filter(|m| m.trust == Trust::Sure);
        assert!(sure.count() <= 8, "{what}");
        if references < responses {
            assert!(
                says(&model, "references measured one after another"),
                "{what}"
            );
        }
    }
}

#[test]
fn drift_between_few_responses_is_told() {
    for (responses, references) in [(4, 20), (20, 4)] {
        let set = panel(responses, references, 62);
        let model = drifted(set, Side::Responses, 1e-3);
        let what = format!("{responses} x {references}: {:?}", model.quality.findings);
        assert!(told(&model, "split-modes"), "{what}");
        assert!(!told(&model, "sensor-reversed"), "{what}");
    }
}

#[test]
fn two_shapes_are_no_drift_where_each_reference_drives_one() {
    let close = 100.0 * (1.0 + 0.15 * 0.01);
    for (responses, references) in [(12, 2), (20, 4), (3, 3), (4, 20)] {
        let mut set = panel(responses, references, 63);
        (set.natural_frequency_hz, set.loss_factor) = (vec![50.0, 100.0, close], vec![0.01]);
        let set = set.build().unwrap();
        let mut truth = set.truth.clone();
        let mut of_pair = 0;
        for mode in truth.modes.iter_mut().filter(|m| m.frequency_hz > 90.0) {
            for j in (0..references).filter(|j| j % 2 != of_pair) {
                mode.participation.0[j] = Complex64::default();
            }
            of_pair += 1;
        }
        assert_eq!(of_pair, 2);
        let mut frf = set.frf.clone();
        values(&mut frf).assign(&truth.synthesise(&set.frf.frequency_hz));
        add_noise_of_variance(values(&mut frf), set.noise_variance, 64);
        let model = fitted(&frf);
        let what = format!("{responses} x {references}: {:?}", model.quality);
        assert!(!told(&model, "split-modes"), "{what}");
        let sure = model.in_band_modes().filter(|m| m.trust == Trust::Sure);
        assert_eq!(sure.count(), 3, "{what}");
    }
}
