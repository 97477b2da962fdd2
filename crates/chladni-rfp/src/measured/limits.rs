//! Every constant of this room: meaning, unit, and where it comes from.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// candidates.rs

/// Half-bandwidths of the broader within which a pole explains a peak.
pub(super) const EXPLAINS: f64 = 1.5;

// consensus.rs

/// Poles that represent out-of-band modes or background; more are not needed to be smooth.
pub(super) const NUISANCE_MOST: usize = 8;
/// Orders of the three runs, over the number of peaks or of modes asked for, and poles
/// beside them.
pub(super) const LADDER: [f64; 3] = [1.0, 1.5, 2.2];
/// See [`LADDER`].
pub(super) const LADDER_EXTRA: usize = 4;
/// Poles beyond the strong peaks, in the three runs that start from these alone.
pub(super) const STRONG_EXTRA: [usize; 3] = [4, 8, 14];
/// Lines per pole of a run at least.
pub(super) const LINES_PER_POLE: usize = 4;
/// Seed of the random mixtures of every run: any serves.
pub(super) const VOTE_SEED: u64 = 7;
/// Half-bandwidths of the broader, or lines, within which two poles are the same.
pub(super) const SAME_POLE: f64 = 0.5;
/// Least share of the runs of a ladder that makes a pole: half.
pub(super) const AGREED_LEAST: f64 = 0.5;

// correlated_noise.rs

/// Correlation of noise on neighbouring lines from which on it makes poles: under a
/// rectangular window lines one cycle of the record apart have none.
pub(super) const CORRELATION_LEAST: f64 = 0.3;
/// Half-width of a pole, cycles per record, from which on it is far broader than what
/// correlation makes; and cycles on both sides of a pole in which noise is whitened.
pub(super) const CORRELATION_WIDEST: f64 = 8.0;
/// See [`CORRELATION_WIDEST`].
pub(super) const CORRELATION_REACH: f64 = 16.0;
/// Part of the variance that is white in any case: no correlation is exact.
pub(super) const CORRELATION_WHITE: f64 = 1e-3;

// error_model.rs

/// Least and largest multiplicative part that is believed.
pub(super) const MULTIPLICATIVE_RANGE: (f64, f64) = (1e-4, 0.32);
/// Median of |E|²: a mean over a few columns of exponential variables has its median a
/// little below the mean.
pub(super) const MEDIAN_TO_MEAN: f64 = 0.8;
/// Multiplicative part at the start: gain noise of 2 %.
pub(super) const MULTIPLICATIVE_START: f64 = 0.02;
/// Least additive variance of a line over the mean, or over the largest mean square of
/// the model: rounding.
pub(super) const ADDITIVE_LEAST: f64 = 1e-12;
/// Half window of the additive level: one in so many lines, at least and at most so many.
pub(super) const LEVEL_WINDOW: (usize, usize, usize) = (16, 20, 400);
/// Lines, in per cent, that tell the multiplicative part: the strongest of the model.
pub(super) const STRONGEST_PERCENT: usize = 15;
/// Part of the mean square of an FRF that its scale holds beside its noise: 1 % of its
/// rms.
pub(super) const OWN_SHARE: f64 = 1e-4;

// evidence.rs

/// Least FRFs from which one that stands alone, or has another phase than all others,
/// tells anything.
pub(super) const FEWEST: usize = 3;
/// Half-bandwidths, and lines, on both sides of a pole on which misfit is told.
pub(super) const MISFIT_WINDOW: (f64, usize) = (1.5, 2);
/// The same on which its peak is looked for.
pub(super) const PEAK_WINDOW: (f64, usize) = (1.0, 1);
/// The same that are its surroundings: 30 bandwidths.
pub(super) const SURROUNDINGS: (f64, usize) = (60.0, 30);

// impulse.rs

/// Parts of the record the energy is summed over.
pub(super) const SEGMENTS: usize = 32;
/// Fall of the impulse response at the end of a padded record, dB.
pub(super) const CUT_DB: f64 = 8.0;
/// A decay that grows by this much from one quarter of the record to the next is a
/// window's, dB. Modes alone decay ever more slowly, and a uniform window takes 1.6 dB; a
/// Hann window takes 9 dB (random) to 13 dB (burst).
pub(super) const WINDOWED_DB: f64 = 6.0;
/// Fall before the cut over that at it from which on the fall is no cut.
pub(super) const TREND_SHARE: f64 = 0.5;
/// Segments before a cut that tell the trend, and those after it that the wrap-around
/// spoils.
pub(super) const TREND_SEGMENTS: usize = 3;
/// See [`TREND_SEGMENTS`].
pub(super) const WRAPPED_SEGMENTS: usize = 2;

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
/// Half-bandwidths of a neighbour that count at most, over that of the candidate.
pub(super) const NEIGHBOUR_WIDTHS: f64 = 2.0;
/// Lines of a neighbourhood beyond its unknowns.
pub(super) const LOCAL_LINES_TO_SPARE: usize = 2;

// path.rs

/// Variance that lines at a peak are told to have, over that of the median line, from which
/// they count as loud: that of a force 6 dB lower there. Seen once, six tests each: 7 and more
/// under 12 dB, 14 and more under noise of the force.
pub(super) const LOUD_AT_PEAKS: f64 = 4.0;
/// Most columns the path works on; more FRFs than that are compressed.
pub(super) const COLUMNS_MOST: usize = 24;
/// Half-bandwidths of a peak that a pole explaining it has at most.
pub(super) const PEAK_WIDTHS: f64 = 2.0;

// record.rs

/// Half window of the noise under peaks: one in so many lines, at least and at most so
/// many.
pub(super) const NOISE_WINDOW: (usize, usize, usize) = (20, 30, 400);

// resolved.rs

/// Half-width in lines from which a line counts as resolved.
pub(super) const RESOLVED_LINES: f64 = 0.5;
/// Half-widths within which no other pole may stand.
pub(super) const ALONE: f64 = 12.0;
/// Half-widths of the window of a resolved mode.
pub(super) const WINDOW: f64 = 4.0;
/// Half-widths of another pole within which it may not stand.
pub(super) const ALONE_OF_OTHER: f64 = 2.0;
/// Lines on both sides in such a window at least.
pub(super) const RESOLVED_LEAST_LINES: usize = 6;

// sandwich.rs

/// Half-bandwidths over which lines are taken to correlate: two bandwidths; and the part
/// of the lines that is at most.
pub(super) const LAGS: f64 = 4.0;
/// See [`LAGS`].
pub(super) const LAGS_ONE_IN: usize = 4;

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
/// Fall below the strongest peak up to which peaks are strong, dB.
pub(super) const STRONG_DB: f64 = 30.0;
/// Modes that the orders are made for at least.
pub(super) const BASE_LEAST: usize = 4;
/// Share of the orders, and modal part, below which the partner in a close pair of one
/// FRF is misfit.
pub(super) const SHADOW: (f64, f64) = (0.75, 0.1);
/// Half-bandwidths beyond a cut up to which a section still owns a pole; its twin is
/// dropped.
pub(super) const OWNED_BEYOND: f64 = 0.5;
/// Nearest lines without which a gain is told once more: the two beside a line, and
/// skirts.
pub(super) const NEAREST_LINES: [usize; 2] = [2, 4];
/// Distance of the positions on odd and on even lines over the least standard deviation
/// that it leaves.
pub(super) const ODD_EVEN_SIGMAS: f64 = 4.0;
/// Square of the half-bandwidths from the common pole beyond which the own pole of an FRF
/// counts no farther.
pub(super) const OWN_POLE_FARTHEST: f64 = 4.0;

// moving_pairs.rs

/// Two poles nearer than this many half-bandwidths are looked at.
pub(super) const TWINS_NEAR: f64 = 2.5;
/// Energy that own poles leave over what the pair leaves, from which on the pair is two modes.
pub(super) const OWN_OVER_PAIR: f64 = 1.3;
/// The same as a geometric mean over the FRFs, below which the pair is one mode that moves. Of 60
/// simulated ones none lay above 0.94.
pub(super) const ONE_MODE: f64 = 0.95;
/// ... from which on it is two. Of 60 simulated pairs under noise that follows the FRFs 10 lay
/// below [`OWN_OVER_PAIR`], and of these 9 above 1.12.
pub(super) const MAY_BE_ONE: f64 = 1.1;
/// Residues of the pair that agree this well are one shape.
pub(super) const SAME_SHAPE_MAC: f64 = 0.85;
/// Half-bandwidths, and lines, on both sides of a pair in which own poles are fitted, and
/// steps.
pub(super) const TWINS_WINDOW: (f64, usize) = (6.0, 8);
/// See [`TWINS_WINDOW`].
pub(super) const TWINS_STEPS: usize = 20;
/// Columns from which on residues tell a shape.
pub(super) const SHAPE_LEAST_COLUMNS: usize = 3;
