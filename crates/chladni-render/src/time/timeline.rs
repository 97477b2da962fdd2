//! Ground of each place at each time.

use crate::scene::plane::{Position, Rectangle};
use crate::scene::zones::{Ground, ZoneLayout, ZoneMap, Zones};
use crate::time::plan::{Chain, Place, Plan, Spot};
use crate::time::table::Move;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, Result};

/// Ground of the rows while one thing lasts.
#[derive(Debug, Clone)]
pub(crate) struct RowGround {
    pub(crate) classes: Vec<Ground>,
    /// Square of the factor on the limit of each hot row.
    pub(crate) levels: Vec<f64>,
}

impl RowGround {
    /// The ground of `map` at `positions_m`.
    fn of(map: &ZoneMap, positions_m: &[Position]) -> Self {
        let level = |&place: &Position| map.level_at(place).powi(2);
        Self {
            classes: positions_m.iter().map(|&p| map.classify(p)).collect(),
            levels: positions_m.iter().map(level).collect(),
        }
    }
}

/// All that is ever asked of the rows.
#[derive(Debug, Clone)]
pub(crate) struct Grounds {
    pub(crate) of: Vec<RowGround>,
    rows: usize,
}

/// Samples during which the same is asked.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    pub(crate) first: usize,
    /// One past the last.
    pub(crate) end: usize,
    /// Number in [`Grounds::of`].
    pub(crate) ground: usize,
    /// `None`: hot ground is not looked at; `Some(false)`: it may reach its limit, and
    /// need not; `Some(true)`: it must.
    pub(crate) hot: Option<bool>,
    /// Segments of one group share their hot rows.
    pub(crate) group: usize,
    /// Number of the chain.
    pub(crate) event: usize,
}

/// The zones of a place.
pub(crate) fn zones_of(place: &Place, zones: &Zones) -> Zones {
    let layout = match (place, &zones.layout) {
        (Place::Scene, layout) => layout.clone(),
        (Place::Cells(cells), ZoneLayout::Grid { grid, cells_m, .. }) => ZoneLayout::Grid {
            grid: *grid,
            hot: cells.clone(),
            cells_m: *cells_m,
        },
        (Place::Cells(_), layout) => layout.clone(),
        (Place::Spot(spot), _) => layout_of(spot),
    };
    Zones {
        layout,
        ..zones.clone()
    }
}

/// The ground that responses at `positions_m` span, and the zones of each place on it.
///
/// # Errors
/// No responses.
pub(crate) fn maps_over(
    positions_m: &[Position],
    plan: &Plan,
    zones: &Zones,
) -> Result<(Rectangle, Vec<ZoneMap>)> {
    let scanned = Rectangle::around(positions_m)
        .ok_or_else(|| Error::new(ErrorKind::Internal, "an operator without responses"))?;
    let places = plan.places.iter();
    let maps = places.map(|place| zones_of(place, zones).over(scanned));
    Ok((scanned, maps.collect()))
}

fn layout_of(spot: &Spot) -> ZoneLayout {
    ZoneLayout::Spot {
        centre_m: spot.centre,
        hot_radius_m: spot.hot_radius_m,
        quiet_from_m: spot.quiet_from_m,
    }
}

/// The demands over time.
#[derive(Debug, Clone)]
pub(crate) struct Timeline {
    pub(crate) grounds: Grounds,
    pub(crate) segments: Vec<Segment>,
    /// The beginning of each event, s.
    pub(crate) starts_s: Vec<f64>,
    /// Sample at which the next one begins.
    pub(crate) ends: Vec<usize>,
}

impl Grounds {
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    fn push(&mut self, ground: RowGround) -> usize {
        self.of.push(ground);
        self.of.len() - 1
    }
}

impl Timeline {
    /// Of `chains` over rows at `positions_m`, on `count` samples `step_s` apart.
    ///
    /// * `maps`: of every place
    /// * `scanned`: the box around the responses
    pub(crate) fn new(
        chains: &[Chain],
        maps: &[ZoneMap],
        zones: &Zones,
        scanned: Rectangle,
        positions_m: &[Position],
        step_s: f64,
        count: usize,
    ) -> Self {
        let of_map = |map: &ZoneMap| RowGround::of(map, positions_m);
        let mut draft = Draft {
            zones,
            scanned,
            positions_m,
            step_s,
            count,
            grounds: Grounds {
                of: maps.iter().map(of_map).collect(),
                rows: positions_m.len(),
            },
            segments: Vec::new(),
            group: 0,
            event: 0,
        };
        let mut ends = Vec::new();
        for (event, chain) in chains.iter().enumerate() {
            let end = chains
                .get(event + 1)
                .map_or(count, |next| draft.sample(next.start_s()));
            ends.push(end);
            draft.event = event;
            let rise = chain.ramps[0];
            let risen = draft.sample(rise.end_s());
            draft.add(rise.start_s, risen, chain.stops[0], Some(false));
            match &chain.moving {
                Some(moving) => draft.add_travel(chain, moving, end),
                None => draft.add_stops(chain, end),
            }
        }
        Self {
            grounds: draft.grounds,
            segments: draft.segments,
            starts_s: chains.iter().map(Chain::start_s).collect(),
            ends,
        }
    }
}

/// A timeline to which chains are added one by one.
struct Draft<'a> {
    zones: &'a Zones,
    /// The box around the responses.
    scanned: Rectangle,
    positions_m: &'a [Position],
    step_s: f64,
    /// Samples in all.
    count: usize,
    grounds: Grounds,
    segments: Vec<Segment>,
    /// Group of the segments to come.
    group: usize,
    /// Chain of the segments to come.
    event: usize,
}

impl Draft<'_> {
    fn sample(&self, time_s: f64) -> usize {
        ((time_s / self.step_s - tolerances::STEP_ROUNDING)
            .ceil()
            .max(0.0) as usize)
            .min(self.count)
    }

    fn add(&mut self, from_s: f64, to: usize, ground: usize, hot: Option<bool>) {
        self.segments.push(Segment {
            first: self.sample(from_s),
            end: to,
            ground,
            hot,
            group: self.group,
            event: self.event,
        });
    }

    /// The way of a spot in short slices, each with the ground under its middle, and its
    /// fall.
    fn add_travel(&mut self, chain: &Chain, moving: &Move, end: usize) {
        let (rise, fall) = (chain.ramps[0], chain.ramps[chain.ramps.len() - 1]);
        let slices = (moving.travel_s() / tolerances::SPOT_STEP_S)
            .ceil()
            .max(1.0);
        let slice_s = moving.travel_s() / slices;
        for k in 0..slices as usize {
            let from_s = rise.end_s() + slice_s * k as f64;
            let along = moving.length_m() * (k as f64 + 0.5) / slices;
            let spot = Zones {
                layout: ZoneLayout::Spot {
                    centre_m: moving.place(along),
                    hot_radius_m: moving.hot_radius_m,
                    quiet_from_m: moving.quiet_from_m,
                },
                ..self.zones.clone()
            };
            let under = RowGround::of(&spot.over(self.scanned), self.positions_m);
            let ground = self.grounds.push(under);
            let to = self.sample(from_s + slice_s);
            self.add(from_s, to, ground, Some(true));
        }
        let last = *chain.stops.last().unwrap_or(&chain.stops[0]);
        self.add(fall.start_s, end, last, None);
        self.group += 1;
    }

    /// The hold of each stop, and the fade to the next.
    fn add_stops(&mut self, chain: &Chain, end: usize) {
        for (k, &stop) in chain.stops.iter().enumerate() {
            let (before, after) = (chain.ramps[k], chain.ramps[k + 1]);
            let hold_end = self.sample(after.start_s) + 1;
            self.add(before.end_s(), hold_end.min(end), stop, Some(true));
            let leaving_s = self.step_s * hold_end as f64;
            match chain.stops.get(k + 1) {
                None => self.add(leaving_s, end, stop, None),
                Some(&next) => {
                    let both = common_cold(&self.grounds.of[stop], &self.grounds.of[next]);
                    let ground = self.grounds.push(both);
                    let to = self.sample(after.end_s());
                    self.add(leaving_s, to, ground, None);
                }
            }
            self.group += 1;
        }
    }
}

/// Cold ground of both, during a fade.
fn common_cold(a: &RowGround, b: &RowGround) -> RowGround {
    let classes = a
        .classes
        .iter()
        .zip(&b.classes)
        .map(|(a, b)| match (a, b) {
            (Ground::Cold, Ground::Cold) => Ground::Cold,
            _ => Ground::Ignored,
        })
        .collect();
    RowGround {
        classes,
        levels: a.levels.clone(),
    }
}
