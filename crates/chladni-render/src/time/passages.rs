//! The drive of a chain of places: how it rises, passes from one to the next, and falls.

use crate::scene::zones::ZoneMap;
use crate::time::envelope::{Edge, Envelope, Travel};
use crate::time::plan::Chain;
use crate::time::program_ramp::program_ends;
use crate::time::table::{Move, Ramps};
use crate::time::tracks::{Track, Tracks};
use crate::time::voice::Voice;
use ndarray::{Array2, Axis};
use num_complex::Complex64;

impl Voice {
    /// The drive of a chain; `maps` are the zones of every place.
    ///
    /// A pattern is turned so that its field has the phase of the one before: two that
    /// sound at once are to add. A moving spot rises and falls by modal ramps where
    /// programs are asked for.
    pub(crate) fn tracks(&self, chain: &Chain, ramps: Ramps, maps: &[ZoneMap]) -> Vec<Track> {
        let turns = self.turns(chain);
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
        let corrected = ramps != Ramps::Plain;
        if let Some(moving) = &chain.moving {
            let still = |k: usize| track(k, Edge::NEVER, Edge::NEVER, 1.0, corrected);
            return keyframes(chain, moving, still);
        }
        let ends = (ramps == Ramps::Program).then(|| {
            let end = |k: usize| (chain.stops[k], turns[k], &maps[chain.stops[k]]);
            program_ends(self, chain, [end(0), end(last)])
        });
        let mut tracks = Vec::new();
        for k in 0..=last {
            let rise = match &ends {
                Some(ends) if k == 0 => ends.rise,
                _ => Edge::Cosine(chain.ramps[k]),
            };
            let fall = match &ends {
                Some(ends) if k == last => ends.fall,
                _ => Edge::Cosine(chain.ramps[k + 1]),
            };
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
    fn turns(&self, chain: &Chain) -> Vec<Complex64> {
        let mut turn = Complex64::ONE;
        let mut turns = vec![turn];
        for pair in chain.stops.windows(2) {
            let (before, here) = (self.steady.column(pair[0]), self.steady.column(pair[1]));
            let inner: Complex64 = here.iter().zip(before).map(|(h, b)| h.conj() * b).sum();
            if inner.norm() > 0.0 {
                turn *= inner / inner.norm();
            }
            turns.push(turn);
        }
        turns
    }

    /// These tracks as the drive of this tone.
    pub(crate) fn sounding(&self, tracks: Vec<Track>) -> Tracks {
        Tracks {
            frequency_hz: self.frequency_hz,
            tracks,
        }
    }
}

/// The drive of a moving spot; `still`: the track of each keyframe before it has an
/// envelope.
fn keyframes(chain: &Chain, moving: &Move, still: impl Fn(usize) -> Track) -> Vec<Track> {
    let last = chain.stops.len() - 1;
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
        ..still(k)
    };
    (0..=last).map(keyframe).collect()
}
