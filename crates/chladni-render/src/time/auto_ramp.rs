//! The least ramp that keeps every limit.

use crate::time::listener::{Judging, Listener};
use crate::time::plan::Event;
use crate::time::table::{Measure, RampTime, Ramps};
use crate::time::voice::Voice;
use crate::tolerances;
use chladni_frf::{Error, ModalModel, Result, Trust};
use std::collections::HashMap;

/// Shortest ramp that the band of a model can describe at `frequency_hz`, s; outside the
/// band the longest that is ever tried.
///
/// A band that begins well below the lowest mode has nothing below it that a ramp could
/// excite, and only its upper end counts.
pub(crate) fn shortest_s(model: &ModalModel, frequency_hz: f64) -> f64 {
    let [low, high] = model.band_hz;
    let lowest_hz = model
        .modes
        .iter()
        .filter(|mode| mode.trust != Trust::Rejected)
        .map(|mode| mode.frequency_hz)
        .fold(f64::INFINITY, f64::min);
    let below = match low < tolerances::BEGINS_BELOW * lowest_hz {
        true if frequency_hz > low => f64::INFINITY,
        _ => frequency_hz - low,
    };
    let room = below.min(high - frequency_hz).max(0.0);
    (tolerances::RAMP_PERIODS / room).min(tolerances::LONGEST_AUTO_RAMP_S)
}

/// Refuses a ramp that the band cannot describe.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`].
pub(crate) fn refuse_short(event: &Event, ramp_s: f64, shortest_s: f64) -> Result<()> {
    if ramp_s >= shortest_s * (1.0 - tolerances::SAME_FREQUENCY) {
        return Ok(());
    }
    Err(
        Error::bad_data("the ramp is faster than the model's band can describe")
            .at_line(event.ramp_line)
            .field(event.key("ramp_s"))
            .found(format!("{ramp_s} s"))
            .expected(format!("at least {shortest_s:.4} s"))
            .help("take longer ramps, or fit a wider band about the drive frequency"),
    )
}

/// Refuses an event that leaves less time for the ramps that are looked for than the band
/// can describe.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`].
fn refuse_narrow(event: &Event, longest_s: f64, shortest_s: f64) -> Result<()> {
    if refuse_short(event, longest_s, shortest_s).is_ok() {
        return Ok(());
    }
    Err(
        Error::bad_data("the event leaves too little time for its rise and fall")
            .at_line(event.line)
            .field(event.name.clone())
            .found(format!(
                "{:.1} ms beside what sounds in it",
                1e3 * longest_s
            ))
            .expected(format!(
                "at least {:.1} ms, the shortest ramp that the model's band can describe",
                1e3 * shortest_s
            ))
            .help(match event.is_fade() {
                true => {
                    "its rise ends at start_s: take a later start_s, or fit a wider band about \
                     the drive frequency"
                }
                false => {
                    "begin it earlier and end it later than the fades inside it, take a longer \
                     duration_s, or fit a wider band about the drive frequency"
                }
            }),
    )
}

/// The dB by which a drive is to be lowered where cold ground is over its limit by `over_db`
/// and hot ground has `room_db` above its own; `None` where hot ground cannot give so much.
///
/// Hot ground keeps half of its room: it has less between the responses than on them.
pub(crate) fn spared_db(over_db: f64, room_db: f64) -> Option<f64> {
    let lower_db = over_db + tolerances::LOWERED_FURTHER_DB;
    let most_db = f64::min(0.5 * room_db, tolerances::MOST_LOWERED_DB);
    (over_db > 0.0 && lower_db <= most_db).then_some(lower_db)
}

/// Finds ramps for events.
pub(crate) struct RampFinder<'a> {
    pub(crate) voices: &'a [Voice],
    pub(crate) listener: &'a Listener,
    pub(crate) judging: &'a Judging<'a>,
    pub(crate) ramps: Ramps,
    pub(crate) shortest_s: f64,
    /// The level of the drive may be lowered.
    pub(crate) lowers: bool,
    /// Found before, by the stops that were tried.
    pub(crate) known: HashMap<Vec<usize>, (f64, bool)>,
}

impl RampFinder<'_> {
    /// The ramp of an event, s; and whether it passed, where that was asked.
    ///
    /// # Errors
    /// A ramp that the band cannot describe.
    pub(crate) fn of(&mut self, event: &Event) -> Result<(f64, bool)> {
        if let RampTime::Seconds(ramp_s) = event.ramp {
            refuse_short(event, ramp_s, self.shortest_s)?;
            return Ok((ramp_s, true));
        }
        let mut tried: Vec<usize> = event
            .stops
            .first()
            .into_iter()
            .chain(event.stops.last())
            .copied()
            .collect();
        tried.dedup();
        if let Some(&known) = self.known.get(&tried) {
            return Ok((known.0.min(event.longest_ramp_s()), known.1));
        }
        let step_s = tolerances::AUTO_RAMP_STEP_S;
        let first = (self.shortest_s / step_s - tolerances::STEP_ROUNDING)
            .ceil()
            .max(1.0) as usize;
        let longest_s = event.longest_ramp_s().min(tolerances::LONGEST_AUTO_RAMP_S);
        let mut best: Option<(f64, f64)> = None;
        // at a lower level of the drive, and by how much
        let mut lowered: Option<(f64, f64)> = None;
        let mut passed = false;
        for k in first.. {
            let ramp_s = step_s * k as f64;
            let is_slow = ramp_s > tolerances::QUICK_RAMP_S + tolerances::SAME_TIME_S;
            if ramp_s > longest_s + tolerances::SAME_TIME_S || (is_slow && lowered.is_some()) {
                break;
            }
            let [cold_db, hot_db] = self.missed_db(event, &tried, ramp_s);
            let excess_db = cold_db.max(hot_db);
            if best.is_none_or(|(_, least)| excess_db < least) {
                best = Some((ramp_s, excess_db));
            }
            if excess_db <= 0.0 {
                passed = true;
                break;
            }
            let spared = self.lowers.then(|| spared_db(cold_db, -hot_db)).flatten();
            if let Some(db) = spared.filter(|db| lowered.is_none_or(|(_, least)| *db < least)) {
                lowered = Some((ramp_s, db));
            }
        }
        if !passed && lowered.is_some() {
            (best, passed) = (lowered, true);
        }
        let ramp_s = match best {
            Some((ramp_s, _)) => ramp_s,
            None => {
                refuse_narrow(event, longest_s, self.shortest_s)?;
                longest_s
            }
        };
        self.known.insert(tried, (ramp_s, passed));
        Ok((ramp_s, passed))
    }

    /// By how much the worst cold and the worst hot ground miss their limits at any instant
    /// beyond what the steady drive misses, dB; 0 or less: none does.
    fn missed_db(&self, event: &Event, stops: &[usize], ramp_s: f64) -> [f64; 2] {
        let mut most = [f64::NEG_INFINITY; 2];
        for &stop in stops {
            let chain = event.trial(stop, ramp_s, tolerances::TRIAL_HOLD_S);
            let sounding: Vec<_> = self
                .voices
                .iter()
                .map(|voice| voice.sounding(voice.tracks(&chain, self.ramps, self.judging.maps)))
                .collect();
            let chains = std::slice::from_ref(&chain);
            let heard = (self.listener).hear(&sounding, chains, self.judging, &[Measure::Peak]);
            let measure = heard.measures[0];
            let tried = [
                measure.worst_cold_db.unwrap_or(f64::NEG_INFINITY),
                -measure.worst_hot_db.unwrap_or(f64::NEG_INFINITY),
            ];
            let steady = self.steady_db(stop);
            for ((most, tried), steady) in most.iter_mut().zip(tried).zip(steady) {
                let allowed = f64::max(steady + tolerances::STEADY_MISS_DB, 0.0);
                *most = most.max(tried - allowed);
            }
        }
        most
    }

    /// The same of the steady drive of a stop: cold over, hot under its limit.
    pub(crate) fn steady_db(&self, stop: usize) -> [f64; 2] {
        let map = &self.judging.maps[stop];
        let mut worst = [f64::NEG_INFINITY; 2];
        for (voice, (model, tone)) in self
            .voices
            .iter()
            .zip(self.listener.models.iter().zip(&self.listener.limits))
        {
            let field = model.steady(voice.patterns.view());
            for (v, &place) in field.column(stop).iter().zip(&self.listener.positions_m) {
                let db = |ratio: f64| 20.0 * ratio.log10();
                match map.classify(place) {
                    crate::scene::zones::Ground::Cold => {
                        worst[0] = worst[0].max(db(v.norm() / tone.limits.cold_m_per_s))
                    }
                    crate::scene::zones::Ground::Hot => {
                        let limit = tone.limits.hot_m_per_s * map.level_at(place);
                        worst[1] = worst[1].max(db(limit / v.norm()))
                    }
                    crate::scene::zones::Ground::Ignored => {}
                }
            }
        }
        worst
    }
}
