//! Pictures of the ground while a scene is played.

use crate::panel::field::AreaGrid;
use crate::scene::plane::Position;
use crate::scene::zones::Ground;
use crate::time::listener::Listener;
use crate::time::tracks::Tracks;
use crate::tolerances;
use chladni_frf::Dof;
use ndarray::Array2;
use num_complex::Complex64;

/// The ground and the drive at even times, from 0 on.
#[derive(Debug, Clone)]
pub struct TimeFrames {
    /// From frame to frame, s.
    pub step_s: f64,
    /// Names of the responses.
    pub names: Vec<Dof>,
    /// Their ground at the beginning.
    pub ground: Vec<Ground>,
    /// Their amplitudes over the threshold, of all tones together; axes (frame, response).
    pub responses: Array2<f64>,
    /// |a| of each actuator, N or V, the tones added; axes (frame, actuator).
    pub drive: Array2<f64>,
    /// Between the responses; `None` where they carry no area.
    pub area: Option<AreaFrames>,
    /// Corners of what is hot at the beginning, m.
    pub hot: Vec<Vec<Position>>,
    /// x_min, y_min, x_max, y_max of what is judged, m.
    pub area_m: [f64; 4],
}

impl TimeFrames {
    /// The responses from hot to cold ground, and the number of hot ones.
    pub fn by_ground(&self) -> (Vec<usize>, usize) {
        let place = |k: &usize| match self.ground[*k] {
            Ground::Hot => 0,
            Ground::Ignored => 1,
            Ground::Cold => 2,
        };
        let mut order: Vec<usize> = (0..self.names.len()).collect();
        order.sort_by_key(place);
        let hot = order.iter().filter(|k| place(k) == 0).count();
        (order, hot)
    }
}

/// Amplitudes on a grid.
#[derive(Debug, Clone)]
pub struct AreaFrames {
    /// Columns, m, rising.
    pub x_m: Vec<f64>,
    /// Rows, m, rising.
    pub y_m: Vec<f64>,
    /// Row and column of each place that lies inside the hull of the responses.
    pub places: Vec<[usize; 2]>,
    /// Amplitudes over the threshold; axes (frame, place).
    pub values: Array2<f64>,
}

/// Samples from frame to frame, and frames, for about `wanted` of them over `length_s`.
pub(crate) fn rhythm(length_s: f64, wanted: usize) -> (usize, usize) {
    let samples = ((length_s + tolerances::JUDGE_TAIL_S) / tolerances::JUDGE_STEP_S).ceil();
    let every = (samples / wanted.max(1) as f64).ceil().max(1.0) as usize;
    (every, (samples as usize).div_ceil(every))
}

/// |a| of each actuator, the tones added; axes (frame, actuator).
pub(crate) fn drives(tones: &[Tracks], actuators: usize, step_s: f64, count: usize) -> Array2<f64> {
    let mut drive = Array2::zeros((count, actuators));
    let mut sum = vec![Complex64::ZERO; actuators];
    for (frame, mut row) in drive.rows_mut().into_iter().enumerate() {
        for tone in tones {
            tone.at(step_s * frame as f64, &mut sum);
            for (value, a) in row.iter_mut().zip(&sum) {
                *value += a.norm();
            }
        }
    }
    drive
}

/// The ground between the responses.
pub(crate) fn of_area(
    grid: AreaGrid,
    listener: &Listener,
    tones: &[Tracks],
    (every, count): (usize, usize),
) -> AreaFrames {
    AreaFrames {
        values: listener.frames(tones, every, count),
        places: grid.places.iter().map(|place| place.0).collect(),
        x_m: grid.x_m,
        y_m: grid.y_m,
    }
}
