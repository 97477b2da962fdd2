//! The field of a drive: velocities at the responses, and on a fine grid between them.

use crate::panel::drive::Drive;
use crate::panel::interpolation::{Interpolation, Nodes};
use crate::panel::operator::Operator;
use crate::scene::limits::Limits;
use crate::scene::plane::{convex_hull, polygon_contains, Position, Rectangle};
use crate::scene::zones::{Ground, ZoneMap};
use crate::tolerances;
use chladni_frf::Dof;
use ndarray::{Array2, ArrayView1, Axis};
use num_complex::Complex64;

/// Velocities at the responses, m/s, peak phasors of e^{+jωt}.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Response DOFs.
    pub responses: Vec<Dof>,
    /// Their positions, m.
    pub positions_m: Vec<Position>,
    /// Ground of each.
    pub ground: Vec<Ground>,
    /// Velocity along +Z at each, m/s.
    pub velocity_m_per_s: Vec<Complex64>,
}

impl Field {
    /// True where response `k` keeps its limit, that of its zone on hot ground; `None` where it is
    /// not judged.
    pub fn keeps(&self, k: usize, limits: &Limits, zones: &ZoneMap) -> Option<bool> {
        let speed = self.velocity_m_per_s[k].norm();
        match self.ground[k] {
            Ground::Hot => Some(limits.is_felt(speed / zones.level_at(self.positions_m[k]))),
            Ground::Cold => Some(limits.is_quiet(speed)),
            Ground::Ignored => None,
        }
    }
}

/// Velocities on a grid between the responses, m/s, peak phasors of e^{+jωt}.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaField {
    /// Columns of the grid, m, rising.
    pub x_m: Vec<f64>,
    /// Rows of the grid, m, rising.
    pub y_m: Vec<f64>,
    /// Ground of each place; axes (row, column). [`Ground::Ignored`] outside the hull of
    /// the responses.
    pub ground: Array2<Ground>,
    /// Velocity along +Z, m/s, NaN outside the hull of the responses; axes (row, column).
    pub velocity_m_per_s: Array2<Complex64>,
}

impl Field {
    /// The field of `drive`, with the ground that `zones` lays under each response.
    pub(crate) fn new(operator: &Operator, zones: &ZoneMap, drive: &Drive) -> Self {
        Self {
            responses: operator.responses.clone(),
            positions_m: operator.positions_m.clone(),
            ground: operator
                .positions_m
                .iter()
                .map(|&point| zones.classify(point))
                .collect(),
            velocity_m_per_s: operator.mobility.dot(drive).to_vec(),
        }
    }

    /// Interpolates the complex field between the responses, on a grid of at most
    /// [`crate::AREA_STEP_M`] over what is judged, inside the convex hull of the
    /// responses. `None` where they carry no plane, or lie outside the area.
    pub fn area(&self, zones: &ZoneMap) -> Option<AreaField> {
        self.area_from(&Nodes::new(&self.positions_m)?, zones)
    }

    /// The same with the responses made ready before.
    pub(crate) fn area_from(&self, nodes: &Nodes, zones: &ZoneMap) -> Option<AreaField> {
        let places = Places::new(&self.positions_m, zones.area(), tolerances::AREA_STEP_M)?;
        let at_responses = ArrayView1::from(&self.velocity_m_per_s);
        let inside = nodes.field(at_responses, &places.positions_m())?;
        let size = [places.y_m.len(), places.x_m.len()];
        let velocity_m_per_s = laid_out(size, &places.inside, inside);
        let mut ground = Array2::from_elem(velocity_m_per_s.dim(), Ground::Ignored);
        for &(place, point) in &places.inside {
            ground[place] = zones.classify(point);
        }
        Some(AreaField {
            x_m: places.x_m,
            y_m: places.y_m,
            ground,
            velocity_m_per_s,
        })
    }
}

/// A grid between the responses, and the interpolation onto it: made once, it serves any
/// number of fields.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaGrid {
    /// Columns, m, rising.
    pub x_m: Vec<f64>,
    /// Rows, m, rising.
    pub y_m: Vec<f64>,
    /// Row and column, and position, of each grid point inside the hull of the responses.
    pub(crate) places: Vec<([usize; 2], Position)>,
    /// From the responses to `places`.
    interpolation: Interpolation,
}

impl AreaGrid {
    /// The grid of at most `step_m` over `area`, inside the convex hull of the responses;
    /// `None` where they carry no plane, or lie outside the area.
    pub fn new(responses: &[Position], area: Rectangle, step_m: f64) -> Option<Self> {
        let nodes = Nodes::new(responses)?;
        let places = Places::new(responses, area, step_m)?;
        let interpolation = nodes.onto(&places.positions_m())?;
        Some(Self {
            x_m: places.x_m,
            y_m: places.y_m,
            places: places.inside,
            interpolation,
        })
    }

    /// From the responses to [`Self::places`].
    pub(crate) fn interpolation(&self) -> &Interpolation {
        &self.interpolation
    }

    /// The field between the responses from its values at them; axes (row, column), NaN
    /// outside their hull.
    pub fn field(&self, at_responses: &[Complex64]) -> Array2<Complex64> {
        let inside = self
            .interpolation
            .apply(ArrayView1::from(at_responses).insert_axis(Axis(1)));
        laid_out([self.y_m.len(), self.x_m.len()], &self.places, inside)
    }
}

/// Values at places of a grid of so many rows and columns, NaN elsewhere.
fn laid_out(
    size: [usize; 2],
    places: &[([usize; 2], Position)],
    values: impl IntoIterator<Item = Complex64>,
) -> Array2<Complex64> {
    let mut field = Array2::from_elem(size, Complex64::new(f64::NAN, f64::NAN));
    for (&(place, _), value) in places.iter().zip(values) {
        field[place] = value;
    }
    field
}

/// The places of a grid inside the convex hull of the responses.
pub(crate) struct Places {
    x_m: Vec<f64>,
    y_m: Vec<f64>,
    /// Row and column, and position, of each.
    pub(crate) inside: Vec<([usize; 2], Position)>,
}

impl Places {
    /// At most `step_m` apart over `area`; `None` where the responses carry no plane, or
    /// lie outside the area.
    pub(crate) fn new(responses: &[Position], area: Rectangle, step_m: f64) -> Option<Self> {
        let hull = convex_hull(responses);
        let (x_m, y_m) = grid_axes(Rectangle::around(&hull)?, area, step_m)?;
        let mut inside = Vec::with_capacity(x_m.len() * y_m.len());
        for (row, &y) in y_m.iter().enumerate() {
            // a convex hull holds the places between its first and its last of a row
            let holds = |&x: &f64| polygon_contains(&hull, [x, y]);
            if let (Some(first), Some(last)) =
                (x_m.iter().position(holds), x_m.iter().rposition(holds))
            {
                let columns = x_m.iter().enumerate().take(last + 1).skip(first);
                inside.extend(columns.map(|(column, &x)| ([row, column], [x, y])));
            }
        }
        Some(Self { x_m, y_m, inside })
    }

    /// Positions of those inside.
    fn positions_m(&self) -> Vec<Position> {
        self.inside.iter().map(|place| place.1).collect()
    }
}

/// Columns and rows of the grid over the common part of both rectangles, borders
/// included; `None` where that is empty.
fn grid_axes(responses: Rectangle, area: Rectangle, step_m: f64) -> Option<(Vec<f64>, Vec<f64>)> {
    let x = [
        responses.x_min.max(area.x_min),
        responses.x_max.min(area.x_max),
    ];
    let y = [
        responses.y_min.max(area.y_min),
        responses.y_max.min(area.y_max),
    ];
    let (width, height) = (x[1] - x[0], y[1] - y[0]);
    if width <= tolerances::POSITION_M || height <= tolerances::POSITION_M {
        return None;
    }
    let most = tolerances::MAX_AREA_POINTS as f64;
    // of a narrow strip the length alone counts
    let coarsest = (width * height / most).sqrt().max(width.max(height) / most);
    let step = step_m.max(coarsest);
    let axis = |[start, stop]: [f64; 2]| {
        let intervals = ((stop - start) / step - tolerances::AREA_GRID_ROUNDING)
            .ceil()
            .max(1.0) as usize;
        (0..=intervals)
            .map(|k| start + (stop - start) * k as f64 / intervals as f64)
            .collect()
    };
    Some((axis(x), axis(y)))
}
