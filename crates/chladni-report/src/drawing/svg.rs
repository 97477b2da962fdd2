//! The SVG writer.

use super::{image_png, Anchor, Colour, Drawing, Item, Point, Stroke};
use crate::text::{base64, escape};
use std::fmt::Write;

/// Fonts of SVG files. The layout uses the widths of DejaVu Sans, which is wider than most.
const FONTS: &str = "system-ui, 'Segoe UI', Helvetica, Arial, 'DejaVu Sans', sans-serif";

pub(super) fn write(drawing: &Drawing) -> String {
    let mut out = String::new();
    let (width, height) = (number(drawing.width), number(drawing.height));
    push(
        &mut out,
        format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" font-family="{FONTS}">"#
        ),
    );
    push(
        &mut out,
        format_args!(
            "\n<title>{}</title><desc>{}</desc>\n",
            escape(&drawing.title),
            escape(&drawing.description)
        ),
    );
    push(
        &mut out,
        format_args!(
            "<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
            hex(Colour::Paper)
        ),
    );
    for item in &drawing.items {
        write_item(&mut out, item);
    }
    out.push_str("</svg>\n");
    out
}

fn push(out: &mut String, text: std::fmt::Arguments) {
    out.write_fmt(text)
        .expect("writing to a string cannot fail");
}

fn write_item(out: &mut String, item: &Item) {
    match item {
        Item::Path {
            lines,
            closed,
            fill,
            stroke,
            name,
            hint,
        } => {
            let named = name
                .as_ref()
                .map(|name| format!(" data-name=\"{}\"", escape(name)))
                .unwrap_or_default();
            let paint = paint(*fill, *stroke);
            let rule = match fill.is_some() && lines.len() > 1 {
                true => " fill-rule=\"evenodd\"",
                false => "",
            };
            let data = path_data(lines, *closed);
            let attributes = format!("{named}{paint}{rule} d=\"{data}\"");
            element(out, "path", &attributes, hint.as_deref());
        }
        Item::Disc {
            centre,
            radius,
            fill,
            stroke,
            hint,
        } => {
            let paint = paint(*fill, *stroke);
            let ([x, y], radius) = (centre.map(number), number(*radius));
            let attributes = format!("{paint} cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"");
            element(out, "circle", &attributes, hint.as_deref());
        }
        Item::Text { .. } => write_text(out, item),
        Item::Image {
            corner,
            size,
            image,
        } => {
            let [x, y] = corner.map(number);
            let [width, height] = size.map(number);
            let data = base64(&image_png(image));
            let place = format!(
                "x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                                 preserveAspectRatio=\"none\""
            );
            push(
                out,
                format_args!("<image {place} href=\"data:image/png;base64,{data}\"/>\n"),
            );
        }
    }
}

fn element(out: &mut String, tag: &str, attributes: &str, hint: Option<&str>) {
    match hint {
        Some(hint) => push(
            out,
            format_args!(
                "<{tag}{attributes}><title>{}</title></{tag}>\n",
                escape(hint)
            ),
        ),
        None => push(out, format_args!("<{tag}{attributes}/>\n")),
    }
}

fn write_text(out: &mut String, item: &Item) {
    let Item::Text {
        at,
        text,
        size,
        anchor,
        turned,
        bold,
        colour,
        halo,
    } = item
    else {
        return;
    };
    let [x, y] = at.map(number);
    let anchor = match anchor {
        Anchor::Start => "",
        Anchor::Middle => " text-anchor=\"middle\"",
        Anchor::End => " text-anchor=\"end\"",
    };
    let turned = if *turned {
        format!(" transform=\"rotate(-90 {x} {y})\"")
    } else {
        String::new()
    };
    let weight = if *bold { " font-weight=\"600\"" } else { "" };
    let halo = if *halo {
        format!(
            " stroke=\"{}\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\"",
            hex(Colour::Paper)
        )
    } else {
        String::new()
    };
    let fill = hex(*colour);
    let size = number(*size);
    push(
        out,
        format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" \
             fill=\"{fill}\"{anchor}{weight}{halo}{turned}>{}</text>\n",
            escape(text)
        ),
    );
}

fn paint(fill: Option<Colour>, stroke: Option<Stroke>) -> String {
    let mut out = format!(" fill=\"{}\"", fill.map_or("none".into(), hex));
    if let Some(stroke) = stroke {
        push(
            &mut out,
            format_args!(
                " stroke=\"{}\" stroke-width=\"{}\"",
                hex(stroke.colour),
                number(stroke.width)
            ),
        );
        out.push_str(" stroke-linejoin=\"round\"");
        if let Some([ink, gap]) = stroke.dash.pattern() {
            push(&mut out, format_args!(" stroke-dasharray=\"{ink} {gap}\""));
        }
    }
    out
}

fn hex(colour: Colour) -> String {
    let [r, g, b] = colour.rgb();
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Polylines as path data: a start point, then steps, rounded to tenths of a px.
fn path_data(lines: &[Vec<Point>], closed: bool) -> String {
    let tenths = |value: f64| (value * 10.0).round() as i64;
    let mut out = String::new();
    for line in lines {
        let mut last = [0, 0];
        for (k, point) in line.iter().enumerate() {
            let here = point.map(tenths);
            if k == 0 {
                push(
                    &mut out,
                    format_args!("M{} {}", decimal(here[0]), decimal(here[1])),
                );
            } else {
                push(
                    &mut out,
                    format_args!(
                        "{}{} {}",
                        if k == 1 { "l" } else { " " },
                        decimal(here[0] - last[0]),
                        decimal(here[1] - last[1])
                    ),
                );
            }
            last = here;
        }
        if closed {
            out.push('Z');
        }
    }
    out
}

fn number(value: f64) -> String {
    decimal((value * 10.0).round() as i64)
}

fn decimal(tenths: i64) -> String {
    let sign = if tenths < 0 { "-" } else { "" };
    match (tenths.abs() / 10, tenths.abs() % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, tenth) => format!("{sign}.{tenth}"),
        (whole, tenth) => format!("{sign}{whole}.{tenth}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Dash, Stroke};

    #[test]
    fn paths_are_short_and_exact_to_a_tenth() {
        let lines = vec![vec![[0.04, 10.0], [1.26, 9.5], [2.0, 9.5]]];
        assert_eq!(path_data(&lines, false), "M0 10l1.3 -.5 .7 0");
        assert_eq!(path_data(&lines, true), "M0 10l1.3 -.5 .7 0Z");
    }

    #[test]
    fn files_carry_their_colours_and_escape_words() {
        let mut drawing = Drawing::new(10.0, "a < b", "");
        drawing.line(
            vec![[0.0, 0.0], [1.0, 1.0]],
            Stroke::new(Colour::Ink, 1.0).dashed(Dash::Dashed),
        );
        assert!(drawing.to_svg().contains("#1a1c1f") && drawing.to_svg().contains("a &lt; b"));
    }
}
