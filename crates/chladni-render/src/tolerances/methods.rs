//! Constants of the methods: meaning, unit, origin.

/// Condition number above which the two-step inverse says that it is ill conditioned. The
/// study saw 4e2 for usable sets of modes and 5e5 where forces rose to newtons; ten times
/// more or less only moves a warning.
pub const ILL_CONDITIONED: f64 = 1e4;

/// Relative distance to its limit within which a drive counts as limited. Only decides
/// whether a stronger ridge is tried.
pub const AT_LIMIT: f64 = 1e-6;

/// Gain at which a next row would meet its limit, over that of the last one that does: beyond
/// the last all gains serve the same rows. One of them is tried, the geometric mean of the two.
pub const BEYOND_LAST_GAIN: f64 = 4.0;

/// Ridges, relative to the mean diagonal of the normal matrix, tried in turn where the
/// force limit binds. From below the covariance of a good model to where the drive is
/// little more than time reversal.
pub const FORCE_RIDGES: [f64; 5] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Steps of the magnitude iteration, and how many drives go on after them: from all
/// starts on the responses; from their leaders with every margin; from the leaders of
/// those with the ground between. All drives to the end of every round cost twice the
/// time for the same drives; two at the last end lose 4 % of the hot ground of the 3×3
/// edges.
pub const MLS_ROUNDS: [[(usize, usize); 2]; 3] =
    [[(12, 4), (18, 2)], [(20, 3), (40, 2)], [(10, 4), (30, 4)]];

/// Overshoot of the magnitude iteration, below 2 for convergence; 1 is the plain one.
/// Flat between 1.5 (κ 2.4) and 1.9 (2.6).
pub const MLS_RELAXATION: f64 = 1.8;

/// Rows of a matrix that are summed at once in its steps: eight sums of four lanes are on
/// their way, so that none waits for the one before it.
pub const LANES: usize = 8;

/// Margins by which the iteration wants its rows inside their limits, dB: all starts with
/// the first, the best start with the others. On the corner scene alone: 0.5 dB κ 1.0, 1
/// dB 2.1, 2 dB 3.3, 3 dB 3.0, 4 dB 2.6, 6 dB 1.8.
pub const MLS_MARGINS_DB: [f64; 3] = [2.0, 1.0, 3.0];

/// Weight of rows between the responses against 1 for a response. Without them 20 mm
/// between responses let dips of 1 to 2 dB through (hot ratio of the corner scene's area
/// 0.93 against 0.98); at 1, scenes near what is possible give up responses for the
/// ground between them.
pub const BETWEEN_WEIGHT: f64 = 0.3;

/// κ above which more of it counts less than ground between the responses. Two standard
/// deviations hold for most of some 70 responses at once.
pub const KAPPA_ENOUGH: f64 = 2.0;

/// κ that differ by less than this, relative, are the same: a thousand roundings of a
/// conic program.
pub const SAME_KAPPA: f64 = 1e-4;

/// Ridge of the baseline `tikhonov` over the largest eigenvalue of HᴴH; the best of the
/// study's grid of powers of ten.
pub const TIKHONOV: f64 = 1e-3;

/// Least singular value of the baseline `tsvd` over the largest.
pub const TSVD: f64 = 1e-2;

/// Directions of the baseline `vast`: the study's choice.
pub const VAST_RANK: usize = 8;

/// κ of `min-effort`.
pub const KAPPA_EFFORT: f64 = 1.0;

/// Most starts of conic programs, with method `best`.
pub const MOST_STARTS: usize = 3;

/// Likeness |aᴴb|/(‖a‖‖b‖) of drives that lead to the same place.
pub const SAME_WAY: f64 = 0.95;

/// Largest responses × actuators² for which the default method is `robust`. For 34 actuators
/// 77 responses (8.9e4) take 0.03 s of processor time, 330 (3.8e5) 0.06 s, 693 (8e5) 0.15 s, a
/// scene of the last that no drive serves 1.2 s; its programs grow with this number.
pub const ROBUST_SIZE: f64 = 1e6;

/// Errors of each actuator's force for its weight that a drive of method `robust` tolerates
/// where its scene names none and margin allows, rms of the complex factor, relative. The
/// first is that of the scene contract (amplifiers of 1 % and 1°). docs/accuracy.md has what
/// each buys and costs.
pub const TOLERATED_DRIVE_ERRORS: [f64; 2] = [0.02, 0.01];
