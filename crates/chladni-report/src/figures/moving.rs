//! The moving ground as a GIF file: over a period of a steady drive, and over the time of a scene.

use crate::drawing::{gif, ColourMap};
use crate::input::ShownField;
use crate::sizes::FIELD_RANGE_DB;
use chladni_frf::Result;
use chladni_render::{Position, TimeFrames};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Width of the picture, px.
const WIDTH_PX: usize = 480;
/// Time of each picture, hundredths of a second.
const DELAY_CS: u16 = 7;
/// Pictures of a period.
const PICTURES: usize = 24;
/// Number of colours of levels, which come first in the palette.
const LEVELS: u8 = 254;
/// Palette index of the outline of hot ground.
const OUTLINE: u8 = 254;
/// Palette index of ground without a level.
const PAPER: u8 = 255;

/// A GIF file of the level of the ground over the time of a scene; `None` where the
/// responses span no area.
///
/// # Errors
/// Those of the encoder, which are internal errors.
pub fn moving_field(frames: &TimeFrames) -> Result<Option<Vec<u8>>> {
    let Some(area) = frames.area.as_ref() else {
        return Ok(None);
    };
    let Some(picture) = Picture::new(&area.x_m, &area.y_m) else {
        return Ok(None);
    };
    let width = area.x_m.len();
    let grids = area.values.rows().into_iter().map(|values| {
        let mut grid = vec![f64::NAN; width * area.y_m.len()];
        for (&[row, column], &value) in area.places.iter().zip(values) {
            grid[row * width + column] = value;
        }
        grid
    });
    let colour = |value: f64| colour_of(0.5 + 0.5 * 20.0 * value.log10() / FIELD_RANGE_DB);
    picture.film(grids, colour, &frames.hot, ColourMap::Sequential)
}

/// A GIF file of the velocity of the ground over one period of a steady drive, relative to the
/// largest velocity; `None` where the responses span no area.
///
/// # Errors
/// Those of the encoder, which are internal errors.
pub(crate) fn moving_period(shown: &ShownField) -> Result<Option<Vec<u8>>> {
    let Some(area) = shown.area else {
        return Ok(None);
    };
    let Some(picture) = Picture::new(&area.x_m, &area.y_m) else {
        return Ok(None);
    };
    let velocities = &area.velocity_m_per_s;
    let largest = velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let grids = (0..PICTURES).map(|k| {
        let turn = Complex64::from_polar(1.0, TAU * k as f64 / PICTURES as f64);
        velocities.iter().map(|v| (v * turn).re).collect()
    });
    let colour = |value: f64| colour_of(0.5 + 0.5 * value / largest);
    let hot = shown.zones.hot_outlines();
    picture.film(grids, colour, hot, ColourMap::Diverging)
}

/// Pixels over a grid of places.
struct Picture<'a> {
    columns: usize,
    rows: usize,
    corner_m: Position,
    pixel_m: f64,
    x_m: &'a [f64],
    y_m: &'a [f64],
}

impl<'a> Picture<'a> {
    fn new(x_m: &'a [f64], y_m: &'a [f64]) -> Option<Self> {
        let span = |axis: &[f64]| Some((*axis.first()?, axis.last()? - axis.first()?));
        let ((x_min, wide), (y_min, high)) = (span(x_m)?, span(y_m)?);
        let pixel_m = wide / (WIDTH_PX - 1) as f64;
        if !(pixel_m > 0.0 && high > 0.0) {
            return None;
        }
        Some(Self {
            columns: WIDTH_PX,
            rows: ((high / pixel_m).round() as usize + 1).min(4 * WIDTH_PX),
            corner_m: [x_min, y_min],
            pixel_m,
            x_m,
            y_m,
        })
    }

    /// The file of `grids`, each row by row from the lowest y, with the outlines of hot ground;
    /// `None` where the picture is too large for a GIF.
    fn film(
        &self,
        grids: impl Iterator<Item = Vec<f64>>,
        colour: impl Fn(f64) -> u8,
        hot: &[Vec<Position>],
        map: ColourMap,
    ) -> Result<Option<Vec<u8>>> {
        let pictures: Vec<Vec<u8>> = grids
            .map(|grid| {
                let mut pixels = self.pixels(&grid, &colour);
                for outline in hot {
                    self.draw(&mut pixels, outline);
                }
                pixels
            })
            .collect();
        let mut palette = [[255; 3]; 256];
        for (k, colour) in palette[..usize::from(LEVELS)].iter_mut().enumerate() {
            *colour = map.at(k as f64 / f64::from(LEVELS - 1));
        }
        palette[usize::from(OUTLINE)] = [200, 30, 30];
        let side = |length: usize| u16::try_from(length).ok();
        let (Some(width), Some(height)) = (side(self.columns), side(self.rows)) else {
            return Ok(None);
        };
        gif([width, height], &palette, &pictures, DELAY_CS).map(Some)
    }

    /// Palette indices of the pixels, by bilinear interpolation, the upper row first.
    fn pixels(&self, grid: &[f64], colour: impl Fn(f64) -> u8) -> Vec<u8> {
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
            let (row, v) = along(self.y_m, self.corner_m[1] + self.pixel_m * y as f64);
            for x in 0..self.columns {
                let (column, u) = along(self.x_m, self.corner_m[0] + self.pixel_m * x as f64);
                let at = |dr: usize, dc: usize| grid[(row + dr) * self.x_m.len() + column + dc];
                let value = (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(0, 1))
                    + v * ((1.0 - u) * at(1, 0) + u * at(1, 1));
                pixels.push(colour(value));
            }
        }
        pixels
    }

    /// Draws a closed line, 2 px wide.
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

/// The palette index of a place between 0 and 1 on the colour map.
fn colour_of(place: f64) -> u8 {
    if place.is_nan() {
        return PAPER;
    }
    (f64::from(LEVELS - 1) * place.clamp(0.0, 1.0)).round() as u8
}
