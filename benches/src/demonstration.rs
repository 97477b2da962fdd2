//! The panel and the scene of the demonstration.

use chladni_frf::Result;
use chladni_plate::{simulate, Panel, Simulation};
use chladni_render::Scene;
use std::path::Path;

/// Memory that the committed panel may take.
const MEMORY_BYTES: u64 = 2 << 30;

/// The glass panel of the demonstration: 77 responses, 34 references, 1997 lines, 40 dB,
/// 25 modes in the band.
///
/// # Errors
/// None for the committed file.
pub fn panel_77x34_1997_lines() -> Result<Simulation> {
    let panel = Panel::from_toml(include_str!("../../fixtures/panel.toml"), MEMORY_BYTES)?;
    simulate(&panel, None, None)
}

/// The first quarter of the panel felt at 300 Hz, the rest quiet.
///
/// # Errors
/// None for the committed file.
pub fn corner_scene() -> Result<Scene> {
    Scene::parse(
        include_str!("../../fixtures/scene-corner.toml"),
        Path::new(""),
    )
}
