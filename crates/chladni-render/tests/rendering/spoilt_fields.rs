//! Fields that are spoilt as a whole or at single points: what a correction makes of them.

use crate::common::rig::{magnitudes, Rig};
use crate::common::{cell_scene, truth};
use chladni_frf::MeasuredField;
use chladni_render::{
    calibrate, evaluate_field, poles_of_fields, render, Calibration, FieldEvaluation, PlayedField,
    RenderOptions, Scene, Weights,
};
use num_complex::Complex64;

fn corner() -> Scene {
    cell_scene([2, 2], 1, "")
}

fn drive() -> Weights {
    let options = RenderOptions::default();
    render(truth(), &corner(), &options).unwrap().weights
}

/// The field of `rig` at all responses, 1 % noise.
fn measured(weights: &Weights, mut rig: Rig) -> MeasuredField {
    rig.measured(weights, 0.01, &(0..77).collect::<Vec<_>>())
}

fn calibrated(weights: &Weights, field: MeasuredField) -> (Weights, Calibration) {
    let played = [PlayedField::new(weights.clone(), field)];
    calibrate(truth(), &corner(), &played, &RenderOptions::default()).unwrap()
}

#[test]
fn a_factor_of_all_channels_makes_none_of_them_odd() {
    let weights = drive();
    for factor in [
        Complex64::from_polar(1.0, 0.2),
        Complex64::new(0.0, 1.0),
        Complex64::new(-1.0, 0.0),
        Complex64::new(1.4, 0.0),
        Complex64::new(0.05, 0.0),
    ] {
        let mut rig = Rig::new(300.0, 3);
        rig.gains.mapv_inplace(|gain| gain * factor);
        let field = measured(&weights, rig);
        let (_, known) = calibrated(&weights, field.clone());
        for gain in &known.gains {
            let off = (Complex64::new(gain.re, gain.im) / factor - 1.0).norm();
            assert!(!gain.odd && off < 0.05, "{factor}: {gain:?}");
        }
        assert!(known.dead.is_empty());
        for mode in &known.modes {
            let moved = mode.frequency_hz / mode.model_hz - 1.0;
            assert!(moved.abs() < 2e-3, "{factor}: {mode:?}");
        }
        let poles = poles_of_fields(truth(), &[PlayedField::new(weights.clone(), field)]).unwrap();
        assert!(
            poles.common_shift.abs() < 1e-3,
            "{factor}: {}",
            poles.common_shift
        );
    }
}

#[test]
fn a_dead_channel_behind_a_common_factor_is_still_found() {
    let weights = drive();
    let mut rig = Rig::new(300.0, 4).channel(12, 0.0);
    rig.gains.mapv_inplace(|gain| -gain);
    let (_, known) = calibrated(&weights, measured(&weights, rig));
    assert_eq!(known.dead, [truth().references[12]]);
    assert_eq!(known.gains.iter().filter(|gain| gain.odd).count(), 1);
}

#[test]
fn a_point_that_no_motion_explains_is_named_and_teaches_nothing() {
    let weights = drive();
    let rig = || Rig::new(300.0, 5).scattered(0.02, 2.0).channel(12, 0.0);
    let clean = measured(&weights, rig());
    let points = &clean.points;
    let square = points
        .iter()
        .map(|p| p.velocity_m_per_s.norm_sqr())
        .sum::<f64>();
    let rms = (square / points.len() as f64).sqrt();
    let margin = |evaluated: &FieldEvaluation| evaluated.indices.points.margin_db.unwrap();
    let sound = evaluate_field(&weights, &corner(), truth(), &clean, None).unwrap();
    for (place, size) in [(20, 10.0), (41, 3.0)] {
        let mut field = clean.clone();
        field.points[place].velocity_m_per_s += Complex64::from_polar(size * rms, 1.0);
        let spoilt = field.points[place].response;
        let judged = evaluate_field(&weights, &corner(), truth(), &field, None).unwrap();
        // nor does it spoil the score
        assert!((margin(&judged) - margin(&sound)).abs() < 1.0);
        let (corrected, known) = calibrated(&weights, field);
        for findings in [&judged.findings[..], &corrected.findings[..]] {
            let named = findings.iter().find(|one| one.code == "field-point-off");
            assert_eq!(named.unwrap().dofs, [spoilt]);
        }
        assert_eq!(known.dead, [truth().references[12]], "{place}");
        assert_eq!(known.gains.iter().filter(|gain| gain.odd).count(), 1);
    }
    let (corrected, _) = calibrated(&weights, clean);
    assert!(corrected
        .findings
        .iter()
        .all(|one| one.code != "field-point-off"));
}

#[test]
fn a_field_that_turns_the_wrong_way_is_refused_and_one_of_other_weights_is_named() {
    let weights = drive();
    let mut turned = measured(&weights, Rig::new(300.0, 6));
    for point in &mut turned.points {
        point.velocity_m_per_s = point.velocity_m_per_s.conj();
    }
    let judged = evaluate_field(&weights, &corner(), truth(), &turned, None).unwrap();
    assert_eq!(judged.findings[0].code, "field-conjugated");
    let played = [PlayedField::new(weights.clone(), turned)];
    let error = calibrate(truth(), &corner(), &played, &RenderOptions::default()).unwrap_err();
    assert_eq!(error.field.as_deref(), Some("velocity"), "{error}");
    let other = render(
        truth(),
        &cell_scene([2, 2], 4, ""),
        &RenderOptions::default(),
    )
    .unwrap();
    let field = measured(&other.weights, Rig::new(300.0, 7));
    let judged = evaluate_field(&weights, &corner(), truth(), &field, None).unwrap();
    assert_eq!(judged.findings[0].code, "field-unlike");
    let (corrected, _) = calibrated(&weights, field);
    assert!(corrected
        .findings
        .iter()
        .any(|one| one.code == "field-unlike"));
}

#[test]
fn amplifiers_scatter_beside_their_common_factor() {
    let weights = drive();
    for (factor, seed) in [(0.5, 11), (0.5, 12), (10.0, 13)] {
        let mut rig = Rig::new(300.0, seed).scattered(0.02, 2.0);
        let gains = rig.gains.mapv(|gain| gain * factor);
        rig.gains.assign(&gains);
        let (_, known) = calibrated(&weights, measured(&weights, rig));
        let mut square = 0.0;
        for (gain, truth) in known.gains.iter().zip(&gains) {
            assert!(!gain.odd, "{factor} {seed}: {gain:?}");
            square += (Complex64::new(gain.re, gain.im) - truth).norm_sqr();
        }
        let rms = (square / gains.len() as f64).sqrt() / factor;
        assert!(rms < 0.06, "{factor} {seed}: {rms}");
    }
}

#[test]
fn magnitudes_tell_the_size_of_a_common_factor_and_leave_its_phase() {
    let weights = drive();
    let mut rig = Rig::new(300.0, 14);
    rig.gains.mapv_inplace(|gain| gain * 1.4);
    let (corrected, known) = calibrated(&weights, magnitudes(measured(&weights, rig)));
    for gain in &known.gains {
        assert!(
            gain.std < 0.1 && (gain.re - 1.4).abs() < 0.1 && gain.im.abs() < 0.1,
            "{gain:?}"
        );
    }
    let said = corrected
        .findings
        .iter()
        .find(|one| one.code == "common-factor");
    assert!(!said.unwrap().to_string().contains('j'), "{said:?}");
}

#[test]
fn one_point_does_not_set_the_noise_of_all() {
    let weights = drive();
    let rig = || Rig::new(300.0, 15).channel(12, 0.0);
    let mut field = measured(&weights, rig());
    for point in &mut field.points {
        point.std_m_per_s = None;
    }
    field.points[30].velocity_m_per_s *= 1e4;
    let (_, known) = calibrated(&weights, field);
    assert_eq!(known.dead, [truth().references[12]]);
}

#[test]
fn one_dead_channel_is_no_field_of_other_weights() {
    let weights = drive();
    for channel in 0..34 {
        let field = measured(&weights, Rig::new(300.0, 16).channel(channel, 0.0));
        let judged = evaluate_field(&weights, &corner(), truth(), &field, None).unwrap();
        assert!(
            judged.findings.iter().all(|one| one.code != "field-unlike"),
            "{channel}"
        );
        let (corrected, _) = calibrated(&weights, field);
        assert!(
            corrected
                .findings
                .iter()
                .all(|one| one.code != "field-unlike"),
            "{channel}"
        );
    }
}

/// A later field is held against what those before it taught.
#[test]
fn a_second_field_that_turns_the_wrong_way_is_refused() {
    let weights = drive();
    let first = measured(&weights, Rig::new(300.0, 8));
    let (again, _) = calibrated(&weights, first.clone());
    let mut turned = measured(&again, Rig::new(300.0, 8));
    let both = |second: &MeasuredField| {
        let first = PlayedField::new(weights.clone(), first.clone());
        let played = [first, PlayedField::new(again.clone(), second.clone())];
        calibrate(truth(), &corner(), &played, &RenderOptions::default())
    };
    both(&turned).unwrap();
    for point in &mut turned.points {
        point.velocity_m_per_s = point.velocity_m_per_s.conj();
    }
    let error = both(&turned).unwrap_err();
    let about = error.field.as_deref();
    assert_eq!(about, Some("velocity of field 2"), "{error}");
}

#[test]
fn no_shift_is_offered_that_no_panel_has() {
    let weights = drive();
    let clean = measured(&weights, Rig::new(300.0, 6));
    for step in [5, 11, 30, 76] {
        let mut field = clean.clone();
        for (k, point) in field.points.iter_mut().enumerate() {
            point.velocity_m_per_s = clean.points[step * k % 77].velocity_m_per_s * 3.0;
        }
        let judged = evaluate_field(&weights, &corner(), truth(), &field, None).unwrap();
        let causes = &judged.agreement.hypotheses;
        for cause in causes.iter().filter(|one| one.kind.starts_with("mode")) {
            let [shift, _] = cause.value.unwrap();
            println!("{step}: {} {shift}", cause.kind);
            assert!(shift.abs() <= 0.1, "{step}: {cause:?}");
        }
    }
}
