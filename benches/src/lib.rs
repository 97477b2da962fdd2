//! Named problems that speed and accuracy runs share.

use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::Scene;
use ndarray::Array1;
use std::path::Path;

/// The glass panel of the demonstration: 77 responses, 34 references, 1997 lines, 40 dB, 25 modes in the band.
///
/// # Panics
/// Never: the panel is a constant.
pub fn panel_77x34_1997_lines() -> Simulation {
    let panel = Panel::from_toml(include_str!("../../fixtures/panel.toml"), 2 << 30).expect("the committed panel");
    simulate(&panel, None, None).expect("the committed panel")
}

/// Eight separate modes, twelve FRFs, 2200 lines, 40 dB.
///
/// # Panics
/// Never: the case is a constant.
pub fn easy_12_frfs() -> chladni_frf::FrfSet {
    let case = chladni_plate::Synthetic {
        natural_frequency_hz: vec![31.0, 52.0, 78.0, 101.0, 133.0, 160.0, 187.0, 215.0],
        responses: 6,
        references: 2,
        frequency_hz: Array1::range(20.0, 240.0, 0.1),
        ..chladni_plate::Synthetic::default()
    };
    case.build().expect("a constant case").frf
}

/// The first quarter of the panel felt at 300 Hz, the rest quiet.
///
/// # Panics
/// Never: the scene is a constant.
pub fn corner_scene() -> Scene {
    Scene::parse(include_str!("../../fixtures/scene-corner.toml"), Path::new("")).expect("the committed scene")
}
