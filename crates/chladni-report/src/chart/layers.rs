//! The layers of a chart as shapes, and their samples in the legend.

use super::axis::Ruler;
use super::clip::{clip_line, thinned};
use super::marks::{disc, Mark};
use super::{Cell, Disc, Layer, Place};
use crate::drawing::{is_dark, text_width, Anchor, Colour, Drawing, Image, Item, Point, Stroke};

/// Width of a sample in the legend, px.
pub(super) const SAMPLE: f64 = 24.0;
/// Diameter of the mark at the end of a stem, px.
const STEM_MARK: f64 = 7.0;

/// Least and largest coordinate `which` (0: x, 1: y) of all data; +∞ and −∞ without data.
pub(super) fn extent(layers: &[Layer], which: usize, positive: bool) -> [f64; 2] {
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    let mut take = |value: f64| {
        if value.is_finite() && (!positive || value > 0.0) {
            ends = [ends[0].min(value), ends[1].max(value)];
        }
    };
    for layer in layers {
        match layer {
            Layer::Lines { lines, .. } => {
                lines.iter().flatten().for_each(|point| take(point[which]))
            }
            Layer::Marks { points, .. } | Layer::Outline { points, .. } => {
                points.iter().for_each(|point| take(point[which]))
            }
            Layer::Stems { points, .. } => points.iter().for_each(|(point, _)| take(point[which])),
            Layer::Verticals { at, .. } if which == 0 => at.iter().copied().for_each(&mut take),
            Layer::Horizontals { at, .. } if which == 1 => at.iter().copied().for_each(&mut take),
            Layer::Pixels { x, y, .. } => [x, y][which].iter().copied().for_each(&mut take),
            Layer::Cells(cells) => cells
                .iter()
                .flat_map(|cell| cell.sides[which])
                .for_each(&mut take),
            Layer::Discs(discs) => discs.iter().for_each(|disc| take(disc.at[which])),
            Layer::Verticals { .. } | Layer::Horizontals { .. } | Layer::Words { .. } => {}
        }
    }
    ends
}

pub(super) fn legend_name(layer: &Layer) -> Option<&str> {
    match layer {
        Layer::Lines { name, .. }
        | Layer::Marks { name, .. }
        | Layer::Verticals { name, .. }
        | Layer::Horizontals { name, .. }
        | Layer::Stems { name, .. }
        | Layer::Outline { name, .. } => name.as_deref(),
        Layer::Pixels { .. } | Layer::Cells(_) | Layer::Discs(_) | Layer::Words { .. } => None,
    }
}

/// The box of a chart, px, with the rulers of its axes.
#[derive(Clone, Copy)]
struct Plotted<'a> {
    sides: [f64; 4],
    x: &'a Ruler,
    y: &'a Ruler,
}

impl Plotted<'_> {
    fn place(&self, point: &Place) -> Point {
        [self.x.place(point[0]), self.y.place(point[1])]
    }

    fn holds(&self, p: &Point) -> bool {
        let [left, top, right, bottom] = self.sides;
        p[0] >= left - 0.5 && p[0] <= right + 0.5 && p[1] >= top - 0.5 && p[1] <= bottom + 0.5
    }

    /// Lines across the box at the values `at` of axis `which`, where these lie in the box.
    fn across(&self, at: &[f64], which: usize) -> Vec<Vec<Point>> {
        let [left, top, right, bottom] = self.sides;
        let (ruler, [low, high]) = [(self.x, [left, right]), (self.y, [top, bottom])][which];
        let places = at.iter().map(|&value| ruler.place(value));
        places
            .filter(|p| (low..=high).contains(p))
            .map(|p| match which {
                0 => vec![[p, top], [p, bottom]],
                _ => vec![[left, p], [right, p]],
            })
            .collect()
    }

    /// The parts of lines that lie in the box.
    fn cut(&self, lines: &[Vec<Place>]) -> Vec<Vec<Point>> {
        let placed = |line: &[Place]| line.iter().map(|point| self.place(point)).collect();
        lines
            .iter()
            .flat_map(|line| clip_line(&thinned(placed(line)), self.sides))
            .collect()
    }

    /// An image from the ends of its sides, in the units of the axes.
    fn image(&self, x: [f64; 2], y: [f64; 2], image: &Image) -> Item {
        let (corner, lower_right) = (self.place(&[x[0], y[1]]), self.place(&[x[1], y[0]]));
        Item::Image {
            corner,
            size: [lower_right[0] - corner[0], lower_right[1] - corner[1]],
            image: image.clone(),
        }
    }

    fn stems(&self, drawing: &mut Drawing, points: &[(Place, String)], mark: Mark, colour: Colour) {
        let [_, top, _, bottom] = self.sides;
        let zero = self.y.place(0.0);
        let base = match zero.is_finite() {
            true => zero.clamp(top, bottom),
            false => bottom,
        };
        for (point, hint) in points {
            let tip = self.place(point);
            if self.holds(&tip) {
                drawing.line(vec![[tip[0], base], tip], Stroke::new(colour, 2.0));
                mark.draw(drawing, tip, colour, STEM_MARK, Some(hint.clone()));
            }
        }
    }

    fn outline(&self, drawing: &mut Drawing, points: &[Place], stroke: Stroke, casing: bool) {
        let closed = points.iter().chain(points.first());
        let closed: Vec<Point> = closed.map(|point| self.place(point)).collect();
        let cut = clip_line(&closed, self.sides);
        if casing {
            let white = Stroke::new(Colour::Rgb([255, 255, 255]), stroke.width + 2.5);
            push_lines(drawing, cut.clone(), white, None);
        }
        push_lines(drawing, cut, stroke, None);
    }
}

pub(super) fn draw_layer(
    drawing: &mut Drawing,
    layer: &Layer,
    sides: [f64; 4],
    x: &Ruler,
    y: &Ruler,
) {
    let plotted = Plotted { sides, x, y };
    let place = |point: &Place| plotted.place(point);
    match layer {
        Layer::Lines {
            name,
            lines,
            stroke,
        } => push_lines(drawing, plotted.cut(lines), *stroke, name.clone()),
        Layer::Marks {
            points,
            mark,
            colour,
            size,
            ..
        } => {
            for point in points.iter().map(place).filter(|p| plotted.holds(p)) {
                mark.draw(drawing, point, *colour, *size, None);
            }
        }
        Layer::Verticals { at, stroke, .. } => {
            push_lines(drawing, plotted.across(at, 0), *stroke, None)
        }
        Layer::Horizontals { at, stroke, .. } => {
            push_lines(drawing, plotted.across(at, 1), *stroke, None)
        }
        Layer::Stems {
            points,
            mark,
            colour,
            ..
        } => plotted.stems(drawing, points, *mark, *colour),
        Layer::Outline {
            points,
            stroke,
            casing,
            ..
        } => plotted.outline(drawing, points, *stroke, *casing),
        Layer::Pixels { x, y, image } => drawing.items.push(plotted.image(*x, *y, image)),
        Layer::Cells(cells) => cells.iter().for_each(|cell| draw_cell(drawing, cell, x, y)),
        Layer::Discs(discs) => discs
            .iter()
            .for_each(|disc| draw_disc(drawing, disc, place(&disc.at))),
        Layer::Words {
            at,
            text,
            anchor,
            bold,
        } => drawing
            .items
            .push(words(place(at), text.clone(), *anchor, *bold)),
    }
}

fn words([x, y]: Point, text: String, anchor: Anchor, bold: bool) -> Item {
    Item::Text {
        at: [x, y + 4.0],
        text,
        size: 12.0,
        anchor,
        turned: false,
        bold,
        colour: Colour::Ink,
        halo: true,
    }
}

fn push_lines(drawing: &mut Drawing, lines: Vec<Vec<Point>>, stroke: Stroke, name: Option<String>) {
    if !lines.is_empty() {
        drawing.items.push(Item::Path {
            lines,
            closed: false,
            fill: None,
            stroke: Some(stroke),
            name,
            hint: None,
        });
    }
}

fn draw_cell(drawing: &mut Drawing, cell: &Cell, x: &Ruler, y: &Ruler) {
    let ([x0, x1], [y0, y1]) = (
        cell.sides[0].map(|value| x.place(value)),
        cell.sides[1].map(|value| y.place(value)),
    );
    let hint = (!cell.hint.is_empty()).then(|| cell.hint.clone());
    drawing.polygon(
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]],
        Some(Colour::Rgb(cell.fill)),
        None,
        hint,
    );
    let size = (0.36 * (x1 - x0)).min(11.0);
    if !cell.text.is_empty() && size >= 6.0 && text_width(&cell.text, size) < (x1 - x0).abs() {
        let colour = Colour::Rgb(if is_dark(cell.fill) {
            [255, 255, 255]
        } else {
            [26, 28, 31]
        });
        drawing.text(
            [(x0 + x1) / 2.0, (y0 + y1) / 2.0 + 0.36 * size],
            cell.text.clone(),
            size,
            Anchor::Middle,
            colour,
        );
    }
}

fn draw_disc(drawing: &mut Drawing, data: &Disc, centre: Point) {
    let hint = (!data.hint.is_empty()).then(|| data.hint.clone());
    disc(
        drawing,
        centre,
        data.radius.max(1.5),
        Some(data.fill),
        Some(Stroke::new(Colour::Ink, 1.0)),
        hint,
    );
    if let (Some(angle), true) = (data.hand, data.radius > 2.0) {
        let tip = [
            centre[0] + data.radius * angle.cos(),
            centre[1] - data.radius * angle.sin(),
        ];
        drawing.line(
            vec![centre, tip],
            Stroke::new(Colour::Rgb([255, 255, 255]), 3.6),
        );
        drawing.line(vec![centre, tip], Stroke::new(Colour::Rgb([0, 0, 0]), 1.8));
    }
}

/// A sample of the layer, left of its name.
pub(super) fn draw_sample(drawing: &mut Drawing, layer: &Layer, [x, y]: Point) {
    let middle = [x + SAMPLE / 2.0, y];
    if has_fixed_colour(layer) {
        // colours for maps may not be visible on white or black paper
        drawing.rectangle(
            [x - 3.0, y - 7.5, x + SAMPLE + 3.0, y + 7.5],
            Some(Colour::Rgb([178, 184, 190])),
            None,
        );
    }
    match layer {
        Layer::Lines { stroke, .. }
        | Layer::Horizontals { stroke, .. }
        | Layer::Outline { stroke, .. } => {
            drawing.line(vec![[x, y], [x + SAMPLE, y]], *stroke);
        }
        Layer::Verticals { stroke, .. } => {
            drawing.line(vec![[middle[0], y - 8.0], [middle[0], y + 8.0]], *stroke)
        }
        Layer::Marks {
            mark, colour, size, ..
        } => mark.draw(drawing, middle, *colour, *size, None),
        Layer::Stems { mark, colour, .. } => mark.draw(drawing, middle, *colour, STEM_MARK, None),
        Layer::Pixels { .. } | Layer::Cells(_) | Layer::Discs(_) | Layer::Words { .. } => {}
    }
}

fn has_fixed_colour(layer: &Layer) -> bool {
    match layer {
        Layer::Lines { stroke, .. } | Layer::Outline { stroke, .. } => {
            matches!(stroke.colour, Colour::Rgb(_))
        }
        Layer::Marks { colour, .. } => matches!(colour, Colour::Rgb(_)),
        _ => false,
    }
}
