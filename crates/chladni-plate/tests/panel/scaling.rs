//! Shapes scaled by the geometry of the panel, on exact modes whose scale was taken away.

use chladni_frf::{Direction, FrfKind, ModalModel, Scaling, Trust};
use chladni_plate::{scale_by_panel, simulate, Panel, ScaleRoute};
use num_complex::Complex64;

/// The panel of the study, up to 700 Hz: responses and references have no point in common.
fn panel(coil_kg: f64) -> Panel {
    let mut panel = Panel::default();
    (panel.frf.start_hz, panel.frf.stop_hz, panel.frf.step_hz) = (5.0, 700.0, 50.0);
    panel.references.mass_kg = coil_kg;
    panel
}

/// The panel as it is believed to be: 20 % off in Poisson's ratio, and no coils.
fn nominal(panel: &Panel) -> Panel {
    let mut nominal = panel.clone();
    nominal.plate.poisson_ratio *= 1.2;
    nominal.references.mass_kg = 0.0;
    nominal
}

/// The exact model without its scale: the largest entry of every shape is 1.
fn unscaled(truth: &ModalModel) -> ModalModel {
    let mut model = truth.clone();
    model.scaling = Scaling::Unscaled;
    for mode in &mut model.modes {
        let largest =
            mode.shape.0.iter().fold(
                Complex64::ZERO,
                |a, &b| if b.norm() > a.norm() { b } else { a },
            );
        mode.shape.0.iter_mut().for_each(|value| *value /= largest);
        mode.participation
            .0
            .iter_mut()
            .for_each(|value| *value *= largest);
    }
    model
}

/// Rms relative error of ψψᵀ over the modes up to a frequency.
fn error_of(scaled: &ModalModel, truth: &ModalModel, top_hz: f64) -> f64 {
    let modes = scaled.modes.iter().zip(&truth.modes);
    let own = modes
        .filter(|(mode, _)| mode.in_band && mode.frequency_hz <= top_hz)
        .map(|(mode, truth)| {
            let square = |values: &[Complex64]| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
            square(&mode.shape.0) / square(&truth.shape.0) - 1.0
        });
    let own: Vec<f64> = own.collect();
    assert!(own.len() > 8);
    (own.iter().map(|e| e * e).sum::<f64>() / own.len() as f64).sqrt()
}

#[test]
fn frfs_alone_do_not_tell_the_scale() {
    let truth = simulate(&panel(0.0), None, None).unwrap().truth;
    let other = unscaled(&truth);
    for hz in [7.0, 130.0, 299.4, 700.0] {
        let [a, b] = [&truth, &other].map(|model| model.frf_matrix(FrfKind::Mobility, hz));
        let size = a.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let apart = (&a - &b).iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(apart < 1e-12 * size, "{hz} Hz: {apart} of {size}");
    }
    let [a, b] = [&truth, &other].map(|model| model.modes[3].shape.0[0].norm());
    assert!((a / b - 1.0).abs() > 0.1, "the same shapes: {a}, {b}");
}

#[test]
fn both_routes_scale_within_a_percent_below_420_hz_with_poissons_ratio_off() {
    let panel = panel(0.0);
    let truth = simulate(&panel, None, None).unwrap().truth;
    for route in [ScaleRoute::Continuity, ScaleRoute::Mass] {
        let scaled = scale_by_panel(&unscaled(&truth), &nominal(&panel), route).unwrap();
        let [low, all] = [420.0, 700.0].map(|hz| error_of(&scaled.model, &truth, hz));
        eprintln!(
            "{}: {low:.4} {all:.4}, said {:.4}",
            route.name(),
            scaled.disagreement
        );
        assert!(low <= 0.01, "{}: {low}", route.name());
        assert!(scaled.model.scaling == Scaling::UnitModalMass);
        assert!(
            all <= 2.0 * scaled.disagreement.max(0.005),
            "{all}: {}",
            scaled.disagreement
        );
        let before = truth.frf_matrix(FrfKind::Mobility, 300.0);
        let after = scaled.model.frf_matrix(FrfKind::Mobility, 300.0);
        let size = before.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!((&before - &after).iter().all(|v| v.norm() < 1e-12 * size));
    }
}

#[test]
fn the_residual_tells_mass_inertia_gains_and_coils() {
    let panel = panel(0.5e-3);
    let truth = simulate(&panel, None, None).unwrap().truth;
    let mut measured = unscaled(&truth);
    // channel 4 gives 3 % more, channel 9 drives the other way and is noted so
    let column = |model: &mut ModalModel, j: usize, gain: f64| {
        for mode in &mut model.modes {
            mode.participation.0[j] *= gain;
        }
        for term in &mut model.residual_terms.terms {
            term.matrix.0.column_mut(j).mapv_inplace(|v| v * gain);
        }
    };
    column(&mut measured, 4, 1.03);
    column(&mut measured, 9, -1.0);
    measured.references[9].direction = Direction::from_code(-3).unwrap();
    let nominal = nominal(&panel);
    let scaled = scale_by_panel(&measured, &nominal, ScaleRoute::Continuity).unwrap();
    let body = scaled.rigid.as_ref().unwrap();
    let (plate, mean) = (&panel.plate, 1.0 + 0.03 / 34.0);
    let true_kg = plate.mass() + 34.0 * 0.5e-3;
    assert!(
        (body.mass_kg * mean / true_kg - 1.0).abs() < 1e-6,
        "{body:?}"
    );
    assert!((body.coil_mass_kg - 0.5e-3).abs() < 0.05e-3, "{body:?}");
    assert!((body.centre_m[0] - 0.134).abs() < 1e-6, "{body:?}");
    assert!((body.centre_m[1] - 0.085).abs() < 1e-6, "{body:?}");
    let about = |axis: usize, side: f64| {
        let arms = panel.layout().references_m;
        let coils: f64 = arms
            .iter()
            .map(|place| 0.5e-3 * (place[axis] - 0.5 * side).powi(2))
            .sum();
        plate.mass() * side * side / 12.0 + coils
    };
    let inertia = [about(1, plate.width_m), about(0, plate.length_m)];
    for (said, truth) in body.inertia_kg_m2.iter().zip(inertia) {
        assert!(
            (said * mean / truth - 1.0).abs() < 1e-6,
            "{body:?}, {inertia:?}"
        );
    }
    for (j, gain) in body.gains.iter().enumerate() {
        let truth = if j == 4 { 1.03 } else { 1.0 } / mean;
        assert!((gain - truth).abs() < 1e-6, "{j}: {gain}");
    }
    // with the coils that it found the scale is within what is said of it
    let low = error_of(&scaled.model, &truth, 420.0);
    eprintln!("coils: {low:.4}, said {:.4}", scaled.disagreement);
    assert!(
        low <= 0.02 && low <= 2.0 * scaled.disagreement,
        "{low} {}",
        scaled.disagreement
    );
}

#[test]
fn another_panel_is_refused_and_says_what_it_weighs() {
    let panel = panel(0.5e-3);
    let mut measured = unscaled(&simulate(&panel, None, None).unwrap().truth);
    let nominal = nominal(&panel);
    // without the residual nothing tells of the coils
    let whole = measured.clone();
    measured
        .residual_terms
        .terms
        .retain(|term| term.power != -2);
    let refused = |model: &ModalModel, panel: &Panel| {
        scale_by_panel(model, panel, ScaleRoute::Continuity)
            .map(|_| ())
            .unwrap_err()
            .to_string()
    };
    let said = refused(&measured, &nominal);
    assert!(
        said.contains("between continuity and mass") && said.contains("mass_kg"),
        "{said}"
    );
    let mut unplaced = whole.clone();
    unplaced.nodes.retain(|node| node.label != 107);
    assert!(refused(&unplaced, &nominal).contains("107:+Z"));
    let mut held = whole;
    for mode in held.modes.iter_mut().filter(|mode| mode.in_band) {
        mode.trust = Trust::Rejected;
    }
    assert!(refused(&held, &nominal).contains("no mode to scale"));
}
