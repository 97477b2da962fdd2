//! Constants of scenes with fingers: meaning, unit, origin.

/// Most fingers at once: those of one hand.
pub const MOST_FINGERS: usize = 5;

/// Distance of the places that fingers are tried at, m: a fifteenth of a wavelength on the
/// study's panel, half of its responses' spacing.
pub const TOUCH_STEP_M: f64 = 0.010;

/// Most of these places; beyond, they lie farther apart.
pub const MOST_TOUCH_PLACES: usize = 150;

/// Most places of the grid that these are taken from: 10 m² at [`TOUCH_STEP_M`], some
/// milliseconds.
pub const MOST_TOUCH_GRID: f64 = 1e5;

/// Touched rows that join a conic program at once: they are alike from place to place, so
/// that a few of the worst speak for most.
pub const TOUCH_ROWS_JOINING: usize = 60;

/// Relative shortfall of κ under fingers that counts as none: rows join only where they miss
/// by more than [`JOIN_SLACK`](super::JOIN_SLACK).
pub const SAME_TOUCHED_KAPPA: f64 = 0.02;

/// Motion that a finger takes from its own place, dB, above which no program is tried in a
/// sweep: the study found none that tolerates it.
pub const TOUCH_LOSS_DB: f64 = 3.0;

/// Rounds of programs that a frequency of a sweep is worth.
pub const TOUCH_SWEEP_ROUNDS: usize = 4;
