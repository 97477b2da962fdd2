//! A mode shape of the measured structure as a GIF file.

use crate::drawing::{gif, ColourMap};
use crate::structure::{Structure, Vector};
use chladni_frf::{ModalModel, Mode, Result};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Pictures of a period.
const PICTURES: usize = 24;
/// Time of each picture, hundredths of a second.
const DELAY_CS: u16 = 6;
/// Width and height, px.
const SIZE_PX: [usize; 2] = [420, 300];
/// Free ground around the structure, px.
const BORDER_PX: f64 = 16.0;
/// Drawn size of the largest motion, part of the longest side.
const LIFT: f64 = 0.16;
/// View from the left front above, rad; as on the page.
const AZIMUTH: f64 = -0.6;
const ELEVATION: f64 = 0.62;
/// Number of colours of motion, which come first in the palette.
const LEVELS: u8 = 253;
/// Palette index of the structure at rest.
const REST: u8 = 253;
/// Palette index of lines.
const INK: u8 = 254;
/// Palette index of the ground.
const PAPER: u8 = 255;

/// Name and content of a GIF file for each mode of the band; none where the structure has
/// neither lines nor faces.
///
/// # Errors
/// Those of the encoder, which are internal errors.
pub(crate) fn moving_shapes(model: &ModalModel) -> Result<Vec<(String, Vec<u8>)>> {
    let Some(structure) = Structure::of(model) else {
        return Ok(Vec::new());
    };
    if structure.lines.is_empty() && structure.faces.is_empty() {
        return Ok(Vec::new());
    }
    let modes = model.in_band_modes().take(crate::sizes::MODE_SHAPES);
    modes
        .zip(1..)
        .map(|(mode, number)| {
            let bytes = moving(&structure, mode)?;
            Ok((format!("mode-{number:02}.gif"), bytes))
        })
        .collect()
}

fn moving(structure: &Structure, mode: &Mode) -> Result<Vec<u8>> {
    let motion = structure.motion(mode);
    let view = View::of(structure);
    let pictures: Vec<Vec<u8>> = (0..PICTURES)
        .map(|k| view.picture(structure, &motion, TAU * k as f64 / PICTURES as f64))
        .collect();
    let mut palette = [[255; 3]; 256];
    for (k, colour) in palette[..usize::from(LEVELS)].iter_mut().enumerate() {
        *colour = ColourMap::Diverging.at(k as f64 / f64::from(LEVELS - 1));
    }
    palette[usize::from(REST)] = [190, 194, 198];
    palette[usize::from(INK)] = [40, 44, 48];
    let size = SIZE_PX.map(|side| u16::try_from(side).unwrap_or(u16::MAX));
    gif(size, &palette, &pictures, DELAY_CS)
}

/// The projection from space to the picture.
struct View {
    zoom: f64,
    middle: [f64; 2],
    lift_m: f64,
}

/// A place in the coordinates of the viewer: right, up, depth.
fn seen(place: Vector) -> Vector {
    let [x, y, z] = place;
    let (sin_a, cos_a) = AZIMUTH.sin_cos();
    let (sin_e, cos_e) = ELEVATION.sin_cos();
    let (right, away) = (x * cos_a - y * sin_a, x * sin_a + y * cos_a);
    [right, z * cos_e + away * sin_e, away * cos_e - z * sin_e]
}

impl View {
    /// The view that shows the whole structure with its motion.
    fn of(structure: &Structure) -> Self {
        let ends = |axis: usize| {
            let values = structure.places_m.iter().map(|place| place[axis]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                [low.min(v), high.max(v)]
            })
        };
        let sides = [0, 1, 2].map(ends);
        let longest = sides
            .iter()
            .map(|[low, high]| high - low)
            .fold(0.0, f64::max);
        let lift_m = LIFT * longest.max(f64::MIN_POSITIVE);
        // room for the motion, along each axis
        let moves = |axis: usize| {
            let moved = structure.moves.iter().flatten();
            moved.map(|(_, to)| to[axis].abs()).fold(0.0, f64::max)
        };
        let room_m = [0, 1, 2].map(|axis| lift_m * moves(axis));
        let corners = (0..8).map(|k| {
            seen([0, 1, 2].map(|axis| {
                let [low, high] = sides[axis];
                if (k >> axis) & 1 == 0 {
                    low - room_m[axis]
                } else {
                    high + room_m[axis]
                }
            }))
        });
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in corners {
            for k in 0..2 {
                low[k] = low[k].min(corner[k]);
                high[k] = high[k].max(corner[k]);
            }
        }
        let room = |k: usize| (SIZE_PX[k] as f64 - 2.0 * BORDER_PX) / (high[k] - low[k]);
        Self {
            zoom: room(0).min(room(1)),
            middle: [0, 1].map(|k| 0.5 * (low[k] + high[k])),
            lift_m,
        }
    }

    /// Pixel coordinates and depth.
    fn place(&self, at: Vector) -> Vector {
        let [right, up, depth] = seen(at);
        [
            0.5 * SIZE_PX[0] as f64 + self.zoom * (right - self.middle[0]),
            0.5 * SIZE_PX[1] as f64 - self.zoom * (up - self.middle[1]),
            depth,
        ]
    }

    fn picture(
        &self,
        structure: &Structure,
        motion: &[Option<[Complex64; 3]>],
        phase: f64,
    ) -> Vec<u8> {
        let turn = Complex64::from_polar(1.0, phase);
        let moved: Vec<Option<(Vector, u8)>> = motion
            .iter()
            .zip(&structure.places_m)
            .map(|(parts, place_m)| {
                let by = (*parts)?.map(|part| (part * turn).re);
                Some(self.moved(place_m, by))
            })
            .collect();
        let rest: Vec<Vector> = structure
            .places_m
            .iter()
            .map(|at| self.place(*at))
            .collect();
        let mut canvas = Canvas(vec![PAPER; SIZE_PX[0] * SIZE_PX[1]]);
        for outline in structure.faces.iter().chain(&structure.lines) {
            canvas.path(outline.iter().map(|&k| rest[k]), REST);
        }
        for Face { outline, code, .. } in &moved_faces(structure, &moved) {
            canvas.fill(outline, *code);
            let closed = outline.iter().chain(outline.first()).copied();
            canvas.path(closed, INK);
        }
        for line in &structure.lines {
            for pair in line.windows(2) {
                if let (Some((a, _)), Some((b, _))) = (moved[pair[0]], moved[pair[1]]) {
                    canvas.path([a, b].into_iter(), INK);
                }
            }
        }
        // without faces the nodes are drawn
        if structure.faces.is_empty() {
            for (at, code) in moved.iter().flatten() {
                canvas.dot(*at, *code);
            }
        }
        canvas.0
    }

    /// Pixel coordinates and palette index of a place that has moved by `by`.
    fn moved(&self, place_m: &Vector, by: Vector) -> (Vector, u8) {
        let at = [0, 1, 2].map(|n| place_m[n] + self.lift_m * by[n]);
        let further = |most: f64, part: &f64| {
            if part.abs() > most.abs() {
                *part
            } else {
                most
            }
        };
        (self.place(at), level(by.iter().fold(0.0, further)))
    }
}

/// A face in the picture.
struct Face {
    /// Mean depth of the corners.
    depth: f64,
    /// Pixel coordinates of the corners.
    outline: Vec<Vector>,
    /// Mean palette index of the corners.
    code: u8,
}

/// The faces whose corners all move, the furthest first.
fn moved_faces(structure: &Structure, moved: &[Option<(Vector, u8)>]) -> Vec<Face> {
    let mut faces: Vec<Face> = structure
        .faces
        .iter()
        .filter_map(|face| {
            let corners: Vec<(Vector, u8)> =
                face.iter().map(|&k| moved[k]).collect::<Option<_>>()?;
            let count = corners.len() as f64;
            let depth = corners.iter().map(|(at, _)| at[2]).sum::<f64>() / count;
            let mean = corners
                .iter()
                .map(|(_, code)| f64::from(*code))
                .sum::<f64>()
                / count;
            let outline = corners.into_iter().map(|(at, _)| at).collect();
            Some(Face {
                depth,
                outline,
                code: mean.round() as u8,
            })
        })
        .collect();
    faces.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    faces
}

/// The palette index of a motion between −1 and 1.
fn level(motion: f64) -> u8 {
    (f64::from(LEVELS - 1) * (0.5 + 0.5 * motion.clamp(-1.0, 1.0))).round() as u8
}

/// Pixels row by row from the top.
struct Canvas(Vec<u8>);

impl Canvas {
    fn set(&mut self, x: f64, y: f64, code: u8) {
        let [width, height] = SIZE_PX;
        if x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64 {
            self.0[y as usize * width + x as usize] = code;
        }
    }

    fn path(&mut self, mut points: impl Iterator<Item = Vector>, code: u8) {
        let Some(mut from) = points.next() else {
            return;
        };
        for to in points {
            let steps = (to[0] - from[0])
                .abs()
                .max((to[1] - from[1]).abs())
                .ceil()
                .max(1.0);
            for k in 0..=steps as usize {
                let share = k as f64 / steps;
                let [x, y] = [0, 1].map(|n| from[n] + share * (to[n] - from[n]));
                self.set(x, y, code);
            }
            from = to;
        }
    }

    fn dot(&mut self, at: Vector, code: u8) {
        for (dx, dy) in (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy))) {
            if dx * dx + dy * dy <= 5 {
                self.set(at[0] + f64::from(dx), at[1] + f64::from(dy), code);
            }
        }
    }

    /// Fills a polygon, in each row between its crossings with the outline.
    fn fill(&mut self, outline: &[Vector], code: u8) {
        let edges = || outline.iter().zip(outline.iter().cycle().skip(1));
        let (low, high) = outline
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |ends, at| {
                (ends.0.min(at[1]), ends.1.max(at[1]))
            });
        let last = (SIZE_PX[1] - 1) as f64;
        let (first, last) = (
            low.ceil().max(0.0) as usize,
            high.floor().clamp(0.0, last) as usize,
        );
        for row in first..=last {
            let y = row as f64;
            let mut crossings: Vec<f64> = edges()
                .filter(|(a, b)| (a[1] > y) != (b[1] > y))
                .map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
                .collect();
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let mut x = pair[0].ceil();
                while x <= pair[1] {
                    self.set(x, y, code);
                    x += 1.0;
                }
            }
        }
    }
}
