//! The report from top to bottom, as sections of words, tables and figures: the page and the chart files come from one list.

use crate::chart::Figure;
use crate::comparison::Comparison;
use crate::figures;
use crate::html::tables;
use crate::input::{RenderedScene, ReportInput};
use crate::sizes;
use crate::text::{counted, escape, fixed};
use chladni_frf::Result;
use chladni_rfp::FitOptions;

/// A section of the page.
pub(crate) struct Section {
    /// Anchor in the page.
    pub(crate) id: String,
    pub(crate) heading: String,
    pub(crate) blocks: Vec<Block>,
}

/// What a section is made of.
pub(crate) enum Block {
    /// Ready HTML; foreign text in it is escaped.
    Html(String),
    /// One figure.
    Figure(Box<Figure>),
    /// Small figures side by side.
    Gallery(Vec<Figure>),
    /// Figures of which the reader chooses one, with the text of each choice.
    Choice { label: String, figures: Vec<(String, Figure)> },
}

impl Block {
    fn figure(figure: Figure) -> Self {
        Self::Figure(Box::new(figure))
    }
    /// The figures of this block, in order.
    pub(crate) fn figures(&self) -> Vec<&Figure> {
        match self {
            Self::Html(_) => Vec::new(),
            Self::Figure(figure) => vec![figure],
            Self::Gallery(figures) => figures.iter().collect(),
            Self::Choice { figures, .. } => figures.iter().map(|(_, figure)| figure).collect(),
        }
    }
}

/// All sections of the report.
///
/// # Errors
/// Measured FRFs that do not belong to the model; a singular value decomposition that fails.
pub(crate) fn sections(input: &ReportInput) -> Result<Vec<Section>> {
    let mut sections = Vec::new();
    if let Some(model) = input.model {
        sections.push(section("model", "Model", vec![Block::Html(tables::model_facts(model))]));
        sections.push(section("poles", "Poles", vec![Block::Html(tables::pole_table(model))]));
    }
    if let Some(comparison) = Comparison::new(input)? {
        sections.push(frf_section(&comparison));
        let block = match figures::cmif(&comparison, input.measured)? {
            Some(figure) => Block::figure(figure),
            None => Block::Html("<p>No CMIF: it needs every FRF, and some pairs of DOFs were not measured.</p>".into()),
        };
        sections.push(section("cmif", "CMIF", vec![block]));
        if let Some(set) = input.measured {
            let options = FitOptions { band_hz: input.model.map(|model| model.band_hz), ..FitOptions::default() };
            let block = match chladni_rfp::stabilization(set, &options) {
                Ok(diagram) => Block::figure(figures::stabilization(&comparison, &diagram)),
                Err(error) => Block::Html(format!("<p>No stabilization diagram: {}.</p>", escape(&error.to_string()))),
            };
            sections.push(section("stabilization", "Stabilization", vec![block]));
        }
    }
    if let Some(model) = input.model {
        let mac = figures::auto_mac(model);
        sections.extend(mac.map(|figure| section("auto-mac", "AutoMAC", vec![Block::figure(figure)])));
        let shapes = figures::mode_shapes(model);
        if !shapes.is_empty() {
            let words = format!(
                "<p>Each shape is turned to the phase at which it is as real as can be; its largest motion is +1. Full thin lines are \
                 contours of motion one way, dashed ones of motion the other way, thick lines stand still.{}</p>",
                shapes_left_out(model, shapes.len())
            );
            sections.push(section("shapes", "Mode shapes", vec![Block::Html(words), Block::Gallery(shapes)]));
        }
    }
    for (k, scene) in input.scenes.iter().enumerate() {
        sections.push(scene_section(scene, input, k + 1));
    }
    Ok(sections)
}

fn section(id: &str, heading: &str, blocks: Vec<Block>) -> Section {
    Section { id: id.into(), heading: heading.into(), blocks }
}

fn frf_section(comparison: &Comparison) -> Section {
    let sums = comparison.sums();
    let pairs = comparison.pairs(&sums);
    let total = comparison.pair_count();
    let overlays = pairs.iter().enumerate().map(|(k, pair)| {
        let choice = format!("{}: {}", pair.label, pair.why);
        (choice, figures::frf_overlay(comparison, pair, k + 1))
    });
    let overlays: Vec<(String, Figure)> = overlays.collect();
    let mut words = format!("Shown are {} of {} FRFs, to keep the page small, and the sum over all of them.", overlays.len(), total);
    if comparison.measured.is_none() {
        words = format!("The measured FRFs are not at hand: only the model's synthesis is shown. {words}");
    } else if comparison.model.is_none() {
        words = format!("There is no model: only the measured FRFs are shown. {words}");
    }
    let both = comparison.measured.is_some() && comparison.model.is_some();
    if both {
        words += " The difference of a pair is the rms of measured minus synthesised values over the rms of the measured ones, in the fitted band.";
    }
    let heading = if both { "Measured FRFs and synthesis" } else { "FRFs" };
    let mut blocks = vec![Block::Html(format!("<p>{words}</p>")), Block::figure(figures::frf_sum(comparison, &sums))];
    if !overlays.is_empty() {
        blocks.push(Block::Choice { label: "Response / reference".into(), figures: overlays });
    }
    section("frfs", heading, blocks)
}

fn shapes_left_out(model: &chladni_frf::ModalModel, shown: usize) -> String {
    let modes = model.in_band_modes().count();
    let responses = figures::shown_responses(model).len();
    let mut words = String::new();
    if shown < modes {
        words += &format!(" The first {} are shown of {}.", sizes::MODE_SHAPES, counted(modes, "mode"));
    }
    if responses < model.responses.len() {
        words += &format!(" Shown is the motion along one axis, at {responses} of {} response DOFs.", model.responses.len());
    }
    words
}

fn scene_section(scene: &RenderedScene, input: &ReportInput, number: usize) -> Section {
    let weights = scene.weights;
    let name = if weights.scene.is_empty() { format!("Scene {number}") } else { format!("Scene {number}: {}", weights.scene) };
    let mut blocks = vec![Block::Html(tables::scene_facts(scene)), Block::Html(tables::index_table(scene))];
    match &scene.shown {
        Some(shown) => {
            let map = figures::field_map(shown, input.model, weights.frequency_hz, number);
            blocks.extend(map.map(Block::figure));
        }
        None => blocks.push(Block::Html("<p>The field is not shown: weights alone do not carry it.</p>".into())),
    }
    let around = input.model.and_then(|model| figures::weights_around_edge(weights, model, number));
    if around.is_none() {
        blocks.push(Block::Html("<p>The positions of the actuators are not known; their weights are listed one by one.</p>".into()));
    }
    blocks.extend(around.map(Block::figure));
    blocks.push(Block::figure(figures::weights_by_actuator(weights, number)));
    section(&format!("scene-{number}"), &name, blocks)
}

/// Warnings of all parts, each with what it is about, first of all in the page.
pub(crate) fn warnings(input: &ReportInput) -> Vec<(String, String)> {
    let mut warnings: Vec<(String, String)> = input.warnings.iter().map(|text| ("Report".to_owned(), text.clone())).collect();
    if let Some(model) = input.model {
        if !model.quality.trusted {
            warnings.push(("Model".into(), "this model is not to be trusted; the reasons follow".into()));
        }
        warnings.extend(model.quality.warnings.iter().map(|text| ("Model".to_owned(), text.clone())));
        let weak = model.in_band_modes().filter(|mode| mode.trust == chladni_frf::Trust::Weak).count();
        if weak > 0 {
            warnings.push(("Model".into(), format!("{} kept with doubts; the pole table says why", counted(weak, "mode"))));
        }
    }
    for (k, scene) in input.scenes.iter().enumerate() {
        let about = format!("Scene {}", k + 1);
        if !scene.weights.feasible {
            let ratio = scene.weights.indices.points.min_ratio;
            warnings.push((
                about.clone(),
                format!("not met: the worse zone keeps its limit at {} % of its responses", fixed(100.0 * ratio, 1)),
            ));
        }
        let shown = scene.shown.map_or(&[][..], |shown| shown.warnings);
        warnings.extend(scene.weights.warnings.iter().chain(shown).map(|text| (about.clone(), text.clone())));
    }
    warnings
}

/// The list of contents.
pub(crate) fn contents(sections: &[Section]) -> String {
    let link = |section: &Section| format!("<li><a href=\"#{}\">{}</a></li>", escape(&section.id), escape(&section.heading));
    sections.iter().map(link).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_plate::{simulate, Panel};
    use chladni_render::{render, Scene};
    use std::path::Path;

    #[test]
    fn every_axis_of_every_figure_has_a_label_and_a_unit() {
        let simulation = simulate(&Panel::from_toml("[frf]\nstop_hz = 320\nstep_hz = 4\n", 1 << 30).unwrap(), None, None).unwrap();
        let scene = Scene::parse("frequency_hz = 300\n[zones]\ngrid = [2, 2]\nhot = [4]\n", Path::new("")).unwrap();
        let rendering = render(&simulation.truth, &scene, &Default::default()).unwrap();
        let scenes = vec![RenderedScene::of_rendering(&rendering)];
        let input = ReportInput { model: Some(&simulation.truth), measured: Some(&simulation.frf), scenes, ..Default::default() };
        let sections = sections(&input).unwrap();
        let figures: Vec<&Figure> = sections.iter().flat_map(|section| &section.blocks).flat_map(Block::figures).collect();
        assert!(figures.len() > 20);
        for figure in figures {
            assert!(!figure.title.is_empty(), "{}", figure.name);
            for chart in &figure.charts {
                for axis in [&chart.x, &chart.y].into_iter().chain(chart.colour_bar.as_ref().map(|bar| &bar.axis)) {
                    assert!(!axis.label.is_empty() && !axis.unit.is_empty(), "{}: {axis:?}", figure.name);
                }
            }
        }
    }
}
