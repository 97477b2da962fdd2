//! The ground where the panel is to be felt, where it is to be quiet, and what nobody
//! judges.
//!
//! Ground nearer to a hot border than the transition width is not judged, on either side:
//! with cells of a grid that is the hot rectangle shrunk and grown (distance of the
//! larger coordinate, so that corners stay square), with polygons the ordinary distance.
//! A border counts only where the judged area goes on beyond it; where two hot cells or
//! polygons touch there is no border. Positions are compared to
//! `tolerances::POSITION_M`.

use crate::scene::plane::{
    area_goes_on_beyond, distance, polygon_contains, union_border, Metric, Position, Rectangle,
};
use crate::tolerances;
use crate::tolerances::SPOT_CORNERS;
use chladni_frf::{Error, Result};
use std::collections::BTreeSet;

/// The demand on a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Ground {
    /// To be felt: |v| at least threshold + limen.
    Hot,
    /// To be quiet: |v| at most threshold − limen.
    Cold,
    /// Not judged: transition, outside the area, or declared so.
    Ignored,
}

/// The kind of ground that a polygon of the scene declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PolygonKind {
    /// To be felt.
    Hot,
    /// To be quiet.
    Cold,
    /// Not judged, whatever else covers it.
    Ignore,
}

/// A polygon of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ZonePolygon {
    /// The kind that it declares.
    pub kind: PolygonKind,
    /// Distance of the limit of a hot polygon above threshold + limen, dB.
    pub level_db: f64,
    /// Corners, m, in either sense.
    pub points_m: Vec<Position>,
}

/// The layout of the zones.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ZoneLayout {
    /// Equal cells; those that are not hot are cold.
    Grid {
        /// Columns, rows.
        grid: [usize; 2],
        /// Hot cells, counted from 1, row by row from the corner (x_min, y_min).
        hot: Vec<usize>,
        /// The rectangle that the grid divides; `None`: the area.
        cells_m: Option<[f64; 4]>,
    },
    /// Polygons: `ignore` wins over `hot`, `hot` over `cold`; without any `cold` polygon
    /// all the rest is cold.
    Polygons(Vec<ZonePolygon>),
    /// A disc: hot within one radius, cold beyond the other, not judged between; no
    /// scene file says it, a spot that moves does.
    Spot {
        /// Middle, m.
        centre_m: Position,
        /// Ground within it is hot, m.
        hot_radius_m: f64,
        /// Ground beyond it is cold, m.
        quiet_from_m: f64,
    },
}

/// The `[zones]` of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Zones {
    /// Cells or polygons.
    pub layout: ZoneLayout,
    /// x_min, y_min, x_max, y_max of what is judged, m; `None`: the box around the
    /// responses.
    pub area_m: Option<[f64; 4]>,
    /// Width of the ground on both sides of a hot border that is not judged, m.
    pub transition_m: f64,
}

/// The zones of a scene laid over a panel: the demand on every place.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneMap {
    area: Rectangle,
    hot: Vec<Vec<Position>>,
    /// Factor on the limit of each of `hot`.
    levels: Vec<f64>,
    cold: Vec<Vec<Position>>,
    ignored: Vec<Vec<Position>>,
    border: Vec<[Position; 2]>,
    /// Beyond it nothing is hot, nor in a transition.
    around_hot: Option<Rectangle>,
    metric: Metric,
    transition_m: f64,
    /// Middle of a spot and its two radii, m.
    spot: Option<(Position, [f64; 2])>,
}

impl Zones {
    /// Lays the zones over the panel; `default_area` is the box around the responses.
    pub fn over(&self, default_area: Rectangle) -> ZoneMap {
        let area = self.area_m.map_or(default_area, Rectangle::from_array);
        let mut map = ZoneMap {
            area,
            hot: Vec::new(),
            levels: Vec::new(),
            cold: Vec::new(),
            ignored: Vec::new(),
            border: Vec::new(),
            around_hot: None,
            metric: Metric::Larger,
            transition_m: self.transition_m,
            spot: None,
        };
        match &self.layout {
            ZoneLayout::Grid { grid, hot, cells_m } => {
                map.add_cells(*grid, hot, cells_m.map_or(area, Rectangle::from_array))
            }
            ZoneLayout::Polygons(polygons) => map.add_polygons(polygons),
            ZoneLayout::Spot {
                centre_m,
                hot_radius_m,
                quiet_from_m,
            } => map.add_spot(*centre_m, [*hot_radius_m, *quiet_from_m]),
        }
        map.border
            .retain(|&[a, b]| area_goes_on_beyond(&area, a, b));
        map.around_hot =
            Rectangle::around(&map.hot.concat()).map(|hot| hot.grown(self.transition_m));
        map
    }
}

impl ZoneMap {
    /// Classifies the place `point`, m.
    pub fn classify(&self, point: Position) -> Ground {
        if let Some((centre, [hot, quiet])) = self.spot {
            let from_centre = (point[0] - centre[0]).hypot(point[1] - centre[1]);
            return match from_centre {
                _ if !self.area.contains(point) => Ground::Ignored,
                r if r <= hot + tolerances::POSITION_M => Ground::Hot,
                r if r >= quiet - tolerances::POSITION_M => Ground::Cold,
                _ => Ground::Ignored,
            };
        }
        let inside = |polygons: &[Vec<Position>]| {
            polygons
                .iter()
                .any(|polygon| polygon_contains(polygon, point))
        };
        let is_near = self.around_hot.is_some_and(|hot| hot.contains(point));
        if !self.area.contains(point)
            || inside(&self.ignored)
            || (is_near && self.is_transition(point))
        {
            Ground::Ignored
        } else if is_near && inside(&self.hot) {
            Ground::Hot
        } else if self.cold.is_empty() || inside(&self.cold) {
            Ground::Cold
        } else {
            Ground::Ignored
        }
    }

    /// Factor of the limit at `point` over the scene's: the largest level of the hot
    /// polygons there, 1 elsewhere.
    pub fn level_at(&self, point: Position) -> f64 {
        if self.levels.iter().all(|&level| level == 1.0) {
            return 1.0;
        }
        let here = self
            .hot
            .iter()
            .zip(&self.levels)
            .filter(|(polygon, _)| polygon_contains(polygon, point));
        here.map(|(_, &level)| level)
            .fold(None, |largest: Option<f64>, level| {
                Some(largest.map_or(level, |l| l.max(level)))
            })
            .unwrap_or(1.0)
    }

    /// The area judged, m.
    pub fn area(&self) -> Rectangle {
        self.area
    }

    /// Outlines of the hot cells or polygons, m.
    pub fn hot_outlines(&self) -> &[Vec<Position>] {
        &self.hot
    }

    /// Hot polygons without any hot one of the `places`: numbers from 0, in the order of
    /// [`Self::hot_outlines`].
    pub(crate) fn hot_without(&self, places: &[Position]) -> Vec<usize> {
        let hot: Vec<Position> = places
            .iter()
            .copied()
            .filter(|&place| self.classify(place) == Ground::Hot)
            .collect();
        let is_empty =
            |outline: &[Position]| !hot.iter().any(|&place| polygon_contains(outline, place));
        (0..self.hot.len())
            .filter(|&k| is_empty(&self.hot[k]))
            .collect()
    }

    /// Width of the transition on each side of a hot border, m.
    pub fn transition_m(&self) -> f64 {
        self.transition_m
    }

    fn is_transition(&self, point: Position) -> bool {
        let near = |&[a, b]: &[Position; 2]| {
            distance(self.metric, point, a, b) < self.transition_m - tolerances::POSITION_M
        };
        self.border.iter().any(near)
    }

    /// Hot cells, and those of their sides that have no hot neighbour; each side runs
    /// with the hot ground on its left.
    fn add_cells(&mut self, [columns, rows]: [usize; 2], hot: &[usize], cells: Rectangle) {
        let hot: BTreeSet<(usize, usize)> = hot
            .iter()
            .map(|cell| ((cell - 1) % columns, (cell - 1) / columns))
            .collect();
        let x = |i: usize| cells.x_min + (cells.x_max - cells.x_min) * i as f64 / columns as f64;
        let y = |j: usize| cells.y_min + (cells.y_max - cells.y_min) * j as f64 / rows as f64;
        for &(i, j) in &hot {
            let corners = Rectangle {
                x_min: x(i),
                y_min: y(j),
                x_max: x(i + 1),
                y_max: y(j + 1),
            }
            .corners();
            let below = j.checked_sub(1).is_some_and(|j| hot.contains(&(i, j)));
            let left = i.checked_sub(1).is_some_and(|i| hot.contains(&(i, j)));
            let neighbours = [
                below,
                hot.contains(&(i + 1, j)),
                hot.contains(&(i, j + 1)),
                left,
            ];
            for (side, is_hot) in neighbours.into_iter().enumerate() {
                if !is_hot {
                    self.border.push([corners[side], corners[(side + 1) % 4]]);
                }
            }
            self.hot.push(corners.to_vec());
            self.levels.push(1.0);
        }
    }

    fn add_spot(&mut self, centre: Position, radii_m: [f64; 2]) {
        let corner = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / SPOT_CORNERS as f64;
            let (sine, cosine) = angle.sin_cos();
            [
                centre[0] + radii_m[0] * cosine,
                centre[1] + radii_m[0] * sine,
            ]
        };
        self.hot.push((0..SPOT_CORNERS).map(corner).collect());
        self.levels.push(1.0);
        self.spot = Some((centre, radii_m));
    }

    fn add_polygons(&mut self, polygons: &[ZonePolygon]) {
        self.metric = Metric::Euclidean;
        for polygon in polygons {
            if polygon.kind == PolygonKind::Hot {
                self.levels.push(10f64.powf(polygon.level_db / 20.0));
            }
            let list = match polygon.kind {
                PolygonKind::Hot => &mut self.hot,
                PolygonKind::Cold => &mut self.cold,
                PolygonKind::Ignore => &mut self.ignored,
            };
            list.push(polygon.points_m.clone());
        }
        self.border = union_border(&self.hot);
    }
}

/// Refuses a scene without hot or without cold responses.
pub(crate) fn check_zones(hot: usize, cold: usize) -> Result<()> {
    for (name, count, other) in [("hot", hot, cold), ("cold", cold, hot)] {
        if count == 0 {
            return Err(Error::bad_data(format!("no response lies in the {name} zone"))
                .field("zones")
                .found(format!("0 {name} responses and {other} of the other kind, outside the \
                                transition"))
                .expected(format!("at least one {name} response"))
                .help("check area_m and cells_m against the positions of the nodes (metres), and \
                       transition_m against their spacing"));
        }
    }
    Ok(())
}
