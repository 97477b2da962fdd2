//! The painter of PNG files.

use super::font::{text_outline, text_width};
use super::{Anchor, Colour, Drawing, Image, Item, Point, Stroke};
use tiny_skia::{
    FillRule, FilterQuality, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint,
    StrokeDash, Transform,
};

/// Largest side of a PNG, pixels.
const MAX_SIDE: u32 = 8192;

pub(super) fn paint(drawing: &Drawing, scale: f64) -> Vec<u8> {
    let side = |length: f64| ((length * scale).ceil() as u32).clamp(1, MAX_SIDE);
    let mut canvas = Pixmap::new(side(drawing.width), side(drawing.height))
        .expect("sides are positive and bounded");
    canvas.fill(colour(Colour::Paper));
    let view = Transform::from_scale(scale as f32, scale as f32);
    for item in &drawing.items {
        paint_item(&mut canvas, item, view);
    }
    encode(&canvas)
}

fn encode(canvas: &Pixmap) -> Vec<u8> {
    canvas
        .encode_png()
        .expect("pixels in memory can be encoded")
}

/// An image as the bytes of a PNG file.
pub(crate) fn image_png(image: &Image) -> Vec<u8> {
    pixmap(image)
        .map(|pixels| encode(&pixels))
        .unwrap_or_default()
}

fn pixmap(image: &Image) -> Option<Pixmap> {
    let mut pixels = Pixmap::new(
        u32::try_from(image.columns).ok()?,
        u32::try_from(image.rows).ok()?,
    )?;
    for (target, source) in pixels
        .pixels_mut()
        .iter_mut()
        .zip(image.rgba.chunks_exact(4))
    {
        *target =
            tiny_skia::ColorU8::from_rgba(source[0], source[1], source[2], source[3]).premultiply();
    }
    Some(pixels)
}

fn paint_item(canvas: &mut Pixmap, item: &Item, view: Transform) {
    match item {
        Item::Path {
            lines,
            closed,
            fill,
            stroke,
            ..
        } => {
            if let Some(path) = polylines(lines, *closed) {
                fill_and_stroke(canvas, &path, *fill, *stroke, view);
            }
        }
        Item::Disc {
            centre,
            radius,
            fill,
            stroke,
            ..
        } => {
            if let Some(path) =
                PathBuilder::from_circle(centre[0] as f32, centre[1] as f32, *radius as f32)
            {
                fill_and_stroke(canvas, &path, *fill, *stroke, view);
            }
        }
        Item::Text { .. } => paint_text(canvas, item, view),
        Item::Image {
            corner,
            size,
            image,
        } => {
            let Some(pixels) = pixmap(image) else { return };
            let stretch = [size[0] / image.columns as f64, size[1] / image.rows as f64];
            let place = Transform::from_row(
                stretch[0] as f32,
                0.0,
                0.0,
                stretch[1] as f32,
                corner[0] as f32,
                corner[1] as f32,
            );
            let paint = PixmapPaint {
                quality: FilterQuality::Bilinear,
                ..PixmapPaint::default()
            };
            canvas.draw_pixmap(0, 0, pixels.as_ref(), &paint, place.post_concat(view), None);
        }
    }
}

fn paint_text(canvas: &mut Pixmap, item: &Item, view: Transform) {
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
    let Some(path) = text_outline(text, *size) else {
        return;
    };
    let shift = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => 0.5,
        Anchor::End => 1.0,
    } * text_width(text, *size);
    let turn = if *turned {
        Transform::from_rotate(-90.0)
    } else {
        Transform::identity()
    };
    let place = turn
        .pre_translate(-shift as f32, 0.0)
        .post_translate(at[0] as f32, at[1] as f32)
        .post_concat(view);
    if *halo {
        let paper = Stroke::new(Colour::Paper, 3.0);
        fill_and_stroke(canvas, &path, None, Some(paper), place);
    }
    let thick = bold.then(|| Stroke::new(*colour, size / 24.0));
    let rule = FillRule::Winding;
    fill_and_stroke_by(canvas, &path, Some(*colour), thick, place, rule);
}

fn polylines(lines: &[Vec<Point>], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for line in lines {
        for (k, point) in line.iter().enumerate() {
            let [x, y] = point.map(|value| value as f32);
            if k == 0 {
                path.move_to(x, y);
            } else {
                path.line_to(x, y);
            }
        }
        if closed && !line.is_empty() {
            path.close();
        }
    }
    path.finish()
}

fn fill_and_stroke(
    canvas: &mut Pixmap,
    path: &Path,
    fill: Option<Colour>,
    stroke: Option<Stroke>,
    view: Transform,
) {
    fill_and_stroke_by(canvas, path, fill, stroke, view, FillRule::EvenOdd);
}

fn fill_and_stroke_by(
    canvas: &mut Pixmap,
    path: &Path,
    fill: Option<Colour>,
    stroke: Option<Stroke>,
    view: Transform,
    rule: FillRule,
) {
    if let Some(fill) = fill {
        canvas.fill_path(path, &ink(fill), rule, view, None);
    }
    if let Some(stroke) = stroke {
        let dash = stroke
            .dash
            .pattern()
            .and_then(|pattern| StrokeDash::new(pattern.map(|length| length as f32).to_vec(), 0.0));
        let pen = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash,
            ..Default::default()
        };
        canvas.stroke_path(path, &ink(stroke.colour), &pen, view, None);
    }
}

fn ink(colour_role: Colour) -> Paint<'static> {
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color(colour(colour_role));
    paint
}

fn colour(role: Colour) -> tiny_skia::Color {
    let [r, g, b] = role.rgb();
    tiny_skia::Color::from_rgba8(r, g, b, 255)
}
