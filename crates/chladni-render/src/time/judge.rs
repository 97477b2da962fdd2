//! Judging in time: is cold ground ever over its limit, is hot ground held, and from when
//! until when.
//!
//! Ground moves at the energies e(t) = |v⁺|²/T². Three measures of it: at each instant;
//! averaged over a window that slides; and summed as touch does,
//! I(t) = (1/τ)∫e^{−(t−s)/τ}e(s)ds, so that a long tone ends at its own level
//! (theory.md, eq. 63).

use crate::scene::Limits;
use crate::time::table::Measure;
use crate::time::timeline::{Grounds, Segment};
use crate::tolerances;
use crate::zones::Ground;
use ndarray::Array2;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Performance of ground in time, by one measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimeMeasure {
    /// The most that cold ground is over its limit, dB; negative: never over. `None`
    /// where none moves.
    pub worst_cold_db: Option<f64>,
    /// Time of that, s.
    pub worst_cold_s: Option<f64>,
    /// The longest that any cold ground is over its limit, s.
    pub over_s: f64,
    /// Share of cold ground that is over its limit at any time.
    pub ever_over_ratio: f64,
    /// The least by which hot ground is over its limit while it is to be felt, dB: at any
    /// instant (peak), or at its best (summed, rms). `None` where nothing moves.
    pub worst_hot_db: Option<f64>,
    /// Share of hot ground that keeps its limit so.
    pub hot_held_ratio: f64,
    /// From when ground is to be felt, as at the beginning of a burst, until it has its
    /// limit, s: the longest of all; `None` where some never has.
    pub hot_reached_s: Option<f64>,
    /// From the beginning of an event until all ground moves by less than the cold limit
    /// for good, s: the longest of all events; `None` where another begins before.
    pub quiet_s: Option<f64>,
    /// Least hot over largest cold level, dB.
    pub contrast_db: Option<f64>,
}

/// The course of ground over time; empty where nothing of it is judged.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TimeTraces {
    /// Time from one value to the next, from 0 on, s.
    pub step_s: f64,
    /// The weakest hot ground over its limit at each instant, dB.
    pub hot_db: Vec<Option<f64>>,
    /// The loudest cold ground over its limit, dB.
    pub cold_db: Vec<Option<f64>>,
    /// Largest |a_i|, N or V.
    pub drive: Vec<f64>,
}

/// Energies of the rows over their thresholds; axes (time, row).
pub(crate) struct Energies {
    /// Of all tones together: what must be quiet.
    pub(crate) cold: Array2<f64>,
    /// Of the weakest tone, over what it owes: what must be felt.
    pub(crate) hot: Array2<f64>,
}

/// Limits of the energies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EnergyLimits {
    hot: f64,
    cold: f64,
}

impl EnergyLimits {
    /// Of a scene with `limits` whose tones share energy.
    pub(crate) fn of(limits: &Limits, share: &crate::tones::Share) -> Self {
        let squared = |velocity: f64| (velocity / limits.threshold_m_per_s).powi(2);
        Self {
            hot: squared(limits.hot_m_per_s) / share.hot,
            cold: squared(limits.cold_m_per_s) / share.cold,
        }
    }
}

/// Takes energies block by block, and judges them by one measure.
pub(crate) struct Judge<'a> {
    measure: Measure,
    step_s: f64,
    limits: EnergyLimits,
    segments: &'a [Segment],
    grounds: &'a Grounds,
    /// Level of each row, cold and hot.
    means: Vec<Mean>,
    cold: Vec<ColdRow>,
    /// For each group of segments and each row.
    hot: Vec<Option<HotRow>>,
    groups: usize,
    /// Last sample at which some ground was over the cold limit, of each event.
    loud: Vec<Option<usize>>,
    /// Weakest hot and loudest cold ground over its limit, at each sample.
    trace: Vec<[Option<f64>; 2]>,
}

#[derive(Clone, Default)]
struct ColdRow {
    judged: bool,
    worst: f64,
    worst_at: usize,
    over: usize,
}

#[derive(Clone)]
struct HotRow {
    level: f64,
    /// First sample at which it was asked for.
    asked: usize,
    /// First sample after which the row kept its limit, so far.
    reached: Option<usize>,
}

impl<'a> Judge<'a> {
    pub(crate) fn new(
        measure: Measure,
        summation_s: f64,
        step_s: f64,
        limits: EnergyLimits,
        segments: &'a [Segment],
        grounds: &'a Grounds,
    ) -> Self {
        let rows = grounds.rows();
        let groups = segments.iter().map(|s| s.group + 1).max().unwrap_or(0);
        let events = segments.iter().map(|s| s.event + 1).max().unwrap_or(0);
        Self {
            measure,
            step_s,
            limits,
            segments,
            grounds,
            means: vec![Mean::new(measure, summation_s, step_s); 2 * rows],
            cold: vec![ColdRow::default(); rows],
            hot: vec![None; groups * rows],
            groups,
            loud: vec![None; events],
            trace: Vec::new(),
        }
    }

    /// The energies from sample `first` on.
    pub(crate) fn feed(&mut self, first: usize, energies: &Energies) {
        let rows = self.grounds.rows();
        let segments = self.segments;
        let mut levels = Energies {
            cold: energies.cold.clone(),
            hot: energies.hot.clone(),
        };
        let end = first + energies.cold.nrows();
        let mut asked = vec![None; end - first];
        for segment in segments {
            for sample in segment.first.max(first)..segment.end.min(end) {
                asked[sample - first] = Some(segment);
            }
        }
        for (at, segment) in asked.iter().enumerate() {
            for row in 0..rows {
                // what ground took while it was hot is no matter of its quiet
                let is_cold =
                    segment.is_some_and(|s| self.grounds.of[s.ground].classes[row] == Ground::Cold);
                let owed = if is_cold {
                    energies.cold[[at, row]]
                } else {
                    0.0
                };
                if self.measure != Measure::Peak {
                    levels.cold[[at, row]] = self.means[row].of(owed);
                    levels.hot[[at, row]] = self.means[rows + row].of(energies.hot[[at, row]]);
                }
            }
            self.trace.push([None; 2]);
            if let Some(segment) = segment {
                self.judge(segment, first + at, &levels, &energies.cold, at);
            }
        }
    }

    fn judge(
        &mut self,
        segment: &Segment,
        sample: usize,
        levels: &Energies,
        moved: &Array2<f64>,
        at: usize,
    ) {
        let ground = &self.grounds.of[segment.ground];
        let rows = self.grounds.rows();
        let slack = 1.0 + tolerances::LIMIT;
        let (mut loud, mut trace) = (false, [None; 2]);
        for row in 0..rows {
            let over = levels.cold[[at, row]] / self.limits.cold;
            let moves = moved[[at, row]] / self.limits.cold;
            loud |= moves > slack && ground.classes[row] != Ground::Ignored;
            match ground.classes[row] {
                Ground::Ignored => {}
                Ground::Cold => {
                    trace[1] = Some(trace[1].map_or(over, |most: f64| most.max(over)));
                    let known = &mut self.cold[row];
                    known.judged = true;
                    known.over += usize::from(over > slack);
                    if over > known.worst {
                        (known.worst, known.worst_at) = (over, sample);
                    }
                }
                Ground::Hot => {
                    let felt = levels.hot[[at, row]] / (self.limits.hot * ground.levels[row]);
                    trace[0] = Some(trace[0].map_or(felt, |least: f64| least.min(felt)));
                    self.feel(segment, row, sample, felt);
                }
            }
        }
        if let Some(last) = self.trace.last_mut() {
            *last = trace;
        }
        if loud {
            self.loud[segment.event] = Some(sample);
        }
    }

    /// A hot row at a sample, so far over its limit.
    fn feel(&mut self, segment: &Segment, row: usize, sample: usize, felt: f64) {
        let Some(counts) = segment.hot else {
            return;
        };
        let place = &mut self.hot[segment.group * self.grounds.rows() + row];
        let at_worst = self.measure == Measure::Peak;
        let known = place.get_or_insert(HotRow {
            level: if at_worst { f64::INFINITY } else { 0.0 },
            asked: sample,
            reached: None,
        });
        if counts {
            known.level = match at_worst {
                true => known.level.min(felt),
                false => known.level.max(felt),
            };
        }
        if felt < 1.0 - tolerances::LIMIT {
            if at_worst {
                known.reached = None;
            }
        } else {
            known.reached.get_or_insert(sample);
        }
    }

    /// The result; `starts_s` are the beginnings of the events, `ends` the samples after
    /// which nothing of them is judged.
    pub(crate) fn result(&self, starts_s: &[f64], ends: &[usize]) -> TimeMeasure {
        let db = |ratio: f64| Some(10.0 * ratio.log10()).filter(|level| level.is_finite());
        let cold: Vec<&ColdRow> = self.cold.iter().filter(|row| row.judged).collect();
        let worst = cold.iter().max_by(|a, b| a.worst.total_cmp(&b.worst));
        let ever = cold.iter().filter(|row| row.over > 0).count();
        let hot: Vec<&HotRow> = self
            .hot
            .iter()
            .flatten()
            .filter(|row| row.level.is_finite())
            .collect();
        let held = hot
            .iter()
            .filter(|row| row.level >= 1.0 - tolerances::LIMIT)
            .count();
        let least = hot
            .iter()
            .map(|row| row.level)
            .fold(f64::INFINITY, f64::min);
        let since = |sample: usize, event: usize| self.step_s * sample as f64 - starts_s[event];
        let reached: Option<Vec<f64>> = hot
            .iter()
            .map(|row| {
                row.reached
                    .map(|sample| self.step_s * (sample - row.asked) as f64)
            })
            .collect();
        let quiet: Option<Vec<f64>> = (0..self.loud.len())
            .map(|event| match self.loud[event] {
                None => Some(0.0),
                Some(sample) if sample + 1 < ends[event] => Some(since(sample + 1, event)),
                Some(_) => None,
            })
            .collect();
        let largest = |all: Vec<f64>| {
            all.into_iter().fold(None, |most: Option<f64>, value| {
                Some(most.map_or(value, |most| most.max(value)))
            })
        };
        let ratio = |part: usize, all: usize| {
            if all == 0 {
                0.0
            } else {
                part as f64 / all as f64
            }
        };
        let apart = self.limits.hot / self.limits.cold;
        let loudest = worst.map_or(0.0, |row| row.worst);
        TimeMeasure {
            worst_cold_db: db(loudest),
            worst_cold_s: worst
                .filter(|row| row.worst > 0.0)
                .map(|row| self.step_s * row.worst_at as f64),
            over_s: self.step_s * cold.iter().map(|row| row.over).max().unwrap_or(0) as f64,
            ever_over_ratio: ratio(ever, cold.len()),
            worst_hot_db: db(least),
            hot_held_ratio: ratio(held, hot.len()),
            hot_reached_s: reached.and_then(largest),
            quiet_s: quiet.and_then(largest),
            contrast_db: db(least / loudest * apart),
        }
    }

    /// The traces, under a drive of these amplitudes.
    pub(crate) fn traces(&self, drive: Vec<f64>) -> TimeTraces {
        let of = |which: usize| {
            let db = |energy: f64| Some(10.0 * energy.log10()).filter(|level| level.is_finite());
            self.trace
                .iter()
                .map(|pair| pair[which].and_then(db))
                .collect()
        };
        TimeTraces {
            step_s: self.step_s,
            hot_db: of(0),
            cold_db: of(1),
            drive,
        }
    }

    /// The least level of hot rows in each group over its limit: by what a group must be
    /// raised.
    pub(crate) fn hot_levels(&self) -> Vec<Option<f64>> {
        let rows = self.grounds.rows();
        (0..self.groups)
            .map(|group| {
                let of_group = self.hot[group * rows..(group + 1) * rows].iter().flatten();
                of_group
                    .map(|row| row.level)
                    .filter(|level| level.is_finite())
                    .fold(None, |least: Option<f64>, level| {
                        Some(least.map_or(level, |least| least.min(level)))
                    })
            })
            .collect()
    }
}

/// A running mean of one row.
#[derive(Clone)]
enum Mean {
    Peak,
    Summed {
        decay: f64,
        last: f64,
        sum: f64,
    },
    Rms {
        length: usize,
        window: VecDeque<f64>,
        sum: f64,
    },
}

impl Mean {
    fn new(measure: Measure, summation_s: f64, step_s: f64) -> Self {
        match measure {
            Measure::Peak => Self::Peak,
            Measure::Summed => Self::Summed {
                decay: (-step_s / summation_s).exp(),
                last: 0.0,
                sum: 0.0,
            },
            Measure::Rms => Self::Rms {
                length: (summation_s / step_s).round().max(1.0) as usize,
                window: VecDeque::new(),
                sum: 0.0,
            },
        }
    }

    /// The mean with the next sample.
    fn of(&mut self, energy: f64) -> f64 {
        match self {
            Self::Peak => energy,
            Self::Summed { decay, last, sum } => {
                *sum = *decay * *sum + (1.0 - *decay) * 0.5 * (*last + energy);
                *last = energy;
                *sum
            }
            Self::Rms {
                length,
                window,
                sum,
            } => {
                window.push_back(energy);
                *sum += energy;
                if window.len() > *length {
                    *sum -= window.pop_front().unwrap_or(0.0);
                }
                sum.max(0.0) / *length as f64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_tone_ends_at_its_own_level_and_a_short_one_below() {
        let (step_s, tau) = (2.5e-4, 0.2);
        let level = |measure, duration_s: f64| {
            let mut mean = Mean::new(measure, tau, step_s);
            (0..(duration_s / step_s) as usize)
                .map(|_| mean.of(4.0))
                .fold(0.0, f64::max)
        };
        assert!((level(Measure::Summed, 3.0) - 4.0).abs() < 1e-5);
        assert!((level(Measure::Rms, 3.0) - 4.0).abs() < 1e-9);
        assert_eq!(level(Measure::Peak, 0.001), 4.0);
        // 10 lg(1 − e^{−D/τ}) of 0.1 s: 4.05 dB
        let loss = -10.0 * (level(Measure::Summed, 0.1) / 4.0).log10();
        assert!((loss - 4.05).abs() < 0.03, "{loss}");
        assert!((level(Measure::Rms, 0.1) - 2.0).abs() < 1e-9);
    }
}
