//! Model and renderings as one HTML page.

use crate::detached::detached;
use crate::error::raised;
use crate::frf::FrfSet;
use crate::model::Model;
use crate::rendering::Rendering;
use chladni_io::write_atomically;
use chladni_report::{html, RenderedScene, ReportInput};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Writes the report, one HTML page that needs nothing else.
///
/// Parameters
/// ----------
/// path : path
///     File to write.
/// model : Model
///     What it is about.
/// measured : FrfSet, optional
///     The FRFs it was fitted to, drawn beside it.
/// renderings : sequence of Rendering
///     Scenes, in order.
/// title : str
///     Title of the page.
/// force : bool
///     Overwrite the file.
#[pyfunction]
#[pyo3(signature = (path, model, *, measured=None, renderings=Vec::new(), title="Chladni", force=false))]
pub fn report(
    py: Python<'_>,
    path: PathBuf,
    model: &Model,
    measured: Option<&FrfSet>,
    renderings: Vec<PyRef<'_, Rendering>>,
    title: &str,
    force: bool,
) -> PyResult<()> {
    let rendered: Vec<Rendering> = renderings.iter().map(|one| (**one).clone()).collect();
    detached(py, || {
        let input = ReportInput {
            title: title.to_owned(),
            model: Some(&model.model),
            measured: measured.map(|frf| &frf.set),
            scenes: rendered
                .iter()
                .map(|rendering| RenderedScene::of_rendering(&rendering.0))
                .collect(),
            ..ReportInput::default()
        };
        let page = html(&input)?;
        write_atomically(&path, force, |out| out.write_all(page.as_bytes()))
    })?
    .map_err(|error| raised(py, &error))
}
