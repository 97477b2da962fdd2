//! From a model and a scene with `[time]` to a drive, and how it does: the whole in one
//! function.

use crate::digits::hertz;
use crate::methods::options::RenderOptions;
use crate::panel::operator::{column_of, Operator};
use crate::results::evaluate::rename_field;
use crate::results::weights::Weights;
use crate::scene::scene_file::Scene;
use crate::time::auto_ramp::RampFinder;
use crate::time::check_paths::{check_cells, check_paths};
use crate::time::frames::TimeFrames;
use crate::time::indices::{is_met, said, AreaMeasures, TimeEvent, TimeIndices};
use crate::time::judge::TimeTraces;
use crate::time::listener::{Heard, Judging, Listener};
use crate::time::plan::{Chain, Event, Plan};
use crate::time::stage::{Driven, Stage};
use crate::time::table::{Level, Measure, RampTime, Ramps, TimeTable};
use crate::time::tracks::Tracks;
use crate::time::voice::Voice;
use crate::tolerances;
use chladni_frf::{Dof, Error, Finding, ModalModel, ReferenceUnit, Result};
use std::collections::HashMap;

/// Options of [`crate::play()`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlayOptions {
    /// In place of the scene's.
    pub ramps: Option<Ramps>,
    /// Options by which steady drives are found.
    pub render: RenderOptions,
    /// Judge the ground between the responses, too.
    pub area: bool,
    /// About so many pictures of the ground; 0: none.
    pub frames: usize,
    /// Hear plain ramps of the same length, too.
    pub plain: bool,
}

impl Default for PlayOptions {
    fn default() -> Self {
        Self {
            ramps: None,
            render: RenderOptions::default(),
            area: true,
            frames: 0,
            plain: false,
        }
    }
}

/// A drive over time, and how it does in the model.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct Played {
    /// One per tone, the first one's frequency first.
    pub(crate) tones: Vec<Tracks>,
    /// Actuators, in the order of the drive's channels.
    pub references: Vec<Dof>,
    /// N or V.
    pub unit: ReferenceUnit,
    /// End of the drive, s.
    pub length_s: f64,
    /// Indices in the model.
    pub indices: TimeIndices,
    /// The responses over time.
    pub traces: TimeTraces,
    /// The same under plain ramps, where they were asked for.
    pub plain: Option<TimeTraces>,
    /// Pictures of the ground, where they were asked for.
    pub frames: Option<TimeFrames>,
    /// No ground misses its limit by the measure of the scene.
    pub feasible: bool,
    /// Findings that the user must know.
    pub findings: Vec<Finding>,
}

impl Played {
    /// The sentences of what is more than a note.
    pub fn warnings(&self) -> Vec<String> {
        chladni_frf::warnings(&self.findings)
    }
}

/// The drive of a scene over time, on the panel of `model`.
///
/// * `given`: the steady drive of the scene's own zones, where it is known; all others
///   are rendered
///
/// # Errors
/// As [`crate::render`]; events that overlap, ramps that do not fit or that the model's
/// band cannot describe, a path that leaves the judged ground, cells that hold no response or
/// leave none to keep quiet, weights of other tones, of another unit, or of actuators that the
/// model lacks.
pub fn play(
    model: &ModalModel,
    scene: &Scene,
    given: Option<&Weights>,
    options: &PlayOptions,
) -> Result<Played> {
    if let Some(weights) = given {
        check_given(weights, model)?;
    }
    let table = scene.time.clone().unwrap_or_default();
    let plan = Plan::new(&table, &scene.zones)?;
    let only = scene.actuators.only.as_deref();
    let names_cells = table.bursts.iter().any(|burst| burst.hot.is_some());
    if names_cells || !table.fades.is_empty() || !table.moves.is_empty() {
        let operator = Operator::of_model(model, scene.frequency_hz, only)?;
        check_cells(&operator, scene, &table)?;
        check_paths(&operator, scene, &table, &plan)?;
    }
    let voices = voices(model, scene, &plan, given, options)?;
    let stage = Stage::new(model, scene, &table, &plan, voices)?;
    let (points, judging) = (stage.points(), stage.judging());
    let rehearsal = Rehearsal {
        stage: &stage,
        plan: &plan,
        table: &table,
        ramps: options.ramps.unwrap_or(table.ramps),
        points: &points,
        judging: &judging,
    };
    let of_voices = stage.voices.iter().flat_map(|voice| &voice.findings);
    let mut findings: Vec<Finding> = of_voices.cloned().collect();
    findings.extend(given.and_then(|weights| tones_not_played(weights, scene)));
    findings.extend(given.and_then(|weights| actuators_not_played(weights, scene)));
    let take = rehearsal.shortest(&mut findings)?;
    findings.extend(take.limited);
    let driven = take.driven;
    let area = options.area.then(|| stage.area()).flatten();
    let area = area.map(|area| area.hear(&driven.tones, &take.chains, &judging, &Measure::ALL));
    let length_s = take.chains.iter().map(Chain::end_s).fold(0.0, f64::max);
    let pictures = || stage.frames(&driven.tones, length_s, options.frames);
    let frames = (options.frames > 0).then(pictures);
    let plain = match options.plain {
        true => rehearsal.plain(&take.chains)?,
        false => None,
    };
    let events: Vec<TimeEvent> = take
        .chains
        .iter()
        .zip(&driven.gains)
        .map(|(chain, &gain)| TimeEvent::of(chain, gain))
        .collect();
    let indices = indices(&driven.heard, area.as_ref(), events, &stage);
    findings.extend(said(&indices, &table, rehearsal.ramps));
    dedup(&mut findings);
    Ok(Played {
        references: stage.voices[0].operator.references.clone(),
        unit: stage.voices[0].operator.unit,
        length_s,
        frames,
        tones: driven.tones,
        feasible: is_met(&indices, &table),
        indices,
        traces: driven.heard.traces.unwrap_or_default(),
        plain,
        findings,
    })
}

/// Refuses weights of another unit than that of the references, and those of actuators that
/// the model lacks.
fn check_given(weights: &Weights, model: &ModalModel) -> Result<()> {
    weights.check_unit(model.reference_unit)?;
    for reference in weights.driven() {
        column_of(reference, &model.references).map_err(rename_field)?;
    }
    Ok(())
}

/// The finding on actuators of the weights that the scene leaves out.
fn actuators_not_played(weights: &Weights, scene: &Scene) -> Option<Finding> {
    let used = scene.actuators.only.as_deref()?;
    let is_out = |dof: &Dof| !used.iter().any(|known| known.same_axis(*dof));
    let out: Vec<Dof> = weights.driven().into_iter().filter(is_out).collect();
    let shown = out.iter().take(tolerances::DOFS_SHOWN);
    let shown: Vec<String> = shown.map(Dof::to_string).collect();
    let more = if out.len() > shown.len() { ", ..." } else { "" };
    let words = format!(
        "the weights drive actuators that the scene leaves out: {}{more}; they are not played",
        shown.join(", ")
    );
    (!out.is_empty()).then(|| {
        Finding::caution("actuator-not-played", words)
            .dofs(out)
            .help("use the same actuators in the scene, or render its weights anew")
    })
}

/// The finding on tones of the weights that the scene does not have.
fn tones_not_played(weights: &Weights, scene: &Scene) -> Option<Finding> {
    let others: Vec<String> = weights
        .tones()
        .filter(|tone| scene.tone_at(tone.frequency_hz).is_none())
        .map(|tone| hertz(tone.frequency_hz))
        .collect();
    let words = format!(
        "the weights have a tone at {} Hz that the scene does not have: it is not played",
        others.join(", ")
    );
    (!others.is_empty())
        .then(|| Finding::caution("tone-not-played", words).help("play the scene of these weights"))
}

/// A scene whose ramps are not all known.
struct Rehearsal<'a> {
    stage: &'a Stage<'a>,
    plan: &'a Plan,
    table: &'a TimeTable,
    ramps: Ramps,
    points: &'a Listener,
    judging: &'a Judging<'a>,
}

/// The whole with ramps of some length.
struct Take {
    chains: Vec<Chain>,
    driven: Driven,
    /// Findings on what the actuators did not allow.
    limited: Vec<Finding>,
}

impl Rehearsal<'_> {
    /// The take with the least ramps that keep every limit.
    ///
    /// Each event finds its own; then all that are open grow together, because an event
    /// may hear what the one before has left.
    fn shortest(&self, findings: &mut Vec<Finding>) -> Result<Take> {
        let mut finder = RampFinder {
            voices: &self.stage.voices,
            listener: self.points,
            judging: self.judging,
            ramps: self.ramps,
            shortest_s: self.stage.shortest_s,
            lowers: self.table.level == Level::Steady,
            known: HashMap::new(),
        };
        let mut ramps_s = Vec::with_capacity(self.plan.events.len());
        let is_auto = |event: &Event| event.ramp == RampTime::Auto;
        let mut open = self.table.level == Level::Steady && self.plan.events.iter().any(is_auto);
        for event in &self.plan.events {
            let (ramp_s, passed) = finder.of(event)?;
            open &= passed;
            if !passed {
                let longest_s = event.longest_ramp_s().min(tolerances::LONGEST_AUTO_RAMP_S);
                findings.push(no_ramp(&event.name, longest_s, ramp_s, self.ramps));
            }
            ramps_s.push(ramp_s);
        }
        let stops = self.plan.events.iter().flat_map(|event| &event.stops);
        let steady_db = stops
            .map(|&stop| finder.steady_db(stop)[0])
            .fold(f64::NEG_INFINITY, f64::max);
        let allowed_db = f64::max(steady_db + tolerances::STEADY_MISS_DB, 0.0);
        let is_over = |take: &Take| {
            let cold_db = take.driven.heard.measures[1].worst_cold_db;
            cold_db.is_some_and(|level| level > allowed_db)
        };
        let mut take = self.take(&ramps_s, 0.0)?;
        let mut longer_s = tolerances::AUTO_RAMP_STEP_S;
        while open && is_over(&take) && longer_s < tolerances::LONGEST_AUTO_RAMP_S {
            match self.take(&ramps_s, longer_s) {
                Ok(longer) => take = longer,
                Err(_) => break,
            }
            longer_s += tolerances::AUTO_RAMP_STEP_S;
        }
        Ok(take)
    }

    /// The responses when the same chains come and go by plain ramps.
    fn plain(&self, chains: &[Chain]) -> Result<Option<TimeTraces>> {
        let (points, judging) = (self.points, self.judging);
        let mut limited = Vec::new();
        let driven = self
            .stage
            .drive(chains, Ramps::Plain, points, judging, &mut limited)?;
        Ok(driven.heard.traces)
    }

    /// With ramps that are so much longer than `ramps_s` where the scene leaves them open.
    fn take(&self, ramps_s: &[f64], longer_s: f64) -> Result<Take> {
        let chains = self.plan.chains(|number, event| match event.ramp {
            RampTime::Auto => f64::min(ramps_s[number] + longer_s, event.longest_ramp_s()),
            RampTime::Seconds(seconds) => seconds,
        })?;
        let mut limited = Vec::new();
        let driven =
            self.stage
                .drive(&chains, self.ramps, self.points, self.judging, &mut limited)?;
        Ok(Take {
            chains,
            driven,
            limited,
        })
    }
}

fn indices(
    heard: &Heard,
    area: Option<&Heard>,
    events: Vec<TimeEvent>,
    stage: &Stage,
) -> TimeIndices {
    // of each place and actuator, all tones together
    let sizes = |voice: &Voice| voice.patterns.mapv(|value| value.norm());
    let steady = stage
        .voices
        .iter()
        .map(sizes)
        .reduce(|sum, tone| sum + tone);
    TimeIndices {
        summed: heard.measures[0],
        peak: heard.measures[1],
        rms: heard.measures[2],
        area: area.map(|area| AreaMeasures::of(&area.measures)),
        ramp_s: events.iter().map(|event| event.ramp_s).fold(0.0, f64::max),
        peak_drive: heard.peak_together,
        steady_drive: steady.iter().flatten().copied().fold(0.0, f64::max),
        events,
    }
}

fn dedup(findings: &mut Vec<Finding>) {
    let mut seen = std::collections::HashSet::new();
    findings.retain(|finding| seen.insert(finding.text.clone()));
}

fn no_ramp(event: &str, longest_s: f64, ramp_s: f64, ramps: Ramps) -> Finding {
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
    .help(match ramps {
        Ramps::Program => "take a steady drive with more margin",
        _ => "take ramps = \"program\", or a steady drive with more margin",
    })
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
                    .find(|weights| {
                        crate::scene::tones::is_same(weights.frequency_hz, tone.frequency_hz)
                    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_advice_names_the_ramps_that_are_there() {
        let help = |ramps| no_ramp("a burst", 0.05, 0.01, ramps).help;
        assert!(help(Ramps::Modal).contains("program"));
        assert!(!help(Ramps::Program).contains("program"));
    }
}
