//! Constants of the panel at the drive frequency and of its fields: meaning, unit, origin.

/// Number of DOFs that a message lists.
pub const DOFS_SHOWN: usize = 8;

/// Share of the responses that may lie at the place of another one, such as driving points on the
/// back; beyond, positions may be wrong. Judgement: nobody has calibrated it.
pub const MOST_COINCIDING: f64 = 0.1;

/// Relative ridge of every normal matrix, times its mean diagonal: keeps Cholesky alive
/// where the drift is switched off. Ten times less meets rounding (condition 1e13), ten
/// times more is still 60 dB below the default isotropic error.
pub const RIDGE: f64 = 1e-12;

/// Largest spacing of the grid on which areas are judged, m. From the weights contract.
pub const AREA_STEP_M: f64 = 0.005;

/// Largest number of points of that grid; beyond it the step grows. 200 000 points are a
/// plate of 2 m by 2.5 m at 5 mm.
pub const MAX_AREA_POINTS: usize = 200_000;

/// Up to so many responses are interpolated by one system; above, by the
/// [`NEAREST_RESPONSES`] around each place. A wave at 2000 places (largest error, time for
/// a new set of responses), one system against patches: 330 responses 1.0e-3 against
/// 1.2e-3, 11 against 118 ms; 600 2.5e-4 against 3.2e-4, 27 against 131 ms; 2000 both
/// 1e-5, 287 against 155 ms.
pub const GLOBAL_INTERPOLATION: usize = 1000;

/// Responses × places up to which one system serves: 240 MB of numbers.
pub const GLOBAL_BASIS: usize = 30_000_000;

/// Responses around a place that its interpolated value is made of. Three rings of a
/// square grid; fewer lose accuracy at the rim of the scan, more only time.
pub const NEAREST_RESPONSES: usize = 49;

/// Coordinates nearer than this are the same, over the radius of the responses: rounding
/// of grids. A thousand times more would still be below a micrometre.
pub const SAME_COORDINATE: f64 = 1e-10;

/// Rows of places, times distances in x, lines and columns of nodes, over places times nodes,
/// up to which places of one row share sums over nodes; grids of one step have one of each.
/// Beyond, sharing costs more than it saves.
pub const SHARED_MOST: usize = 4;

/// Rms of a mode over the responses, over its rms at the actuators, where no driving
/// point tells. On the study's panel, with actuators at its free edges, 0.44 to 0.93 with
/// a median of 0.58; where actuators stand among the responses it is 1, and a touch does
/// twice to three times as much.
pub const RESPONSES_OVER_ACTUATORS: f64 = 0.6;

/// Relative step of the slope of a field over a natural frequency: a thousandth of a narrow
/// bandwidth, and a thousand times the rounding of its square root.
pub const SLOPE_STEP: f64 = 1e-6;

/// Part of a step by which rounding of decimal lengths may exceed a grid of areas before it gets
/// another step.
pub const AREA_GRID_ROUNDING: f64 = 1e-3;

/// The same of grids of fingers and loads.
pub const GRID_ROUNDING: f64 = 1e-9;

/// Pairs of places and nodes for each pair of distances along x and y from which on sharing
/// distances pays.
pub const PAIRS_PER_DISTANCE: usize = 4;

/// The orders m that are tried, the smoothest first.
pub const ORDERS: [usize; 3] = [4, 3, 2];
