//! The part of the last scene that the studio keeps.

use super::question::SceneQuestion;
use chladni_frf::ModalModel;
use chladni_render::{Rendering, Scene};
use std::sync::Arc;

/// A rendering with the question that it answers and the model that it was made with.
pub struct Rendered {
    pub question: SceneQuestion,
    pub model: Arc<ModalModel>,
    pub scene: Scene,
    pub rendering: Rendering,
}
