//! Plane geometry of the zones: rectangles, polygons, distances and the border of a
//! union.

use crate::tolerances;

/// A position in the plane of the plate, m.
pub type Position = [f64; 2];

/// An axis-parallel rectangle, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Smaller x.
    pub x_min: f64,
    /// Smaller y.
    pub y_min: f64,
    /// Larger x.
    pub x_max: f64,
    /// Larger y.
    pub y_max: f64,
}

impl Rectangle {
    /// From `[x_min, y_min, x_max, y_max]`.
    pub fn from_array([x_min, y_min, x_max, y_max]: [f64; 4]) -> Self {
        Self {
            x_min,
            y_min,
            x_max,
            y_max,
        }
    }
    /// The smallest one that holds all `points`; `None` without points.
    pub fn around(points: &[Position]) -> Option<Self> {
        let first = points.first()?;
        let start = Self {
            x_min: first[0],
            y_min: first[1],
            x_max: first[0],
            y_max: first[1],
        };
        Some(points.iter().fold(start, |r, p| Self {
            x_min: r.x_min.min(p[0]),
            y_min: r.y_min.min(p[1]),
            x_max: r.x_max.max(p[0]),
            y_max: r.y_max.max(p[1]),
        }))
    }
    /// True inside and on the border.
    pub fn contains(&self, [x, y]: Position) -> bool {
        let e = tolerances::POSITION_M;
        x >= self.x_min - e && x <= self.x_max + e && y >= self.y_min - e && y <= self.y_max + e
    }
    /// The same with every side farther out by `width_m`.
    pub(crate) fn grown(&self, width_m: f64) -> Self {
        Self {
            x_min: self.x_min - width_m,
            y_min: self.y_min - width_m,
            x_max: self.x_max + width_m,
            y_max: self.y_max + width_m,
        }
    }
    /// Corners, counter-clockwise from (x_min, y_min).
    pub fn corners(&self) -> [Position; 4] {
        [
            [self.x_min, self.y_min],
            [self.x_max, self.y_min],
            [self.x_max, self.y_max],
            [self.x_min, self.y_max],
        ]
    }
}

/// The metric of distances from a border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Metric {
    /// max(|Δx|, |Δy|).
    Larger,
    /// √(Δx² + Δy²).
    Euclidean,
}

/// True where some corner of the area lies to the right of a → b, that is on the side
/// that is not hot.
pub(crate) fn area_goes_on_beyond(area: &Rectangle, a: Position, b: Position) -> bool {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let beyond =
        |p: Position| ((p[0] - a[0]) * (b[1] - a[1]) - (p[1] - a[1]) * (b[0] - a[0])) / length;
    area.corners()
        .into_iter()
        .any(|corner| beyond(corner) > tolerances::POSITION_M)
}

/// The pieces of the polygons' sides that have hot ground on one side only, directed with
/// the hot ground on their left.
pub(crate) fn union_border(polygons: &[Vec<Position>]) -> Vec<[Position; 2]> {
    let sides: Vec<[Position; 2]> = polygons.iter().flat_map(|polygon| sides(polygon)).collect();
    let is_hot = |point| {
        polygons
            .iter()
            .any(|polygon| polygon_contains(polygon, point))
    };
    let mut border = Vec::new();
    for &[a, b] in &sides {
        let along = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        // Far enough from the side that `polygon_contains` does not count the point as
        // lying on it.
        let step = 3.0 * tolerances::POSITION_M / length;
        let left = |[x, y]: Position, sign: f64| {
            [
                x - sign * step * (b[1] - a[1]),
                y + sign * step * (b[0] - a[0]),
            ]
        };
        let mut cuts: Vec<f64> = sides
            .iter()
            .flat_map(|&other| crossings([a, b], other))
            .chain([0.0, 1.0])
            .collect();
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            if (pair[1] - pair[0]) * length <= tolerances::POSITION_M {
                continue;
            }
            let middle = along(0.5 * (pair[0] + pair[1]));
            match (is_hot(left(middle, 1.0)), is_hot(left(middle, -1.0))) {
                (true, false) => border.push([along(pair[0]), along(pair[1])]),
                (false, true) => border.push([along(pair[1]), along(pair[0])]),
                _ => {}
            }
        }
    }
    border
}

pub(crate) fn sides(polygon: &[Position]) -> impl Iterator<Item = [Position; 2]> + '_ {
    let next = polygon.iter().skip(1).chain(polygon.first());
    polygon
        .iter()
        .zip(next)
        .map(|(&a, &b)| [a, b])
        .filter(|[a, b]| a != b)
}

/// True where two sides of a polygon cross; sides that only touch do not.
pub(crate) fn crosses_itself(polygon: &[Position]) -> bool {
    let sides: Vec<[Position; 2]> = sides(polygon).collect();
    let apart = |[a, b]: [Position; 2], [c, d]: [Position; 2]| {
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let [c, d] = [c, d].map(|point| turn(a, b, point) / length);
        c.abs().min(d.abs()) > tolerances::POSITION_M && (c < 0.0) != (d < 0.0)
    };
    let crossed = |(k, &side): (usize, &[Position; 2])| {
        let mut others = sides[k + 1..].iter();
        others.any(|&other| apart(side, other) && apart(other, side))
    };
    sides.iter().enumerate().any(crossed)
}

/// Points on a → b (0..1) where the other side crosses it, or one of its ends lies on it.
fn crossings([a, b]: [Position; 2], [c, d]: [Position; 2]) -> Vec<f64> {
    let (u, w) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]]);
    let squared = u[0] * u[0] + u[1] * u[1];
    let mut cuts = Vec::new();
    for end in [c, d] {
        if distance(Metric::Euclidean, end, a, b) <= tolerances::POSITION_M {
            cuts.push(
                (((end[0] - a[0]) * u[0] + (end[1] - a[1]) * u[1]) / squared).clamp(0.0, 1.0),
            );
        }
    }
    let determinant = u[0] * w[1] - u[1] * w[0];
    let offset = [c[0] - a[0], c[1] - a[1]];
    let (t, s) = (
        (offset[0] * w[1] - offset[1] * w[0]) / determinant,
        (offset[0] * u[1] - offset[1] * u[0]) / determinant,
    );
    // Parallel sides divide by zero; their ends, taken above, are all that matters.
    if t.is_finite() && s.is_finite() && (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&s) {
        cuts.push(t);
    }
    cuts
}

/// Distance of a point from the side a–b (axis-parallel where the metric is
/// [`Metric::Larger`]).
pub(crate) fn distance(metric: Metric, [x, y]: Position, a: Position, b: Position) -> f64 {
    match metric {
        Metric::Larger => {
            let outside =
                |value: f64, p: f64, q: f64| (p.min(q) - value).max(value - p.max(q)).max(0.0);
            outside(x, a[0], b[0]).max(outside(y, a[1], b[1]))
        }
        Metric::Euclidean => {
            let (u, v) = (b[0] - a[0], b[1] - a[1]);
            let t = (((x - a[0]) * u + (y - a[1]) * v) / (u * u + v * v)).clamp(0.0, 1.0);
            ((x - a[0] - t * u).powi(2) + (y - a[1] - t * v).powi(2)).sqrt()
        }
    }
}

/// True inside (even-odd rule) and on the border.
pub(crate) fn polygon_contains(polygon: &[Position], point: Position) -> bool {
    let [x, y] = point;
    let mut inside = false;
    let between = |value: f64, p: f64, q: f64| {
        value >= p.min(q) - tolerances::POSITION_M && value <= p.max(q) + tolerances::POSITION_M
    };
    let mut a = *polygon.last().unwrap_or(&point);
    for &b in polygon {
        let near = between(x, a[0], b[0]) && between(y, a[1], b[1]) && a != b;
        if near && distance(Metric::Euclidean, point, a, b) <= tolerances::POSITION_M {
            return true;
        }
        if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            inside = !inside;
        }
        a = b;
    }
    inside
}

/// Corners of the convex hull, counter-clockwise; fewer than three where all points lie
/// on one line (Andrew's monotone chain).
pub(crate) fn convex_hull(points: &[Position]) -> Vec<Position> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = &Position>| {
        let mut chain: Vec<Position> = Vec::new();
        for &p in points {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter());
    hull.extend(half(&mut sorted.iter().rev()));
    hull
}

/// Twice the area of the triangle a, b, c; positive where it turns left.
fn turn(a: Position, b: Position, c: Position) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
