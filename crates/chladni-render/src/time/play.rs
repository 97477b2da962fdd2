//! From a model and a scene with `[time]` to a drive, and how it does: the whole in one
//! function.

use crate::field::AreaGrid;
use crate::options::RenderOptions;
use crate::plane::Rectangle;
use crate::scene::Scene;
use crate::time::auto_ramp::{shortest_s, RampFinder};
use crate::time::frames::{self, TimeFrames};
use crate::time::judge::{TimeMeasure, TimeTraces};
use crate::time::listener::{Heard, Judging, Listener, ToneLimits};
use crate::time::plan::{Chain, Event, Plan};
use crate::time::signal::schroeder;
use crate::time::table::{Level, Measure, RampTime, Ramps, TimeTable};
use crate::time::timeline::zones_of;
use crate::time::tracks::Tracks;
use crate::time::voice::Voice;
use crate::tolerances;
use crate::weights::Weights;
use crate::zones::ZoneMap;
use chladni_frf::{Dof, Error, ErrorKind, Finding, ModalModel, ReferenceUnit, Result};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Options of [`play`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlayOptions {
    /// In place of the scene's.
    pub ramps: Option<Ramps>,
    /// How steady drives are found.
    pub render: RenderOptions,
    /// Judge the ground between the responses, too.
    pub area: bool,
    /// About so many pictures of the ground; 0: none.
    pub frames: usize,
}

impl Default for PlayOptions {
    fn default() -> Self {
        Self {
            ramps: None,
            render: RenderOptions::default(),
            area: true,
            frames: 0,
        }
    }
}

/// A drive over time, and how it does in the model.
#[derive(Debug, Clone)]
#[must_use]
pub struct Played {
    /// One per tone, the first one's frequency first.
    pub(crate) tones: Vec<Tracks>,
    /// Actuators, in the order of the drive's channels.
    pub references: Vec<Dof>,
    /// N or V.
    pub unit: ReferenceUnit,
    /// Where the drive ends, s.
    pub length_s: f64,
    /// Indices in the model.
    pub indices: TimeIndices,
    /// The responses over time.
    pub traces: TimeTraces,
    /// Pictures of the ground, where they were asked for.
    pub frames: Option<TimeFrames>,
    /// No ground misses its limit by the measure of the scene.
    pub feasible: bool,
    /// What the user must know.
    pub findings: Vec<Finding>,
}

impl Played {
    /// The sentences of what is more than a note.
    pub fn warnings(&self) -> Vec<String> {
        chladni_frf::warnings(&self.findings)
    }
}

/// How the ground does in time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeIndices {
    /// By the energy that touch adds up; at the responses, as the next two.
    pub summed: TimeMeasure,
    /// At each instant.
    pub peak: TimeMeasure,
    /// By the root mean square over a sliding window.
    pub rms: TimeMeasure,
    /// The same on a grid between the responses; `None` where they carry no area.
    pub area: Option<AreaMeasures>,
    /// The longest ramp, s.
    pub ramp_s: f64,
    /// Largest |a_i| at any instant, N or V.
    pub peak_drive: f64,
    /// The same of the steady drives.
    pub steady_drive: f64,
    /// What happened when.
    pub events: Vec<TimeEvent>,
}

/// The measures over ground between the responses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AreaMeasures {
    /// By the energy that touch adds up.
    pub summed: TimeMeasure,
    /// At each instant.
    pub peak: TimeMeasure,
    /// By the root mean square over a sliding window.
    pub rms: TimeMeasure,
}

/// One event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeEvent {
    /// Its table in the scene.
    pub event: String,
    /// First and last instant, s.
    pub start_s: f64,
    /// See `start_s`.
    pub end_s: f64,
    /// Rise and fall, s.
    pub ramp_s: f64,
    /// Factor on the steady drive, by the level that was asked for.
    pub gain: f64,
}

/// The drive of a scene over time, on the panel of `model`.
///
/// * `given`: the steady drive of the scene's own zones, where it is known; all others
///   are rendered
///
/// # Errors
/// As [`crate::render`]; events that overlap, ramps that do not fit or that the model's
/// band cannot describe, a path that leaves the judged ground, weights of other tones.
pub fn play(
    model: &ModalModel,
    scene: &Scene,
    given: Option<&Weights>,
    options: &PlayOptions,
) -> Result<Played> {
    let table = scene.time.clone().unwrap_or_default();
    let ramps = options.ramps.unwrap_or(table.ramps);
    let plan = Plan::new(&table, &scene.zones)?;
    let voices = voices(model, scene, &plan, given, options)?;
    let stage = Stage::new(model, scene, &table, &plan, voices)?;
    let points = stage.points();
    let judging = stage.judging();
    let mut finder = RampFinder {
        voices: &stage.voices,
        listener: &points,
        judging: &judging,
        ramps,
        shortest_s: stage.shortest_s,
        known: HashMap::new(),
    };
    let mut findings: Vec<Finding> = Vec::new();
    for voice in &stage.voices {
        findings.extend(voice.findings.iter().cloned());
    }
    let mut ramps_s = Vec::with_capacity(plan.events.len());
    let is_auto = |event: &Event| event.ramp == RampTime::Auto;
    let mut open = table.level == Level::Steady && plan.events.iter().any(is_auto);
    for event in &plan.events {
        let (ramp_s, passed) = finder.of(event)?;
        open &= passed;
        if !passed {
            let longest_s = event.longest_ramp_s().min(tolerances::LONGEST_AUTO_RAMP_S);
            findings.push(no_ramp(&event.name, longest_s, ramp_s));
        }
        ramps_s.push(ramp_s);
    }
    let stops = plan.events.iter().flat_map(|event| &event.stops);
    let steady_db = stops
        .map(|&stop| finder.steady_db(stop)[0])
        .fold(f64::NEG_INFINITY, f64::max);
    let allowed_db = f64::max(steady_db + tolerances::STEADY_MISS_DB, 0.0);
    let make = |longer_s: f64| -> Result<_> {
        let chains = plan.chains(|number, event| match event.ramp {
            RampTime::Auto => f64::min(ramps_s[number] + longer_s, event.longest_ramp_s()),
            RampTime::Seconds(seconds) => seconds,
        })?;
        let mut limited = Vec::new();
        let (tones, gains) = stage.drive(&chains, ramps, &points, &judging, &mut limited)?;
        let heard = points.hear(&tones, &chains, &judging, &Measure::ALL);
        Ok((chains, tones, gains, heard, limited))
    };
    let over = |heard: &Heard| {
        let cold_db = heard.measures[1].worst_cold_db;
        cold_db.is_some_and(|level| level > allowed_db)
    };
    // an event may hear what the one before has left: ramps that are open grow together
    let mut made = make(0.0)?;
    let mut longer_s = tolerances::AUTO_RAMP_STEP_S;
    while open && over(&made.3) && longer_s < tolerances::LONGEST_AUTO_RAMP_S {
        match make(longer_s) {
            Ok(longer) => made = longer,
            Err(_) => break,
        }
        longer_s += tolerances::AUTO_RAMP_STEP_S;
    }
    let (chains, tones, gains, heard, limited) = made;
    findings.extend(limited);
    let area = match options.area {
        true => stage.area(),
        false => None,
    }
    .map(|area| area.hear(&tones, &chains, &judging, &Measure::ALL));
    let length_s = chains.iter().map(Chain::end_s).fold(0.0, f64::max);
    let frames = (options.frames > 0).then(|| stage.frames(&tones, length_s, options.frames));
    let events = chains
        .iter()
        .zip(&gains)
        .map(|(chain, &gain)| TimeEvent {
            event: chain.name.clone(),
            start_s: chain.start_s(),
            end_s: chain.end_s(),
            ramp_s: chain.ramp_s,
            gain,
        })
        .collect();
    let indices = indices(&heard, area.as_ref(), events, &stage);
    let feasible = is_met(&indices, &table);
    findings.extend(said(&indices, &table));
    dedup(&mut findings);
    Ok(Played {
        references: stage.voices[0].operator.references.clone(),
        unit: stage.voices[0].operator.unit,
        length_s,
        frames,
        tones,
        indices,
        traces: heard.traces.unwrap_or_default(),
        feasible,
        findings,
    })
}

fn dedup(findings: &mut Vec<Finding>) {
    let mut seen = std::collections::HashSet::new();
    findings.retain(|finding| seen.insert(finding.text.clone()));
}

fn no_ramp(event: &str, longest_s: f64, ramp_s: f64) -> Finding {
    Finding::caution(
        "time-no-ramp",
        format!(
            "{event}: no ramp up to {:.0} ms keeps every limit at every instant; {:.0} ms come \
             nearest",
            1e3 * longest_s,
            1e3 * ramp_s
        ),
    )
    .value("ramp_s", ramp_s)
    .help("take ramps = \"program\", or a steady drive with more margin")
}

fn too_strong(event: &str, unit: ReferenceUnit, asked: f64, allowed: f64) -> Finding {
    Finding::caution(
        "time-force-limited",
        format!(
            "{event} is limited by the actuators: it would take {asked:.3e} {unit} and has \
             {allowed:.3e}"
        ),
    )
    .value("asked", asked)
    .value("allowed", allowed)
    .help("take longer ramps, or raise the limit of the actuators")
}

/// The tones of a scene with the steady drives of all places.
fn voices(
    model: &ModalModel,
    scene: &Scene,
    plan: &Plan,
    given: Option<&Weights>,
    options: &PlayOptions,
) -> Result<Vec<Voice>> {
    let tone = |tone: &Scene| {
        let of_tone = match given {
            None => None,
            Some(weights) => Some(
                weights
                    .tones()
                    .find(|weights| crate::tones::is_same(weights.frequency_hz, tone.frequency_hz))
                    .ok_or_else(|| {
                        Error::bad_data("the weights are for another frequency")
                            .field("frequency_hz")
                            .found(format!("{} Hz", weights.frequency_hz))
                            .expected(format!("{} Hz, as the scene says", tone.frequency_hz))
                    })?,
            ),
        };
        Voice::new(model, tone, &plan.places, of_tone, &options.render)
    };
    scene.tones().iter().map(tone).collect()
}

/// All that is known before a drive is made.
struct Stage<'a> {
    scene: &'a Scene,
    table: &'a TimeTable,
    voices: Vec<Voice>,
    maps: Vec<ZoneMap>,
    scanned: Rectangle,
    limits: Vec<ToneLimits>,
    shortest_s: f64,
}

impl<'a> Stage<'a> {
    fn new(
        model: &ModalModel,
        scene: &'a Scene,
        table: &'a TimeTable,
        plan: &Plan,
        voices: Vec<Voice>,
    ) -> Result<Self> {
        let positions = &voices[0].operator.positions_m;
        let scanned = Rectangle::around(positions)
            .ok_or_else(|| Error::new(ErrorKind::Internal, "an operator without responses"))?;
        let maps: Vec<ZoneMap> = plan
            .places
            .iter()
            .map(|place| zones_of(place, &scene.zones).over(scanned))
            .collect();
        let area = scene.zones.area_m.map_or(scanned, Rectangle::from_array);
        for (number, moving) in table.moves.iter().enumerate() {
            if let Some(outside) = moving.path_m.iter().find(|point| !area.contains(**point)) {
                return Err(Error::bad_data("the path leaves the ground that is judged")
                    .at_line(moving.line)
                    .field(format!("[[time.move]] {} path_m", number + 1))
                    .found(format!("[{}, {}]", outside[0], outside[1]))
                    .expected(format!(
                        "points inside x {} to {} m, y {} to {} m",
                        area.x_min, area.x_max, area.y_min, area.y_max
                    )));
            }
        }
        let shortest = voices
            .iter()
            .map(|voice| shortest_s(model, voice.frequency_hz))
            .fold(0.0, f64::max);
        Ok(Self {
            scene,
            table,
            voices,
            maps,
            scanned,
            limits: scene
                .tones()
                .iter()
                .map(ToneLimits::of)
                .collect::<Result<_>>()?,
            shortest_s: shortest,
        })
    }

    fn judging(&self) -> Judging<'_> {
        Judging {
            zones: &self.scene.zones,
            maps: &self.maps,
            scanned: self.scanned,
            summation_s: self.table.summation_s,
        }
    }

    /// The responses.
    fn points(&self) -> Listener {
        Listener {
            positions_m: self.voices[0].operator.positions_m.clone(),
            models: self
                .voices
                .iter()
                .map(|voice| voice.model.clone())
                .collect(),
            limits: self.limits.clone(),
            touch: None,
        }
    }

    fn grid(&self) -> Option<AreaGrid> {
        AreaGrid::new(
            &self.voices[0].operator.positions_m,
            self.maps[0].area(),
            tolerances::AREA_STEP_M,
        )
    }

    /// Pictures of the ground over `length_s`.
    fn frames(&self, tones: &[Tracks], length_s: f64, wanted: usize) -> TimeFrames {
        let rhythm = frames::rhythm(length_s, wanted);
        let step_s = tolerances::JUDGE_STEP_S * rhythm.0 as f64;
        let operator = &self.voices[0].operator;
        let (first, positions) = (&self.maps[0], &operator.positions_m);
        let area = first.area();
        TimeFrames {
            step_s,
            names: operator.responses.clone(),
            ground: positions
                .iter()
                .map(|&place| first.classify(place))
                .collect(),
            responses: self.points().frames(tones, rhythm.0, rhythm.1),
            drive: frames::drives(tones, operator.references.len(), step_s, rhythm.1),
            area: self.grid().map(|grid| {
                let listener = self.at(&grid);
                frames::of_area(grid, &listener, tones, rhythm)
            }),
            hot: first.hot_outlines().to_vec(),
            area_m: [area.x_min, area.y_min, area.x_max, area.y_max],
        }
    }

    /// The ground between them; `None` where they carry none.
    fn area(&self) -> Option<Listener> {
        self.grid().map(|grid| self.at(&grid))
    }

    fn at(&self, grid: &AreaGrid) -> Listener {
        Listener {
            positions_m: grid.places.iter().map(|place| place.1).collect(),
            models: self
                .voices
                .iter()
                .map(|voice| voice.model.at(grid.interpolation()))
                .collect(),
            limits: self.limits.clone(),
            touch: None,
        }
    }

    /// The drive of every tone, and the gain of every chain.
    fn drive(
        &self,
        chains: &[Chain],
        ramps: Ramps,
        points: &Listener,
        judging: &Judging,
        findings: &mut Vec<Finding>,
    ) -> Result<(Vec<Tracks>, Vec<f64>)> {
        let mut tones: Vec<Tracks> = self
            .voices
            .iter()
            .map(|voice| voice.sounding(Vec::new()))
            .collect();
        let mut gains = Vec::with_capacity(chains.len());
        for chain in chains {
            let mut alone: Vec<Tracks> = self
                .voices
                .iter()
                .enumerate()
                .map(|(k, voice)| {
                    let turn = schroeder(k, self.voices.len());
                    voice
                        .sounding(voice.tracks(chain, ramps, judging.maps))
                        .turned(turn)
                })
                .collect();
            let heard = points.hear(
                &alone,
                std::slice::from_ref(chain),
                judging,
                &[self.table.measure, Measure::Peak],
            );
            let mut gain = match self.table.level {
                Level::Compensated => compensation(&heard),
                Level::Steady if chain.moving.is_some() => balance(&heard.measures[1]),
                Level::Steady => 1.0,
            };
            for (voice, &peak) in self.voices.iter().zip(&heard.peaks) {
                let allowed = voice.drive_limits.each / peak;
                if gain > allowed * (1.0 + tolerances::LIMIT) {
                    let most = voice.drive_limits.each;
                    let unit = voice.operator.unit;
                    findings.push(too_strong(&chain.name, unit, gain * peak, most));
                    gain = allowed;
                }
            }
            for (tone, alone) in tones.iter_mut().zip(alone.drain(..)) {
                tone.tracks.extend(alone.scaled(gain).tracks);
            }
            gains.push(gain);
        }
        Ok((tones, gains))
    }
}

/// The factor by which every hot place of a chain reaches its limit.
fn compensation(heard: &Heard) -> f64 {
    let least = heard.hot_levels[0]
        .iter()
        .flatten()
        .copied()
        .fold(f64::INFINITY, f64::min);
    if least > 0.0 && least < 1.0 {
        1.0 / least.sqrt()
    } else {
        1.0
    }
}

/// The factor that gives hot and cold ground under a moving spot the same margin, where
/// one of them misses its limit: between keyframes both are a little louder.
fn balance(peak: &TimeMeasure) -> f64 {
    match (peak.worst_cold_db, peak.worst_hot_db) {
        (Some(cold_db), Some(hot_db)) if cold_db > 0.0 || hot_db < 0.0 => {
            10f64.powf(-0.5 * (cold_db + hot_db) / 20.0)
        }
        _ => 1.0,
    }
}

fn indices(
    heard: &Heard,
    area: Option<&Heard>,
    events: Vec<TimeEvent>,
    stage: &Stage,
) -> TimeIndices {
    let steady_drive = stage
        .voices
        .iter()
        .flat_map(|voice| voice.patterns.iter().map(|value| value.norm()))
        .fold(0.0, f64::max);
    TimeIndices {
        summed: heard.measures[0],
        peak: heard.measures[1],
        rms: heard.measures[2],
        area: area.map(|area| AreaMeasures {
            summed: area.measures[0],
            peak: area.measures[1],
            rms: area.measures[2],
        }),
        ramp_s: events.iter().map(|event| event.ramp_s).fold(0.0, f64::max),
        peak_drive: heard.peaks.iter().copied().fold(0.0, f64::max),
        steady_drive,
        events,
    }
}

impl TimeIndices {
    /// The whole in a sentence, by the measure at each instant.
    pub fn sentence(&self) -> String {
        let peak = &self.peak;
        let hot = match peak.hot_reached_s {
            Some(reached_s) => format!("hot after {:.0} ms", 1e3 * reached_s),
            None => "hot ground never has its limit everywhere".into(),
        };
        let cold = match (peak.worst_cold_db, peak.ever_over_ratio > 0.0) {
            (None, _) => "cold never moves".into(),
            (Some(level), false) => format!("cold never over ({level:+.1} dB)"),
            (Some(level), true) => format!(
                "cold over by up to {level:.1} dB for {:.0} ms",
                1e3 * peak.over_s
            ),
        };
        let lengths = self.events.iter().map(|event| event.end_s - event.start_s);
        let drive_s = lengths.fold(0.0, f64::max);
        let quiet = match peak.quiet_s.map(|quiet_s| 1e3 * (quiet_s - drive_s)) {
            Some(late_ms) if late_ms <= 0.0 => {
                format!("quiet {:.0} ms before the drive ends", -late_ms)
            }
            Some(late_ms) => format!("quiet {late_ms:.0} ms after the drive ends"),
            None => "not quiet before the next event".into(),
        };
        format!("{hot}, {cold}, {quiet}")
    }

    /// By one of the measures.
    pub fn by(&self, measure: Measure) -> &TimeMeasure {
        match measure {
            Measure::Summed => &self.summed,
            Measure::Peak => &self.peak,
            Measure::Rms => &self.rms,
        }
    }
}

/// Cold ground keeps its limit by the measure; hot ground, too, or, where the drive is no
/// stronger than the steady one, at every instant of the hold.
fn is_met(indices: &TimeIndices, table: &TimeTable) -> bool {
    let cold = indices.by(table.measure).ever_over_ratio == 0.0;
    let hot = match table.level {
        Level::Steady => indices.peak.hot_held_ratio,
        Level::Compensated => indices.by(table.measure).hot_held_ratio,
    };
    cold && hot == 1.0
}

/// What is to be known of the outcome.
fn said(indices: &TimeIndices, table: &TimeTable) -> Vec<Finding> {
    let mut said = Vec::new();
    let measure = indices.by(table.measure);
    if let Some(over) = measure
        .worst_cold_db
        .filter(|_| measure.ever_over_ratio > 0.0)
    {
        said.push(
            Finding::caution(
                "time-cold-over",
                format!(
                    "cold ground is over its limit by up to {over:.1} dB ({}), {:.0} ms in all",
                    table.measure.as_str(),
                    1e3 * measure.over_s
                ),
            )
            .value("worst_cold_db", over)
            .value("over_s", measure.over_s)
            .help("take longer ramps, or ramps = \"modal\""),
        );
    }
    if table.measure != Measure::Peak && indices.peak.ever_over_ratio > 0.0 {
        let over = indices.peak.worst_cold_db.unwrap_or(0.0);
        said.push(
            Finding::caution(
                "time-cold-instants",
                format!(
                    "at some instants cold ground is over its limit by up to {over:.1} dB; summed \
                     over time it may not be felt"
                ),
            )
            .value("worst_cold_db", over)
            .help("ask for it by measure = \"peak\""),
        );
    }
    if indices.peak.hot_held_ratio < 1.0 && table.level == Level::Steady {
        let under = -indices.peak.worst_hot_db.unwrap_or(f64::NEG_INFINITY);
        said.push(
            Finding::caution(
                "time-hot-not-held",
                format!(
                    "hot ground is not held: at some instant it is {under:.1} dB below its limit"
                ),
            )
            .value("worst_hot_db", -under)
            .help("take longer ramps, or a steady drive with more margin"),
        );
    }
    if let Some(level) = indices.summed.worst_hot_db.filter(|&level| level < 0.0) {
        if table.level == Level::Steady && table.measure == Measure::Summed {
            said.push(
                Finding::caution(
                    "time-burst-short",
                    format!(
                        "the events are short for the sense of touch, which sums over {} s: hot \
                         ground stays {:.1} dB below its limit",
                        table.summation_s, -level
                    ),
                )
                .value("worst_hot_db", level)
                .help("level = \"compensated\" makes up for it"),
            );
        }
    }
    said
}
