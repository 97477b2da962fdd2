//! Colours by role, which follow the light or dark theme of the page, and colour maps that are
//! readable with colour blindness and in grey.

/// A colour by its role, or as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Text and frames.
    Ink,
    /// Secondary text, measured curves.
    Muted,
    /// Grid lines.
    Grid,
    /// Background.
    Paper,
    /// Colour of a data series, counted from 0, repeating after [`SERIES`].
    Series(u8),
    /// Red, green, blue; the same in every theme.
    Rgb([u8; 3]),
}

/// Number of different series colours.
pub const SERIES: u8 = 6;

/// Series colours of the light theme: blue, red, olive, wine, orange, navy. A search found these
/// six: they have contrast 3 on white and are distinct for every kind of colour vision and in
/// grey. `page/colour_vision.rs` tests both themes.
const LIGHT: [[u8; 3]; SERIES as usize] = [
    [25, 108, 228],
    [182, 39, 32],
    [116, 137, 82],
    [108, 28, 59],
    [209, 128, 42],
    [25, 76, 131],
];

impl Colour {
    /// Red, green, blue on a white ground.
    pub fn rgb(self) -> [u8; 3] {
        match self {
            Self::Ink => [26, 28, 31],
            Self::Muted => [112, 117, 124],
            Self::Grid => [224, 227, 231],
            Self::Paper => [255, 255, 255],
            Self::Series(number) => LIGHT[usize::from(number % SERIES)],
            Self::Rgb(rgb) => rgb,
        }
    }
}

/// A map from numbers to colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColourMap {
    /// Dark violet over teal to yellow, with evenly rising lightness, so that grey shows the same.
    Sequential,
    /// Blue over white to brown. Both ends are dark in grey, so that figures add signs and dashed
    /// contours.
    Diverging,
    /// A cycle for phases; figures add a hand that points to the phase.
    Cyclic,
    /// White to dark blue, for matrices that hold mostly zeros.
    White,
}

impl ColourMap {
    /// Colour of `t` in 0..=1, clamped; NaN is grey.
    pub fn at(self, t: f64) -> [u8; 3] {
        let anchors: &[[u8; 3]] = match self {
            Self::Sequential => &[
                [42, 18, 84],
                [52, 80, 140],
                [36, 126, 140],
                [80, 172, 112],
                [176, 212, 74],
                [253, 236, 116],
            ],
            Self::Diverging => &[
                [8, 48, 107],
                [66, 130, 190],
                [176, 208, 230],
                [250, 250, 248],
                [248, 205, 155],
                [214, 120, 40],
                [115, 48, 6],
            ],
            Self::Cyclic => &[
                [236, 226, 214],
                [120, 165, 205],
                [62, 84, 160],
                [44, 24, 62],
                [130, 40, 62],
                [205, 120, 88],
                [236, 226, 214],
            ],
            Self::White => &[
                [255, 255, 255],
                [150, 190, 222],
                [40, 110, 175],
                [5, 40, 90],
            ],
        };
        if t.is_nan() {
            return [128, 128, 128];
        }
        let place = t.clamp(0.0, 1.0) * (anchors.len() - 1) as f64;
        let below = (place.floor() as usize).min(anchors.len() - 2);
        let part = place - below as f64;
        let mix = |channel: usize| {
            let (a, b) = (
                f64::from(anchors[below][channel]),
                f64::from(anchors[below + 1][channel]),
            );
            (a + part * (b - a)).round() as u8
        };
        [mix(0), mix(1), mix(2)]
    }
}

/// True where white letters are more readable than black ones on `rgb`.
pub(crate) fn is_dark([r, g, b]: [u8; 3]) -> bool {
    0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b) < 135.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lightness([r, g, b]: [u8; 3]) -> f64 {
        0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b)
    }

    #[test]
    fn the_sequential_map_rises_in_grey_and_the_cyclic_one_closes() {
        let levels: Vec<f64> = (0..=50)
            .map(|k| lightness(ColourMap::Sequential.at(f64::from(k) / 50.0)))
            .collect();
        assert!(
            levels.windows(2).all(|pair| pair[1] > pair[0]),
            "{levels:?}"
        );
        assert_eq!(ColourMap::Cyclic.at(0.0), ColourMap::Cyclic.at(1.0));
        assert_eq!(ColourMap::Sequential.at(f64::NAN), [128, 128, 128]);
    }
}
