//! The layout of a figure: margins, ticks, labels, legends, colour bars.

use super::axis::{Ruler, ALONG_X, ALONG_Y};
use super::layers::{draw_layer, draw_sample, extent, legend_name, SAMPLE};
use super::{Axis, Chart, ColourBar, Figure, Height, Layer, RightAxis, Scale};
use crate::drawing::{fitted, text_width, Anchor, Colour, Drawing, Image, Item, Point, Stroke};

/// Size of the title, px.
const TITLE: f64 = 15.0;
/// Size of labels and legends, px.
const LABEL: f64 = 12.5;
/// Size of the numbers at the ticks, px.
const TICK: f64 = 11.5;
/// Room at the border of the picture, px.
const EDGE: f64 = 8.0;
/// Room for a colour bar with its numbers, beside the plotted box, px.
const BAR: f64 = 78.0;
/// Height of a line of the legend, px.
const LEGEND_LINE: f64 = 19.0;
/// Distance of the lines of an axis label, px.
const LABEL_LINE: f64 = LABEL + 3.0;
/// Length by which the label of a vertical axis may exceed the box, px.
const LABEL_OVER: f64 = 20.0;
/// Gap between a sample in the legend and its name, px.
const SAMPLE_GAP: f64 = 8.0;

impl Figure {
    /// The picture.
    pub fn draw(&self) -> Drawing {
        let mut drawing = Drawing::new(self.width, &self.title, &self.caption);
        drawing.items.push(Item::Text {
            at: [EDGE, EDGE + TITLE],
            text: fitted(&self.title, TITLE * 1.06, self.width - 2.0 * EDGE),
            size: TITLE,
            anchor: Anchor::Start,
            turned: false,
            bold: true,
            colour: Colour::Ink,
            halo: false,
        });
        let left = self.charts.iter().map(left_margin).fold(0.0, f64::max);
        let right = self.charts.iter().map(right_margin).fold(EDGE, f64::max);
        let mut top = EDGE + TITLE + 12.0;
        for chart in &self.charts {
            top = draw_chart(&mut drawing, chart, [left, top, self.width - right]);
        }
        drawing.height = top;
        drawing
    }
}

impl Chart {
    /// Ends of the x axis and of the y axis.
    pub(crate) fn ends(&self) -> [[f64; 2]; 2] {
        [ends(&self.x, self, 0), ends(&self.y, self, 1)]
    }
}

fn ends(axis: &Axis, chart: &Chart, which: usize) -> [f64; 2] {
    axis.ends(extent(&chart.layers, which, axis.scale == Scale::Log))
}

fn left_margin(chart: &Chart) -> f64 {
    axis_width(&chart.y, ends(&chart.y, chart, 1), chart.height)
}

fn right_margin(chart: &Chart) -> f64 {
    match (&chart.colour_bar, &chart.right) {
        (Some(_), _) => BAR + EDGE,
        (None, Some(right)) => axis_width(&right.axis, right_ends(right), chart.height),
        // half a number may stand beyond the right end of the x axis
        (None, None) => EDGE + 14.0,
    }
}

/// Room for the numbers and the label of a vertical axis.
fn axis_width(axis: &Axis, ends: [f64; 2], height: Height) -> f64 {
    let ticks = axis.ticks(ends, 260.0, ALONG_Y);
    let widest = ticks
        .iter()
        .map(|tick| text_width(&tick.1, TICK))
        .fold(0.0, f64::max);
    let more_lines = label_lines(axis, height).len() - 1;
    EDGE + LABEL + more_lines as f64 * LABEL_LINE + 10.0 + widest + 6.0
}

/// The label of a vertical axis: one line, or two where the box is low.
fn label_lines(axis: &Axis, height: Height) -> Vec<String> {
    let (Height::Px(height) | Height::EqualScales(height)) = height;
    let (text, room) = (axis.caption(), (height + LABEL_OVER).max(60.0));
    if text_width(&text, LABEL) <= room {
        return vec![text];
    }
    let longer = |at: usize| text_width(&text[..at], LABEL).max(text_width(&text[at + 1..], LABEL));
    let cut = text
        .match_indices(' ')
        .map(|(at, _)| at)
        .min_by(|&a, &b| longer(a).total_cmp(&longer(b)));
    let lines = cut.map_or(vec![text.as_str()], |at| vec![&text[..at], &text[at + 1..]]);
    lines
        .into_iter()
        .map(|line| fitted(line, LABEL, room))
        .collect()
}

fn right_ends(right: &RightAxis) -> [f64; 2] {
    right
        .axis
        .ends(extent(&right.layers, 1, right.axis.scale == Scale::Log))
}

/// Draws a chart below `top` and returns its lower end.
fn draw_chart(drawing: &mut Drawing, chart: &Chart, [left, top, right]: [f64; 3]) -> f64 {
    let top = draw_legend(drawing, chart, [left, top, right]);
    let [x_ends, y_ends] = chart.ends();
    let (right, height) = match chart.height {
        Height::Px(height) => (right, height),
        Height::EqualScales(highest) => {
            let (x_span, y_span) = (x_ends[1] - x_ends[0], y_ends[1] - y_ends[0]);
            let height = (right - left) * y_span / x_span;
            if height > highest {
                (left + highest * x_span / y_span, highest)
            } else {
                (right, height.max(1.0))
            }
        }
    };
    let bottom = top + height;
    let sides = [left, top, right, bottom];
    let x = Ruler {
        ends: x_ends,
        px: [left, right],
        log: chart.x.scale == Scale::Log,
    };
    let y = Ruler {
        ends: y_ends,
        px: [bottom, top],
        log: chart.y.scale == Scale::Log,
    };

    let below = draw_axes(drawing, chart, sides, &x, &y);
    for layer in &chart.layers {
        draw_layer(drawing, layer, sides, &x, &y);
    }
    if let Some(right) = &chart.right {
        let y = Ruler {
            ends: right_ends(right),
            px: [bottom, top],
            log: right.axis.scale == Scale::Log,
        };
        right
            .layers
            .iter()
            .for_each(|layer| draw_layer(drawing, layer, sides, &x, &y));
        draw_right_axis(drawing, &right.axis, chart.height, sides, &y);
    }
    drawing.rectangle(sides, None, Some(Stroke::new(Colour::Muted, 1.0)));
    if let Some(bar) = &chart.colour_bar {
        draw_colour_bar(drawing, bar, [right + 12.0, top, right + 26.0, bottom]);
    }
    below + 8.0
}

/// Draws grid, ticks, numbers and labels; returns their lower end.
fn draw_axes(drawing: &mut Drawing, chart: &Chart, sides: [f64; 4], x: &Ruler, y: &Ruler) -> f64 {
    let [left, top, right, bottom] = sides;
    let numbers = draw_x_ticks(drawing, chart, sides, x);
    draw_y_ticks(drawing, chart, sides, y);
    let label_line = bottom + numbers + LABEL + 5.0;
    let room = right - left + 40.0;
    drawing.text(
        [(left + right) / 2.0, label_line],
        fitted(&chart.x.caption(), LABEL, room),
        LABEL,
        Anchor::Middle,
        Colour::Ink,
    );
    for (k, line) in label_lines(&chart.y, chart.height).iter().enumerate() {
        let across = EDGE + LABEL - 2.0 + k as f64 * LABEL_LINE;
        turned_text(
            drawing,
            [across, (top + bottom) / 2.0],
            line,
            LABEL,
            Anchor::Middle,
            Colour::Ink,
        );
    }
    label_line + 5.0
}

/// Draws grid, ticks and numbers of the x axis; returns the height of the numbers.
fn draw_x_ticks(
    drawing: &mut Drawing,
    chart: &Chart,
    [left, top, right, bottom]: [f64; 4],
    x: &Ruler,
) -> f64 {
    let ticks = chart.x.ticks(x.ends, right - left, ALONG_X);
    let widest = ticks
        .iter()
        .map(|tick| text_width(&tick.1, TICK))
        .fold(0.0, f64::max);
    let named: Vec<f64> = ticks
        .iter()
        .filter(|tick| !tick.1.is_empty())
        .map(|tick| x.place(tick.0))
        .collect();
    let nearest = named
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .fold(f64::INFINITY, f64::min);
    let turned = widest + 3.0 > nearest;
    // turned names take the height of a letter each; where there is no room for that, only
    // every second, third, ... is named
    let every = if turned {
        ((TICK + 1.0) / nearest).ceil().max(1.0) as usize
    } else {
        1
    };
    let mut count = 0;
    for (value, name) in &ticks {
        let place = x.place(*value);
        if chart.grid && (place - left).min(right - place) > 0.5 {
            drawing.line(
                vec![[place, top], [place, bottom]],
                Stroke::new(Colour::Grid, 1.0),
            );
        }
        let end = bottom + tick_length(name);
        drawing.line(
            vec![[place, bottom], [place, end]],
            Stroke::new(Colour::Muted, 1.0),
        );
        if name.is_empty() {
            continue;
        }
        if count % every == 0 {
            draw_number(drawing, [place, bottom], name, turned);
        }
        count += 1;
    }
    if turned {
        widest + 10.0
    } else {
        TICK + 5.0
    }
}

/// A number, or a name, below a tick.
fn draw_number(drawing: &mut Drawing, [place, bottom]: Point, name: &str, turned: bool) {
    if turned {
        let at = [place + 0.36 * TICK, bottom + 8.0];
        turned_text(drawing, at, name, TICK, Anchor::End, Colour::Ink);
    } else {
        let at = [place, bottom + 5.0 + TICK];
        drawing.text(at, name, TICK, Anchor::Middle, Colour::Ink);
    }
}

/// Length of a tick, px; ticks with a number are longer.
fn tick_length(name: &str) -> f64 {
    if name.is_empty() {
        3.0
    } else {
        5.0
    }
}

/// Grid, ticks and numbers left of the box.
fn draw_y_ticks(
    drawing: &mut Drawing,
    chart: &Chart,
    [left, top, right, bottom]: [f64; 4],
    y: &Ruler,
) {
    for (value, name) in chart.y.ticks(y.ends, bottom - top, ALONG_Y) {
        let place = y.place(value);
        if chart.grid && (place - top).min(bottom - place) > 0.5 {
            drawing.line(
                vec![[left, place], [right, place]],
                Stroke::new(Colour::Grid, 1.0),
            );
        }
        let end = left - tick_length(&name);
        drawing.line(
            vec![[end, place], [left, place]],
            Stroke::new(Colour::Muted, 1.0),
        );
        drawing.text(
            [left - 8.0, place + 0.36 * TICK],
            name,
            TICK,
            Anchor::End,
            Colour::Ink,
        );
    }
}

/// Ticks, numbers and label right of the box.
fn draw_right_axis(
    drawing: &mut Drawing,
    axis: &Axis,
    height: Height,
    [_, top, right, bottom]: [f64; 4],
    y: &Ruler,
) {
    for (value, name) in axis.ticks(y.ends, bottom - top, ALONG_Y) {
        let place = y.place(value);
        drawing.line(
            vec![[right, place], [right + tick_length(&name), place]],
            Stroke::new(Colour::Muted, 1.0),
        );
        drawing.text(
            [right + 8.0, place + 0.36 * TICK],
            name,
            TICK,
            Anchor::Start,
            Colour::Ink,
        );
    }
    for (k, line) in label_lines(axis, height).iter().rev().enumerate() {
        let across = drawing.width - EDGE - k as f64 * LABEL_LINE;
        turned_text(
            drawing,
            [across, (top + bottom) / 2.0],
            line,
            LABEL,
            Anchor::Middle,
            Colour::Ink,
        );
    }
}

fn turned_text(
    drawing: &mut Drawing,
    at: [f64; 2],
    text: &str,
    size: f64,
    anchor: Anchor,
    colour: Colour,
) {
    drawing.items.push(Item::Text {
        at,
        text: text.into(),
        size,
        anchor,
        turned: true,
        bold: false,
        colour,
        halo: false,
    });
}

/// Draws the names of the layers with a sample of each; returns their lower end.
fn draw_legend(drawing: &mut Drawing, chart: &Chart, [left, top, right]: [f64; 3]) -> f64 {
    let on_right = chart.right.iter().flat_map(|right| &right.layers);
    let entries: Vec<(&Layer, &str)> = chart
        .layers
        .iter()
        .chain(on_right)
        .filter_map(|layer| Some((layer, legend_name(layer)?)))
        .collect();
    if entries.is_empty() {
        return top + 2.0;
    }
    // where the plotted box is narrow the legend takes the whole width
    let right = right.max(drawing.width - EDGE);
    let (mut x, mut y) = (left, top + 10.0);
    for (layer, name) in entries {
        let name = fitted(name, LABEL, right - left - SAMPLE - SAMPLE_GAP);
        let width = SAMPLE + SAMPLE_GAP + text_width(&name, LABEL) + 18.0;
        if x > left && x + width - 18.0 > right {
            (x, y) = (left, y + LEGEND_LINE);
        }
        draw_sample(drawing, layer, [x, y]);
        drawing.text(
            [x + SAMPLE + SAMPLE_GAP, y + 0.36 * LABEL],
            name,
            LABEL,
            Anchor::Start,
            Colour::Ink,
        );
        x += width;
    }
    y + 16.0
}

/// Fills a colour bar: with rectangles where it has bands, else with an image.
fn draw_colours(drawing: &mut Drawing, bar: &ColourBar, [left, top, right, bottom]: [f64; 4]) {
    let rows = if bar.bands > 0 { bar.bands } else { 128 };
    let colours = (0..rows)
        .rev()
        .map(|row| bar.map.at((row as f64 + 0.5) / rows as f64));
    let step = (bottom - top) / rows as f64;
    if bar.bands > 0 {
        for (row, colour) in colours.enumerate() {
            let y = top + row as f64 * step;
            drawing.rectangle(
                [left, y, right, y + step + 0.3],
                Some(Colour::Rgb(colour)),
                None,
            );
        }
    } else {
        let image = Image {
            columns: 1,
            rows,
            rgba: colours.flat_map(|[r, g, b]| [r, g, b, 255]).collect(),
        };
        drawing.items.push(Item::Image {
            corner: [left, top],
            size: [right - left, bottom - top],
            image,
        });
    }
}

fn draw_colour_bar(drawing: &mut Drawing, bar: &ColourBar, sides: [f64; 4]) {
    let [left, top, right, bottom] = sides;
    let ends = bar.axis.ends([f64::INFINITY, f64::NEG_INFINITY]);
    draw_colours(drawing, bar, sides);
    let ruler = Ruler {
        ends,
        px: [bottom, top],
        log: bar.axis.scale == Scale::Log,
    };
    for (value, stroke) in &bar.lines {
        let y = ruler.place(*value);
        drawing.line(vec![[left, y], [right, y]], *stroke);
    }
    drawing.rectangle(sides, None, Some(Stroke::new(Colour::Muted, 1.0)));
    for (value, name) in bar.axis.ticks(ends, bottom - top, ALONG_Y) {
        let y = ruler.place(value);
        drawing.line(
            vec![[right, y], [right + 4.0, y]],
            Stroke::new(Colour::Muted, 1.0),
        );
        drawing.text(
            [right + 7.0, y + 0.36 * TICK],
            name,
            TICK,
            Anchor::Start,
            Colour::Ink,
        );
    }
    let label = fitted(&bar.axis.caption(), LABEL, (bottom - top + 50.0).max(60.0));
    turned_text(
        drawing,
        [left + BAR - 14.0, (top + bottom) / 2.0],
        &label,
        LABEL,
        Anchor::Middle,
        Colour::Ink,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_longer_than_its_box_takes_two_lines_and_loses_no_word() {
        let axis = Axis::linear("Regularisation over the error assumed", "–");
        assert_eq!(
            label_lines(&axis, Height::Px(400.0)),
            ["Regularisation over the error assumed (–)"]
        );
        let two = label_lines(&axis, Height::Px(140.0));
        assert_eq!(two.join(" "), axis.caption());
        assert!(
            two.iter()
                .all(|line| text_width(line, LABEL) <= 140.0 + LABEL_OVER),
            "{two:?}"
        );
    }
}
