//! A rendering by one method, and its ratios on other data.

use chladni_frf::ModalModel;
use chladni_render::{evaluate, render, Method, On, RenderOptions, Rendering, Scene};

pub(super) fn options(method: Method) -> RenderOptions {
    RenderOptions {
        method: method.into(),
        ..Default::default()
    }
}

pub(super) fn rendered(model: &ModalModel, scene: &Scene, method: Method) -> Rendering {
    render(model, scene, &options(method)).unwrap()
}

/// Hot and cold ratio on other data.
pub(super) fn ratios(rendering: &Rendering, scene: &Scene, model: &ModalModel) -> (f64, f64) {
    let points = evaluate(&rendering.weights, scene, On::Model(model))
        .unwrap()
        .indices
        .points;
    (points.hot_ratio, points.cold_ratio)
}
