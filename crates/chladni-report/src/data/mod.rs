//! The data that the page's script draws, as one JSON object: numbers of the model, the
//! FRFs, the diagrams and the scenes.
//!
//! It contains no markup; the script inserts every word as text. The key of a missing part is
//! `null`, and the page says so.

mod array;
mod chart;
mod diagrams;
mod findings;
mod frfs;
mod geometry;
mod lines;
mod model;
mod scenes;
mod time;

pub(crate) use diagrams::stabilization_options;

use crate::comparison::Comparison;
use crate::input::ReportInput;
use crate::sentence::{advised_band, sentence};
use chladni_frf::{FrfSet, ModalModel, Result, CREATED_BY};
use serde_json::{json, Value};

/// The whole object.
///
/// # Errors
/// Measured FRFs that do not belong to the model; a singular value decomposition that
/// fails.
pub(crate) fn of(input: &ReportInput) -> Result<Value> {
    let comparison = Comparison::new(input)?;
    let geometry = geometry::Geometry::of(input);
    Ok(json!({
        "title": input.title,
        "created_by": CREATED_BY,
        "sentence": input.model.map(sentence),
        "better_band": input.model.and_then(advised_band).map(|band| band.hz),
        "findings": findings::all(input),
        "model": input.model.map(|model| model::value(model, input.model_file.as_deref())),
        "frfs": comparison.as_ref().map(frfs::value),
        "cmif": comparison.as_ref().map(|comparison| diagrams::cmif(comparison, input.measured)).transpose()?,
        "stabilization": input.measured.map(|set| diagrams::stabilization(set, input.model)),
        "mac": input.model.and_then(diagrams::mac),
        "geometry": geometry.as_ref().map(geometry::Geometry::value),
        "structure": input.model.and_then(geometry::structure),
        "scenes": input.scenes.iter().enumerate().map(|(k, scene)| scenes::value(scene, k + 1, input, geometry.as_ref())).collect::<Vec<_>>(),
        "tables": input.tables.iter().map(|table| json!({"name": table.name, "header": table.header, "rows": table.rows})).collect::<Vec<_>>(),
    }))
}

/// The measured FRFs alone and the places of their DOFs: the first picture of the studio.
///
/// # Errors
/// [`chladni_frf::ErrorKind::UnknownFrfKind`].
pub(crate) fn of_measured(set: &FrfSet) -> Result<Value> {
    set.known_kind()?;
    let input = ReportInput {
        measured: Some(set),
        ..ReportInput::default()
    };
    let comparison = Comparison::new(&input)?;
    Ok(json!({
        "frfs": comparison.as_ref().map(frfs::value),
        "geometry": geometry::board(set),
        "responses": set.responses.len(),
        "references": set.references.len(),
        "lines": set.frequency_hz.len(),
        "has_coherence": set.coherence.is_some(),
    }))
}

/// The data that a quick fit changes. Parts that take longer than the fit are left out: the page
/// keeps residuals, sums, CMIF and diagram of the last full fit.
pub(crate) fn of_draft(model: &ModalModel) -> Value {
    let input = ReportInput {
        model: Some(model),
        ..ReportInput::default()
    };
    json!({
        "model": model::value(model, None),
        "terms": frfs::model_terms(model),
        "mac": diagrams::mac(model),
        "geometry": geometry::Geometry::of(&input).as_ref().map(geometry::Geometry::value),
        "structure": geometry::structure(model),
    })
}

/// The head of a result: its sentence, findings, and the band to fit instead.
pub(crate) fn head(input: &ReportInput) -> Value {
    json!({
        "sentence": input.model.map(sentence),
        "findings": findings::all(input),
        "better_band": input.model.and_then(advised_band).map(|band| band.hz),
    })
}

/// The first scene alone, as an entry of `scenes`, for the studio; `None` without a scene.
pub(crate) fn of_scene(input: &ReportInput) -> Option<Value> {
    let geometry = geometry::Geometry::of(input);
    input
        .scenes
        .first()
        .map(|scene| scenes::value(scene, 1, input, geometry.as_ref()))
}
