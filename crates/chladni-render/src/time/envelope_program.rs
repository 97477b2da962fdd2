//! Ramps below 10 ms: a program over the envelopes of all actuators (theory.md, eq. 66).
//!
//! The envelopes are cubic B-splines with control points c. Splines are not negative and
//! add up to one, so that |c| ≤ F keeps |a(t)| ≤ F at every instant. Least squares of what
//! misses its limit,
//!
//! ½Σ(|v| − V_c + p)₊² + Σ(V_h + q − |v|)₊² + ½κΣ(|c| − F + r)₊² + ½ρΣ|c|²,
//!
//! over rows and times, from the drive of modal ramps by quasi-Newton steps of limited
//! memory. Rounds of them make the sum hold where limits can be kept at all: what a round
//! leaves missing becomes the p, q and r of the next one (the method of multipliers).

use crate::time::splines::Splines;
use crate::tolerances;
use ndarray::{Array2, Zip};
use num_complex::Complex64;
use std::collections::VecDeque;

/// The limits of a row at a time, in thresholds.
pub(crate) struct Asked {
    /// At most this; axes (row, time); infinite where nothing is.
    pub(crate) most: Array2<f64>,
    /// At least this; 0 where nothing is.
    pub(crate) least: Array2<f64>,
    /// The factor by which both may be missed.
    pub(crate) slack: f64,
}

impl Asked {
    /// Factor by which a row misses its limit at its worst; 1 or less: none does.
    fn worst(&self, moved: &Array2<Complex64>) -> f64 {
        let mut worst: f64 = 0.0;
        Zip::from(moved)
            .and(&self.most)
            .and(&self.least)
            .for_each(|v, most, least| {
                let size = v.norm().max(f64::MIN_POSITIVE);
                worst = worst.max(size / most).max(least / size);
            });
        worst
    }
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
    let program = Program {
        splines,
        scale: Complex64::from(unit / threshold),
        fixed,
        asked,
        limit: limit / unit,
    };
    let mut goal = Goal::new(asked, program.limit, start.dim());
    let mut reached = program.at(start.mapv(|value| value / unit));
    let mut memory = Memory::default();
    let mut best = program.kept(&reached.control);
    let mut in_vain = 0;
    for _ in 0..tolerances::PROGRAM_ROUNDS {
        program.descend(&goal, &mut reached, &mut memory);
        let found = program.kept(&reached.control);
        in_vain += 1;
        if found.0 < best.0 {
            best = found;
            in_vain = 0;
        }
        // limits that cannot be kept drive the shifts of the rounds ever further
        if best.0 <= asked.slack || in_vain == tolerances::PROGRAM_PATIENCE {
            break;
        }
        goal.shift(asked, program.limit, &reached.moved, &reached.control);
    }
    best.1 * Complex64::from(unit)
}

/// The program in units of its own.
struct Program<'a> {
    splines: &'a Splines<'a>,
    /// From a drive of these units to thresholds.
    scale: Complex64,
    fixed: &'a Array2<Complex64>,
    asked: &'a Asked,
    /// Largest |c|.
    limit: f64,
}

/// Control points, and the field that they make.
struct Reached {
    control: Array2<Complex64>,
    moved: Array2<Complex64>,
}

impl Program<'_> {
    fn field(&self, control: &Array2<Complex64>) -> Array2<Complex64> {
        self.splines.field(control) * self.scale
    }

    fn at(&self, control: Array2<Complex64>) -> Reached {
        Reached {
            moved: self.field(&control) + self.fixed,
            control,
        }
    }

    /// Control points within the limit, and the factor by which they miss what is asked.
    fn kept(&self, control: &Array2<Complex64>) -> (f64, Array2<Complex64>) {
        let control = control.mapv(|value| value * (self.limit / value.norm()).min(1.0));
        let Reached { control, moved } = self.at(control);
        (self.asked.worst(&moved), control)
    }

    /// The gradient by the control points.
    fn slope(&self, goal: &Goal, reached: &Reached) -> Array2<Complex64> {
        let [pull, strain] = goal.pulls(&reached.moved, &reached.control);
        self.splines.adjoint(&pull) * self.scale + strain
    }

    /// The steps of a round.
    fn descend(&self, goal: &Goal, reached: &mut Reached, memory: &mut Memory) {
        let mut gradient = self.slope(goal, reached);
        for _ in 0..tolerances::PROGRAM_STEPS {
            let way = memory.descent(&gradient);
            let along = self.field(&way);
            let begins = inner(&gradient, &way);
            // at the bottom, to the last digit: numbers below the normal ones tell no way
            if !(begins < 0.0 && begins.is_normal()) {
                break;
            }
            let share = goal.share(&Line {
                from: [&reached.moved, &reached.control],
                along: [&along, &way],
                begins,
            });
            let step = way * Complex64::from(share);
            let ahead = Reached {
                control: &reached.control + &step,
                moved: &reached.moved + &(along * Complex64::from(share)),
            };
            let next = self.slope(goal, &ahead);
            if !inner(&next, &next).is_finite() {
                break;
            }
            *reached = ahead;
            memory.learn(step, &next - &gradient);
            gradient = next;
        }
    }
}

/// A way from one drive to another: of the field and of the control points.
struct Line<'a> {
    from: [&'a Array2<Complex64>; 2],
    along: [&'a Array2<Complex64>; 2],
    /// Slope of the sum at its beginning.
    begins: f64,
}

/// The limits as a round sees them.
struct Goal {
    most: Array2<f64>,
    least: Array2<f64>,
    /// Of the control points.
    limit: Array2<f64>,
}

impl Goal {
    fn new(asked: &Asked, limit: f64, controls: (usize, usize)) -> Self {
        Self {
            most: asked.most.clone(),
            least: asked.least.clone(),
            limit: Array2::from_elem(controls, limit),
        }
    }

    /// The gradient by the field, and that by the control points themselves.
    fn pulls(
        &self,
        moved: &Array2<Complex64>,
        control: &Array2<Complex64>,
    ) -> [Array2<Complex64>; 2] {
        let pull = Zip::from(moved)
            .and(&self.most)
            .and(&self.least)
            .map_collect(|&v, &most, &least| pull(v, most, least));
        let strain = Zip::from(control)
            .and(&self.limit)
            .map_collect(|&c, &limit| strain(c, limit));
        [pull, strain]
    }

    /// Slope of the sum at a part of the way.
    fn slope(&self, line: &Line, share: f64) -> f64 {
        let mut sum = 0.0;
        Zip::from(line.from[0])
            .and(line.along[0])
            .and(&self.most)
            .and(&self.least)
            .for_each(|v, way, &most, &least| {
                let pull = pull(v + way * share, most, least);
                sum += pull.re * way.re + pull.im * way.im;
            });
        Zip::from(line.from[1])
            .and(line.along[1])
            .and(&self.limit)
            .for_each(|c, way, &limit| {
                let strain = strain(c + way * share, limit);
                sum += strain.re * way.re + strain.im * way.im;
            });
        sum
    }

    /// The part of the way to where the sum hardly falls any more, by secants.
    fn share(&self, line: &Line) -> f64 {
        let flat = tolerances::PROGRAM_FLAT * -line.begins;
        let at = |share: f64| [share, self.slope(line, share)];
        let secant =
            |from: [f64; 2], to: [f64; 2]| to[0] - to[1] * (to[0] - from[0]) / (to[1] - from[1]);
        let (mut from, mut to) = ([0.0, line.begins], at(1.0));
        for _ in 0..tolerances::PROGRAM_TRIES {
            if to[1] >= -flat {
                break;
            }
            let ahead = secant(from, to);
            let farthest = tolerances::PROGRAM_GROWTH * to[0];
            let reaches = ahead > to[0] && ahead < farthest;
            (from, to) = (to, at(if reaches { ahead } else { farthest }));
        }
        for _ in 0..tolerances::PROGRAM_TRIES {
            if to[1] <= flat {
                break;
            }
            let edge = tolerances::PROGRAM_EDGE * (to[0] - from[0]);
            let ahead = secant(from, to);
            let ahead = match ahead.is_finite() {
                true => ahead.clamp(from[0] + edge, to[0] - edge),
                false => 0.5 * (from[0] + to[0]),
            };
            let found = at(ahead);
            if found[1] < -flat {
                from = found;
            } else {
                to = found;
            }
        }
        to[0]
    }

    /// Asks for more where a limit is missed, and for less where one is kept again.
    fn shift(
        &mut self,
        asked: &Asked,
        limit: f64,
        moved: &Array2<Complex64>,
        control: &Array2<Complex64>,
    ) {
        Zip::from(&mut self.most)
            .and(&asked.most)
            .and(moved)
            .for_each(|most, asked, v| {
                if asked.is_finite() {
                    *most = asked - (v.norm() - *most).max(0.0);
                }
            });
        Zip::from(&mut self.least)
            .and(&asked.least)
            .and(moved)
            .for_each(|least, asked, v| {
                if *asked > 0.0 {
                    *least = asked + (*least - v.norm()).max(0.0);
                }
            });
        Zip::from(&mut self.limit)
            .and(control)
            .for_each(|most, c| *most = limit - (c.norm() - *most).max(0.0));
    }
}

/// |v|, the short way where that does not overflow.
fn size_of(v: Complex64) -> f64 {
    let square = v.norm_sqr();
    match square.is_finite() {
        true => square.sqrt(),
        false => v.norm(),
    }
}

/// The way from the limits of a row.
fn pull(v: Complex64, most: f64, least: f64) -> Complex64 {
    let size = size_of(v);
    if size > most {
        v * ((size - most) / size)
    } else if size < least {
        let way = if size > 0.0 { v / size } else { Complex64::ONE };
        way * (-2.0 * (least - size))
    } else {
        Complex64::ZERO
    }
}

/// The same of a control point, and what it costs.
fn strain(c: Complex64, limit: f64) -> Complex64 {
    let size = size_of(c).max(f64::MIN_POSITIVE);
    let over = (1.0 - limit / size).max(0.0);
    c * (tolerances::PROGRAM_FORCE * over + tolerances::PROGRAM_RIDGE)
}

/// The last steps with the changes of the gradient over them: what is known of the
/// curvature (Nocedal, Math. Comp. 35, 1980).
#[derive(Default)]
struct Memory(VecDeque<(Array2<Complex64>, Array2<Complex64>, f64)>);

impl Memory {
    fn learn(&mut self, step: Array2<Complex64>, change: Array2<Complex64>) {
        let curvature = inner(&step, &change);
        // a quotient by a number below the normal ones need not be finite
        let is_told =
            curvature > 0.0 && curvature.is_normal() && inner(&change, &change).is_normal();
        if !is_told {
            return;
        }
        if self.0.len() == tolerances::PROGRAM_MEMORY {
            self.0.pop_front();
        }
        self.0.push_back((step, change, curvature));
    }

    /// The way down.
    fn descent(&self, gradient: &Array2<Complex64>) -> Array2<Complex64> {
        let mut way = gradient.mapv(|value| -value);
        let mut shares = Vec::with_capacity(self.0.len());
        for (step, change, curvature) in self.0.iter().rev() {
            let share = inner(step, &way) / curvature;
            way.scaled_add((-share).into(), change);
            shares.push(share);
        }
        if let Some((_, change, curvature)) = self.0.back() {
            let length = curvature / inner(change, change);
            way.mapv_inplace(|value| value * length);
        }
        for ((step, change, curvature), share) in self.0.iter().zip(shares.into_iter().rev()) {
            let back = inner(change, &way) / curvature;
            way.scaled_add((share - back).into(), step);
        }
        way
    }
}

fn inner(a: &Array2<Complex64>, b: &Array2<Complex64>) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.re * b.re + a.im * b.im)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(value: f64) -> Array2<Complex64> {
        Array2::from_elem((1, 1), value.into())
    }

    #[test]
    fn a_step_of_subnormal_curvature_is_not_remembered() {
        let mut memory = Memory::default();
        memory.learn(single(1e-10), single(1e-312));
        let way = memory.descent(&single(1.0));
        assert!(way[[0, 0]].is_finite(), "{way}");
    }

    #[test]
    fn a_way_that_overflows_is_halved_and_not_followed() {
        let none = single(f64::INFINITY).mapv(|value| value.re);
        let goal = Goal {
            most: Array2::from_elem((1, 1), 1.0),
            least: Array2::zeros((1, 1)),
            limit: none,
        };
        let share = goal.share(&Line {
            from: [&single(2.0), &single(0.0)],
            along: [&single(-1e200), &single(0.0)],
            begins: -1e200,
        });
        assert!(share > 0.0 && share < 1.0, "{share}");
    }
}
