//! All that is known before a drive in time is made: the tones with the steady drives of
//! every place, the zones of each, the limits, and who listens.

use crate::panel::field::AreaGrid;
use crate::scene::plane::Rectangle;
use crate::scene::scene_file::Scene;
use crate::scene::zones::ZoneMap;
use crate::time::auto_ramp::{shortest_s, spared_db};
use crate::time::frames::{self, TimeFrames};
use crate::time::judge::TimeMeasure;
use crate::time::listener::{Heard, Judging, Listener, ToneLimits};
use crate::time::plan::{Chain, Plan};
use crate::time::table::{Level, Measure, Ramps, TimeTable};
use crate::time::timeline::maps_over;
use crate::time::tracks::{schroeder, Tracks};
use crate::time::voice::Voice;
use crate::tolerances;
use chladni_frf::{Finding, ModalModel, ReferenceUnit, Result};

/// All that is known before a drive is made.
pub(crate) struct Stage<'a> {
    scene: &'a Scene,
    table: &'a TimeTable,
    pub(crate) voices: Vec<Voice>,
    maps: Vec<ZoneMap>,
    scanned: Rectangle,
    limits: Vec<ToneLimits>,
    pub(crate) shortest_s: f64,
}

impl<'a> Stage<'a> {
    pub(crate) fn new(
        model: &ModalModel,
        scene: &'a Scene,
        table: &'a TimeTable,
        plan: &Plan,
        voices: Vec<Voice>,
    ) -> Result<Self> {
        let positions_m = &voices[0].operator.positions_m;
        let (scanned, maps) = maps_over(positions_m, plan, &scene.zones)?;
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

    pub(crate) fn judging(&self) -> Judging<'_> {
        Judging {
            zones: &self.scene.zones,
            maps: &self.maps,
            scanned: self.scanned,
            summation_s: self.table.summation_s,
        }
    }

    /// The responses.
    pub(crate) fn points(&self) -> Listener {
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
    pub(crate) fn frames(&self, tones: &[Tracks], length_s: f64, wanted: usize) -> TimeFrames {
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
                let listener = self.points().over(&grid);
                frames::of_area(grid, &listener, tones, rhythm)
            }),
            hot: first.hot_outlines().to_vec(),
            area_m: [area.x_min, area.y_min, area.x_max, area.y_max],
        }
    }

    /// The ground between them; `None` where they carry none.
    pub(crate) fn area(&self) -> Option<Listener> {
        self.grid().map(|grid| self.points().over(&grid))
    }

    /// The drive of `chains`, each as loud as its limits allow.
    pub(crate) fn drive(
        &self,
        chains: &[Chain],
        ramps: Ramps,
        points: &Listener,
        judging: &Judging,
        findings: &mut Vec<Finding>,
    ) -> Result<Driven> {
        let mut tones: Vec<Tracks> = self
            .voices
            .iter()
            .map(|voice| voice.sounding(Vec::new()))
            .collect();
        let mut gains = Vec::with_capacity(chains.len());
        let mut as_it_is = None;
        for chain in chains {
            let mut alone: Vec<Tracks> = self
                .voices
                .iter()
                .enumerate()
                .map(|(k, voice)| {
                    let turn = schroeder(k, self.voices.len());
                    voice
                        .sounding(voice.tracks(chain, ramps, judging.maps))
                        .times(turn)
                })
                .collect();
            let heard = points.hear(&alone, std::slice::from_ref(chain), judging, &Measure::ALL);
            let gain = self.gain(chain, &heard, findings);
            for (tone, alone) in tones.iter_mut().zip(alone.drain(..)) {
                tone.tracks.extend(alone.times(gain.into()).tracks);
            }
            gains.push(gain);
            as_it_is = (chains.len() == 1 && gain == 1.0).then_some(heard);
        }
        let heard = as_it_is.unwrap_or_else(|| points.hear(&tones, chains, judging, &Measure::ALL));
        Ok(Driven {
            tones,
            gains,
            heard,
        })
    }

    /// The factor on the drive of a chain that is `heard` alone: what its level asks for,
    /// as far as the limits of the actuators allow.
    fn gain(&self, chain: &Chain, heard: &Heard, findings: &mut Vec<Finding>) -> f64 {
        let peak = &heard.measures[1];
        let mut gain = match self.table.level {
            Level::Compensated => compensation(heard, self.table.measure),
            Level::Steady if chain.moving.is_some() => balance(peak),
            Level::Steady => match spared(chain, peak) {
                None => 1.0,
                Some(lower_db) => {
                    findings.push(lowered(&chain.name, lower_db));
                    10f64.powf(-lower_db / 20.0)
                }
            },
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
        gain
    }
}

/// A drive, and how the responses do under it.
pub(crate) struct Driven {
    /// Of every tone.
    pub(crate) tones: Vec<Tracks>,
    /// Of every chain.
    pub(crate) gains: Vec<f64>,
    /// By every measure.
    pub(crate) heard: Heard,
}

/// The factor by which every hot place of a chain reaches its limit.
fn compensation(heard: &Heard, measure: Measure) -> f64 {
    let by = Measure::ALL.iter().position(|&each| each == measure);
    let levels = by.map(|by| &heard.hot_levels[by]);
    let least = levels
        .into_iter()
        .flatten()
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

/// The dB that leave cold ground under a chain the margin that it is to have, where it lacks
/// some and hot ground can give them.
fn spared(chain: &Chain, peak: &TimeMeasure) -> Option<f64> {
    let over_db = peak.worst_cold_db? + chain.cold_margin_db?;
    spared_db(over_db, peak.worst_hot_db?)
}

fn lowered(event: &str, lower_db: f64) -> Finding {
    Finding::note(
        "time-lowered",
        format!(
            "{event} plays {lower_db:.2} dB below its steady drive, so that cold ground stays \
             quiet: hot responses have that to give, hot ground between them may have less"
        ),
    )
    .value("lower_db", lower_db)
    .help("see the share of ground between the responses that is held; give a longer ramp_s")
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
