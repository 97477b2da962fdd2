//! Judging in time: is cold ground ever over its limit, is hot ground held, and from when
//! until when.
//!
//! Ground moves at the energies e(t) = |v⁺|²/T². Three measures of it: at each instant;
//! averaged over a window that slides; and summed as touch does,
//! I(t) = (1/τ)∫e^{−(t−s)/τ}e(s)ds, so that a long tone ends at its own level
//! (theory.md, eq. 63).

use crate::scene::limits::Limits;
use crate::scene::zones::Ground;
use crate::time::table::Measure;
use crate::time::timeline::{Grounds, RowGround, Segment};
use crate::tolerances;
use ndarray::{Array2, ArrayView1};
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
    pub(crate) fn of(limits: &Limits, share: &crate::scene::tones::Share) -> Self {
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
    cold: Rows<ColdRow>,
    /// For each group of segments.
    hot: Rows<Vec<Option<HotRow>>>,
    groups: usize,
    /// Last sample at which some ground was over the cold limit, of each event.
    loud: Vec<Option<usize>>,
    /// Weakest hot and loudest cold ground over its limit, at each sample.
    trace: Vec<[Option<f64>; 2]>,
}

/// The rows that are ever cold, or ever hot, with their means.
struct Rows<T> {
    numbers: Vec<usize>,
    /// For each ground, the places in `numbers` of those that it has.
    of: Vec<Vec<usize>>,
    means: Means,
    /// Level of each at the last sample.
    levels: Vec<f64>,
    known: Vec<T>,
}

impl<T: Clone> Rows<T> {
    fn new(grounds: &Grounds, class: Ground, means: impl Fn(usize) -> Means, known: T) -> Self {
        let is_ever = |row: &usize| grounds.of.iter().any(|known| known.classes[*row] == class);
        let numbers: Vec<usize> = (0..grounds.rows()).filter(is_ever).collect();
        let places = |known: &RowGround| {
            let is_there = |at: &usize| known.classes[numbers[*at]] == class;
            (0..numbers.len()).filter(is_there).collect()
        };
        Self {
            of: grounds.of.iter().map(places).collect(),
            means: means(numbers.len()),
            levels: vec![0.0; numbers.len()],
            known: vec![known; numbers.len()],
            numbers,
        }
    }
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

impl HotRow {
    /// The row is `felt` times its limit at a sample.
    ///
    /// * `must`: it has to be
    /// * `at_worst`: by its worst instant, not by its best
    fn feel(known: &mut Option<Self>, sample: usize, felt: f64, must: bool, at_worst: bool) {
        let known = known.get_or_insert(Self {
            level: if at_worst { f64::INFINITY } else { 0.0 },
            asked: sample,
            reached: None,
        });
        if must {
            known.level = match at_worst {
                true => known.level.min(felt),
                false => known.level.max(felt),
            };
        }
        if felt >= 1.0 - tolerances::LIMIT {
            known.reached.get_or_insert(sample);
        } else if at_worst {
            known.reached = None;
        }
    }
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
        let groups = segments.iter().map(|s| s.group + 1).max().unwrap_or(0);
        let events = segments.iter().map(|s| s.event + 1).max().unwrap_or(0);
        let means = |rows| Means::new(measure, summation_s, step_s, rows);
        Self {
            measure,
            step_s,
            limits,
            segments,
            grounds,
            cold: Rows::new(grounds, Ground::Cold, means, ColdRow::default()),
            hot: Rows::new(grounds, Ground::Hot, means, vec![None; groups]),
            groups,
            loud: vec![None; events],
            trace: Vec::new(),
        }
    }

    /// Takes so many samples at which nothing moves and nothing is asked, before all others.
    pub(crate) fn pass_over(&mut self, samples: usize) {
        self.trace.resize(self.trace.len() + samples, [None; 2]);
    }

    /// The energies from sample `first` on.
    pub(crate) fn feed(&mut self, first: usize, energies: &Energies) {
        let segments = self.segments;
        let end = first + energies.cold.nrows();
        let mut asked = vec![None; end - first];
        for segment in segments {
            for sample in segment.first.max(first)..segment.end.min(end) {
                asked[sample - first] = Some(segment);
            }
        }
        for (at, segment) in asked.iter().enumerate() {
            let (cold, hot) = (energies.cold.row(at), energies.hot.row(at));
            // what ground took while it was hot is no matter of its quiet
            self.cold.levels.fill(0.0);
            for &place in segment.map_or(&Vec::new(), |segment| &self.cold.of[segment.ground]) {
                self.cold.levels[place] = cold[self.cold.numbers[place]];
            }
            for (level, &row) in self.hot.levels.iter_mut().zip(&self.hot.numbers) {
                *level = hot[row];
            }
            self.cold.means.take(&mut self.cold.levels);
            self.hot.means.take(&mut self.hot.levels);
            self.trace.push([None; 2]);
            if let Some(segment) = segment {
                self.judge(segment, first + at, cold);
            }
        }
    }

    fn judge(&mut self, segment: &Segment, sample: usize, moved: ArrayView1<f64>) {
        let ground = &self.grounds.of[segment.ground];
        let slack = 1.0 + tolerances::LIMIT;
        let loudest = moved
            .iter()
            .zip(&ground.classes)
            .filter(|(_, class)| **class != Ground::Ignored)
            .fold(0.0, |most, (&energy, _)| f64::max(most, energy));
        if loudest / self.limits.cold > slack {
            self.loud[segment.event] = Some(sample);
        }
        let mut trace = [None; 2];
        for &place in &self.cold.of[segment.ground] {
            let over = self.cold.levels[place] / self.limits.cold;
            let known = &mut self.cold.known[place];
            trace[1] = Some(trace[1].map_or(over, |most: f64| most.max(over)));
            known.judged = true;
            known.over += usize::from(over > slack);
            if over > known.worst {
                (known.worst, known.worst_at) = (over, sample);
            }
        }
        let felt = |place: usize| {
            let owed = self.limits.hot * ground.levels[self.hot.numbers[place]];
            self.hot.levels[place] / owed
        };
        let hot = &self.hot.of[segment.ground];
        trace[0] = hot.iter().map(|&place| felt(place)).reduce(f64::min);
        if let Some(must) = segment.hot {
            for &place in hot {
                let felt = felt(place);
                let known = &mut self.hot.known[place][segment.group];
                let at_worst = self.measure == Measure::Peak;
                HotRow::feel(known, sample, felt, must, at_worst);
            }
        }
        if let Some(last) = self.trace.last_mut() {
            *last = trace;
        }
    }

    /// The result; `starts_s` are the beginnings of the events, `ends` the samples after
    /// which nothing of them is judged.
    pub(crate) fn result(&self, starts_s: &[f64], ends: &[usize]) -> TimeMeasure {
        let db = |ratio: f64| Some(10.0 * ratio.log10()).filter(|level| level.is_finite());
        let cold: Vec<&ColdRow> = self.cold.known.iter().filter(|row| row.judged).collect();
        let worst = cold.iter().max_by(|a, b| a.worst.total_cmp(&b.worst));
        let ever = cold.iter().filter(|row| row.over > 0).count();
        let hot: Vec<&HotRow> = self
            .hot
            .known
            .iter()
            .flatten()
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
        (0..self.groups)
            .map(|group| {
                let known = self.hot.known.iter();
                let of_group = known.filter_map(|groups| groups[group].as_ref());
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

/// The largest value; `None` where there is none.
fn largest(all: Vec<f64>) -> Option<f64> {
    all.into_iter().fold(None, |most: Option<f64>, value| {
        Some(most.map_or(value, |most| most.max(value)))
    })
}

/// Share of `all`; 0 of none.
fn ratio(part: usize, all: usize) -> f64 {
    if all == 0 {
        0.0
    } else {
        part as f64 / all as f64
    }
}

/// Running means of some rows.
enum Means {
    Peak,
    Summed {
        decay: f64,
        last: Vec<f64>,
        sums: Vec<f64>,
    },
    Rms {
        length: usize,
        /// The energies of the last samples.
        window: VecDeque<Vec<f64>>,
        sums: Vec<f64>,
    },
}

impl Means {
    fn new(measure: Measure, summation_s: f64, step_s: f64, rows: usize) -> Self {
        match measure {
            Measure::Peak => Self::Peak,
            Measure::Summed => Self::Summed {
                decay: (-step_s / summation_s).exp(),
                last: vec![0.0; rows],
                sums: vec![0.0; rows],
            },
            Measure::Rms => Self::Rms {
                length: (summation_s / step_s).round().max(1.0) as usize,
                window: VecDeque::new(),
                sums: vec![0.0; rows],
            },
        }
    }

    /// Puts the means with the next sample in place of its energies.
    fn take(&mut self, energies: &mut [f64]) {
        match self {
            Self::Peak => {}
            Self::Summed { decay, last, sums } => {
                let (kept, added) = (*decay, 1.0 - *decay);
                for ((energy, last), sum) in energies.iter_mut().zip(last).zip(sums) {
                    *sum = kept * *sum + added * 0.5 * (*last + *energy);
                    *last = *energy;
                    *energy = *sum;
                }
            }
            Self::Rms {
                length,
                window,
                sums,
            } => {
                for (sum, &energy) in sums.iter_mut().zip(energies.iter()) {
                    *sum += energy;
                }
                let mut newest = Vec::new();
                if window.len() == *length {
                    newest = window.pop_front().unwrap_or_default();
                    for (sum, gone) in sums.iter_mut().zip(&newest) {
                        *sum -= gone;
                    }
                }
                newest.clear();
                newest.extend_from_slice(energies);
                window.push_back(newest);
                for (energy, sum) in energies.iter_mut().zip(sums) {
                    *energy = sum.max(0.0) / *length as f64;
                }
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
            let mut means = Means::new(measure, tau, step_s, 1);
            let mut next = || {
                let mut energies = [4.0];
                means.take(&mut energies);
                energies[0]
            };
            (0..(duration_s / step_s) as usize)
                .map(|_| next())
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
