//! The factor of a pattern over time, with its derivatives: raised-cosine steps, and the
//! cubic splines of an envelope program.

use crate::tolerances::EASE_S;
use std::f64::consts::PI;

/// A value with its first three derivatives by time; where one jumps, either side.
pub(crate) type Course = [f64; 4];

/// Course of an envelope that is zero.
const NOTHING: Course = [0.0; 4];
/// Course of an envelope that stays 1.
const WHOLE: Course = [1.0, 0.0, 0.0, 0.0];

fn sum(a: Course, b: Course) -> Course {
    std::array::from_fn(|k| a[k] + b[k])
}

fn difference(a: Course, b: Course) -> Course {
    std::array::from_fn(|k| a[k] - b[k])
}

/// A raised-cosine step from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ramp {
    pub(crate) start_s: f64,
    pub(crate) duration_s: f64,
}

impl Ramp {
    pub(crate) fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    fn at(&self, time_s: f64) -> Course {
        let Self {
            start_s,
            duration_s,
        } = *self;
        if time_s <= start_s {
            return NOTHING;
        }
        if time_s >= self.end_s() {
            return WHOLE;
        }
        let rate = PI / duration_s;
        let (sine, cosine) = (rate * (time_s - start_s)).sin_cos();
        [
            0.5 - 0.5 * cosine,
            0.5 * rate * sine,
            0.5 * rate.powi(2) * cosine,
            -0.5 * rate.powi(3) * sine,
        ]
    }
}

/// The course of a pattern's rise or fall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Edge {
    /// By a raised cosine.
    Cosine(Ramp),
    /// By the sum of all cubic B-splines that begin at `start_s` and later, one every
    /// `knot_s`.
    Splines { start_s: f64, knot_s: f64 },
}

impl Edge {
    /// The edge that never comes.
    pub(crate) const NEVER: Self = Self::Splines {
        start_s: f64::INFINITY,
        knot_s: 1.0,
    };

    fn span_s(&self) -> [f64; 2] {
        match *self {
            Self::Cosine(ramp) => [ramp.start_s, ramp.end_s()],
            Self::Splines { start_s, knot_s } => [start_s, start_s + 3.0 * knot_s],
        }
    }

    fn at(&self, time_s: f64) -> Course {
        match *self {
            Self::Cosine(ramp) => ramp.at(time_s),
            Self::Splines { start_s, knot_s } => spline_step((time_s - start_s) / knot_s, knot_s),
        }
    }
}

/// The level of a pattern over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Envelope {
    /// In over one edge, out over the other.
    Gate { rise: Edge, fall: Edge },
    /// A cubic B-spline over four intervals from `start_s`.
    Spline { start_s: f64, knot_s: f64 },
    /// Keyframe `number` of a travel; the first one comes over `rise`, the last one goes
    /// over `fall`.
    Keyframe {
        number: usize,
        travel: Travel,
        rise: Edge,
        fall: Edge,
    },
}

/// From keyframe 0 to the last one at a constant speed that comes and goes smoothly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Travel {
    pub(crate) start_s: f64,
    pub(crate) duration_s: f64,
    /// Number of the last keyframe.
    pub(crate) last: usize,
}

impl Travel {
    /// The position between the keyframes, with its derivatives.
    fn at(&self, time_s: f64) -> Course {
        let ease = EASE_S.min(0.5 * self.duration_s);
        // ∫ of a speed that rises from 0 to 1 over `ease` about τ = 0
        let run = |tau: f64| {
            let within = tau + 0.5 * ease;
            if within <= 0.0 {
                return NOTHING;
            }
            if within >= ease {
                return [tau, 1.0, 0.0, 0.0];
            }
            let rate = PI / ease;
            let (sine, cosine) = (rate * within).sin_cos();
            [
                0.5 * (within - sine / rate),
                0.5 - 0.5 * cosine,
                0.5 * rate * sine,
                0.5 * rate * rate * cosine,
            ]
        };
        let (begun, ended) = (
            run(time_s - self.start_s),
            run(time_s - self.start_s - self.duration_s),
        );
        let rate = self.last as f64 / self.duration_s;
        difference(begun, ended).map(|value| rate * value)
    }

    /// Weight of a keyframe, with its derivatives: cubic between them (Catmull and Rom),
    /// the first and the last one repeated beyond the ends.
    fn weight(&self, number: usize, time_s: f64) -> Course {
        let [place, speed, change, jerk] = self.at(time_s);
        let mut along = cardinal(place - number as f64);
        let beyond = [
            (number == 0).then_some(place + 1.0),
            (number == self.last).then_some(place - self.last as f64 - 1.0),
        ];
        for x in beyond.into_iter().flatten() {
            along = sum(along, cardinal(x));
        }
        let [value, slope, bend, third] = along;
        [
            value,
            slope * speed,
            bend * speed.powi(2) + slope * change,
            third * speed.powi(3) + 3.0 * bend * speed * change + slope * jerk,
        ]
    }
}

/// The cubic of Catmull and Rom about 0, with its derivatives.
fn cardinal(x: f64) -> Course {
    let (size, sign) = (x.abs(), x.signum());
    if size < 1.0 {
        [
            (1.5 * size - 2.5) * size * size + 1.0,
            sign * (4.5 * size - 5.0) * size,
            9.0 * size - 5.0,
            sign * 9.0,
        ]
    } else if size < 2.0 {
        [
            ((2.5 - 0.5 * size) * size - 4.0) * size + 2.0,
            sign * ((5.0 - 1.5 * size) * size - 4.0),
            5.0 - 3.0 * size,
            sign * -3.0,
        ]
    } else {
        NOTHING
    }
}

impl Envelope {
    /// First and last time at which it is not zero, s.
    pub(crate) fn span_s(&self) -> [f64; 2] {
        match self {
            Self::Gate { rise, fall } => [rise.span_s()[0], fall.span_s()[1]],
            Self::Spline { start_s, knot_s } => [*start_s, start_s + 4.0 * knot_s],
            Self::Keyframe {
                number,
                travel,
                rise,
                fall,
            } => {
                let interval_s = travel.duration_s / travel.last as f64;
                let at = |number: f64| travel.start_s + interval_s * number;
                let [from, to] = [*number as f64 - 2.5, *number as f64 + 2.5];
                [
                    if *number == 0 {
                        rise.span_s()[0]
                    } else {
                        at(from)
                    },
                    if *number == travel.last {
                        fall.span_s()[1]
                    } else {
                        at(to)
                    },
                ]
            }
        }
    }

    /// Value and derivatives.
    pub(crate) fn at(&self, time_s: f64) -> Course {
        match self {
            Self::Gate { rise, fall } => difference(rise.at(time_s), fall.at(time_s)),
            Self::Spline { start_s, knot_s } => spline((time_s - start_s) / knot_s, *knot_s),
            Self::Keyframe {
                number,
                travel,
                rise,
                fall,
            } => {
                let mut weight = travel.weight(*number, time_s);
                if *number == 0 {
                    weight = difference(sum(weight, rise.at(time_s)), WHOLE);
                }
                if *number == travel.last {
                    weight = difference(weight, fall.at(time_s));
                }
                weight
            }
        }
    }
}

/// The cubic B-spline on the knots 0 to 4, with its derivatives per `knot_s`.
fn spline(x: f64, knot_s: f64) -> Course {
    if !(0.0..4.0).contains(&x) {
        return NOTHING;
    }
    // (1/6)·Σ_k (−1)^k·C(4, k)·(x − k)₊³
    const SIGNED: [f64; 4] = [1.0, -4.0, 6.0, -4.0];
    let mut sums = NOTHING;
    for (k, sign) in SIGNED.iter().enumerate() {
        let left = x - k as f64;
        if left > 0.0 {
            sums[0] += sign * left.powi(3) / 6.0;
            sums[1] += sign * left.powi(2) / 2.0;
            sums[2] += sign * left;
            sums[3] += sign;
        }
    }
    [0, 1, 2, 3].map(|k| sums[k] / knot_s.powi(k as i32))
}

/// The sum of the splines that begin at 0, 1, 2, …: 1 from x = 3 on.
fn spline_step(x: f64, knot_s: f64) -> Course {
    if x <= 0.0 {
        return NOTHING;
    }
    if x >= 3.0 {
        return WHOLE;
    }
    (0..3).fold(NOTHING, |all, k| sum(all, spline(x - f64::from(k), knot_s)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_values() {
        let ramp = |start_s: f64, duration_s: f64| Ramp {
            start_s,
            duration_s,
        };
        let envelopes = [
            Envelope::Gate {
                rise: Edge::Cosine(ramp(0.0, 0.01)),
                fall: Edge::Cosine(ramp(0.03, 0.005)),
            },
            Envelope::Spline {
                start_s: 0.004,
                knot_s: 0.002,
            },
            Envelope::Gate {
                rise: Edge::Splines {
                    start_s: 0.001,
                    knot_s: 0.003,
                },
                fall: Edge::Cosine(ramp(0.02, 0.01)),
            },
            Envelope::Keyframe {
                number: 1,
                travel: Travel {
                    start_s: 0.005,
                    duration_s: 0.03,
                    last: 3,
                },
                rise: Edge::NEVER,
                fall: Edge::NEVER,
            },
        ];
        for envelope in envelopes {
            for k in 0..400 {
                let (t, h) = (1e-4 * f64::from(k) + 3.3e-5, 1e-8);
                let [before, here, after] = [t - h, t, t + h].map(|t| envelope.at(t));
                let slope = (after[0] - before[0]) / (2.0 * h);
                let bend = (after[1] - before[1]) / (2.0 * h);
                assert!(
                    (slope - here[1]).abs() < 1e-4 * 500.0,
                    "{envelope:?} at {t}"
                );
                assert!((bend - here[2]).abs() < 1e-3 * 5e5, "{envelope:?} at {t}");
                let third = (after[2] - before[2]) / (2.0 * h);
                assert!((third - here[3]).abs() < 1e-2 * 5e8, "{envelope:?} at {t}");
            }
        }
    }

    #[test]
    fn keyframes_add_up_to_one_from_rise_to_fall() {
        let travel = Travel {
            start_s: 0.1,
            duration_s: 0.5,
            last: 4,
        };
        let edge = |start_s| {
            Edge::Cosine(Ramp {
                start_s,
                duration_s: 0.02,
            })
        };
        for k in 0..700 {
            let time_s = 1e-3 * f64::from(k);
            let all: f64 = (0..=4)
                .map(|number| {
                    let envelope = Envelope::Keyframe {
                        number,
                        travel,
                        rise: edge(0.08),
                        fall: edge(0.6),
                    };
                    envelope.at(time_s)[0]
                })
                .sum();
            let expected = edge(0.08).at(time_s)[0] - edge(0.6).at(time_s)[0];
            assert!((all - expected).abs() < 1e-12, "{time_s}: {all} {expected}");
        }
        assert!((travel.at(0.35)[0] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn splines_add_up_to_one() {
        for k in 0..100 {
            let x = 0.03 * f64::from(k);
            let all: f64 = (-3..6).map(|n| spline(x - f64::from(n), 1.0)[0]).sum();
            assert!((all - 1.0).abs() < 1e-12);
        }
        assert!((spline_step(2.999_999_9, 1.0)[0] - 1.0).abs() < 1e-12);
    }
}
