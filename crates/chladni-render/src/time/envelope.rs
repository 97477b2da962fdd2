//! The factor of a pattern over time, with its derivatives: raised-cosine steps, and the
//! cubic splines of an envelope program.

use std::f64::consts::PI;

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

    /// Value, first and second derivative.
    fn at(&self, time_s: f64) -> [f64; 3] {
        let Self {
            start_s,
            duration_s,
        } = *self;
        if time_s <= start_s {
            return [0.0; 3];
        }
        if time_s >= self.end_s() {
            return [1.0, 0.0, 0.0];
        }
        let rate = PI / duration_s;
        let (sine, cosine) = (rate * (time_s - start_s)).sin_cos();
        [
            0.5 - 0.5 * cosine,
            0.5 * rate * sine,
            0.5 * rate * rate * cosine,
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

    fn at(&self, time_s: f64) -> [f64; 3] {
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
    /// Time in which the speed rises, s: 1 mm of the path at 800 mm/s lies between this
    /// and a speed that jumps.
    const EASE_S: f64 = 0.01;

    /// The position between the keyframes, with its derivatives.
    fn at(&self, time_s: f64) -> [f64; 3] {
        let ease = Self::EASE_S.min(0.5 * self.duration_s);
        // ∫ of a speed that rises from 0 to 1 over `ease` about τ = 0
        let run = |tau: f64| {
            let within = tau + 0.5 * ease;
            if within <= 0.0 {
                return [0.0; 3];
            }
            if within >= ease {
                return [tau, 1.0, 0.0];
            }
            let (sine, cosine) = (PI * within / ease).sin_cos();
            [
                0.5 * (within - ease / PI * sine),
                0.5 - 0.5 * cosine,
                0.5 * PI / ease * sine,
            ]
        };
        let (begun, ended) = (
            run(time_s - self.start_s),
            run(time_s - self.start_s - self.duration_s),
        );
        let rate = self.last as f64 / self.duration_s;
        [0, 1, 2].map(|k| rate * (begun[k] - ended[k]))
    }

    /// Weight of a keyframe, with its derivatives: cubic between them (Catmull and Rom),
    /// the first and the last one repeated beyond the ends.
    fn weight(&self, number: usize, time_s: f64) -> [f64; 3] {
        let [place, speed, change] = self.at(time_s);
        let mut sum = cardinal(place - number as f64);
        let beyond = [
            (number == 0).then_some(place + 1.0),
            (number == self.last).then_some(place - self.last as f64 - 1.0),
        ];
        for x in beyond.into_iter().flatten() {
            let more = cardinal(x);
            (0..3).for_each(|k| sum[k] += more[k]);
        }
        [
            sum[0],
            sum[1] * speed,
            sum[2] * speed * speed + sum[1] * change,
        ]
    }
}

/// The cubic of Catmull and Rom about 0, with its derivatives.
fn cardinal(x: f64) -> [f64; 3] {
    let (size, sign) = (x.abs(), x.signum());
    if size < 1.0 {
        [
            (1.5 * size - 2.5) * size * size + 1.0,
            sign * (4.5 * size - 5.0) * size,
            9.0 * size - 5.0,
        ]
    } else if size < 2.0 {
        [
            ((2.5 - 0.5 * size) * size - 4.0) * size + 2.0,
            sign * ((5.0 - 1.5 * size) * size - 4.0),
            5.0 - 3.0 * size,
        ]
    } else {
        [0.0; 3]
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

    /// Value, first and second derivative.
    pub(crate) fn at(&self, time_s: f64) -> [f64; 3] {
        match self {
            Self::Gate { rise, fall } => {
                let (a, b) = (rise.at(time_s), fall.at(time_s));
                [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
            }
            Self::Spline { start_s, knot_s } => spline((time_s - start_s) / knot_s, *knot_s),
            Self::Keyframe {
                number,
                travel,
                rise,
                fall,
            } => {
                let mut sum = travel.weight(*number, time_s);
                if *number == 0 {
                    let risen = rise.at(time_s);
                    (0..3).for_each(|k| sum[k] += risen[k]);
                    sum[0] -= 1.0;
                }
                if *number == travel.last {
                    let fallen = fall.at(time_s);
                    (0..3).for_each(|k| sum[k] -= fallen[k]);
                }
                sum
            }
        }
    }
}

/// The cubic B-spline on the knots 0 to 4, with its derivatives per `knot_s`.
fn spline(x: f64, knot_s: f64) -> [f64; 3] {
    if !(0.0..4.0).contains(&x) {
        return [0.0; 3];
    }
    // (1/6)·Σ_k (−1)^k·C(4, k)·(x − k)₊³
    const SIGNED: [f64; 4] = [1.0, -4.0, 6.0, -4.0];
    let mut sums = [0.0; 3];
    for (k, sign) in SIGNED.iter().enumerate() {
        let left = x - k as f64;
        if left > 0.0 {
            sums[0] += sign * left.powi(3) / 6.0;
            sums[1] += sign * left.powi(2) / 2.0;
            sums[2] += sign * left;
        }
    }
    [sums[0], sums[1] / knot_s, sums[2] / (knot_s * knot_s)]
}

/// The sum of the splines that begin at 0, 1, 2, …: 1 from x = 3 on.
fn spline_step(x: f64, knot_s: f64) -> [f64; 3] {
    if x <= 0.0 {
        return [0.0; 3];
    }
    if x >= 3.0 {
        return [1.0, 0.0, 0.0];
    }
    (0..3).fold([0.0; 3], |sum, k| {
        let one = spline(x - f64::from(k), knot_s);
        [sum[0] + one[0], sum[1] + one[1], sum[2] + one[2]]
    })
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
            let sum: f64 = (0..=4)
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
            assert!((sum - expected).abs() < 1e-12, "{time_s}: {sum} {expected}");
        }
        assert!((travel.at(0.35)[0] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn splines_add_up_to_one() {
        for k in 0..100 {
            let x = 0.03 * f64::from(k);
            let sum: f64 = (-3..6).map(|n| spline(x - f64::from(n), 1.0)[0]).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
        assert!((spline_step(2.999_999_9, 1.0)[0] - 1.0).abs() < 1e-12);
    }
}
