//! Reports of a small panel.

use base64::engine::general_purpose::STANDARD;
use base64::Engine;
use chladni_frf::{FrfSet, ModalModel};
use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::{render, Rendering, Scene};
use chladni_report::{ChartFormats, RenderedScene, ReportInput};
use std::path::Path;
use std::sync::OnceLock;

pub const ALL_FORMATS: ChartFormats = ChartFormats {
    svg: true,
    png: true,
    gif: true,
};

pub fn simulated(text: &str) -> Simulation {
    simulate(&Panel::from_toml(text, 1 << 30).unwrap(), None, None).unwrap()
}

/// The glass panel up to 400 Hz at 24 × 12 pairs, with bounds as from a fit.
pub fn small() -> &'static Simulation {
    static SMALL: OnceLock<Simulation> = OnceLock::new();
    SMALL.get_or_init(|| {
        let mut simulation = simulated(
            "[responses]\ngrid = [6, 4]\nspacing_m = \
                                        0.04\n[references]\nedge_count = [4, 2]\nspacing_m = \
                                        0.05\n[frf]\nstop_hz = 400\nstep_hz = 2\n",
        );
        for mode in &mut simulation.truth.modes {
            (mode.frequency_std_hz, mode.loss_factor_std) = (0.0123, 1e-5);
        }
        simulation
    })
}

pub fn scene() -> Scene {
    Scene::parse(
        "frequency_hz = 300.0\n[zones]\ngrid = [2, 2]\nhot = [1]\ncells_m = [0.0, 0.0, \
                  0.268, 0.170]\n",
        Path::new(""),
    )
    .unwrap()
}

pub fn rendering(model: &ModalModel) -> Rendering {
    render(model, &scene(), &Default::default()).unwrap()
}

pub fn input<'a>(
    model: &'a ModalModel,
    measured: Option<&'a FrfSet>,
    rendering: &'a Rendering,
) -> ReportInput<'a> {
    let scenes = vec![RenderedScene::of_rendering(rendering)];
    ReportInput {
        title: "Panel".into(),
        model: Some(model),
        measured,
        scenes,
        ..ReportInput::default()
    }
}

/// Numbers from base64 of little-endian single precision.
pub fn f32s(coded: &serde_json::Value) -> Vec<f32> {
    let bytes = STANDARD.decode(coded["f32"].as_str().unwrap()).unwrap();
    bytes
        .chunks_exact(4)
        .map(|four| f32::from_le_bytes(four.try_into().unwrap()))
        .collect()
}
