//! A picture as a list of shapes, from which SVG and PNG files are made.

mod colour;
mod font;
mod gif;
mod png;
mod svg;

pub(crate) use colour::is_dark;
pub use colour::{Colour, ColourMap, SERIES};
pub(crate) use font::{fitted, text_width};
pub(crate) use gif::gif;
pub(crate) use png::image_png;

/// A place in the picture, px, y downwards.
pub(crate) type Point = [f64; 2];

/// The style of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub colour: Colour,
    /// Width, px.
    pub width: f64,
    /// Dashes.
    pub dash: Dash,
}

/// Dashes of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// None.
    #[default]
    Solid,
    /// Long.
    Dashed,
    /// Short.
    Dotted,
}

impl Dash {
    /// Lengths of dash and gap, px; `None` for a solid line.
    fn pattern(self) -> Option<[f64; 2]> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some([6.0, 4.0]),
            Self::Dotted => Some([1.5, 3.0]),
        }
    }
}

impl Stroke {
    /// A solid line.
    pub fn new(colour: Colour, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: Dash::Solid,
        }
    }
    /// The same line with dashes.
    pub fn dashed(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }
}

/// The anchor of text on its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// Text begins at the point.
    Start,
    /// Text is centred on the point.
    Middle,
    /// Text ends at the point.
    End,
}

/// One shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Item {
    /// Open or closed polylines, filled (even-odd) and stroked as one.
    Path {
        lines: Vec<Vec<Point>>,
        closed: bool,
        fill: Option<Colour>,
        stroke: Option<Stroke>,
        name: Option<String>,
        hint: Option<String>,
    },
    /// A disc.
    Disc {
        centre: Point,
        radius: f64,
        fill: Option<Colour>,
        stroke: Option<Stroke>,
        hint: Option<String>,
    },
    /// One line of text on a base line, upwards where `turned`. `halo` puts paper around the
    /// letters.
    Text {
        at: Point,
        text: String,
        size: f64,
        anchor: Anchor,
        turned: bool,
        bold: bool,
        colour: Colour,
        halo: bool,
    },
    /// Pixels row by row from the top, each red, green, blue, opacity.
    Image {
        corner: Point,
        size: Point,
        image: Image,
    },
}

/// Pixels row by row from the top, each red, green, blue, opacity.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels in a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// 4·columns·rows bytes.
    pub rgba: Vec<u8>,
}

/// A picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) title: String,
    pub(crate) description: String,
    pub(crate) items: Vec<Item>,
}

impl Drawing {
    pub(crate) fn new(width: f64, title: &str, description: &str) -> Self {
        Self {
            width,
            height: 0.0,
            title: title.into(),
            description: description.into(),
            items: Vec::new(),
        }
    }

    pub(crate) fn line(&mut self, points: Vec<Point>, stroke: Stroke) {
        self.items.push(Item::Path {
            lines: vec![points],
            closed: false,
            fill: None,
            stroke: Some(stroke),
            name: None,
            hint: None,
        });
    }

    pub(crate) fn polygon(
        &mut self,
        points: Vec<Point>,
        fill: Option<Colour>,
        stroke: Option<Stroke>,
        hint: Option<String>,
    ) {
        self.items.push(Item::Path {
            lines: vec![points],
            closed: true,
            fill,
            stroke,
            name: None,
            hint,
        });
    }

    pub(crate) fn rectangle(
        &mut self,
        [left, top, right, bottom]: [f64; 4],
        fill: Option<Colour>,
        stroke: Option<Stroke>,
    ) {
        self.polygon(
            vec![[left, top], [right, top], [right, bottom], [left, bottom]],
            fill,
            stroke,
            None,
        );
    }

    pub(crate) fn text(
        &mut self,
        at: Point,
        text: impl Into<String>,
        size: f64,
        anchor: Anchor,
        colour: Colour,
    ) {
        self.items.push(Item::Text {
            at,
            text: text.into(),
            size,
            anchor,
            turned: false,
            bold: false,
            colour,
            halo: false,
        });
    }

    /// A complete SVG file in the colours of the light theme.
    pub fn to_svg(&self) -> String {
        svg::write(self)
    }

    /// A PNG file of `scale` pixels per px, on white.
    pub fn to_png(&self, scale: f64) -> Vec<u8> {
        png::paint(self, scale)
    }
}
