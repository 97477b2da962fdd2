//! Charts, and the report: one HTML file that loads nothing else, and its views as SVG and PNG
//! files.
//!
//! [`html`] puts the numbers of a [`ReportInput`] into a page whose own script draws them: FRFs
//! of any pair, stabilization diagram, pole table, MAC, complexity, moving shapes, fields,
//! weights, curves, stress. [`studio_html`] is the live page: its numbers come from [`data`],
//! [`draft_data`] and [`scene_data`] over a local connection. [`charts`] draws the views as
//! files: a [`Figure`] is plain data (axes, layers, legend), [`Figure::draw`] makes a [`Drawing`]
//! of it, and that is written as SVG or PNG.
//!
//! ```
//! use chladni_plate::{simulate, Panel};
//! use chladni_report::{html, ReportInput};
//! # let mut panel = Panel::default();
//! # (panel.frf.start_hz, panel.frf.step_hz) = (100.0, 50.0);
//!
//! let simulation = simulate(&panel, None, None)?;
//! let page = html(&ReportInput {
//!     title: "Panel".into(),
//!     model: Some(&simulation.truth),
//!     ..ReportInput::default()
//! })?;
//! assert!(page.contains("<html"));
//! # Ok::<(), chladni_frf::Error>(())
//! ```
//!
//! Errors are [`chladni_frf::Error`]; the feature `system` computes with LAPACK.
//!
//! The same input gives the same bytes: no clock, no host, no fonts of the machine.

mod better_band;
mod chart;
mod comparison;
mod data;
mod drawing;
mod figures;
mod input;
mod page;
mod sentence;
mod sizes;
mod structure;
mod surface;
mod text;
mod unlike;

pub use better_band::{better_band, BetterBand};
pub use chart::{
    Axis, Cell, Chart, ColourBar, Disc, Figure, Height, Layer, Mark, Place, RightAxis, Scale,
};
pub use drawing::{Anchor, Colour, ColourMap, Dash, Drawing, Image, Stroke, SERIES};
pub use figures::{
    all as figures, field_map, moving_field, time as time_figure, weights_around_edge,
};
pub use input::{CurvePoint, Curves, RenderedScene, ReportInput, ShownField, Table};
pub use sentence::sentence;
pub use unlike::unlike;

use chladni_frf::{FrfSet, ModalModel, Result};
use serde_json::Value;

/// The report as one HTML page.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where the measured FRFs do not belong to the model
/// (no common DOF pair, other reference unit);
/// [`chladni_frf::ErrorKind::UnknownFrfKind`].
pub fn html(input: &ReportInput) -> Result<String> {
    Ok(page::report(&input.title, &data::of(input)?))
}

/// A page of any figures, one section each, with `words` above them. Like the report it loads
/// nothing else.
pub fn gallery(title: &str, words: &str, figures: &[Figure]) -> String {
    page::gallery(title, words, figures)
}

/// The data that the page draws, as JSON.
///
/// # Errors
/// Those of [`html`].
pub fn data(input: &ReportInput) -> Result<Value> {
    data::of(input)
}

/// The measured FRFs alone and the places of their DOFs, for the studio before the first fit.
///
/// # Errors
/// [`chladni_frf::ErrorKind::UnknownFrfKind`].
pub fn measured_data(set: &FrfSet) -> Result<Value> {
    data::of_measured(set)
}

/// The parts of [`data`] that a quick fit of the same FRFs changes, for the studio while
/// something is dragged: `model`, `mac`, `geometry`, `structure`, and the residual `terms`.
pub fn draft_data(model: &ModalModel) -> Value {
    data::of_draft(model)
}

/// The head of [`data`]: `sentence`, `findings`, `better_band`.
pub fn head_data(input: &ReportInput) -> Value {
    data::head(input)
}

/// The first scene of `input` alone, as in [`data`]; null without a scene.
pub fn scene_data(input: &ReportInput) -> Value {
    data::of_scene(input).unwrap_or_default()
}

/// The page of the studio, which asks its server for [`data`]; `number` is that of the page among
/// those of the server.
pub fn studio_html(title: &str, number: u64) -> String {
    page::studio(title, number)
}

/// The files that [`charts`] makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChartFormats {
    /// SVG files.
    pub svg: bool,
    /// PNG files.
    pub png: bool,
    /// Moving pictures: of each shape, where the structure has lines or faces, and of each
    /// field over a period.
    pub gif: bool,
}

/// The views of the report as files in the order of the page: name (`cmif.svg`, `mode-03.png`)
/// and content. The caller writes them.
///
/// # Errors
/// Those of [`html`].
pub fn charts(input: &ReportInput, formats: ChartFormats) -> Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    for figure in figures::all(input)? {
        let drawing = figure.draw();
        if formats.svg {
            files.push((
                format!("{}.svg", figure.name),
                drawing.to_svg().into_bytes(),
            ));
        }
        if formats.png {
            files.push((
                format!("{}.png", figure.name),
                drawing.to_png(sizes::PNG_SCALE),
            ));
        }
    }
    if formats.gif {
        if let Some(model) = input.model {
            files.extend(figures::moving_shapes(model)?);
        }
        for (scene, number) in input.scenes.iter().zip(1..) {
            let shown = scene.shown.as_ref();
            let moving = shown.map_or(Ok(None), figures::moving_period)?;
            files.extend(moving.map(|bytes| (format!("field-{number}.gif"), bytes)));
        }
    }
    Ok(files)
}
