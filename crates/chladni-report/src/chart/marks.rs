//! Signs for single points, and their shapes.

use crate::drawing::{Colour, Drawing, Item, Point, Stroke};

/// Signs for single points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mark {
    /// Filled disc.
    Dot,
    /// Ring.
    Ring,
    /// ×.
    Cross,
    /// Filled square.
    Square,
    /// Filled triangle.
    Triangle,
    /// Filled triangle that stands on a corner.
    Inverted,
    /// Filled square that stands on a corner.
    Diamond,
    /// +.
    Plus,
    /// Upright bar.
    Bar,
    /// The outline of a square.
    Frame,
}

/// Signs of series 0, 1, ...; they differ in shape, so that no colour is needed.
const SERIES_MARKS: [Mark; 10] = [
    Mark::Dot,
    Mark::Square,
    Mark::Ring,
    Mark::Triangle,
    Mark::Diamond,
    Mark::Cross,
    Mark::Inverted,
    Mark::Plus,
    Mark::Frame,
    Mark::Bar,
];

impl Mark {
    /// The sign of series number `k`; they repeat after ten.
    pub fn of_series(k: usize) -> Self {
        SERIES_MARKS[k % SERIES_MARKS.len()]
    }

    /// Draws the sign around `at`, `size` px across. Filled signs show `hint` under the pointer.
    pub(super) fn draw(
        self,
        drawing: &mut Drawing,
        at: Point,
        colour: Colour,
        size: f64,
        hint: Option<String>,
    ) {
        let half = size / 2.0;
        let corners = |places: &[Point]| {
            places
                .iter()
                .map(|[dx, dy]| [at[0] + dx * half, at[1] + dy * half])
                .collect::<Vec<_>>()
        };
        let mut filled =
            |places: &[Point]| drawing.polygon(corners(places), Some(colour), None, hint.clone());
        match self {
            Self::Dot => disc(drawing, at, half, Some(colour), None, hint),
            Self::Ring => {
                let mut ring = |stroke| disc(drawing, at, half, None, Some(stroke), None);
                if matches!(colour, Colour::Rgb(_)) {
                    // visible on dark and on light ground
                    ring(Stroke::new(Colour::Rgb([60, 64, 70]), 3.0));
                }
                ring(Stroke::new(colour, 1.4));
            }
            Self::Cross => strokes(
                drawing,
                &[
                    corners(&[[-1.0, -1.0], [1.0, 1.0]]),
                    corners(&[[-1.0, 1.0], [1.0, -1.0]]),
                ],
                colour,
            ),
            Self::Plus => strokes(
                drawing,
                &[
                    corners(&[[-1.2, 0.0], [1.2, 0.0]]),
                    corners(&[[0.0, -1.2], [0.0, 1.2]]),
                ],
                colour,
            ),
            // larger than a disc, so that it is not taken for one
            Self::Square => filled(&[[-1.05, -1.05], [1.05, -1.05], [1.05, 1.05], [-1.05, 1.05]]),
            Self::Triangle => filled(&[[0.0, -1.1], [1.1, 0.8], [-1.1, 0.8]]),
            Self::Inverted => filled(&[[0.0, 1.1], [1.1, -0.8], [-1.1, -0.8]]),
            Self::Diamond => filled(&[[0.0, -1.25], [0.9, 0.0], [0.0, 1.25], [-0.9, 0.0]]),
            Self::Bar => filled(&[[-0.35, -1.3], [0.35, -1.3], [0.35, 1.3], [-0.35, 1.3]]),
            Self::Frame => {
                let sides = corners(&[[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]]);
                drawing.polygon(
                    sides,
                    Some(Colour::Paper),
                    Some(Stroke::new(colour, 1.6)),
                    None,
                );
            }
        }
    }
}

/// Draws the lines of a sign with white edges.
fn strokes(drawing: &mut Drawing, lines: &[Vec<Point>], colour: Colour) {
    for stroke in [
        Stroke::new(Colour::Rgb([255, 255, 255]), 5.0),
        Stroke::new(colour, 2.2),
    ] {
        let (lines, stroke) = (lines.to_vec(), Some(stroke));
        drawing.items.push(Item::Path {
            lines,
            closed: false,
            fill: None,
            stroke,
            name: None,
            hint: None,
        });
    }
}

/// A disc.
pub(super) fn disc(
    drawing: &mut Drawing,
    centre: Point,
    radius: f64,
    fill: Option<Colour>,
    stroke: Option<Stroke>,
    hint: Option<String>,
) {
    drawing.items.push(Item::Disc {
        centre,
        radius,
        fill,
        stroke,
        hint,
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiny_skia::Pixmap;

    /// Darkness of each pixel, 0 to 1, of a sign as large as in charts.
    fn darkness(mark: Mark) -> Vec<f64> {
        let mut drawing = Drawing::new(16.0, "", "");
        drawing.height = 16.0;
        mark.draw(&mut drawing, [8.0, 8.0], Colour::Ink, 8.0, None);
        let pixels = Pixmap::decode_png(&drawing.to_png(2.0)).unwrap();
        pixels
            .pixels()
            .iter()
            .map(|pixel| 1.0 - f64::from(pixel.red()) / 255.0)
            .collect()
    }

    #[test]
    fn any_two_signs_of_series_differ_in_shape() {
        let drawn = SERIES_MARKS.map(darkness);
        for (k, a) in drawn.iter().enumerate() {
            for (j, b) in drawn[..k].iter().enumerate() {
                let differing: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
                let smaller = a.iter().sum::<f64>().min(b.iter().sum());
                let (one, other) = (SERIES_MARKS[k], SERIES_MARKS[j]);
                assert!(
                    differing > 0.3 * smaller,
                    "{one:?} and {other:?}: {:.2} of the smaller one",
                    differing / smaller
                );
            }
        }
        assert_eq!(Mark::of_series(SERIES_MARKS.len()), Mark::of_series(0));
    }
}
