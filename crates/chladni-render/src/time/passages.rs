//! The drive of a chain of places: how it rises, passes from one to the next, and falls.

use crate::time::envelope::{Edge, Envelope, Ramp, Travel};
use crate::time::plan::Chain;
use crate::time::program_ramp::program_ends;
use crate::time::simulate::Motion;
use crate::time::table::Ramps;
use crate::time::tracks::{Track, Tracks};
use crate::time::voice::Voice;
use crate::tolerances;
use crate::zones::{Ground, ZoneMap};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::PI;

impl Voice {
    /// The drive of a chain; `maps` are the zones of every place.
    ///
    /// A pattern is turned so that its field has the phase of the one before, because two
    /// that sound at once are to add, and in a fade by at most a right angle more, so that
    /// ground which is cold under both stays quiet. A moving spot rises and falls by modal
    /// ramps where programs are asked for.
    pub(crate) fn tracks(&self, chain: &Chain, ramps: Ramps, maps: &[ZoneMap]) -> Vec<Track> {
        let turns = self.turns(chain, ramps, maps);
        let track = |k: usize, rise: Edge, fall: Edge, sign: f64, corrected: bool| {
            let turned = |rows: &Array2<Complex64>| {
                rows.index_axis(Axis(0), chain.stops[k])
                    .mapv(|value| value * turns[k] * sign)
            };
            Track {
                pattern: turned(&self.patterns),
                correction: corrected.then(|| turned(&self.corrections)),
                envelope: Envelope::Gate { rise, fall },
            }
        };
        let last = chain.stops.len() - 1;
        if let Some(moving) = &chain.moving {
            let travel = Travel {
                start_s: chain.ramps[0].end_s(),
                duration_s: moving.travel_s(),
                last,
            };
            let keyframe = |k: usize| Track {
                envelope: Envelope::Keyframe {
                    number: k,
                    travel,
                    rise: Edge::Cosine(chain.ramps[0]),
                    fall: Edge::Cosine(chain.ramps[last + 1]),
                },
                ..track(k, Edge::NEVER, Edge::NEVER, 1.0, ramps != Ramps::Plain)
            };
            return (0..=last).map(keyframe).collect();
        }
        let ends = (ramps == Ramps::Program).then(|| {
            let end = |k: usize| (chain.stops[k], turns[k], &maps[chain.stops[k]]);
            program_ends(self, chain, [end(0), end(last)])
        });
        let mut tracks = Vec::new();
        for k in 0..=last {
            let (mut rise, mut fall) = (
                Edge::Cosine(chain.ramps[k]),
                Edge::Cosine(chain.ramps[k + 1]),
            );
            if let Some(ends) = &ends {
                if k == 0 {
                    rise = ends.rise;
                }
                if k == last {
                    fall = ends.fall;
                }
            }
            let corrected = ramps != Ramps::Plain;
            match (rise, fall) {
                (Edge::Splines { .. }, Edge::Splines { .. }) => {
                    tracks.push(track(k, rise, fall, 1.0, false))
                }
                (Edge::Cosine(_), Edge::Cosine(_)) => {
                    tracks.push(track(k, rise, fall, 1.0, corrected))
                }
                // a program brings its own correction
                _ => {
                    let by_program = |edge| matches!(edge, Edge::Splines { .. });
                    tracks.push(track(k, rise, Edge::NEVER, 1.0, !by_program(rise)));
                    tracks.push(track(k, fall, Edge::NEVER, -1.0, !by_program(fall)));
                }
            }
        }
        tracks.extend(ends.into_iter().flat_map(|ends| ends.tracks));
        tracks
    }

    /// The phase of each stop.
    fn turns(&self, chain: &Chain, ramps: Ramps, maps: &[ZoneMap]) -> Vec<Complex64> {
        let mut turn = Complex64::ONE;
        let mut turns = vec![turn];
        for (k, pair) in chain.stops.windows(2).enumerate() {
            let (before, here) = (pair[0], pair[1]);
            turn *= self.aligned(before, here);
            if chain.moving.is_none() {
                let fade_s = chain.ramps[k + 1].duration_s;
                turn *= self.quietest([before, here], turn / turns[k], fade_s, ramps, maps);
            }
            turns.push(turn);
        }
        turns
    }

    /// The phase by which the field of a place follows that of another one.
    fn aligned(&self, before: usize, here: usize) -> Complex64 {
        let (before, here) = (self.steady.column(before), self.steady.column(here));
        let inner: Complex64 = here.iter().zip(before).map(|(h, b)| h.conj() * b).sum();
        match inner.norm() {
            0.0 => Complex64::ONE,
            size => inner / size,
        }
    }

    /// The turn beyond `aligned` under which cold ground moves least while one place fades
    /// into the other, and after that: what is cold under both, then under the new one.
    fn quietest(
        &self,
        [before, here]: [usize; 2],
        aligned: Complex64,
        fade_s: f64,
        ramps: Ramps,
        maps: &[ZoneMap],
    ) -> Complex64 {
        let positions = &self.operator.positions_m;
        let is_cold = |place: usize, row: usize| {
            let ground = maps[place].classify(positions[row]);
            ground == Ground::Cold
        };
        let cold: Vec<usize> = (0..positions.len())
            .filter(|&row| is_cold(here, row))
            .collect();
        let in_both: Vec<bool> = cold.iter().map(|&row| is_cold(before, row)).collect();
        let step_s = tolerances::JUDGE_STEP_S;
        let count = ((fade_s + tolerances::JUDGED_BEYOND_S) / step_s).ceil() as usize;
        let steady = self.steady.column(before).select(Axis(0), &cold);
        let risen = |place: usize| {
            self.risen(place, fade_s, ramps, count)
                .select(Axis(1), &cold)
        };
        let (goes, comes) = (&steady - &risen(before), risen(here));
        let loudest = |turn: Complex64| {
            let judged = goes.indexed_iter().zip(&comes);
            judged
                .filter(|(((k, row), _), _)| in_both[*row] || step_s * *k as f64 >= fade_s)
                .map(|((_, goes), comes)| (goes + comes * turn).norm_sqr())
                .fold(0.0, f64::max)
        };
        let steps = tolerances::FADE_TURNS as i32;
        (0..=steps)
            .flat_map(|k| [k, -k])
            .map(|k| Complex64::from_polar(1.0, 0.5 * PI * f64::from(k) / f64::from(steps)))
            .map(|turn| (turn, loudest(aligned * turn)))
            .fold((Complex64::ONE, f64::INFINITY), |best, tried| {
                if tried.1 < best.1 {
                    tried
                } else {
                    best
                }
            })
            .0
    }

    /// The responses while a place rises within `rise_s`; axes (time, response).
    fn risen(&self, place: usize, rise_s: f64, ramps: Ramps, count: usize) -> Array2<Complex64> {
        let row = |rows: &Array2<Complex64>| rows.row(place).to_owned();
        let track = Track {
            pattern: row(&self.patterns),
            correction: (ramps != Ramps::Plain).then(|| row(&self.corrections)),
            envelope: Envelope::Gate {
                rise: Edge::Cosine(Ramp {
                    start_s: 0.0,
                    duration_s: rise_s,
                }),
                fall: Edge::NEVER,
            },
        };
        let drive = self
            .sounding(vec![track])
            .sampled(tolerances::JUDGE_STEP_S, 0, count);
        Motion::new(&self.model).under(&drive)
    }

    /// These tracks as the drive of this tone.
    pub(crate) fn sounding(&self, tracks: Vec<Track>) -> Tracks {
        Tracks {
            frequency_hz: self.frequency_hz,
            tracks,
        }
    }
}
