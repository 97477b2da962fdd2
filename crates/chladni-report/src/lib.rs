//! Charts, and the report: one HTML file that needs nothing else, and the same figures as SVG and PNG files.
//!
//! A [`Figure`] is plain data (axes with label and unit, layers, legend); [`Figure::draw`] makes a [`Drawing`], and that writes
//! itself as SVG or PNG. [`html`] and [`charts`] put the figures of modal testing together from a [`ReportInput`]: pole table with
//! bounds and trust, measured FRFs over their synthesis, CMIF, AutoMAC, mode shapes, weights around the panel, field maps, indices
//! beside what silence would score.
//!
//! The same input gives the same bytes: no clock, no host, no fonts of the machine.

// the error carries file, line, field and advice; it is built once, where a run ends

mod chart;
mod comparison;
mod drawing;
mod figures;
mod html;
mod input;
mod sections;
mod sizes;
mod surface;
mod text;

pub use chart::{Axis, Cell, Chart, ColourBar, Disc, Figure, Height, Layer, Mark, Place, Scale};
pub use drawing::{Anchor, Colour, ColourMap, Dash, Drawing, Image, Stroke, SERIES};
pub use input::{RenderedScene, ReportInput, ShownField};

use chladni_frf::Result;

/// The report as one HTML page.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where the measured FRFs do not belong to the model (no common DOF pair, other reference unit);
/// [`chladni_frf::ErrorKind::UnknownFrfKind`].
pub fn html(input: &ReportInput) -> Result<String> {
    Ok(html::page(input, &sections::sections(input)?))
}

/// A page of any figures, one section each, with `words` above them; like the report it needs nothing else.
pub fn gallery(title: &str, words: &str, figures: &[Figure]) -> String {
    html::gallery(title, words, figures)
}

/// Which files [`charts`] makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChartFormats {
    /// SVG files.
    pub svg: bool,
    /// PNG files.
    pub png: bool,
}

/// The figures of the report as files: name (`cmif.svg`, `mode-03.png`) and content, in the order of the report. The caller writes them.
///
/// # Errors
/// Those of [`html`].
pub fn charts(input: &ReportInput, formats: ChartFormats) -> Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    for section in sections::sections(input)? {
        for figure in section.blocks.iter().flat_map(sections::Block::figures) {
            let drawing = figure.draw();
            if formats.svg {
                files.push((format!("{}.svg", figure.name), drawing.to_svg().into_bytes()));
            }
            if formats.png {
                files.push((format!("{}.png", figure.name), drawing.to_png(sizes::PNG_SCALE)));
            }
        }
    }
    Ok(files)
}
