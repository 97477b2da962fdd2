//! Every constant of this room: meaning, unit, and where it comes from. Facts of a format
//! stand beside its parser.

// consensus.rs

/// Poles that stand for the world outside the band or for background; more than these are
/// not needed to be smooth.
pub(super) const NUISANCE_MOST: usize = 8;

// error_model.rs

/// Least and largest multiplicative part that is believed.
pub(super) const MULTIPLICATIVE_RANGE: (f64, f64) = (1e-4, 0.32);
/// Median of |E|²: a mean over a few columns of exponential variables has its median a
/// little below the mean.
pub(super) const MEDIAN_TO_MEAN: f64 = 0.8;

// evidence.rs

/// Least FRFs from which one that stands alone, or has another phase than all others,
/// tells anything.
pub(super) const FEWEST: usize = 3;

// impulse.rs

/// Parts of the record the energy is summed over.
pub(super) const SEGMENTS: usize = 32;
/// Fewest lines whose impulse response means anything.
pub(super) const LINES_LEAST: usize = 64;
/// Fall of the impulse response at the end of a padded record, dB.
pub(super) const CUT_DB: f64 = 8.0;
/// A decay that grows by this much from one quarter of the record to the next is a
/// window's, dB. Modes alone decay ever more slowly, and a uniform window takes 1.6 dB; a
/// Hann window takes 9 dB (random) to 13 dB (burst).
pub(super) const WINDOWED_DB: f64 = 6.0;

// local.rs

/// Relative rise of the local sum of squares below which a pole is not needed.
pub(super) const NEEDED: f64 = 0.35;
/// One-column gains above this need no refit to be believed: neighbours take over a part,
/// never four fifths.
pub(super) const CLEAR: f64 = 4.0;
/// Poles closer than this many half-bandwidths move with the candidate.
pub(super) const NEAR: f64 = 6.0;
/// Most poles that move with it.
pub(super) const MOST: usize = 5;
/// Residual terms of a window: what far poles change by when their residues follow is
/// smooth there.
pub(super) const POWERS: [i32; 2] = [0, 1];
/// Half-bandwidths, and lines, around each moving pole that a window holds.
pub(super) const REACH: (f64, usize) = (6.0, 8);

// path.rs

/// Most columns the path works on; more FRFs than that are compressed.
pub(super) const COLUMNS_MOST: usize = 24;

// resolved.rs

/// Half-width in lines from which a line counts as resolved.
pub(super) const RESOLVED_LINES: f64 = 0.5;
/// Half-widths within which no other pole may stand.
pub(super) const ALONE: f64 = 12.0;
/// Half-widths of the window of a resolved mode.
pub(super) const WINDOW: f64 = 4.0;

// search.rs

/// Multiplicative error above which residual peaks are leakage, not modes.
pub(super) const RESEED_BELOW: f64 = 0.01;
/// Rounds of estimating the error model from residuals.
pub(super) const WEIGHT_ROUNDS: usize = 2;
/// Peaks of the residual tried per round, and rounds.
pub(super) const RESEED: (usize, usize) = (20, 2);
/// Height of a residual peak over the residual's noise, dB.
pub(super) const RESEED_OVER_NOISE_DB: f64 = 10.0;
/// Half-bandwidths of the broader of two poles between which each has a peak of its own.
pub(super) const APART: f64 = 2.5;

// twins.rs

/// Two poles nearer than this many half-bandwidths are looked at.
pub(super) const TWINS_NEAR: f64 = 2.5;
/// Own poles explain the neighbourhood this much better (ratio of sums of squares) and
/// the pair is one mode.
pub(super) const OWN_OVER_PAIR: f64 = 1.3;
/// Residues of the pair that agree this well are one shape.
pub(super) const SAME_SHAPE_MAC: f64 = 0.85;
