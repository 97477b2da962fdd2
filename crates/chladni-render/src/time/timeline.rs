//! Ground of each place at each time.

use crate::plane::Position;
use crate::plane::Rectangle;
use crate::time::plan::{Chain, Place, Plan, Spot};
use crate::tolerances;
use crate::zones::{Ground, ZoneLayout, ZoneMap, Zones};
use chladni_frf::{Error, ErrorKind, Result};

/// Ground of the rows while one thing lasts.
#[derive(Debug, Clone)]
pub(crate) struct RowGround {
    pub(crate) classes: Vec<Ground>,
    /// Square of the factor on the limit of each hot row.
    pub(crate) levels: Vec<f64>,
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
        let of_map = |map: &ZoneMap| RowGround {
            classes: positions_m.iter().map(|&p| map.classify(p)).collect(),
            levels: positions_m
                .iter()
                .map(|&p| map.level_at(p).powi(2))
                .collect(),
        };
        let mut grounds = Grounds {
            of: maps.iter().map(of_map).collect(),
            rows: positions_m.len(),
        };
        let sample = |time_s: f64| ((time_s / step_s - 1e-6).ceil().max(0.0) as usize).min(count);
        let mut segments = Vec::new();
        let mut group = 0;
        let mut ends = Vec::new();
        for (event, chain) in chains.iter().enumerate() {
            let end = chains
                .get(event + 1)
                .map_or(count, |next| sample(next.start_s()));
            ends.push(end);
            let mut add = |from_s: f64, to: usize, ground, hot, group| {
                segments.push(Segment {
                    first: sample(from_s),
                    end: to,
                    ground,
                    hot,
                    group,
                    event,
                })
            };
            let first = chain.stops[0];
            let rise = chain.ramps[0];
            add(
                rise.start_s,
                sample(rise.end_s()),
                first,
                Some(false),
                group,
            );
            if let Some(moving) = &chain.moving {
                let fall = chain.ramps[chain.ramps.len() - 1];
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
                        ..zones.clone()
                    };
                    let ground = grounds.push(of_map(&spot.over(scanned)));
                    add(from_s, sample(from_s + slice_s), ground, Some(true), group);
                }
                let last = *chain.stops.last().unwrap_or(&first);
                add(fall.start_s, end, last, None, group);
                group += 1;
                continue;
            }
            for (k, &stop) in chain.stops.iter().enumerate() {
                let (before, after) = (chain.ramps[k], chain.ramps[k + 1]);
                let hold_end = sample(after.start_s) + 1;
                add(before.end_s(), hold_end.min(end), stop, Some(true), group);
                group += 1;
                let leaving_s = step_s * hold_end as f64;
                match chain.stops.get(k + 1) {
                    None => add(leaving_s, end, stop, None, group - 1),
                    Some(&next) => {
                        let both = common_cold(&grounds.of[stop], &grounds.of[next]);
                        let ground = grounds.push(both);
                        add(leaving_s, sample(after.end_s()), ground, None, group - 1);
                    }
                }
            }
        }
        Self {
            grounds,
            segments,
            starts_s: chains.iter().map(Chain::start_s).collect(),
            ends,
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
