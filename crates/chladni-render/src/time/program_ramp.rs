//! Rise and fall of a chain by envelope programs.

use crate::scene::zones::{Ground, ZoneMap};
use crate::time::envelope::{Edge, Envelope, Ramp};
use crate::time::envelope_program::{solve, Asked};
use crate::time::plan::Chain;
use crate::time::simulate::Motion;
use crate::time::splines::{control_of, tracks_of, Splines};
use crate::time::tracks::{Track, Tracks};
use crate::time::voice::Voice;
use crate::tolerances;
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// The ends of a chain.
pub(crate) struct Ends {
    /// By which the first pattern comes, and the last one goes.
    pub(crate) rise: Edge,
    pub(crate) fall: Edge,
    /// The free splines of both.
    pub(crate) tracks: Vec<Track>,
}

/// A place, the phase of its pattern, and its zones.
type End<'a> = (usize, Complex64, &'a ZoneMap);

/// The programs of a chain's first and last place.
pub(crate) fn program_ends(voice: &Voice, chain: &Chain, [first, last]: [End; 2]) -> Ends {
    let [start_s, end_s] = [chain.start_s(), chain.end_s()];
    let rise_s = chain.ramps[0].duration_s;
    let fall = chain.ramps[chain.ramps.len() - 1];
    // the program may shape what is held, and no passage
    let held = |from_s: f64, to_s: f64| {
        let share = if chain.stops.len() == 1 { 0.5 } else { 1.0 };
        (share * (to_s - from_s)).clamp(0.0, tolerances::SHAPED_BEYOND_S)
    };
    let rise_beyond = held(chain.ramps[0].end_s(), chain.ramps[1].start_s);
    let fall_beyond = held(chain.ramps[chain.ramps.len() - 2].end_s(), fall.start_s);
    let rise = Program {
        voice,
        end: first,
        ramp_s: rise_s,
        beyond_s: rise_beyond,
        falls: false,
    };
    let down = Program {
        voice,
        end: last,
        ramp_s: fall.duration_s,
        beyond_s: fall_beyond,
        falls: true,
    };
    let ((up, knot_s), (down, fall_knot_s)) = rayon::join(|| rise.control(), || down.control());
    let fall_s = end_s - fall.duration_s - fall_beyond;
    let turned = |control: &Array2<Complex64>, turn: Complex64| control.mapv(|value| value * turn);
    let mut tracks = tracks_of(&turned(&up, first.1), start_s, knot_s);
    tracks.extend(tracks_of(&turned(&down, last.1), fall_s, fall_knot_s));
    Ends {
        rise: Edge::Splines {
            start_s: start_s + knot_s * up.nrows() as f64,
            knot_s,
        },
        fall: Edge::Splines {
            start_s: fall_s,
            knot_s: fall_knot_s,
        },
        tracks,
    }
}

/// A rise or a fall.
struct Program<'a> {
    voice: &'a Voice,
    end: End<'a>,
    ramp_s: f64,
    /// The part of the hold that it shapes, s.
    beyond_s: f64,
    falls: bool,
}

impl Program<'_> {
    /// Its control points and the distance of its knots.
    fn control(&self) -> (Array2<Complex64>, f64) {
        let key = (
            self.end.0,
            self.falls,
            self.ramp_s.to_bits(),
            self.beyond_s.to_bits(),
        );
        let knot_s = (self.ramp_s / tolerances::KNOTS_PER_RAMP).max(tolerances::LEAST_KNOT_S);
        // the last splines of a fall end with it
        let shaped_s = self.ramp_s + self.beyond_s - if self.falls { 3.0 * knot_s } else { 0.0 };
        if let Some(known) = self.voice.programs.known().get(&key) {
            return (known.clone(), knot_s);
        }
        let judged_s = self.ramp_s + self.beyond_s + tolerances::JUDGED_BEYOND_S;
        let splines = Splines::new(&self.voice.model, self.ramp_s, shaped_s, judged_s);
        let fixed = self.fixed(&splines);
        let asked = self.asked(&splines);
        let start = control_of(&splines, |time_s| self.modal(time_s));
        let threshold = self.voice.limits.threshold_m_per_s;
        let limit = self.voice.drive_limits.each;
        let control = solve(&splines, threshold, &fixed, &asked, limit, start);
        self.voice.programs.known().insert(key, control.clone());
        (control, knot_s)
    }

    fn pattern(&self) -> Array1<Complex64> {
        self.voice.patterns.row(self.end.0).to_owned()
    }

    /// The drive of modal ramps, from which the program starts.
    fn modal(&self, time_s: f64) -> Array1<Complex64> {
        let ramp = Ramp {
            start_s: if self.falls { self.beyond_s } else { 0.0 },
            duration_s: self.ramp_s,
        };
        let envelope = Envelope::Gate {
            rise: Edge::Cosine(ramp),
            fall: Edge::NEVER,
        };
        let [value, slope, ..] = envelope.at(time_s);
        let correction = self.voice.corrections.row(self.end.0);
        let [value, slope] = if self.falls {
            [1.0 - value, -slope]
        } else {
            [value, slope]
        };
        self.pattern() * Complex64::from(value) + &correction * Complex64::from(slope)
    }

    /// The field, in thresholds, of all that is not free: what comes after a rise, or
    /// what a fall leaves; axes (row, time).
    fn fixed(&self, splines: &Splines) -> Array2<Complex64> {
        let start_s = if self.falls {
            0.0
        } else {
            splines.knot_s * splines.count as f64
        };
        let rest = Tracks {
            frequency_hz: self.voice.frequency_hz,
            tracks: vec![Track {
                pattern: self.pattern(),
                correction: None,
                envelope: Envelope::Gate {
                    rise: Edge::Splines {
                        start_s,
                        knot_s: splines.knot_s,
                    },
                    fall: Edge::NEVER,
                },
            }],
        };
        let drive = rest.sampled(splines.step_s(), 0, splines.times);
        let moved = Motion::new(&self.voice.model).under(&drive);
        let moved = moved.reversed_axes();
        let scale = Complex64::from(1.0 / self.voice.limits.threshold_m_per_s);
        if !self.falls {
            return moved * scale;
        }
        let steady = self.voice.steady.column(self.end.0).insert_axis(Axis(1));
        (&steady - &moved) * scale
    }

    /// Limits with the margin that the program aims at, in thresholds.
    fn asked(&self, splines: &Splines) -> Asked {
        let (limits, map) = (&self.voice.limits, self.end.2);
        let steady = self.voice.steady.column(self.end.0);
        let positions = &self.voice.operator.positions_m;
        let db = |ratio: f64| 20.0 * ratio.log10();
        let ground: Vec<(Ground, f64)> = positions
            .iter()
            .map(|&place| (map.classify(place), map.level_at(place)))
            .collect();
        let margin_db = steady
            .iter()
            .zip(&ground)
            .filter_map(|(v, (ground, level))| match ground {
                Ground::Hot => Some(db(v.norm() / (limits.hot_m_per_s * level))),
                Ground::Cold => Some(db(limits.cold_m_per_s / v.norm())),
                Ground::Ignored => None,
            })
            .fold(f64::INFINITY, f64::min);
        let aim_db =
            (tolerances::PROGRAM_MARGIN * margin_db).clamp(0.0, tolerances::PROGRAM_MARGIN_DB);
        let factor = 10f64.powf(aim_db / 20.0);
        let slack = 10f64.powf(tolerances::PROGRAM_SLACK * aim_db / 20.0);
        let cold = limits.cold_m_per_s / limits.threshold_m_per_s / factor;
        let hot = limits.hot_m_per_s / limits.threshold_m_per_s * factor;
        let times_s = splines.times_s();
        let shape = (positions.len(), times_s.len());
        let ended = |j: usize| self.falls && times_s[j] >= self.ramp_s + self.beyond_s;
        let held = |j: usize| match self.falls {
            true => times_s[j] <= self.beyond_s + tolerances::SAME_TIME_S,
            false => times_s[j] >= self.ramp_s - tolerances::SAME_TIME_S,
        };
        Asked {
            most: Array2::from_shape_fn(shape, |(row, j)| match ground[row].0 {
                Ground::Cold => cold,
                Ground::Hot if ended(j) => cold,
                _ => f64::INFINITY,
            }),
            least: Array2::from_shape_fn(shape, |(row, j)| match ground[row] {
                (Ground::Hot, level) if held(j) => hot * level,
                _ => 0.0,
            }),
            slack,
        }
    }
}
