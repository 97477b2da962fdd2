//! A chart as plain data: axes, layers, a colour bar. [`Figure::draw`] turns it into a
//! picture.

mod axis;
mod clip;
mod layers;
mod layout;
mod marks;

pub use axis::{Axis, Scale};
pub use marks::Mark;

use crate::drawing::{Anchor, Colour, ColourMap, Image, Stroke};

/// A place in data coordinates.
pub type Place = [f64; 2];

/// A disc whose size is data. It may have a hand like that of a clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc {
    /// Centre.
    pub at: Place,
    /// Radius, px.
    pub radius: f64,
    /// Colour.
    pub fill: Colour,
    /// Direction of the hand, rad, counter-clockwise from the right.
    pub hand: Option<f64>,
    /// Shown when the pointer rests on it.
    pub hint: String,
}

/// A filled rectangle of a matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// x ends, then y ends.
    pub sides: [Place; 2],
    /// Colour.
    pub fill: [u8; 3],
    /// Written inside.
    pub text: String,
    /// Shown when the pointer rests on it.
    pub hint: String,
}

/// One layer of data. Layers with a `name` are listed in the legend. Places and numbers are in
/// data coordinates, sizes in px.
#[allow(missing_docs)] // each variant's sentence names its fields
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Layer {
    /// Curves; a coordinate that is not finite breaks them.
    Lines {
        name: Option<String>,
        lines: Vec<Vec<Place>>,
        stroke: Stroke,
    },
    /// Single points. `size` is their diameter, px.
    Marks {
        name: Option<String>,
        points: Vec<Place>,
        mark: Mark,
        colour: Colour,
        size: f64,
    },
    /// Lines from top to bottom.
    Verticals {
        name: Option<String>,
        at: Vec<f64>,
        stroke: Stroke,
    },
    /// Lines from left to right.
    Horizontals {
        name: Option<String>,
        at: Vec<f64>,
        stroke: Stroke,
    },
    /// Lines to each point from zero, or from the lower end of the y axis, with a mark at the
    /// point.
    Stems {
        name: Option<String>,
        points: Vec<(Place, String)>,
        mark: Mark,
        colour: Colour,
    },
    /// A closed outline; `casing` puts paper around its line.
    Outline {
        name: Option<String>,
        points: Vec<Place>,
        stroke: Stroke,
        casing: bool,
    },
    /// Pixels over x ends and y ends; the first row lies at the upper y end.
    Pixels { x: Place, y: Place, image: Image },
    /// Cells of a matrix.
    Cells(Vec<Cell>),
    /// Discs whose size is data.
    Discs(Vec<Disc>),
    /// Words at a place.
    Words {
        at: Place,
        text: String,
        anchor: Anchor,
        bold: bool,
    },
}

/// The meaning of a map's colours.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourBar {
    /// The quantity shown, its unit and its ends.
    pub axis: Axis,
    /// Colours.
    pub map: ColourMap,
    /// Number of equal steps of colour; 0: smooth.
    pub bands: usize,
    /// Values with a line across the bar, as on the contours of the map.
    pub lines: Vec<(f64, Stroke)>,
}

/// Height of the plotted box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Height {
    /// Height in px.
    Px(f64),
    /// Equal scales on both axes (maps), with the largest height in px.
    EqualScales(f64),
}

/// A pair of axes and what is drawn on them.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Layers, the first one lowest.
    pub layers: Vec<Layer>,
    /// Meaning of the colours.
    pub colour_bar: Option<ColourBar>,
    /// Height of the plotted box.
    pub height: Height,
    /// Grid lines at the ticks.
    pub grid: bool,
    /// A second vertical axis with layers of its own.
    pub right: Option<RightAxis>,
}

/// A vertical axis on the right, without a grid, and its layers, which lie above those of the
/// left axis.
#[derive(Debug, Clone, PartialEq)]
pub struct RightAxis {
    /// The axis.
    pub axis: Axis,
    /// Layers, the first one lowest.
    pub layers: Vec<Layer>,
}

impl Chart {
    /// An empty chart of the usual height.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            x,
            y,
            layers: Vec::new(),
            colour_bar: None,
            height: Height::Px(260.0),
            grid: true,
            right: None,
        }
    }
    /// With the plotted box so high.
    pub fn height(self, height: Height) -> Self {
        Self { height, ..self }
    }
    /// With one more layer, above the others.
    pub fn with(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }
    /// With one more curve; an empty name keeps it out of the legend.
    pub fn line(self, name: &str, points: Vec<Place>, stroke: Stroke) -> Self {
        self.with(Layer::Lines {
            name: named(name),
            lines: vec![points],
            stroke,
        })
    }
    /// With single points; an empty name keeps them out of the legend.
    pub fn marks(
        self,
        name: &str,
        points: Vec<Place>,
        mark: Mark,
        colour: Colour,
        size: f64,
    ) -> Self {
        self.with(Layer::Marks {
            name: named(name),
            points,
            mark,
            colour,
            size,
        })
    }
}

/// `None` for an empty name.
pub(crate) fn named(name: &str) -> Option<String> {
    (!name.is_empty()).then(|| name.to_owned())
}

/// A figure: charts one above the other, with a title and a caption.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Stem of the file name, and anchor in the page.
    pub name: String,
    /// Title above the charts.
    pub title: String,
    /// Caption: a sentence or two on what the figure shows.
    pub caption: String,
    /// Width of the picture, px.
    pub width: f64,
    /// Charts from top to bottom.
    pub charts: Vec<Chart>,
}
