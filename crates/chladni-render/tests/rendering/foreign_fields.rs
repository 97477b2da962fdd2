//! Fields that no fault of a rig makes: points in another order, other weights, nothing but noise.

use crate::common::rig::{magnitudes, Rig};
use crate::common::{cell_scene, truth};
use crate::correction::{corner, first_drive, rendered, served};
use chladni_frf::MeasuredField;
use chladni_render::{correct, Finger, PlayedField, RenderOptions, Weights};
use num_complex::Complex64;

/// Columns of the grid of responses, row by row.
const COLUMNS: usize = 11;
/// Its rows.
const ROWS: usize = 7;

fn whole(rig: &mut Rig, weights: &Weights) -> MeasuredField {
    let all: Vec<usize> = (0..ROWS * COLUMNS).collect();
    rig.measured(weights, 0.01, &all)
}

fn corrected(weights: &Weights, field: MeasuredField) -> Weights {
    let played = [PlayedField::new(weights.clone(), field)];
    correct(truth(), &corner(), &played, &RenderOptions::default()).unwrap()
}

fn is_doubted(corrected: &Weights) -> bool {
    let mut findings = corrected.findings.iter();
    findings.any(|one| one.code == "field-unlike" || one.code == "field-unexplained")
}

/// The field with the value of point `from(k)` at point k.
fn reordered(field: &MeasuredField, from: impl Fn(usize) -> usize) -> MeasuredField {
    let mut other = field.clone();
    for (k, point) in other.points.iter_mut().enumerate() {
        point.velocity_m_per_s = field.points[from(k)].velocity_m_per_s;
    }
    other
}

#[test]
fn a_field_that_no_fault_explains_is_doubted() {
    let weights = first_drive();
    for seed in 0..3 {
        let right = whole(&mut Rig::new(300.0, seed).scattered(0.02, 2.0), &weights);
        let other = rendered(&cell_scene([2, 2], 4, ""));
        let foreign = whole(&mut Rig::new(300.0, seed).scattered(0.02, 2.0), &other);
        let mut noise = right.clone();
        for (k, point) in noise.points.iter_mut().enumerate() {
            let turned = Complex64::from_polar(0.01, (2.4 * k as f64).powi(2) + seed as f64);
            point.velocity_m_per_s = turned * point.std_m_per_s.unwrap();
        }
        for (name, field) in [
            (
                "columns",
                reordered(&right, |k| k / ROWS + COLUMNS * (k % ROWS)),
            ),
            (
                "mirrored",
                reordered(&right, |k| k + COLUMNS - 1 - 2 * (k % COLUMNS)),
            ),
            ("of other weights", foreign),
            ("noise", noise),
        ] {
            assert!(is_doubted(&corrected(&weights, field)), "{seed}: {name}");
        }
        assert!(!is_doubted(&corrected(&weights, right)), "{seed}");
    }
}

#[test]
fn a_faulty_rig_is_not_doubted() {
    let weights = first_drive();
    for seed in 0..6 {
        let scattered = || Rig::new(300.0, seed).scattered(0.02, 2.0);
        let channels = [3 * seed as usize, 3 * seed as usize + 7, 31 - seed as usize];
        let dead = |count: usize, gain: f64| {
            let channels = channels[..count].iter();
            channels.fold(scattered(), |rig, &channel| rig.channel(channel, gain))
        };
        let mut turned = scattered();
        turned
            .gains
            .mapv_inplace(|gain| gain * Complex64::from_polar(1.0, 2.5));
        for (name, mut rig) in [
            ("scattered", Rig::new(300.0, seed).scattered(0.07, 4.0)),
            ("dead", dead(3, 0.0)),
            ("reversed", dead(2, -1.0)),
            ("moved", scattered().shifted(3e-3)),
            ("finger", scattered().loaded(&Finger::MID, [0.061, 0.052])),
            (
                "mass",
                scattered().loaded(&Finger::of_mass(3e-3), [0.12, 0.09]),
            ),
            ("turned", turned),
        ] {
            let field = whole(&mut rig, &weights);
            assert!(
                !is_doubted(&corrected(&weights, field.clone())),
                "{seed}: {name}"
            );
            let sizes = corrected(&weights, magnitudes(field));
            assert!(!is_doubted(&sizes), "{seed}: {name} without phases");
        }
    }
}

/// A phase that all channels share lies far beyond the error bars of any channel.
#[test]
fn a_common_phase_is_no_matter_of_single_channels() {
    let weights = first_drive();
    for seed in 0..12 {
        let mut rig = Rig::new(300.0, seed).scattered(0.02, 1.0);
        let phase = Complex64::from_polar(1.0, 0.5 + 0.45 * seed as f64);
        rig.gains.mapv_inplace(|gain| gain * phase);
        let field = whole(&mut rig, &weights);
        let after = corrected(&weights, field);
        let ratio = served(&rig, &after);
        assert!(ratio >= 0.98, "{seed}: {ratio}, {:?}", after.correction);
        let mut findings = after.findings.iter();
        assert!(findings.any(|one| one.code == "common-factor"), "{seed}");
    }
}
