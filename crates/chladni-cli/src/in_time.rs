//! A scene in time, with the options of report and studio.

use crate::limits::FRAMES;
use chladni_frf::{ModalModel, Result};
use chladni_render::{play, PlayOptions, Played, Scene, Weights};

/// The drive over time with pictures of the ground, and the ground under plain ramps; `None`
/// for the scene of a steady tone.
///
/// # Errors
/// Those of [`play`].
pub fn in_time(model: &ModalModel, scene: &Scene, weights: &Weights) -> Result<Option<Played>> {
    if scene.time.is_none() {
        return Ok(None);
    }
    let options = PlayOptions {
        frames: FRAMES,
        plain: true,
        ..PlayOptions::default()
    };
    play(model, scene, Some(weights), &options).map(Some)
}
