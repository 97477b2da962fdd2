//! The events of `[time]` as chains: rise, a place, perhaps a passage to the next, fall.
//!
//! A burst is a chain of one place; a fade inside a burst adds a place to its chain, a
//! fade by itself has two; a moving spot is a chain of keyframes along its path. Chains
//! follow each other and do not overlap.

use crate::scene::plane::Position;
use crate::scene::zones::{ZoneLayout, Zones};
use crate::time::envelope::Ramp;
use crate::time::table::{Fade, Move, RampTime, TimeTable};
use crate::tolerances;
use chladni_frf::{Error, Result};

/// The hot ground at a stop of a chain.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Place {
    /// As `[zones]` says.
    Scene,
    /// Cells of its grid.
    Cells(Vec<usize>),
    /// A disc.
    Spot(Spot),
}

/// A disc that is hot, and the ring around it that nobody judges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spot {
    pub(crate) centre: Position,
    pub(crate) hot_radius_m: f64,
    pub(crate) quiet_from_m: f64,
}

impl Spot {
    /// The spot that its steady drive must keep so that the spot keeps its own limits
    /// half a keyframe further on, too: more hot ground, and more cold.
    pub(crate) fn for_passing(&self) -> Self {
        let room_m = 0.25 * (self.quiet_from_m - self.hot_radius_m);
        let half_m = (0.5 * tolerances::KEYFRAME_M).min(room_m);
        Self {
            hot_radius_m: self.hot_radius_m + half_m,
            quiet_from_m: self.quiet_from_m - half_m,
            ..*self
        }
    }
}

/// A chain whose ramps are not yet known.
#[derive(Debug, Clone)]
pub(crate) struct Event {
    /// As messages call it.
    pub(crate) name: String,
    pub(crate) line: u64,
    pub(crate) ramp: RampTime,
    /// Line of its `ramp_s`, or else its own.
    pub(crate) ramp_line: u64,
    /// Places, as numbers of [`Plan::places`].
    pub(crate) stops: Vec<usize>,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    /// From start to end, with passages between.
    Burst {
        start_s: f64,
        end_s: f64,
        passages: Vec<Ramp>,
    },
    /// The passage; the ramps lie before and after it.
    Fade(Ramp),
    /// The move, and when each passage begins and ends after the rise.
    Move(Move, Vec<Ramp>),
}

/// A chain whose ramps are known.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    pub(crate) name: String,
    pub(crate) stops: Vec<usize>,
    /// Rise, passages, fall: one more than stops.
    pub(crate) ramps: Vec<Ramp>,
    /// Of a spot that moves.
    pub(crate) moving: Option<Move>,
    pub(crate) ramp_s: f64,
    /// Margin below its limit that cold ground is to have at every instant, dB, if need be
    /// at a lower level; `None`: the level is the steady one.
    pub(crate) cold_margin_db: Option<f64>,
    line: u64,
}

/// All of `[time]`.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    pub(crate) places: Vec<Place>,
    pub(crate) events: Vec<Event>,
}

impl Plan {
    /// The events of `table` over `zones`.
    ///
    /// # Errors
    /// Events that overlap even without ramps.
    pub(crate) fn new(table: &TimeTable, zones: &Zones) -> Result<Self> {
        let mut plan = Self {
            places: Vec::new(),
            events: Vec::new(),
        };
        for (number, burst) in table.bursts.iter().enumerate() {
            let place = match &burst.hot {
                None => Place::Scene,
                Some(cells) => of_cells(cells, zones),
            };
            let stop = plan.stop(place);
            for k in 0..burst.count {
                let start_s = burst.start_s + burst.period_s * k as f64;
                plan.events.push(Event {
                    name: format!("[[time.burst]] {}", number + 1),
                    line: burst.line,
                    ramp: burst.ramp,
                    ramp_line: burst.ramp_line,
                    stops: vec![stop],
                    shape: Shape::Burst {
                        start_s,
                        end_s: start_s + burst.duration_s,
                        passages: Vec::new(),
                    },
                });
            }
        }
        let mut fades: Vec<(usize, &Fade)> = table.fades.iter().enumerate().collect();
        fades.sort_by(|a, b| a.1.start_s.total_cmp(&b.1.start_s));
        for (number, fade) in fades {
            plan.add_fade(number, fade, zones);
        }
        for (number, moving) in table.moves.iter().enumerate() {
            plan.add_move(number, moving);
        }
        plan.chains(|_, event| match event.ramp {
            RampTime::Auto => 0.0,
            RampTime::Seconds(seconds) => seconds,
        })?;
        Ok(plan)
    }

    /// The chains in the order of time, with ramps of `ramp_s` of each event and its number.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: chains that overlap or end too late, ramps that do
    /// not fit.
    pub(crate) fn chains(&self, ramp_s: impl Fn(usize, &Event) -> f64) -> Result<Vec<Chain>> {
        let mut chains = self
            .events
            .iter()
            .enumerate()
            .map(|(number, event)| event.with_ramps(ramp_s(number, event)))
            .collect::<Result<Vec<_>>>()?;
        chains.sort_by(|a, b| a.start_s().total_cmp(&b.start_s()));
        if let Some(late) = chains.iter().find(|c| c.end_s() > tolerances::LATEST_END_S) {
            return Err(Error::bad_data("an event ends too late")
                .at_line(late.line)
                .field(late.name.clone())
                .found(format!("{:.4} s", late.end_s()))
                .expected(format!("at most {} s", tolerances::LATEST_END_S))
                .help("times are in seconds; play a part of it again and again for more"));
        }
        for pair in chains.windows(2) {
            let (first, second) = (&pair[0], &pair[1]);
            if second.start_s() < first.end_s() - tolerances::SAME_TIME_S {
                return Err(Error::bad_data("events overlap in time")
                    .at_line(second.line)
                    .field(second.name.clone())
                    .found(format!(
                        "{} from {:.4} s, while {} lasts to {:.4} s",
                        second.name,
                        second.start_s(),
                        first.name,
                        first.end_s()
                    ))
                    .expected(
                        "events that follow each other, or fades inside a burst of their `from`",
                    )
                    .help("move start_s, or shorten the one before"));
            }
        }
        Ok(chains)
    }

    fn stop(&mut self, place: Place) -> usize {
        if let Some(known) = self.places.iter().position(|known| *known == place) {
            return known;
        }
        self.places.push(place);
        self.places.len() - 1
    }

    fn add_fade(&mut self, number: usize, fade: &Fade, zones: &Zones) {
        let from = self.stop(of_cells(&fade.from, zones));
        let to = self.stop(of_cells(&fade.to, zones));
        let passage = Ramp {
            start_s: fade.start_s,
            duration_s: fade.fade_s,
        };
        for event in &mut self.events {
            if let Shape::Burst {
                start_s,
                end_s,
                passages,
            } = &mut event.shape
            {
                let ramp_s = match event.ramp {
                    RampTime::Auto => 0.0,
                    RampTime::Seconds(seconds) => seconds,
                };
                let begins = passages.last().map_or(*start_s + ramp_s, Ramp::end_s);
                if event.stops.last() == Some(&from)
                    && passage.start_s >= begins - tolerances::SAME_TIME_S
                    && passage.end_s() <= *end_s - ramp_s + tolerances::SAME_TIME_S
                {
                    passages.push(passage);
                    event.stops.push(to);
                    return;
                }
            }
        }
        self.events.push(Event {
            name: format!("[[time.fade]] {}", number + 1),
            line: fade.line,
            ramp: fade.ramp,
            ramp_line: fade.ramp_line,
            stops: vec![from, to],
            shape: Shape::Fade(passage),
        });
    }

    fn add_move(&mut self, number: usize, moving: &Move) {
        let length_m = moving.length_m();
        let intervals = (length_m / tolerances::KEYFRAME_M).ceil().max(1.0);
        let along = |k: usize| length_m * k as f64 / intervals;
        let stops = (0..=intervals as usize)
            .map(|k| {
                self.stop(Place::Spot(Spot {
                    centre: moving.place(along(k)),
                    hot_radius_m: moving.hot_radius_m,
                    quiet_from_m: moving.quiet_from_m,
                }))
            })
            .collect();
        let duration_s = moving.travel_s() / intervals;
        let passages = (0..intervals as usize)
            .map(|k| Ramp {
                start_s: moving.start_s + duration_s * k as f64,
                duration_s,
            })
            .collect();
        self.events.push(Event {
            name: format!("[[time.move]] {}", number + 1),
            line: moving.line,
            ramp: moving.ramp,
            ramp_line: moving.ramp_line,
            stops,
            shape: Shape::Move(moving.clone(), passages),
        });
    }
}

impl Event {
    /// A key of its table, as errors of the scene file call it.
    pub(crate) fn key(&self, key: &str) -> String {
        let table = self.name.replace("[[", "").replace("]] ", "[");
        format!("{table}].{key}")
    }

    /// True for a fade by itself, whose rise comes before its start.
    pub(crate) fn is_fade(&self) -> bool {
        matches!(self.shape, Shape::Fade(_))
    }

    /// Its beginning, s; of a fade by itself that of the passage.
    pub(crate) fn start_s(&self) -> f64 {
        match &self.shape {
            Shape::Burst { start_s, .. } => *start_s,
            Shape::Fade(passage) => passage.start_s,
            Shape::Move(moving, _) => moving.start_s,
        }
    }

    /// The longest ramp that fits, s.
    pub(crate) fn longest_ramp_s(&self) -> f64 {
        match &self.shape {
            Shape::Burst {
                start_s,
                end_s,
                passages,
            } => {
                let half = 0.5 * (end_s - start_s);
                match (passages.first(), passages.last()) {
                    // 0 where a fade ends with its burst, but for rounding
                    (Some(first), Some(last)) => half
                        .min(first.start_s - start_s)
                        .min(end_s - last.end_s())
                        .max(0.0),
                    _ => half,
                }
            }
            Shape::Fade(passage) => passage.start_s,
            Shape::Move(..) => f64::INFINITY,
        }
    }

    /// The chain with ramps of `ramp_s`.
    pub(crate) fn with_ramps(&self, ramp_s: f64) -> Result<Chain> {
        if ramp_s > self.longest_ramp_s() + tolerances::SAME_TIME_S {
            return Err(Error::bad_data("there is no time for the ramps")
                .at_line(self.ramp_line)
                .field(self.key("ramp_s"))
                .found(format!("{:.1} ms", 1e3 * ramp_s))
                .expected(format!(
                    "at most {:.1} ms before and after what sounds",
                    1e3 * self.longest_ramp_s()
                ))
                .help("begin later, take more time, or shorten ramp_s"));
        }
        let ramp = |start_s: f64| Ramp {
            start_s,
            duration_s: ramp_s,
        };
        let (rise, passages, fall, moving) = match &self.shape {
            Shape::Burst {
                start_s,
                end_s,
                passages,
            } => (*start_s, passages.clone(), end_s - ramp_s, None),
            Shape::Fade(passage) => (
                passage.start_s - ramp_s,
                vec![*passage],
                passage.end_s(),
                None,
            ),
            Shape::Move(moving, passages) => {
                let later = |passage: &Ramp| Ramp {
                    start_s: passage.start_s + ramp_s,
                    ..*passage
                };
                let fall = moving.start_s + ramp_s + moving.travel_s();
                (
                    moving.start_s,
                    passages.iter().map(later).collect(),
                    fall,
                    Some(moving.clone()),
                )
            }
        };
        Ok(Chain {
            name: self.name.clone(),
            stops: self.stops.clone(),
            ramps: std::iter::once(ramp(rise))
                .chain(passages)
                .chain([ramp(fall)])
                .collect(),
            cold_margin_db: match (&moving, self.stops.len()) {
                (Some(_), _) => None,
                (None, 1) => (self.ramp == RampTime::Auto).then_some(0.0),
                (None, _) => Some(tolerances::PASSAGE_MARGIN_DB),
            },
            moving,
            ramp_s,
            line: self.line,
        })
    }

    /// A short chain that rises into one of the stops and falls again, from time 0: what
    /// a ramp is tried on.
    pub(crate) fn trial(&self, stop: usize, ramp_s: f64, hold_s: f64) -> Chain {
        let ramp = |start_s: f64| Ramp {
            start_s,
            duration_s: ramp_s,
        };
        Chain {
            name: self.name.clone(),
            stops: vec![stop],
            ramps: vec![ramp(0.0), ramp(ramp_s + hold_s)],
            moving: None,
            ramp_s,
            cold_margin_db: None,
            line: self.line,
        }
    }
}

impl Chain {
    pub(crate) fn start_s(&self) -> f64 {
        self.ramps.first().map_or(0.0, |ramp| ramp.start_s)
    }

    pub(crate) fn end_s(&self) -> f64 {
        self.ramps.last().map_or(0.0, Ramp::end_s)
    }
}

/// Cells as a place: those of the scene where they are the same.
fn of_cells(cells: &[usize], zones: &Zones) -> Place {
    let same = match &zones.layout {
        ZoneLayout::Grid { hot, .. } => {
            let mut hot = hot.clone();
            hot.sort_unstable();
            hot.dedup();
            hot == cells
        }
        ZoneLayout::Polygons(_) | ZoneLayout::Spot { .. } => false,
    };
    if same {
        Place::Scene
    } else {
        Place::Cells(cells.to_vec())
    }
}
