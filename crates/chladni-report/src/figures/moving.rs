//! The ground of a scene in time as a moving picture, for talks.

use crate::drawing::{gif, ColourMap};
use crate::sizes::FIELD_RANGE_DB;
use chladni_render::{AreaFrames, Position, TimeFrames};

/// Width of the picture, px.
const WIDTH_PX: usize = 480;
/// Hundredths of a second that each picture stands.
const DELAY_CS: u16 = 7;
/// Colours of levels; then the outline of hot ground, and ground without a level.
const LEVELS: u8 = 254;
const OUTLINE: u8 = 254;
const PAPER: u8 = 255;

/// A GIF file; `None` where the responses carry no area.
pub fn moving_field(frames: &TimeFrames) -> Option<Vec<u8>> {
    let area = frames.area.as_ref()?;
    let picture = Picture::new(area)?;
    let pictures: Vec<Vec<u8>> = area
        .values
        .rows()
        .into_iter()
        .map(|values| {
            let mut pixels = picture.pixels(area, &values.to_vec());
            for outline in &frames.hot {
                picture.draw(&mut pixels, outline);
            }
            pixels
        })
        .collect();
    let mut palette = [[255; 3]; 256];
    for (k, colour) in palette[..usize::from(LEVELS)].iter_mut().enumerate() {
        *colour = ColourMap::Sequential.at(k as f64 / f64::from(LEVELS - 1));
    }
    palette[usize::from(OUTLINE)] = [200, 30, 30];
    let side = |length: usize| u16::try_from(length).ok();
    let size = [side(picture.columns)?, side(picture.rows)?];
    Some(gif(size, &palette, &pictures, DELAY_CS))
}

/// Pixels over the grid of an area.
struct Picture {
    columns: usize,
    rows: usize,
    corner_m: Position,
    pixel_m: f64,
}

impl Picture {
    fn new(area: &AreaFrames) -> Option<Self> {
        let span = |axis: &[f64]| Some((*axis.first()?, axis.last()? - axis.first()?));
        let ((x_min, wide), (y_min, high)) = (span(&area.x_m)?, span(&area.y_m)?);
        let pixel_m = wide / (WIDTH_PX - 1) as f64;
        if !(pixel_m > 0.0 && high > 0.0) {
            return None;
        }
        Some(Self {
            columns: WIDTH_PX,
            rows: ((high / pixel_m).round() as usize + 1).min(4 * WIDTH_PX),
            corner_m: [x_min, y_min],
            pixel_m,
        })
    }

    /// Levels by bilinear interpolation, the upper row first.
    fn pixels(&self, area: &AreaFrames, values: &[f64]) -> Vec<u8> {
        let width = area.x_m.len();
        let mut grid = vec![f64::NAN; width * area.y_m.len()];
        for (&[row, column], &value) in area.places.iter().zip(values) {
            grid[row * width + column] = value;
        }
        let along = |axis: &[f64], place: f64| -> (usize, f64) {
            let k = axis.partition_point(|&at| at <= place);
            let k = k.clamp(1, axis.len() - 1) - 1;
            (
                k,
                ((place - axis[k]) / (axis[k + 1] - axis[k])).clamp(0.0, 1.0),
            )
        };
        let mut pixels = Vec::with_capacity(self.columns * self.rows);
        for y in (0..self.rows).rev() {
            let (row, v) = along(&area.y_m, self.corner_m[1] + self.pixel_m * y as f64);
            for x in 0..self.columns {
                let (column, u) = along(&area.x_m, self.corner_m[0] + self.pixel_m * x as f64);
                let at = |dr: usize, dc: usize| grid[(row + dr) * width + column + dc];
                let value = (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(0, 1))
                    + v * ((1.0 - u) * at(1, 0) + u * at(1, 1));
                pixels.push(colour_of(value));
            }
        }
        pixels
    }

    /// A closed line, 2 px wide.
    fn draw(&self, pixels: &mut [u8], outline: &[Position]) {
        for (k, from) in outline.iter().enumerate() {
            let to = outline[(k + 1) % outline.len()];
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let steps = (length / self.pixel_m).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                let [x, y] = [0, 1].map(|axis| {
                    let place = from[axis] + share * (to[axis] - from[axis]);
                    ((place - self.corner_m[axis]) / self.pixel_m).round()
                });
                for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                    let (x, y) = (x + dx, y + dy);
                    if x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64 {
                        let row = self.rows - 1 - y as usize;
                        pixels[row * self.columns + x as usize] = OUTLINE;
                    }
                }
            }
        }
    }
}

fn colour_of(value: f64) -> u8 {
    if value.is_nan() {
        return PAPER;
    }
    let place = 0.5 + 0.5 * 20.0 * value.log10() / FIELD_RANGE_DB;
    (f64::from(LEVELS - 1) * place.clamp(0.0, 1.0)).round() as u8
}
