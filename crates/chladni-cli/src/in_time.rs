//! A scene in time as pages show it.

use chladni_frf::{ModalModel, Result};
use chladni_render::{play, PlayOptions, Played, Scene, Weights};

/// Pictures of the ground in a page: 16 a second of a burst of 0.25 s run at a tenth of
/// its speed.
const FRAMES: usize = 60;

/// The drive over time with pictures of the ground, and the ground under plain ramps;
/// none where the scene is a steady tone.
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
