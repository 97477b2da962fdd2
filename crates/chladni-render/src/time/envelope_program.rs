//! Ramps below 10 ms: a program over the envelopes of all actuators (theory.md, eq. 66).
//!
//! The envelopes are cubic B-splines with control points c. Splines are not negative and
//! add up to one, so that |c| ≤ F keeps |a(t)| ≤ F at every instant. Least squares of what
//! misses its limit,
//!
//! ½Σ(|v| − V_c)₊² + Σ(V_h − |v|)₊² + ρΣ|c|²,
//!
//! over rows and times, by accelerated projected gradients from the drive of modal ramps.
//! A convex program over the same splines (the study's oracle) finds some tenths of a
//! decibel more in a hundred times the time.

use crate::time::causal::CausalModel;
use crate::time::envelope::Envelope;
use crate::time::simulate::Step;
use crate::time::tracks::Track;
use crate::tolerances;
use chladni_linalg::{matmul, matmul_h};
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;

/// Samples of the response to a spline between two of its knots.
const FINE: usize = 16;

/// Splines on a grid of times: from control points to the field and back.
pub(crate) struct Splines<'a> {
    model: &'a CausalModel,
    /// Distance of the knots, s.
    pub(crate) knot_s: f64,
    /// Free splines.
    pub(crate) count: usize,
    /// Times from knot to knot.
    per_knot: usize,
    /// Times that are judged.
    pub(crate) times: usize,
    /// Response of each pole to the first spline; axes (pole, time).
    kernels: Array2<Complex64>,
    /// The splines at the times; axes (time, spline).
    values: Array2<Complex64>,
    /// Their derivatives.
    slopes: Array2<Complex64>,
}

impl<'a> Splines<'a> {
    /// Splines for ramps of `ramp_s` that shape the drive over `shaped_s`, judged over
    /// `judged_s`.
    pub(crate) fn new(model: &'a CausalModel, ramp_s: f64, shaped_s: f64, judged_s: f64) -> Self {
        let knot_s = (ramp_s / tolerances::KNOTS_PER_RAMP).max(tolerances::LEAST_KNOT_S);
        let count = (shaped_s / knot_s).round().max(4.0) as usize;
        let per_knot = (knot_s / tolerances::PROGRAM_STEP_S - 1e-6).ceil().max(1.0) as usize;
        let step_s = knot_s / per_knot as f64;
        let times = (judged_s / step_s).ceil() as usize + 1;
        let at = |which: usize| {
            Array2::from_shape_fn((times, count), |(j, i)| {
                let spline = Envelope::Spline {
                    start_s: knot_s * i as f64,
                    knot_s,
                };
                Complex64::from(spline.at(step_s * j as f64)[which])
            })
        };
        Self {
            model,
            knot_s,
            count,
            per_knot,
            times,
            kernels: kernels(model, knot_s, per_knot, times),
            values: at(0),
            slopes: at(1),
        }
    }

    /// Time from sample to sample, s.
    pub(crate) fn step_s(&self) -> f64 {
        self.knot_s / self.per_knot as f64
    }

    /// The field of control points, axes (spline, actuator); axes (row, time).
    fn field(&self, control: &Array2<Complex64>) -> Array2<Complex64> {
        let forces = matmul(self.model.inputs.view(), control.t());
        let mut states = Array2::<Complex64>::zeros((forces.nrows(), self.times));
        for (p, mut state) in states.rows_mut().into_iter().enumerate() {
            let kernel = self.kernels.row(p);
            for i in 0..self.count {
                let (force, first) = (forces[[p, i]], i * self.per_knot);
                if first < self.times {
                    let mut later = state.slice_mut(s![first..]);
                    later.scaled_add(force, &kernel.slice(s![..self.times - first]));
                }
            }
        }
        let mut field = self.model.moved(states.view()).reversed_axes();
        for (direct, basis) in [
            (&self.model.direct, &self.values),
            (&self.model.slope, &self.slopes),
        ] {
            let of_splines = matmul(direct.view(), control.t());
            field += &matmul(of_splines.view(), basis.t());
        }
        field
    }

    /// The adjoint of [`Self::field`].
    fn adjoint(&self, pull: &Array2<Complex64>) -> Array2<Complex64> {
        let states = self.model.pulled(pull.view());
        let mut forces = Array2::<Complex64>::zeros((states.nrows(), self.count));
        for (p, mut force) in forces.rows_mut().into_iter().enumerate() {
            let (kernel, state) = (self.kernels.row(p), states.row(p));
            for (i, sum) in force.iter_mut().enumerate() {
                let first = i * self.per_knot;
                if first < self.times {
                    *sum = kernel
                        .slice(s![..self.times - first])
                        .iter()
                        .zip(state.slice(s![first..]))
                        .map(|(kernel, state)| kernel.conj() * state)
                        .sum();
                }
            }
        }
        let mut control = matmul_h(self.model.inputs.view(), forces.view());
        for (direct, basis) in [
            (&self.model.direct, &self.values),
            (&self.model.slope, &self.slopes),
        ] {
            let of_splines = matmul(pull.view(), basis.view());
            control += &matmul_h(direct.view(), of_splines.view());
        }
        control.reversed_axes()
    }

    /// Largest square of a singular value of [`Self::field`], nearly.
    fn gain(&self) -> f64 {
        let actuators = self.model.inputs.ncols();
        let mut control = Array2::from_shape_fn((self.count, actuators), |(i, j)| {
            Complex64::from_polar(1.0, (7 * i + 3 * j) as f64)
        });
        let mut gain = 0.0;
        for _ in 0..tolerances::POWER_STEPS {
            control = self.adjoint(&self.field(&control));
            gain = norm(&control);
            if gain == 0.0 {
                return f64::MIN_POSITIVE;
            }
            control.mapv_inplace(|value| value / gain);
        }
        gain * tolerances::POWER_ROOM
    }
}

/// z of each pole under a unit of force over the first spline; axes (pole, time).
fn kernels(model: &CausalModel, knot_s: f64, per_knot: usize, times: usize) -> Array2<Complex64> {
    let fine = FINE * per_knot;
    let step_s = knot_s / fine as f64;
    let spline = Envelope::Spline {
        start_s: 0.0,
        knot_s,
    };
    let forces: Vec<f64> = (0..=4 * fine)
        .map(|k| spline.at(step_s * k as f64)[0])
        .collect();
    let mut kernels = Array2::zeros((model.poles.len(), times));
    for (p, mut kernel) in kernels.rows_mut().into_iter().enumerate() {
        let step = Step::of(-model.distance(p), step_s);
        let mut z = Complex64::ZERO;
        for k in 1..times * FINE {
            let at = |k: usize| forces.get(k).copied().unwrap_or(0.0);
            z = step.decay * z + step.last * at(k - 1) + step.next * at(k);
            if k % FINE == 0 {
                kernel[k / FINE] = z;
            }
        }
    }
    kernels
}

/// What is asked of a row at a time, in thresholds.
pub(crate) struct Asked {
    /// At most this; axes (row, time); infinite where nothing is.
    pub(crate) most: Array2<f64>,
    /// At least this; 0 where nothing is.
    pub(crate) least: Array2<f64>,
}

/// Control points that miss least, from `start`; the field of all else is `fixed`, in
/// thresholds like what is asked, and |c| at most `limit`.
pub(crate) fn solve(
    splines: &Splines,
    threshold: f64,
    fixed: &Array2<Complex64>,
    asked: &Asked,
    limit: f64,
    start: Array2<Complex64>,
) -> Array2<Complex64> {
    // thresholds instead of m/s, and a typical force of one
    let unit = start
        .iter()
        .map(|value| value.norm())
        .fold(0.0, f64::max)
        .max(f64::MIN_POSITIVE);
    let scale = unit / threshold;
    let steepest = 2.0 * splines.gain() * scale * scale;
    let ridge = tolerances::PROGRAM_RIDGE * steepest;
    let field =
        |control: &Array2<Complex64>| splines.field(control).mapv(|value| value * scale) + fixed;
    let project = |value: Complex64| {
        let (size, most) = (value.norm(), limit / unit);
        if size > most {
            value * (most / size)
        } else {
            value
        }
    };
    let control = start.mapv(|value| project(value / unit));
    let mut here = Point::of(field(&control), asked, control);
    let mut ahead = here.clone();
    let mut momentum: f64 = 1.0;
    // few places miss their limit, so that the curvature met is far below the steepest
    let mut curvature = tolerances::PROGRAM_CURVATURE * steepest;
    for _ in 0..tolerances::PROGRAM_STEPS {
        if here.missed < tolerances::PROGRAM_MISSED {
            break;
        }
        let gradient = splines.adjoint(&ahead.pull).mapv(|value| value * scale)
            + ahead.control.mapv(|value| value * ridge);
        let next = loop {
            let control = Array2::from_shape_fn(gradient.dim(), |at| {
                project(ahead.control[at] - gradient[at] / curvature)
            });
            let next = Point::of(field(&control), asked, control);
            let (along, length) = ahead.way_to(&next, &gradient);
            let bound = ahead.missed + along + 0.5 * curvature * length;
            if next.missed <= bound || curvature >= steepest {
                break next;
            }
            curvature = (tolerances::PROGRAM_STEEPER * curvature).min(steepest);
        };
        curvature *= tolerances::PROGRAM_FLATTER;
        // a step that leads up again begins anew
        if next.missed > here.missed && momentum > 1.0 {
            momentum = 1.0;
            ahead = here.clone();
            continue;
        }
        let faster = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt());
        ahead = next.beyond(&here, (momentum - 1.0) / faster, asked);
        momentum = faster;
        here = next;
    }
    here.control.mapv(|value| value * unit)
}

/// Control points, and what they come to.
#[derive(Clone)]
struct Point {
    control: Array2<Complex64>,
    /// In thresholds; axes (row, time).
    field: Array2<Complex64>,
    /// What pulls it to its limits.
    pull: Array2<Complex64>,
    missed: f64,
}

impl Point {
    fn of(field: Array2<Complex64>, asked: &Asked, control: Array2<Complex64>) -> Self {
        let mut pull = field.clone();
        let missed = missed(&mut pull, asked);
        Self {
            control,
            field,
            pull,
            missed,
        }
    }

    /// So far beyond this point on the way from `before`: the field is linear.
    fn beyond(&self, before: &Self, share: f64, asked: &Asked) -> Self {
        let on = |here: &Array2<Complex64>, before: &Array2<Complex64>| {
            here + &((here - before) * Complex64::from(share))
        };
        Self::of(
            on(&self.field, &before.field),
            asked,
            on(&self.control, &before.control),
        )
    }

    /// How far the gradient rises on the way to another point, and the square of its
    /// length.
    fn way_to(&self, other: &Self, gradient: &Array2<Complex64>) -> (f64, f64) {
        let (mut along, mut length) = (0.0, 0.0);
        ndarray::Zip::from(&self.control)
            .and(&other.control)
            .and(gradient)
            .for_each(|from, to, slope| {
                let step = to - from;
                along += (slope.conj() * step).re;
                length += step.norm_sqr();
            });
        (along, length)
    }
}

/// Turns the field into what pulls it to its limits; the sum of what was missed.
fn missed(field: &mut Array2<Complex64>, asked: &Asked) -> f64 {
    let mut sum = 0.0;
    ndarray::Zip::from(field)
        .and(&asked.most)
        .and(&asked.least)
        .for_each(|value, &most, &least| {
            let size = value.norm();
            *value = if size > most {
                sum += 0.5 * (size - most).powi(2);
                *value * ((size - most) / size)
            } else if size < least {
                sum += (least - size).powi(2);
                let way = if size > 0.0 {
                    *value / size
                } else {
                    Complex64::ONE
                };
                way * (-2.0 * (least - size))
            } else {
                Complex64::ZERO
            };
        });
    sum
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
    let track = |(i, row): (usize, ndarray::ArrayView1<Complex64>)| Track {
        pattern: row.to_owned(),
        correction: None,
        envelope: Envelope::Spline {
            start_s: start_s + knot_s * i as f64,
            knot_s,
        },
    };
    control.rows().into_iter().enumerate().map(track).collect()
}

fn norm(matrix: &Array2<Complex64>) -> f64 {
    matrix.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
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
}
