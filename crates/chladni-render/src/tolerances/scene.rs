//! Constants of scenes and their zones: meaning, unit, origin.

/// Positions closer than this are the same place, m. From the scene contract. Ten times
/// less: coordinates printed with six digits fall off the border they lie on; ten times
/// more is still far below any measuring grid.
pub const POSITION_M: f64 = 1e-6;

/// Largest number of cells of a grid. Bounds the work that a scene file can ask for; real
/// scenes have a few.
pub const MAX_CELLS: usize = 100_000;

/// Largest number of corners of all polygons together. Their union is found in
/// quadratic time; ten times more would take half a minute.
pub const MAX_POLYGON_POINTS: usize = 2000;

/// Largest level of a scene, dB: from the threshold of a fingertip to what no panel
/// survives are some 100 dB.
pub const MOST_DB: f64 = 200.0;

/// Frequencies closer than this, relative, are the same line. Six printed digits of an
/// axis; ten times less calls a line of a single-precision axis another one, ten times
/// more is a fifth of a bandwidth at 0.005 % loss.
pub const SAME_FREQUENCY: f64 = 1e-6;

/// Distance of two tones, Hz, below which they are refused: they beat for ten seconds and
/// more, one tone that swells and fades. Ten times more would refuse what two close modes
/// ask for, ten times less is no pattern of two tones.
pub const LEAST_TONE_DISTANCE_HZ: f64 = 0.1;

/// Largest drift of a scene, relative: a part of what drifts.
pub const MOST_DRIFT: f64 = 1.0;

/// Distance of the tones that a band of a drive is made of, Hz: half of a narrow mode's
/// bandwidth on a glass panel, so that none falls between them.
pub const BAND_STEP_HZ: f64 = 2.0;

/// Most tones of one drive. Each costs a rendering of its own, and has so small a part of
/// what all share.
pub const MOST_TONES: usize = 64;

/// Relative width of a limit: a drive scaled to meet it exactly meets it after rounding,
/// too. A thousand roundings; the difference it can make to a judgement is 1e-11 dB.
pub const LIMIT: f64 = 1e-12;

/// Corners of the outline of a spot, for pictures.
pub const SPOT_CORNERS: usize = 48;
