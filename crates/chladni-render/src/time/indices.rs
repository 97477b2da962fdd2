//! Performance of the ground in time: the figures, the sentence, and what the user must
//! know.

use crate::time::judge::TimeMeasure;
use crate::time::plan::Chain;
use crate::time::table::{Level, Measure, Ramps, TimeTable};
use chladni_frf::Finding;
use serde::{Deserialize, Serialize};

/// Performance of the ground in time.
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
    /// Largest drive of an actuator at any instant, all tones together, N or V: the peak of
    /// the signal.
    pub peak_drive: f64,
    /// The most that the steady drives of all tones together reach; of a recording, its drive
    /// halfway between ramps, over the gain of the event.
    pub steady_drive: f64,
    /// The events and their times.
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
    /// Factor on the steady drive, by the level that was asked for; 1 for a recording whose
    /// sidecar does not tell it.
    pub gain: f64,
}

impl TimeEvent {
    /// A chain, and the factor on its steady drive.
    pub(crate) fn of(chain: &Chain, gain: f64) -> Self {
        Self {
            event: chain.name.clone(),
            start_s: chain.start_s(),
            end_s: chain.end_s(),
            ramp_s: chain.ramp_s,
            gain,
        }
    }
}

impl AreaMeasures {
    /// Of measures in the order of [`Measure::ALL`].
    pub(crate) fn of(measures: &[TimeMeasure]) -> Self {
        Self {
            summed: measures[0],
            peak: measures[1],
            rms: measures[2],
        }
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
            Some(late_ms) if late_ms.round() == 0.0 => "quiet as the drive ends".into(),
            Some(late_ms) if late_ms < 0.0 => {
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
pub(crate) fn is_met(indices: &TimeIndices, table: &TimeTable) -> bool {
    let cold = indices.by(table.measure).ever_over_ratio == 0.0;
    let hot = match table.level {
        Level::Steady => indices.peak.hot_held_ratio,
        Level::Compensated => indices.by(table.measure).hot_held_ratio,
    };
    cold && hot == 1.0
}

/// Findings on the outcome of a drive that came and went by `ramps`.
pub(crate) fn said(indices: &TimeIndices, table: &TimeTable, ramps: Ramps) -> Vec<Finding> {
    [
        cold_over(indices.by(table.measure), table.measure, ramps),
        cold_instants(&indices.peak, table),
        hot_not_held(&indices.peak, table.level),
        burst_short(indices, table),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn cold_over(judged: &TimeMeasure, measure: Measure, ramps: Ramps) -> Option<Finding> {
    let over = judged
        .worst_cold_db
        .filter(|_| judged.ever_over_ratio > 0.0)?;
    let words = format!(
        "cold ground is over its limit by up to {over:.1} dB ({}), {:.0} ms in all",
        measure.as_str(),
        1e3 * judged.over_s
    );
    let finding = Finding::caution("time-cold-over", words)
        .value("worst_cold_db", over)
        .value("over_s", judged.over_s)
        .help(match ramps {
            Ramps::Modal => "take longer ramps",
            Ramps::Plain | Ramps::Program => "take longer ramps, or ramps = \"modal\"",
        });
    Some(finding)
}

fn cold_instants(peak: &TimeMeasure, table: &TimeTable) -> Option<Finding> {
    (table.measure != Measure::Peak && peak.ever_over_ratio > 0.0).then(|| {
        let over = peak.worst_cold_db.unwrap_or(0.0);
        let words = format!(
            "at some instants cold ground is over its limit by up to {over:.1} dB; summed over \
             time it may not be felt"
        );
        Finding::caution("time-cold-instants", words)
            .value("worst_cold_db", over)
            .help(match table.level {
                Level::Steady => "ask for it by measure = \"peak\"",
                Level::Compensated => {
                    "take longer events, which need no stronger drive: measure = \"peak\" would \
                     undo level = \"compensated\""
                }
            })
    })
}

fn hot_not_held(peak: &TimeMeasure, level: Level) -> Option<Finding> {
    (peak.hot_held_ratio < 1.0 && level == Level::Steady).then(|| {
        let worst = match peak.worst_hot_db {
            Some(level) => format!("it is {:.1} dB below its limit", -level),
            None => "it does not move".into(),
        };
        let words = format!("hot ground is not held: at some instant {worst}");
        let mut finding = Finding::caution("time-hot-not-held", words)
            .help("take longer ramps, or a steady drive with more margin");
        if let Some(level) = peak.worst_hot_db {
            finding = finding.value("worst_hot_db", level);
        }
        finding
    })
}

fn burst_short(indices: &TimeIndices, table: &TimeTable) -> Option<Finding> {
    let TimeIndices { peak, summed, .. } = indices;
    let level = summed.worst_hot_db.filter(|&level| level < 0.0)?;
    let lacks = format!("hot ground stays {:.1} dB below its limit", -level);
    let touch = format!(
        "the sense of touch, which sums over {} s",
        table.summation_s
    );
    let (words, stronger) = match (table.level, table.measure) {
        (Level::Steady, Measure::Summed) => (
            format!("the events are short for {touch}: {lacks}"),
            "level = \"compensated\"",
        ),
        (Level::Compensated, Measure::Peak) => (
            format!(
                "level = \"compensated\" makes up for nothing by measure = \"peak\": for {touch}, \
                 {lacks}"
            ),
            "measure = \"summed\"",
        ),
        _ => return None,
    };
    let is_borne = |cold: &TimeMeasure| cold.worst_cold_db.is_none_or(|db| db - level <= 0.0);
    let help = match (is_borne(peak), is_borne(summed)) {
        (true, _) => format!("take longer events, or {stronger}"),
        (false, true) => format!(
            "take longer events; {stronger} makes up for it by a stronger drive, under which cold \
             ground keeps its limit summed over time, but not at each instant"
        ),
        (false, false) => "take longer events: cold ground tolerates no stronger drive".into(),
    };
    let finding = Finding::caution("time-burst-short", words).value("worst_hot_db", level);
    Some(finding.help(help))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still() -> TimeMeasure {
        TimeMeasure {
            worst_cold_db: None,
            worst_cold_s: None,
            over_s: 0.0,
            ever_over_ratio: 0.0,
            worst_hot_db: None,
            hot_held_ratio: 0.0,
            hot_reached_s: None,
            quiet_s: Some(0.1 - 1e-5),
            contrast_db: None,
        }
    }

    #[test]
    fn hot_ground_that_never_moves_has_no_level() {
        let finding = hot_not_held(&still(), Level::Steady).unwrap();
        assert!(finding.text.ends_with("it does not move"), "{finding:?}");
        assert!(finding.values.is_empty(), "{finding:?}");
    }

    #[test]
    fn a_level_that_its_measure_overrules_is_said_and_the_cost_of_a_stronger_drive() {
        let by = |worst_cold_db: f64, worst_hot_db: f64| TimeMeasure {
            worst_cold_db: Some(worst_cold_db),
            worst_hot_db: Some(worst_hot_db),
            ..still()
        };
        let told = |level, measure, cold_summed_db| {
            let indices = TimeIndices {
                peak: by(-0.1, 0.3),
                summed: by(cold_summed_db, -3.8),
                rms: still(),
                area: None,
                ramp_s: 0.01,
                peak_drive: 1.0,
                steady_drive: 1.0,
                events: Vec::new(),
            };
            let table = TimeTable {
                level,
                measure,
                ..TimeTable::default()
            };
            burst_short(&indices, &table).unwrap()
        };
        let steady = told(Level::Steady, Measure::Summed, -4.3);
        assert!(steady.help.contains("but not at each instant"));
        let overruled = told(Level::Compensated, Measure::Peak, -4.3);
        assert!(overruled.text.contains("makes up for nothing"));
        assert!(overruled.help.contains("measure = \"summed\""));
        let borne = told(Level::Steady, Measure::Summed, -3.0).help;
        assert!(!borne.contains("compensated"), "{borne}");
        let louder = TimeTable {
            level: Level::Compensated,
            ..TimeTable::default()
        };
        let loud = TimeMeasure {
            ever_over_ratio: 0.5,
            ..by(3.7, 4.1)
        };
        let help = cold_instants(&loud, &louder).unwrap().help;
        assert!(help.starts_with("take longer events"), "{help}");
    }

    #[test]
    fn nobody_is_told_to_take_the_ramps_that_were_taken() {
        let loud = TimeMeasure {
            worst_cold_db: Some(1.0),
            ever_over_ratio: 0.5,
            ..still()
        };
        for ramps in Ramps::ALL {
            let help = cold_over(&loud, Measure::Peak, ramps).unwrap().help;
            assert!(help.starts_with("take longer ramps"), "{ramps:?}: {help}");
            assert_eq!(help.contains("modal"), ramps != Ramps::Modal, "{help}");
        }
    }

    #[test]
    fn ground_that_is_quiet_as_the_drive_ends_is_not_early_by_minus_nothing() {
        let event = TimeEvent {
            event: "burst".into(),
            start_s: 0.0,
            end_s: 0.1,
            ramp_s: 0.015,
            gain: 1.0,
        };
        let indices = TimeIndices {
            summed: still(),
            peak: still(),
            rms: still(),
            area: None,
            ramp_s: 0.015,
            peak_drive: 0.0,
            steady_drive: 0.0,
            events: vec![event],
        };
        let words = indices.sentence();
        assert!(words.ends_with("quiet as the drive ends"), "{words}");
    }
}
