//! One tone of a play: the panel about its carrier, the steady drive of every place, and
//! how the drive passes from one to the next.

use crate::evaluate::drive_on;
use crate::methods::robust;
use crate::operator::Operator;
use crate::options::RenderOptions;
use crate::problem::{Drive, DriveLimits};
use crate::render::render;
use crate::scene::{Limits, Scene};
use crate::setup::Setup;
use crate::time::causal::CausalModel;
use crate::time::envelope::{Edge, Envelope, Travel};
use crate::time::modal_ramp::{corrected, correction};
use crate::time::plan::{Chain, Place};
use crate::time::program_ramp::{program_ends, Programs};
use crate::time::table::Ramps;
use crate::time::timeline::zones_of;
use crate::time::tracks::{Track, Tracks};
use crate::weights::Weights;
use crate::zones::ZoneMap;
use chladni_frf::{Finding, ModalModel, Result};
use ndarray::{Array2, Axis};
use num_complex::Complex64;

/// One tone.
pub(crate) struct Voice {
    pub(crate) frequency_hz: f64,
    pub(crate) operator: Operator,
    pub(crate) model: CausalModel,
    pub(crate) limits: Limits,
    pub(crate) drive_limits: DriveLimits,
    /// Steady drive of each place; axes (place, actuator).
    pub(crate) patterns: Array2<Complex64>,
    /// K times it; the same axes.
    pub(crate) corrections: Array2<Complex64>,
    /// Velocity of the responses under them; axes (response, place).
    pub(crate) steady: Array2<Complex64>,
    /// Programs that were solved.
    pub(crate) programs: Programs,
    /// What is to be known of the steady drives.
    pub(crate) findings: Vec<Finding>,
}

impl Voice {
    /// The tone of `scene`, with the steady drives of `places`.
    ///
    /// * `given`: those of the scene's own zones, where they are known
    ///
    /// # Errors
    /// As [`crate::render`].
    pub(crate) fn new(
        model: &ModalModel,
        scene: &Scene,
        places: &[Place],
        given: Option<&Weights>,
        options: &RenderOptions,
    ) -> Result<Self> {
        let mut findings = Vec::new();
        let operator =
            Operator::of_model(model, scene.frequency_hz, scene.actuators.only.as_deref())?;
        let mut patterns = Array2::zeros((places.len(), operator.references.len()));
        let mut drive_limits = None;
        let mut before: Option<Drive> = None;
        for (place, mut row) in places.iter().zip(patterns.rows_mut()) {
            let asked = match place {
                Place::Spot(spot) => Place::Spot(spot.for_passing()),
                other => other.clone(),
            };
            let there = Scene {
                zones: zones_of(&asked, &scene.zones),
                time: None,
                ..scene.clone()
            };
            let setup = || Setup::new(model, &there, &options.drift);
            let drive = match (place, given, &before) {
                (Place::Scene, Some(weights), _) => {
                    drive_limits.get_or_insert(setup()?.problem.drive_limits);
                    drive_on(&operator, weights)
                }
                (Place::Spot(_), _, Some(before)) => {
                    let setup = setup()?;
                    drive_limits.get_or_insert(setup.problem.drive_limits);
                    robust::follow(&setup, before, options.effort)?
                }
                _ => {
                    drive_limits.get_or_insert(setup()?.problem.drive_limits);
                    let weights = render(model, &there, options)?.weights;
                    if !weights.feasible {
                        findings.extend(weights.findings.iter().cloned());
                    }
                    drive_on(&operator, &weights)
                }
            };
            if matches!(place, Place::Spot(_)) {
                before = Some(drive.clone());
            }
            row.assign(&drive);
        }
        let causal = CausalModel::new(model, &operator)?;
        let corrections = corrected(&correction(&causal)?, &patterns);
        Ok(Self {
            frequency_hz: scene.frequency_hz,
            steady: causal.steady(patterns.view()),
            programs: Programs::default(),
            model: causal,
            limits: scene.limits()?,
            drive_limits: drive_limits.unwrap_or(DriveLimits {
                each: f64::INFINITY,
                effort: f64::INFINITY,
            }),
            operator,
            patterns,
            corrections,
            findings,
        })
    }

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
