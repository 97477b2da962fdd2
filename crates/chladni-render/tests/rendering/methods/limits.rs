//! Limits of force and voltage, and scenes that they forbid.

use super::rendered::{options, rendered};
use crate::common::{cell_scene, truth};
use chladni_render::{render, Method};

#[test]
fn a_force_limit_is_kept_and_said_to_bind() {
    for method in Method::ALL {
        let free = rendered(truth(), &cell_scene([2, 2], 1, ""), method);
        let limit = 0.3 * free.weights.indices.points.max_force_n.unwrap();
        let scene = cell_scene([2, 2], 1, &format!("[actuators]\nmax_force_n = {limit}\n"));
        let limited = rendered(truth(), &scene, method);
        let force = limited.weights.indices.points.max_force_n.unwrap();
        assert!(
            force <= limit * (1.0 + 1e-12),
            "{method}: {force} N of {limit} N"
        );
        if [Method::PressureMatching, Method::Mls].contains(&method) {
            assert!(
                limited
                    .weights
                    .findings
                    .iter()
                    .any(|w| w.contains(" N per actuator binds")),
                "{method}: {:?}",
                limited.weights.findings
            );
        }
    }
}

#[test]
fn a_tight_force_limit_is_met_by_a_more_economical_drive() {
    let free = rendered(truth(), &cell_scene([2, 2], 1, ""), Method::Mls)
        .weights
        .indices
        .points
        .max_force_n
        .unwrap();
    let scene = cell_scene(
        [2, 2],
        1,
        &format!("[actuators]\nmax_force_n = {}\n", 0.6 * free),
    );
    let limited = rendered(truth(), &scene, Method::Mls).weights;
    assert!(
        limited.indices.points.min_ratio > 0.9,
        "{:?}",
        limited.indices.points
    );
}

#[test]
fn an_infeasible_scene_says_what_is_possible() {
    let scene = cell_scene([2, 2], 1, "[actuators]\nmax_force_n = 1e-5\n");
    let weights = rendered(truth(), &scene, Method::Robust).weights;
    assert!(!weights.feasible && weights.kappa.unwrap() < 0.0);
    let said = weights
        .findings
        .iter()
        .find(|warning| warning.contains("impossible"))
        .expect("what is possible");
    assert!(
        said.contains("% of the hot") && said.contains("4.0 dB"),
        "{said}"
    );
}

#[test]
fn volts_have_a_limit_of_their_own() {
    let mut model = truth().clone();
    model.reference_unit = chladni_frf::ReferenceUnit::Volt;
    let error = render(
        &model,
        &cell_scene([2, 2], 1, "[actuators]\nmax_force_n = 1\n"),
        &options(Method::Mls),
    )
    .unwrap_err();
    assert!(
        error.to_string().contains("actuators.max_voltage_v"),
        "{error}"
    );
    let unlimited = rendered(&model, &cell_scene([2, 2], 1, ""), Method::Mls).weights;
    assert!(unlimited
        .findings
        .iter()
        .any(|w| w.contains("no limit was kept")));
    assert_eq!(unlimited.indices.points.max_force_n, None);
    let limited = rendered(
        &model,
        &cell_scene([2, 2], 1, "[actuators]\nmax_voltage_v = 0.001\n"),
        Method::Mls,
    )
    .weights;
    assert!(limited.indices.points.max_voltage_v.unwrap() <= 0.001 * (1.0 + 1e-12));
}

#[test]
fn current_and_apparent_power_limit_the_voltage_of_coils_and_piezos() {
    let mut model = truth().clone();
    model.reference_unit = chladni_frf::ReferenceUnit::Volt;
    let largest = |actuators: &str| {
        let scene = cell_scene([2, 2], 1, &format!("[actuators]\n{actuators}\n"));
        let weights = rendered(&model, &scene, Method::Mls).weights;
        assert!(!weights.findings.iter().any(|w| w.code == "no-drive-limit"));
        weights.indices.points.max_voltage_v.unwrap()
    };
    let omega = std::f64::consts::TAU * 300.0;
    let coil = 8f64.hypot(omega * 2e-3);
    let piezo = (omega * 1e-7).recip();
    for (actuators, limit) in [
        (
            "max_current_a = 1e-4\nresistance_ohm = 8\ninductance_h = 2e-3",
            1e-4 * coil,
        ),
        ("max_current_a = 1e-7\ncapacitance_f = 1e-7", 1e-7 * piezo),
        (
            "max_apparent_power_va = 1e-8\nresistance_ohm = 8\ninductance_h = 2e-3",
            (2e-8 * coil).sqrt(),
        ),
        (
            "max_voltage_v = 3e-4\nmax_current_a = 1e-4\nresistance_ohm = 8",
            3e-4,
        ),
    ] {
        let used = largest(actuators);
        // a drive of `mls` takes more than each of these where it may
        assert!(
            used <= limit * (1.0 + 1e-12),
            "{actuators}: {used} of {limit}"
        );
        assert!(used >= 0.5 * limit, "{actuators}: {used} of {limit}");
    }
    let refused = |model: &chladni_frf::ModalModel, actuators: &str| {
        let scene = cell_scene([2, 2], 1, &format!("[actuators]\n{actuators}\n"));
        render(model, &scene, &options(Method::Mls))
            .unwrap_err()
            .to_string()
    };
    let said = refused(truth(), "max_current_a = 1\nresistance_ohm = 8");
    assert!(
        said.contains("newtons") && said.contains("max_force_n"),
        "{said}"
    );
    let text = |actuators: &str| {
        let scene = format!(
            "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\n[actuators]\n{actuators}\n"
        );
        let scene = chladni_render::Scene::parse(&scene, std::path::Path::new(""));
        scene.map(|_| ()).unwrap_err().to_string()
    };
    assert!(text("max_current_a = 1").contains("needs the impedance"));
    let both = text("max_current_a = 1\nresistance_ohm = 8\ncapacitance_f = 1e-7");
    assert!(both.contains("coil or a piezo"), "{both}");
}

#[test]
fn a_limit_in_the_other_unit_is_refused_also_beside_the_right_one() {
    let mut volts = truth().clone();
    volts.reference_unit = chladni_frf::ReferenceUnit::Volt;
    for (model, actuators, field) in [
        (truth(), "max_voltage_v = 1.0", "max_voltage_v"),
        (
            truth(),
            "max_force_n = 0.1\nmax_voltage_v = 1.0",
            "max_voltage_v",
        ),
        (
            &volts,
            "max_force_n = 0.1\nmax_voltage_v = 1.0",
            "max_force_n",
        ),
    ] {
        let scene = cell_scene([2, 2], 1, &format!("[actuators]\n{actuators}\n"));
        let error = render(model, &scene, &options(Method::Mls)).unwrap_err();
        let named = error.field.as_deref().unwrap_or_default();
        assert!(named.ends_with(field), "{actuators}: {error}");
    }
}

#[test]
fn the_ceiling_of_a_hopeless_scene_can_be_written_and_read() {
    let rest = "[actuators]\nmax_force_n = 1e-30\n[threshold]\nlimen_db = 100.0\n";
    let scene = cell_scene([2, 2], 1, rest);
    let weights = rendered(truth(), &scene, Method::Robust).weights;
    let ceiling = weights.ceiling.unwrap();
    let numbers = [ceiling.possible_db, ceiling.reached_db];
    assert!(numbers.iter().all(|db| db.is_finite()), "{ceiling:?}");
    let text = weights.to_json().unwrap();
    chladni_render::Weights::parse(&text).unwrap();
}
