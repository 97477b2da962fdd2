//! Cubic B-splines as envelopes: from their control points to the field and back.
//!
//! A spline lasts four knots; what it leaves behind decays. Both ways therefore run by the
//! recursion of each pole, forth in time for the field and back for its adjoint.

use crate::time::causal::CausalModel;
use crate::time::envelope::Envelope;
use crate::time::simulate::CubicStep;
use crate::time::tracks::Track;
use crate::tolerances;
use crate::tolerances::SUPPORT;
use chladni_linalg::{matmul, matmul_h};
use ndarray::{Array1, Array2, ArrayView1};
use num_complex::Complex64;

/// Splines on a grid of times: from control points to the field and back.
pub(crate) struct Splines<'a> {
    model: &'a CausalModel,
    /// Distance of the knots, s.
    pub(crate) knot_s: f64,
    /// Free splines.
    pub(crate) count: usize,
    /// Times from knot to knot.
    per_knot: usize,
    /// Times of the grid.
    pub(crate) times: usize,
    /// E of each pole from one time to the next.
    decays: Vec<Complex64>,
    /// The part that the first spline adds to each pole until it ends; axes (pole, time).
    kicks: Array2<Complex64>,
    /// The first spline, and its derivatives.
    shape: [Vec<f64>; 3],
}

impl<'a> Splines<'a> {
    /// Splines for ramps of `ramp_s` that shape the drive over `shaped_s`, judged over
    /// `judged_s`.
    pub(crate) fn new(model: &'a CausalModel, ramp_s: f64, shaped_s: f64, judged_s: f64) -> Self {
        let knot_s = (ramp_s / tolerances::KNOTS_PER_RAMP).max(tolerances::LEAST_KNOT_S);
        let count = (shaped_s / knot_s).round().max(SUPPORT as f64) as usize;
        let per_knot = (knot_s / tolerances::PROGRAM_STEP_S - 1e-6).ceil().max(1.0) as usize;
        let step_s = knot_s / per_knot as f64;
        let times = (judged_s / step_s).ceil() as usize + 1;
        let shape = |which: usize| {
            let spline = first(knot_s);
            let at = |j: usize| spline.at(step_s * j as f64)[which];
            (0..SUPPORT * per_knot).map(at).collect()
        };
        let poles = 0..model.poles.len();
        Self {
            model,
            knot_s,
            count,
            per_knot,
            times,
            decays: poles.map(|p| (-model.distance(p) * step_s).exp()).collect(),
            kicks: kicks(model, knot_s, per_knot),
            shape: [shape(0), shape(1), shape(2)],
        }
    }

    /// Time from sample to sample, s.
    pub(crate) fn step_s(&self) -> f64 {
        self.knot_s / self.per_knot as f64
    }

    /// The times that a spline touches while it lasts, each with its place in it.
    fn during(&self, spline: usize, length: usize) -> impl Iterator<Item = (usize, usize)> {
        let begins = spline * self.per_knot;
        let times = self.times;
        (0..length)
            .map(move |m| (begins + m, m))
            .take_while(move |&(j, _)| j < times)
    }

    /// The times of the grid, s.
    pub(crate) fn times_s(&self) -> Vec<f64> {
        let step_s = self.step_s();
        (0..self.times).map(|j| step_s * j as f64).collect()
    }

    /// The field of control points, axes (spline, actuator); axes (row, time).
    pub(crate) fn field(&self, control: &Array2<Complex64>) -> Array2<Complex64> {
        let forces = matmul(self.model.inputs.view(), control.t());
        let mut states = Array2::<Complex64>::zeros((forces.nrows(), self.times));
        for (p, mut state) in states.rows_mut().into_iter().enumerate() {
            for i in 0..self.count {
                for (j, m) in self.during(i, self.kicks.ncols()) {
                    state[j] += self.kicks[[p, m]] * forces[[p, i]];
                }
            }
            let mut z = Complex64::ZERO;
            for value in &mut state {
                z = self.decays[p] * z + *value;
                *value = z;
            }
        }
        let mut field = self.model.moved(states.view()).reversed_axes();
        for (direct, shape) in self.at_once() {
            let of_splines = matmul(direct.view(), control.t());
            for i in 0..self.count {
                for (j, m) in self.during(i, shape.len()) {
                    let size = Complex64::from(shape[m]);
                    field.column_mut(j).scaled_add(size, &of_splines.column(i));
                }
            }
        }
        field
    }

    /// The adjoint of [`Self::field`].
    pub(crate) fn adjoint(&self, pull: &Array2<Complex64>) -> Array2<Complex64> {
        let mut states = self.model.pulled(pull.view());
        let mut forces = Array2::<Complex64>::zeros((states.nrows(), self.count));
        for (p, mut state) in states.rows_mut().into_iter().enumerate() {
            let mut later = Complex64::ZERO;
            for value in state.iter_mut().rev() {
                later = self.decays[p].conj() * later + *value;
                *value = later;
            }
            for i in 0..self.count {
                for (j, m) in self.during(i, self.kicks.ncols()) {
                    forces[[p, i]] += self.kicks[[p, m]].conj() * state[j];
                }
            }
        }
        let mut control = matmul_h(self.model.inputs.view(), forces.view());
        for (direct, shape) in self.at_once() {
            let mut of_splines = Array2::zeros((pull.nrows(), self.count));
            for i in 0..self.count {
                for (j, m) in self.during(i, shape.len()) {
                    let size = Complex64::from(shape[m]);
                    of_splines.column_mut(i).scaled_add(size, &pull.column(j));
                }
            }
            control += &matmul_h(direct.view(), of_splines.view());
        }
        control.reversed_axes()
    }

    /// The parts that follow at once, and the splines that they follow.
    fn at_once(&self) -> [(&Array2<Complex64>, &[f64]); 3] {
        let [values, slopes, bends] = &self.shape;
        [
            (&self.model.direct, values),
            (&self.model.slope, slopes),
            (&self.model.bend, bends),
        ]
    }
}

/// The spline that begins at 0.
fn first(knot_s: f64) -> Envelope {
    Envelope::Spline {
        start_s: 0.0,
        knot_s,
    }
}

/// The part that a unit of force over the first spline adds to each pole from one time to
/// the next, until the spline has ended: z_j − E·z_{j−1}; axes (pole, time). Exact, since
/// splines are cubics between the times.
fn kicks(model: &CausalModel, knot_s: f64, per_knot: usize) -> Array2<Complex64> {
    let step_s = knot_s / per_knot as f64;
    let spline = first(knot_s);
    let forces: Vec<[Complex64; 2]> = (0..=SUPPORT * per_knot)
        .map(|k| spline.at(step_s * k as f64))
        .map(|[value, slope, ..]| [value.into(), slope.into()])
        .collect();
    let mut kicks = Array2::zeros((model.poles.len(), forces.len()));
    for (p, mut kick) in kicks.rows_mut().into_iter().enumerate() {
        let step = CubicStep::new(-model.distance(p), step_s);
        for j in 1..kick.len() {
            let ([before, rising], [after, then]) = (forces[j - 1], forces[j]);
            kick[j] = step.of(before, rising, after, then);
        }
    }
    kicks
}

/// Control points whose splines run nearly as `drive(t)` does: (−a₋₁ + 8a₀ − a₁)/6 about
/// the middle of each.
pub(crate) fn control_of(
    splines: &Splines,
    drive: impl Fn(f64) -> Array1<Complex64>,
) -> Array2<Complex64> {
    let mut control = Array2::zeros((splines.count, splines.model.inputs.ncols()));
    for (i, mut row) in control.rows_mut().into_iter().enumerate() {
        let middle = splines.knot_s * (i as f64 + 2.0);
        let [before, here, after] = [-1.0, 0.0, 1.0].map(|k| drive(middle + k * splines.knot_s));
        row.assign(&((here * 8.0 - before - after) / 6.0));
    }
    control
}

/// Control points as tracks from `start_s` on.
pub(crate) fn tracks_of(control: &Array2<Complex64>, start_s: f64, knot_s: f64) -> Vec<Track> {
    let track = |(i, row): (usize, ArrayView1<Complex64>)| Track {
        pattern: row.to_owned(),
        correction: None,
        envelope: Envelope::Spline {
            start_s: start_s + knot_s * i as f64,
            knot_s,
        },
    };
    control.rows().into_iter().enumerate().map(track).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::simulate::Motion;
    use crate::time::tracks::Tracks;
    use ndarray::{concatenate, Axis};

    fn model() -> CausalModel {
        let pole = |re: f64, im: f64| Complex64::new(re, im);
        let poles = [pole(-9.0, 1800.0), pole(-12.0, 2300.0)];
        let poles: Vec<_> = poles
            .iter()
            .copied()
            .chain(poles.iter().map(Complex64::conj))
            .collect();
        let some = |seed: f64| {
            move |(i, j): (usize, usize)| {
                Complex64::from_polar(1.0 + 0.1 * i as f64, seed + 1.7 * i as f64 + 0.6 * j as f64)
            }
        };
        let shapes = Array2::from_shape_fn((5, 2), some(0.7));
        CausalModel {
            carrier_rad_per_s: 1885.0,
            inputs: Array2::from_shape_fn((4, 3), some(0.1)),
            shapes: concatenate![Axis(1), shapes, shapes.mapv(|value| value.conj())],
            direct: Array2::from_shape_fn((5, 3), some(1.3)).mapv(|value| value * 1e-3),
            slope: Array2::from_shape_fn((5, 3), some(2.3)).mapv(|value| value * 1e-6),
            bend: Array2::from_shape_fn((5, 3), some(1.9)).mapv(|value| value * 1e-9),
            poles,
        }
    }

    #[test]
    fn the_adjoint_is_one() {
        let model = model();
        let splines = Splines::new(&model, 0.004, 0.016, 0.03);
        let some = |seed: f64, dim: (usize, usize)| {
            Array2::from_shape_fn(dim, |(i, j)| {
                Complex64::from_polar(1.0, seed * (3 * i + 5 * j) as f64)
            })
        };
        let control = some(0.7, (splines.count, 3));
        let pull = some(1.1, (5, splines.times));
        let inner = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> Complex64 {
            a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
        };
        let there = inner(&splines.field(&control), &pull);
        let back = inner(&control, &splines.adjoint(&pull));
        assert!(
            (there - back).norm() < 1e-10 * there.norm(),
            "{there} {back}"
        );
    }

    #[test]
    fn splines_move_the_ground_as_their_tracks_do() {
        let model = model();
        let splines = Splines::new(&model, 0.004, 0.016, 0.03);
        let control = Array2::from_shape_fn((splines.count, 3), |(i, j)| {
            Complex64::from_polar(1.0, 0.7 * (3 * i + 5 * j) as f64)
        });
        let field = splines.field(&control);
        let tracks = Tracks {
            frequency_hz: 300.0,
            tracks: tracks_of(&control, 0.0, splines.knot_s),
        };
        let fine = 2;
        let drive = tracks.sampled(splines.step_s() / fine as f64, 0, fine * splines.times);
        let moved = Motion::new(&model).under(&drive);
        let largest = field.iter().map(|v| v.norm()).fold(0.0, f64::max);
        for ((row, j), v) in field.indexed_iter() {
            let apart = (v - moved[[fine * j, row]]).norm();
            assert!(
                apart < 1e-9 * largest,
                "{row} {j}: {apart:e} of {largest:e}"
            );
        }
    }
}
