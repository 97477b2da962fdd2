//! Every constant of this room: meaning, unit, origin, and the effect of other values if they were
//! tried.
//!
//! A value without an origin is judgement; it was not calibrated.

// incomplete.rs

/// Part of the lines that gaps may cost without a caution. An FRF whose own gaps cost more may be left
/// out. Beyond it modes of a part of the band may be lost.
pub(super) const LINES_LOST: f64 = 0.1;

// information.rs

/// Part (square) of an unknown in directions without information, from which the unknown is not
/// determined. Rounding of the eigenvectors reaches 1e-12.
pub(super) const IN_THE_DARK: f64 = 1e-6;
/// Least share of an error of a line that counts as staying in the residual: a line that the model
/// interpolates shows nothing of its own error.
pub(super) const LEAST_KEPT: f64 = 0.1;

// layout.rs

/// Relative difference of the record length from the inverse of the line spacing, from which
/// records count as padded. Rounding of the axis is far below it.
pub(super) const OTHER_LENGTH: f64 = 0.01;

// line_variance.rs

/// Part that the denominator of the local rational method adds to the variance of an FRF if it is
/// estimated from one response alone. Estimated from L responses together it adds 1/L of that, by the
/// same error in all. Against the truth of simulated tests sums over three responses had 1.23 times the
/// variance of independent errors, (1 + 0.4)/(1 + 0.4/3), near modes and far from them, at 30 and
/// 50 dB, half a line to two lines per bandwidth; measured once, with three responses.
pub(super) const OF_DENOMINATOR: f64 = 0.4;
/// Part that noise on both sides of the equations of this denominator adds. It is the same error in
/// all responses, whatever their number: at 30 dB errors of poles had 2.6 and 3.0 times the variance
/// of error bars without it for 20 and 30 responses, at 50 dB 1.3 and 1.4 times.
pub(super) const OF_NOISE: f64 = 0.12;
/// Lines of the record in a value of an FRF, over those from one value to the next, from which
/// neighbours share enough of them to correlate: at 1.3 they correlate by 0.03.
pub(super) const LINES_SHARED: f64 = 1.3;
/// Correlation of neighbouring values of the local rational method whose lines overlap by five of 13:
/// 0.08 with one response, 0.12 to 0.15 with three and more, where their denominator follows noise.
pub(super) const OF_SHARED_LINES: f64 = 0.15;
/// Variance over power of an FRF at which half of [`OF_NOISE`] is added.
pub(super) const NOISY_SHARE: f64 = 2e-6;

// memory.rs

/// FRFs per block in a streaming pass: a block of 2000 lines stays in the second-level
/// cache.
pub(super) const BLOCK_FRFS: usize = 64;
/// Least FRFs of a partial sum: fewer, and adding the sums costs more than making them.
pub(super) const GROUP_FRFS: usize = 128;
/// FRFs from which the sums of the first pass are kept for later use: with 80 columns they are
/// a fiftieth of the data and less, and a pass is a tenth of the fit and more.
pub(super) const SUMS_KEPT_FRFS: usize = 4000;
/// Least number of groups, whatever memory their sums take, if there are FRFs enough: work for as
/// many threads.
pub(super) const GROUPS_LEAST: usize = 2;

// fourth_difference.rs

/// Part of themselves by which gaps between lines may differ and count as even: digits that a file
/// rounds make that much.
pub(super) const EVEN_LINES: f64 = 0.01;
/// Factors of the fourth difference of even lines.
pub(super) const DIFFERENCE_OF_EVEN: [f64; 5] = [1.0, -4.0, 6.0, -4.0, 1.0];
/// Sum of the squares of these: E|Δ⁴n|² over σ².
pub(super) const DIFFERENCE_OF_NOISE: f64 = 70.0;

// noise_levels.rs

/// Spread of the noise energies of FRFs from which each has a noise of its own: the gain of a pole
/// that noise feigns grows by this part of itself.
pub(super) const UNEVEN_NOISE: f64 = 0.1;

// noise_weights.rs

/// Loss of variance by equal weights, mean(σ²)·mean(1/σ²) − 1, from which FRFs are
/// weighted. Noise within a factor 1.5 stays below.
pub(super) const WORTH_WEIGHING: f64 = 0.1;
/// Relative error of a fit below which its residual is rounding and not noise.
pub(super) const ROUNDING: f64 = 1e-7;
/// Sweeps of the two-way mean; a complete set is exact after one.
pub(super) const SWEEPS: usize = 20;

// noisy_frfs.rs

/// Noise over the median noise, absolute and relative to the FRF, from which an FRF is
/// left out. It then carries less than 2 % of the information of another; smooth
/// differences of shape between FRFs reach 3.
pub(super) const FAR: f64 = 8.0;
/// Largest share of the FRFs that may go: beyond it there is no usual noise to compare
/// with.
pub(super) const NOISY_FRFS_SHARE_MOST: f64 = 0.25;
/// Stencils of five lines that the noise is estimated from, in all FRFs together. 16 of one FRF
/// give it to a quarter, and many FRFs together still cost far less than a pass over the
/// data.
pub(super) const STENCILS_IN_ALL: usize = 50_000;
/// Fewest and most stencils of one FRF, see [`STENCILS_IN_ALL`].
pub(super) const STENCILS: (usize, usize) = (16, 200);

// onset.rs

/// Fewest lines whose impulse response means anything.
pub(super) const LINES_LEAST: usize = 64;
/// Energy at the place of a step under the taper, over that after it: a quarter.
pub(super) const ONSET: f64 = 0.25;
/// Samples around a step over which it rises under the taper.
pub(super) const ONSET_WIDTH: usize = 4;
/// Fewest samples of silence before an onset that counts, with this rise.
pub(super) const ONSET_LEAST: usize = 16;
/// Energy of a silent sample over the largest: the tail of a record that wraps around, or noise
/// of some 10 dB, has more.
pub(super) const SILENT: f64 = 1e-2;
/// Deviation of a spacing, relative, from which on lines are not even.
pub(super) const UNEVEN: f64 = 0.05;

// options.rs

/// Columns of the count sketch, unless told otherwise. 64–96 keep every mode that stands
/// out of the noise (study); fewer lose weak modes that share a bucket, more only cost
/// time.
pub(super) const SKETCH_COLUMNS: usize = 80;
/// Most passes over the data beyond the two, for modes that only all FRFs together show
/// and for columns without the noise of poles that are gone.
pub(super) const EXTRA_PASSES: usize = 3;

// outliers.rs

/// Residual energy over the level around it from which a line is an outlier. (One FRF of
/// white noise reaches 20 times its median on one line of a million.)
pub(super) const OVER_LEVEL: f64 = 30.0;
/// Residual energy over the level around it, up to which a neighbour is sound.
pub(super) const SOUND: f64 = 8.0;
/// Share of the model's own energy on the line that the residual must reach: less is
/// misfit of a resonance.
pub(super) const OF_MODEL: f64 = 0.1;
/// Most neighbouring outliers.
pub(super) const RUN_MOST: usize = 2;
/// Largest share of the lines that may be left out: more are no outliers.
pub(super) const OUTLIERS_SHARE_MOST: f64 = 0.15;
/// Lines on both sides that the level is taken from.
pub(super) const AROUND: usize = 20;
/// The usual share of misfit is taken from the strongest lines of the model, one in so many.
pub(super) const STRONGEST_ONE_IN: usize = 7;
/// Outlier lines that a finding lists before it only counts.
pub(super) const OUTLIERS_SHOWN: usize = 8;

// peaks.rs

/// Prominence of a peak of the mean |FRF|² that may seed a pole, dB.
pub(super) const SEED_PROMINENCE_DB: f64 = 4.0;
/// Height of a seed over the local noise, dB.
pub(super) const SEED_OVER_NOISE_DB: f64 = 6.0;
/// Prominence and height over the local noise of a peak that must be explained, dB. Side
/// lobes and noise stay below.
pub(super) const STRIKING_PROMINENCE_DB: f64 = 12.0;
/// See [`STRIKING_PROMINENCE_DB`].
pub(super) const STRIKING_OVER_NOISE_DB: f64 = 20.0;
/// Most seeds.
pub(super) const SEEDS_MOST: usize = 100;
/// Records longer than this keep all lines near the peaks and thin out the rest.
pub(super) const DECIMATE_ABOVE_LINES: usize = 4000;
/// Fewest lines that fourth differences, and peaks, are looked for on.
pub(super) const DIFFERENCES_LEAST_LINES: usize = 6;
/// Columns whose fourth differences are summed together; fixed, so that the bits do not depend on
/// the number of threads.
pub(super) const DIFFERENCES_BLOCK: usize = 8;
/// See [`DIFFERENCES_LEAST_LINES`].
pub(super) const PEAKS_LEAST_LINES: usize = 5;
/// Values of a running median over half a window: between them it is held.
pub(super) const MEDIANS_PER_HALF_WINDOW: usize = 8;
/// Fall from a peak at which its width is taken, dB: half power.
pub(super) const WIDTH_DROP_DB: f64 = 3.0;
/// Half-bandwidth of a starting pole over half of the width of its peak, which is measured between
/// lines outside it.
pub(super) const START_OF_WIDTH: f64 = 0.7;
/// Least half-width of a peak in lines, for what is kept around it.
pub(super) const KEPT_LEAST_HALF_WIDTH: f64 = 0.5;
/// Half-widths, and lines, kept on both sides of a peak of a long record.
pub(super) const KEPT_AROUND: (f64, f64) = (25.0, 30.0);

// products.rs

/// Least share of a line's noise that a model leaves in the residual, to divide by: below it the
/// residual is rounding.
pub(super) const LEVERAGE_LEFT: f64 = 0.05;
/// Directions of the second pass weaker than this part of the strongest (in energy) are
/// rounding: the Gram matrix holds them to about 1e-16 of it.
pub(super) const GRAM_ROUNDING: f64 = 1e-13;
/// Part of each direction of the second pass outside those before it, above which all are far from
/// rounding.
pub(super) const GRAM_SOUND: f64 = 1e-6;
/// Least FRFs of a partial sum for each of its columns: so the sums of all groups take an eighth of
/// the data at most.
pub(super) const GROUP_COLUMNS: usize = 8;

// reading.rs

/// Partial sums, which the processor adds in parallel.
pub(super) const READING_LANES: usize = 4;

// screening.rs

/// Lines needed beyond the number of modes.
pub(super) const LINES_TO_SPARE: usize = 8;
/// Least width of a band over its upper end: on 41 lines fits held from 1e-4 on, and the
/// powers of ω were one column less by their rank at 6e-5.
pub(super) const NARROWEST_BAND: f64 = 8e-5;
/// Root mean square of FRFs that a model file can hold, in the measured kind: its numbers
/// end at 1e100, a participation has ω² more than its FRF, and squares must stay above zero.
pub(super) const SENSIBLE_RMS: [f64; 2] = [1e-153, 1e90];
/// FRFs that an error lists before it only counts.
pub(super) const PAIRS_SHOWN: usize = 6;

// sketch.rs

/// Partial sums, which the processor adds in parallel.
pub(super) const SKETCH_LANES: usize = 8;

// window/band.rs

/// Decay after which a response has forgotten its force, nepers (1 %).
pub(super) const MEMORY_NEPERS: f64 = 4.6;
/// Records that the memory of a response goes back at most.
pub(super) const MEMORY_RECORDS: f64 = 3.0;
/// Least decay over a record, nepers, to divide by.
pub(super) const DECAY_LEAST_NEPERS: f64 = 1e-3;

// window/block_errors.rs

/// Places of a record at which force and windows are taken: lines up to half as many cycles
/// from the middle of a band.
pub(super) const RECORD_POINTS: usize = 64;
/// Distance of blocks over the record length, if it is not known.
pub(super) const HOP_ASSUMED: f64 = 0.5;
/// Part of the transform length that a gate fills if nothing was padded. A shorter gate is followed
/// by zeros.
pub(super) const GATE_WHOLE: f64 = 0.99;

// window/kernel.rs

/// Harmonics at the end of a series with less than this share of it are left out.
pub(super) const CUT_SHARE: f64 = 1e-9;

// window/kinds.rs

/// Largest β: of a window that is all but a point.
pub(super) const BETA_MOST: f64 = 40.0;
/// Parts of a record that a burst under Hann's window may last: the window rises with the square of the
/// time, and of a shorter burst nothing is left beside what rounding leaves.
pub(super) const HANN_BURST_PARTS: std::ops::RangeInclusive<f64> = 0.05..=1.0;
/// Numbers of values and of harmonics for a window without a closed form.
pub(super) const BY_VALUES: (usize, usize) = (1024, 256);

// window/leakage.rs

/// Least part of its decay that a pole keeps when the broadening by a window is taken off roughly.
pub(super) const LEAST_DECAY_LEFT: f64 = 0.3;
/// Halvings of an interval for the decay without broadening: to 1e-9 of the interval.
pub(super) const HALVINGS: usize = 30;

// window/ramps.rs

/// Below this |z| quotients lose digits and series are used.
pub(super) const SERIES_BELOW: f64 = 1.0;
/// Terms of a series: the last is below 1/22! of the sum.
pub(super) const SERIES_TERMS: u32 = 20;

// window/of_set.rs

/// Largest deviation of a line from an even axis, as a part of the spacing.
pub(super) const EVEN: f64 = 0.01;
