//! The rendering that the studio keeps.

use super::question::SceneQuestion;
use chladni_frf::ModalModel;
use chladni_render::{Rendering, Scene};
use std::sync::Arc;

/// A rendering with the question that it answers and the models that it was made with.
pub struct Rendered {
    pub question: SceneQuestion,
    /// The fitted or opened model.
    pub whole: Arc<ModalModel>,
    /// That model without the modes that were dropped on the page, as its file holds it.
    pub model: Arc<ModalModel>,
    pub scene: Scene,
    pub rendering: Rendering,
}
