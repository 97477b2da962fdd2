//! Letters: widths for the layout, outlines for PNG. The font is embedded, so that pictures do not
//! depend on the fonts of the machine.

use std::sync::OnceLock;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, OutlineBuilder};

fn face() -> &'static Face<'static> {
    static FACE: OnceLock<Face<'static>> = OnceLock::new();
    FACE.get_or_init(|| {
        Face::parse(dejavu::sans::regular(), 0).expect("the embedded font is sound")
    })
}

/// Width of `text` in letters of `size`, px.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let units: f64 = text.chars().map(advance).sum();
    units * size / f64::from(face().units_per_em())
}

fn advance(letter: char) -> f64 {
    let glyph = face().glyph_index(letter).unwrap_or_default();
    f64::from(
        face()
            .glyph_hor_advance(glyph)
            .unwrap_or(face().units_per_em() / 2),
    )
}

/// Outline of `text` with its base line starting at (0, 0), y downwards; `None` for blank
/// text.
pub(crate) fn text_outline(text: &str, size: f64) -> Option<Path> {
    let scale = size / f64::from(face().units_per_em());
    let mut pen = Pen {
        path: PathBuilder::new(),
        x: 0.0,
        scale,
    };
    for letter in text.chars() {
        face().outline_glyph(face().glyph_index(letter).unwrap_or_default(), &mut pen);
        pen.x += advance(letter) * scale;
    }
    pen.path.finish()
}

struct Pen {
    path: PathBuilder,
    x: f64,
    scale: f64,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (
            (self.x + f64::from(x) * self.scale) as f32,
            (-f64::from(y) * self.scale) as f32,
        )
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) =
            (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

/// `text`, with its middle left out where it is wider than `width` px.
pub(crate) fn fitted(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    let shortened = |keep: usize| -> String {
        let head = letters[..keep.div_ceil(2)].iter();
        let tail = letters[letters.len() - keep / 2..].iter();
        head.chain(['…'].iter()).chain(tail).collect()
    };
    let widest = (1..letters.len())
        .rev()
        .find(|&keep| text_width(&shortened(keep), size) <= width);
    shortened(widest.unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_of_the_charts_has_a_letter() {
        for letter in "aZ09 .,:;()/|%°²³⁻⁰¹⁴⁵⁶⁷⁸⁹−–±×·≥≤ηωζσΣπ√…∞".chars()
        {
            assert!(face().glyph_index(letter).is_some(), "{letter}");
        }
    }

    #[test]
    fn long_text_loses_its_middle() {
        let short = fitted("a_very_long_name_of_a_measurement.h5", 12.0, 100.0);
        assert!(
            short.contains('…') && short.ends_with("h5") && short.starts_with("a_v"),
            "{short}"
        );
        assert!(text_width(&short, 12.0) <= 100.0);
        assert_eq!(fitted("short", 12.0, 100.0), "short");
    }
}
