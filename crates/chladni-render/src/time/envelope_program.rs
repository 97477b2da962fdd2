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

use crate::time::splines::Splines;
use crate::tolerances;
use ndarray::Array2;
use num_complex::Complex64;

/// The limits of a row at a time, in thresholds.
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
    /// The part that pulls it to its limits.
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

    /// Rise of the gradient on the way to another point, and the square of its length.
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
