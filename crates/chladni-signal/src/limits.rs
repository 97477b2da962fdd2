//! Constants of the crate, under the file that uses them: meaning, unit, and where each comes
//! from.

// blows.rs

/// First sample of a blow over its peak from which on its beginning is missing: a bell loses 2 % of
/// its area below a tenth.
pub(crate) const BLOW_CUT: f64 = 0.1;
/// The same over the rms of the last samples, which are noise.
pub(crate) const BLOW_NOISE: f64 = 6.0;
/// Part of a record in which a blow acts, at most: sweeps act longer.
pub(crate) const BLOW_PART: f64 = 0.1;

// clipped.rs

/// Samples at the largest value from which on a record may be clipped.
pub(crate) const CLIPPED_SAMPLES: usize = 5;
/// Values above 0 that a record has at least: of fewer the largest is nothing special.
pub(crate) const CLIPPED_LEVELS: usize = 20;
/// Part of the record at that value from which on it has two levels, or is still.
pub(crate) const CLIPPED_MOST: f64 = 0.4;
/// Values from this part of the largest on lie a little below it.
pub(crate) const CLIPPED_UNDER: f64 = 0.98;
/// Samples at the largest value over those a little below it. A sine on 100 steps has 0.7 of
/// them, noise clipped at three standard deviations 3.5.
pub(crate) const CLIPPED_BESIDE: f64 = 2.0;

// contradictions.rs

/// Contradictions that are told one by one.
pub(crate) const CLAUSES_MOST: usize = 4;
/// Difference of factors up to which they are one.
pub(crate) const SAME_FACTOR: f64 = 0.1;

// estimators.rs

/// References whose smallest normalised principal power is below this act as one.
pub(crate) const SINGULAR: f64 = 1e-10;

// excitation.rs

/// Shortest record that is judged, samples: of shorter ones 16 pieces are a few samples each.
pub(crate) const LEAST_SAMPLES: usize = 256;
/// Pieces of a record whose powers are compared.
pub(crate) const PIECES: usize = 16;
/// Least power of a piece beside the mean; pieces of a random signal scatter, silence
/// between bursts lies far below.
pub(crate) const LEAST_POWER: f64 = 0.1;
/// Lines over which products of neighbours are summed.
pub(crate) const LINES: usize = 13;
/// Largest |Σ X_k·X*_{k+1}| beside Σ|X|²: about 0.24 for random lines, near 1 for the smooth
/// spectrum of a blow or a sweep.
pub(crate) const LARGEST_NEIGHBOUR: f64 = 0.5;
/// The same above which a local fit cannot tell leakage from force: 0.92 for a blow or a sweep
/// (12 products of 13 lines), 0.89 for noise in a seventh of the record, 0.79 in three tenths,
/// which local fits still bear.
pub(crate) const SMOOTH_NEIGHBOUR: f64 = 0.87;
/// Largest autocorrelation at long lags: near 1 for periodic signals.
pub(crate) const LARGEST_REPEAT: f64 = 0.5;
/// Power of the difference of neighbouring blocks, over that of a block, up to which a force repeats
/// from block to block: 2 for noise, 0.02 for a period with noise 20 dB below it.
pub(crate) const BLOCKS_APART: f64 = 0.2;
/// Long lags begin at this part of the record.
pub(crate) const LONG_LAG: usize = 64;
/// ... and are so many samples at least, over which noise of a narrow band is alike.
pub(crate) const LEAST_LAG: usize = 16;
/// Pieces of a block whose powers tell where a burst ends.
pub(crate) const BLOCK_PIECES: usize = 256;
/// Least samples of such a piece: the power of 8 samples of noise lies below [`ACTING`] of the largest
/// in one case of 10⁵, that of a single one in one of four.
pub(crate) const LEAST_PIECE: usize = 8;
/// One in so many samples of a block, the last ones, tells the offset of the sensor (and, in blows.rs,
/// its noise).
pub(crate) const LAST_PART: usize = 16;
/// Offset over the largest value, at most: one level of two is half of what the signal spans.
pub(crate) const OFFSET_MOST: f64 = 0.4;
/// Power of a piece beside the largest from which on the force acts.
pub(crate) const ACTING: f64 = 0.01;
/// Samples of a reference that are looked at, and fewest blocks.
pub(crate) const LOOKED_AT: (usize, usize) = (1 << 20, 4);

// force_noise.rs

/// Lines of the record over which the noise of the force counts as one.
pub(crate) const FORCE_LINES: usize = 845;
/// Local fits that tell it, at least: so many of 13 lines share none of these.
pub(crate) const FORCE_FITS: usize = 65;
/// Part of the lines on which responses must share errors of the force's sign: by chance a
/// half do, ± 2 % of 500.
pub(crate) const FORCE_SIGNS: f64 = 0.8;
/// Median of the power of noise over its mean, by 7 complex values: 13 lines less 6 unknowns.
pub(crate) const FORCE_MEDIAN: f64 = 0.953;
/// Most of an FRF's inverse that is taken off: there the force is half noise.
pub(crate) const FORCE_MOST: f64 = 0.5;

// lib.rs

/// Difference of sampling rates, relative, up to which they are one: rounding of printed rates.
pub(crate) const SAME_RATE: f64 = 1e-6;
/// The same over a record, in samples: printed digits may take a tenth of a sample from either end of
/// each of two records.
pub(crate) const SAME_SAMPLES: f64 = 0.2;

// local.rs

/// Memory of the spectra that are held at a time, bytes. Responses of one run that do not
/// fit share denominators in smaller sets.
pub(crate) const SPECTRA_BYTES: usize = 1 << 30;
/// Frequencies that are fitted before their values are stored.
pub(crate) const BATCH: usize = 8192;

// local_basis.rs

/// Degree of all polynomials.
pub(crate) const DEGREE: usize = 2;
/// Lines beyond the unknowns of one response: what its variance is told from.
pub(crate) const SPARE_LINES: usize = 7;
/// A reference whose part beyond the other columns is less than this acts as one with them.
pub(crate) const BASIS_SINGULAR: f64 = 1e-10;

// lrm.rs

/// Steps of Sanathanan and Koerner after the first, unweighted solution.
pub(crate) const STEPS: usize = 2;
/// Least power of a column beside what it had before projection, by which rounding is told
/// from signal.
pub(crate) const ROUNDING: f64 = 1e-24;
/// |D| on a line, beside its largest, below which the line weighs no more.
pub(crate) const LEAST_DENOMINATOR: f64 = 1e-6;

// runs_differ.rs

/// Blocks agree where at most one in so many of their coherent peaks is apart.
pub(crate) const AGREE_PARTS: usize = 4;

/// Power of the force of a block beside the median one from which on the block is compared.
pub(crate) const FORCE_LEAST: f64 = 0.01;
/// Blocks that all others are compared with before each is compared with each.
pub(crate) const LOOKED_AT_FIRST: usize = 3;
/// Peaks of a response that are compared, at most.
pub(crate) const PEAKS_MOST: usize = 24;
/// Power of a peak beside the strongest, at least: 50 dB hold the modes of a receptance.
pub(crate) const PEAK_LEAST: f64 = 1e-5;
/// Lines to each side of a peak in which no other stands, at least.
pub(crate) const PEAK_LINES: usize = 8;
/// The same as one part in so many of all lines, where lines are fine.
pub(crate) const PEAK_PARTS: usize = 512;
/// Coherence of two blocks on a peak from which on they have a ratio there.
pub(crate) const RATIO_COHERENT: f64 = 0.9;
/// Difference of a ratio from 1 that matters: 10 %, or 0.1 rad.
pub(crate) const RATIO_APART: f64 = 0.1;
/// The same where no factor explains it: hands that strike beside the point change shares of modes.
pub(crate) const RATIO_FAR: f64 = 0.5;
/// Errors of a ratio on top of that.
pub(crate) const RATIO_ERRORS: f64 = 4.0;
/// Part of a factor by which a peak that follows it differs at most, beside errors.
pub(crate) const RATIO_LAW: f64 = 0.12;
/// One part in so many of the largest effect of the law, by which such a peak differs at most: a
/// weak effect must be followed more closely.
pub(crate) const LAW_EFFECT: f64 = 3.0;
/// Errors of a ratio that such a peak may differ by beside that.
pub(crate) const LAW_ERRORS: f64 = 3.0;
/// Share of the coherent peaks that follow a law: so many of so many.
pub(crate) const LAW_PEAKS: [usize; 2] = [3, 4];
/// One in so many coherent peaks is apart under a factor, and under a delay, which hardly turns
/// peaks of low frequency.
pub(crate) const LAW_APART: [usize; 2] = [2, 3];
/// One in so many peaks, on which a majority agrees, is far off where no law explains a block.
pub(crate) const FAR_PARTS: usize = 3;
/// Longest delay that is looked for, samples, and steps of a sample.
pub(crate) const DELAY_MOST: i32 = 8;
pub(crate) const DELAY_STEPS: i32 = 16;

// setting.rs

/// Samples of a block, at least: fewer have one line.
pub(crate) const LEAST_BLOCK: usize = 4;

/// Overlap of Hann blocks: beyond it the variance does not fall any further (the window
/// has a hop of a third for which its squares add up to a constant).
pub(crate) const HANN_OVERLAP: f64 = 2.0 / 3.0;

/// Part of a record in which a burst acts at most, where the record is taken whole: after a later end
/// there is no time to die out.
pub(crate) const BURST_MOST: f64 = 0.9;

// takes.rs

/// Lines of a response that are kept of each block, and blocks that are kept: 8 MB.
pub(crate) const TAKES_LINES: usize = 4096;
pub(crate) const TAKES_MOST: usize = 64;

// unheard.rs

/// Neighbouring lines whose coherences are summed.
pub(crate) const UNHEARD_LINES: usize = 8;
/// Independent blocks beyond the references, at least: two blows are coherent on too many lines.
pub(crate) const UNHEARD_FREEDOM: f64 = 2.0;
/// Chance, over all lines, below which a coherence is more than noise.
pub(crate) const UNHEARD_CHANCE: f64 = 0.01;
/// The mean over all lines, beside that of noise, above which a coherence is more: the worth of
/// blocks that overlap is known to a few parts in a hundred.
pub(crate) const UNHEARD_MEAN: f64 = 1.05;
/// Standard errors of that mean, at least: lines under a window are not independent, so that a true
/// one is up to 1.4 times as large.
pub(crate) const UNHEARD_ERRORS: f64 = 4.0;

// whole_record.rs

/// Least step of local fits over the lines of each: values that share two fifths of their lines err
/// nearly independently, closer ones repeat what their neighbours say.
pub(crate) const LEAST_STEP: f64 = 0.6;
/// Rounding of a number of lines: it must not decide on a line at the border of two frequencies.
pub(crate) const LINE_ROUNDING: f64 = 1e-6;

/// Largest prime factor of a transform's length: above it transforms slow down.
pub(crate) const LARGEST_FACTOR: usize = 7;

// window.rs

/// Difference of the means of the third and the last quarter of a block over their own mean, up to
/// which they tell an offset. Means of noise, or of the rest of an oscillation, agree so in one
/// case of 31.
pub(crate) const QUARTERS_AGREE: f64 = 0.1;
/// Least offset over the largest value of a block: smaller ones are what is left of an oscillation.
pub(crate) const OFFSET_LEAST: f64 = 1e-3;
