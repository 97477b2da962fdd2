//! Performance of a drive in time when the world is not the model: the stress table of
//! bursts, fades and moving spots.

use crate::judging::rig_draw::{worst_twentieth, Draw, StressOptions};
use crate::panel::finger::{finger_rows_of, Finger};
use crate::scene::plane::Rectangle;
use crate::scene::scene_file::Scene;
use crate::scene::zones::{Ground, ZoneMap};
use crate::time::contact::Touch;
use crate::time::judge::TimeMeasure;
use crate::time::listener::{Judging, Listener};
use crate::time::plan::{Chain, Plan};
use crate::time::play::Played;
use crate::time::table::Measure;
use crate::time::timeline::maps_over;
use crate::time::tracks::Tracks;
use crate::tolerances::{FIRMEST, STAYS_S};
use chladni_frf::{Finding, ModalModel, Mode, Result, Scaling};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// One trial in time, at the responses, at each instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeStressRow {
    /// The trial, in words.
    pub trial: String,
    /// Number of cases, each time otherwise.
    pub cases: usize,
    /// The most that cold ground is over its limit in 95 % of the cases, dB; the most of
    /// all where there are fewer than twenty.
    pub worst_cold_db: f64,
    /// The same of how far hot ground is above its limit in the hold, the least.
    pub worst_hot_db: f64,
    /// Mean share of cold ground that is ever over.
    pub ever_over_mean: f64,
    /// Mean share of hot ground that is held.
    pub hot_held_mean: f64,
}

/// The trial of the drive as it is.
const UNDISTURBED: &str = "none";

impl TimeStressRow {
    fn of(trial: &str, judged: &[TimeMeasure]) -> Option<Self> {
        let worst = |of: &dyn Fn(&TimeMeasure) -> Option<f64>| {
            worst_twentieth(judged.iter().filter_map(of).collect())
        };
        let mean = |of: &dyn Fn(&TimeMeasure) -> f64| {
            judged.iter().map(of).sum::<f64>() / judged.len() as f64
        };
        Some(Self {
            trial: trial.into(),
            cases: judged.len(),
            worst_cold_db: -worst(&|m| m.worst_cold_db.map(|level| -level))?,
            worst_hot_db: worst(&|m| m.worst_hot_db)?,
            ever_over_mean: mean(&|m| m.ever_over_ratio),
            hot_held_mean: mean(&|m| m.hot_held_ratio),
        })
    }

    /// True where no ground misses its limit.
    fn holds(&self) -> bool {
        self.worst_cold_db <= 0.0 && self.worst_hot_db >= 0.0
    }

    /// The ways in which ground misses its limit.
    fn missed(&self) -> String {
        let mut missed = Vec::new();
        if self.worst_cold_db > 0.0 {
            missed.push(format!("cold ground over by {:.1} dB", self.worst_cold_db));
        }
        if self.worst_hot_db < 0.0 {
            missed.push(format!("hot ground under by {:.1} dB", -self.worst_hot_db));
        }
        missed.join(", ")
    }
}

/// Judges a drive in time when the panel is not `model`.
///
/// # Errors
/// As [`crate::play`].
pub fn stress_in_time(
    played: &Played,
    scene: &Scene,
    model: &ModalModel,
    options: &StressOptions,
) -> Result<(Vec<TimeStressRow>, Vec<Finding>)> {
    let bench = Bench::new(played, scene, model)?;
    let mut draw = Draw::new(options.seed);
    let mut trials = vec![(UNDISTURBED.into(), vec![bench.as_it_is(&played.tones)])];
    trials.extend(bench.panels(&mut draw, options)?);
    trials.extend(bench.drives(&mut draw, options));
    let mut findings = Vec::new();
    if model.scaling == Scaling::UnitModalMass {
        trials.extend(bench.fingers(&mut draw, options));
    } else {
        findings.push(
            Finding::caution(
                "time-no-finger",
                "fingers cannot be tried in time: that needs mass-scaled modes",
            )
            .help("measure at least one driving point"),
        );
    }
    let row = |(trial, judged): &Trial| TimeStressRow::of(trial, judged);
    let rows: Vec<TimeStressRow> = trials.iter().filter_map(row).collect();
    findings.extend(fragile(&rows));
    Ok((rows, findings))
}

/// A trial in words, and how its cases do.
type Trial = (String, Vec<TimeMeasure>);

/// The trials that a drive does not hold although it is met without them.
fn fragile(rows: &[TimeStressRow]) -> Option<Finding> {
    let (none, tried) = rows
        .split_first()
        .filter(|(first, _)| first.trial == UNDISTURBED)?;
    let fails: Vec<&TimeStressRow> = tried.iter().filter(|row| !row.holds()).collect();
    if fails.is_empty() || !none.holds() {
        return None;
    }
    let list: Vec<String> = fails
        .iter()
        .map(|row| format!("{} ({})", row.trial, row.missed()))
        .collect();
    Some(
        Finding::caution(
            "time-fragile",
            format!(
                "the drive keeps its limits in the model and not under: {}",
                list.join("; ")
            ),
        )
        .list("worst_cold_db", fails.iter().map(|row| row.worst_cold_db))
        .list("worst_hot_db", fails.iter().map(|row| row.worst_hot_db))
        .help("longer ramps and a drive with more margin tolerate more"),
    )
}

/// A finger that jumps between absence and random impedances up to a firm one.
fn coming_and_going(finger: Finger, row: usize, length_s: f64, draw: &mut Draw) -> Touch {
    let mut steps = Vec::new();
    let (mut time_s, mut there) = (0.0, false);
    while time_s < length_s {
        time_s += -STAYS_S * (1.0 - draw.uniform()).ln();
        there = !there;
        let share = if there { FIRMEST * draw.uniform() } else { 0.0 };
        steps.push((time_s, share));
    }
    Touch { row, finger, steps }
}

/// The common data of all trials.
struct Bench<'a> {
    scene: &'a Scene,
    model: &'a ModalModel,
    played: &'a Played,
    chains: Vec<Chain>,
    maps: Vec<ZoneMap>,
    scanned: Rectangle,
    listener: Listener,
    summation_s: f64,
}

impl<'a> Bench<'a> {
    fn new(played: &'a Played, scene: &'a Scene, model: &'a ModalModel) -> Result<Self> {
        let table = scene.time.clone().unwrap_or_default();
        let plan = Plan::new(&table, &scene.zones)?;
        let ramps = &played.indices.events;
        let chains = plan.chains(|_, event| {
            let known = ramps.iter().find(|known| known.event == event.name);
            known.map_or(0.0, |known| known.ramp_s)
        })?;
        let listener = Listener::at_responses(model, scene)?;
        let (scanned, maps) = maps_over(&listener.positions_m, &plan, &scene.zones)?;
        Ok(Self {
            scene,
            model,
            played,
            chains,
            maps,
            scanned,
            listener,
            summation_s: table.summation_s,
        })
    }

    fn judged(&self, tones: &[Tracks], listener: &Listener) -> TimeMeasure {
        let judging = Judging {
            zones: &self.scene.zones,
            maps: &self.maps,
            scanned: self.scanned,
            summation_s: self.summation_s,
        };
        listener
            .hear(tones, &self.chains, &judging, &[Measure::Peak])
            .measures[0]
    }

    fn as_it_is(&self, tones: &[Tracks]) -> TimeMeasure {
        self.judged(tones, &self.listener)
    }

    fn with_modes(&self, mut change: impl FnMut(&mut Mode)) -> Result<TimeMeasure> {
        let mut changed = self.model.clone();
        changed.modes.iter_mut().for_each(&mut change);
        Ok(self.judged(
            &self.played.tones,
            &Listener::at_responses(&changed, self.scene)?,
        ))
    }

    fn with_gains(&self, gains: &[Complex64]) -> TimeMeasure {
        let tones: Vec<Tracks> = self
            .played
            .tones
            .iter()
            .map(|tone| tone.clone().with_gains(gains))
            .collect();
        self.as_it_is(&tones)
    }

    fn touched(&self, touch: Touch) -> TimeMeasure {
        let listener = Listener {
            touch: Some(touch),
            ..self.listener.clone()
        };
        self.judged(&self.played.tones, &listener)
    }

    /// Rows where fingers are tried: hot ground of the first place.
    fn finger_rows(&self) -> Vec<usize> {
        let positions = &self.listener.positions_m;
        let map = &self.maps[self.chains.first().map_or(0, |chain| chain.stops[0])];
        let ground: Vec<Ground> = positions.iter().map(|&place| map.classify(place)).collect();
        finger_rows_of(&ground, positions)
    }

    /// Modes that are not where the model has them.
    fn panels(&self, draw: &mut Draw, options: &StressOptions) -> Result<[Trial; 3]> {
        let fits = (0..options.draws).map(|_| self.with_modes(|mode| draw.fit_error(mode)));
        let fits = fits.collect::<Result<_>>()?;
        let drifted =
            (0..options.draws).map(|_| self.with_modes(|mode| draw.drift(mode, &options.drift)));
        let drifted = drifted.collect::<Result<_>>()?;
        let shifted = [-1.0, 1.0].map(|sign| {
            self.with_modes(|mode| mode.frequency_hz *= 1.0 + sign * options.common_shift)
        });
        let shift = format!(
            "all frequencies {} % lower or higher",
            100.0 * options.common_shift
        );
        Ok([
            ("errors of the fit".into(), fits),
            ("drift".into(), drifted),
            (shift, shifted.into_iter().collect::<Result<_>>()?),
        ])
    }

    /// Drives that are not what was asked for.
    fn drives(&self, draw: &mut Draw, options: &StressOptions) -> [Trial; 3] {
        let actuators = self.played.references.len();
        let each = |gain: f64| -> Vec<TimeMeasure> {
            let odd = |odd: usize| {
                let mut gains = vec![Complex64::ONE; actuators];
                gains[odd] = gain.into();
                self.with_gains(&gains)
            };
            (0..actuators).map(odd).collect()
        };
        let wrong = (0..options.draws).map(|_| {
            let gains: Vec<Complex64> = (0..actuators).map(|_| draw.gain(options)).collect();
            self.with_gains(&gains)
        });
        [
            ("one dead actuator".into(), each(0.0)),
            ("one reversed actuator".into(), each(-1.0)),
            (
                "amplitudes and phases of the drives".into(),
                wrong.collect(),
            ),
        ]
    }

    /// Fingers in the hot zone that stay, and that come and go.
    fn fingers(&self, draw: &mut Draw, options: &StressOptions) -> [Trial; 2] {
        let rows = self.finger_rows();
        let (finger, length_s) = (options.finger, self.played.length_s);
        let stays = |&row: &usize| {
            self.touched(Touch {
                row,
                finger,
                steps: vec![(f64::NEG_INFINITY, 1.0)],
            })
        };
        let comes = (0..options.draws * rows.len().min(1)).map(|k| {
            let row = rows[k % rows.len()];
            self.touched(coming_and_going(finger, row, length_s, draw))
        });
        [
            (
                "a finger in the hot zone".into(),
                rows.iter().map(stays).collect(),
            ),
            ("a finger that comes and goes".into(), comes.collect()),
        ]
    }
}
