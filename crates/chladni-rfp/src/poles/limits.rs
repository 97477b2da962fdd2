//! Every constant of this room: meaning, unit, origin, and the effect of other values if they were
//! tried.
//!
//! A value without an origin is judgement; it was not calibrated.

// several files

/// Part of the modes with misfitted neighbourhood, beyond which the fast chain gives up before it
/// settles the number of poles.
pub(super) const MISFIT_SHARE: f64 = 0.4;

// by_hand.rs

/// Distance in half-bandwidths within which a pole explains a place: nothing is added there.
pub(super) const BY_HAND_EXPLAINED: f64 = 1.0;
/// Narrowest start, line spacings of half-bandwidth: a narrower pole would see one line.
pub(super) const BY_HAND_NARROWEST: f64 = 1.0;
/// An added pole that the refinement carries so many half-bandwidths away is not the one
/// that was seen.
pub(super) const CARRIED_AWAY: f64 = 8.0;

// delay_alone.rs

/// Lines from which on a delay is asked for: ten for each unknown of a column.
pub(super) const DELAY_LINES_LEAST: usize = 40;
/// Columns that tell the delay.
pub(super) const DELAY_COLUMNS: usize = 4;
/// Part of the energy of the columns that a delay may leave; the whiteness of what it leaves decides.
pub(super) const DELAY_LEAVES: f64 = 0.5;

// descent.rs

/// Promised decrease of the sum of squares by a step, in units of the noise variance, below which the
/// step is the last. It moves no pole by more than 1e-3 of its error bar, and the distance that remains
/// is a tenth of that or less.
pub(super) const PROMISED: f64 = 1e-6;
/// Least part of a pole's loss, and of the square of its natural frequency, that a step leaves.
pub(super) const KEPT: f64 = 0.2;
/// Largest step of a pole, half-bandwidths.
pub(super) const STEP_INSIDE: f64 = 0.5;
/// Addition to [`STEP_INSIDE`] for a pole outside the band, over its distance from it.
pub(super) const STEP_OUTSIDE: f64 = 0.3;
/// Least damping after a system that could not be solved.
pub(super) const LM_LEAST_UNSOLVED: f64 = 1e-8;

// estimate.rs

/// Standard deviation of a pole, in half-bandwidths, beyond which its mode is not sure.
pub(crate) const UNCERTAIN: f64 = 0.3;
/// Standard deviation of a pole, in half-bandwidths, from which it may be called faint. Modes that
/// random structures did not have had 0.02 to 0.2 while their neighbours had 1e-6.
pub(super) const FAINT: f64 = 0.01;
/// Standard deviation of a faint pole over the usual one of the band, both in half-bandwidths.
pub(super) const FAINT_OVER_USUAL: f64 = 300.0;
/// Noise variance in one law over that in the other up to which both leave the same: the noise is
/// one, and a misfit of 1 % of it stands out of some ten thousand values.
pub(super) const SAME_NOISE: f64 = 1.01;

// first_look.rs

/// Number of visible peaks from which the strongest sections of the band are judged before the
/// chain begins. For fewer peaks the whole chain costs no more than a few such looks.
pub(super) const FIRST_LOOK_ABOVE: usize = 50;
/// Number of sections that are judged.
pub(super) const ASKED: usize = 3;
/// Excess over the limit of white noise that a mode hardly makes if a rough fit misses it.
pub(super) const CLEAR: f64 = 3.0;
/// Part of a section's energy below which the residual of a rough fit is no misfit of measured data,
/// which is 1 % of the values and more. A hundred modes in twelve exact FRFs leave 4e-8 of it,
/// without shape.
pub(super) const NEXT_TO_NOTHING: f64 = 1e-6;
/// Half-bandwidths of a peak within which a pole explains it.
pub(super) const PEAK_EXPLAINED: f64 = 1.5;

// normal.rs

/// Part of the residual's energy that the rounding of normal equations may reach: a
/// thousandth of the noise of one value in a set of some 10⁵.
pub(super) const NORMAL_ROUNDING: f64 = 1e-8;
/// Part (square) of a derivative outside the columns that normal equations still distinguish from
/// rounding.
pub(super) const DERIVATIVE_OUTSIDE: f64 = 1e-9;

// passes.rs

/// Energy that a place must take out of all FRFs before a pass is spent on it, over the energy that a
/// pole there must take out. The place is not refined yet, and takes at least this part of a mode next
/// to it.
pub(super) const CONFIRMED: f64 = 0.5;
/// The same for a place that was refined on the sketch: it takes nearly all of a mode.
pub(super) const CONFIRMED_REFINED: f64 = 0.9;
/// Most places that one such search tries.
pub(super) const PLACES: usize = 16;
/// Distance in half-bandwidths within which two passes found the same pole.
pub(super) const SAME_POLE: f64 = 0.3;

// pole.rs

/// Two poles are the same one within this part of themselves.
pub(super) const SAME: f64 = 1e-12;

// pool.rs

/// Relative change of the residual in a step, below which it is the last. A panel then takes four
/// steps; heavy overlap and wide bands take all eight.
pub(super) const POOL_SETTLED: f64 = 2e-3;
/// Part of a basis column outside those before it below which it is rounding.
pub(super) const DEPENDENT: f64 = 1e-11;
/// Loss factor of a starting pole without a peak.
pub(super) const START_LOSS: f64 = 0.01;
/// Least half-bandwidth of such a pole, over the highest x.
pub(super) const START_WIDTH_LEAST: f64 = 1e-6;
/// Distance, in half-bandwidths of the narrower, to which starting poles are moved apart.
pub(super) const START_GAP: f64 = 0.05;
/// Least half-bandwidth of a relocated pole over the highest x.
pub(super) const RELOCATED_WIDTH_LEAST: f64 = 1e-9;
/// Ridge on the scaled normal equations: the first, the one above which something else is wrong, and
/// the factor between two.
pub(super) const POOL_RIDGE: (f64, f64, f64) = (1e-14, 1e-4, 100.0);

// prune.rs

/// Rise of the sum of squares, in units of the significance threshold, below which a pole
/// is judged by a fit without it. Poles that lean on a neighbour were seen at 2 to 5;
/// modes in noise stand at 10 and more, and each costs a refinement.
pub(super) const LEANING: f64 = 10.0;
/// Steps after which a pool is thinned again: poles of noise can be recognised long before they
/// converge.
pub(super) const THINNING_STEPS: usize = 2;
/// Rounds of such steps that may take no pole out before the pool counts as thinned.
pub(super) const THINNING_ROUNDS: usize = 3;
/// Distance, in line spacings, within which lines are no evidence for a narrow pole.
pub(super) const OWN_LINES: f64 = 1.5;
/// Half-width, in line spacings, below which a pole stands for one bad line. Panels with a
/// fifteenth of a line per bandwidth have 0.03; what a spoilt value makes stays below 0.001.
pub(super) const NARROWEST: f64 = 0.01;

// rank.rs

/// Part of the energy of a column outside those before it from which on singular values of a Gram
/// matrix tell the rank: they are then off by a part of some 1e-4 at most.
pub(super) const GRAM_TELLS_RANK: f64 = 1e-11;
/// The noise is taken from the singular values after this share of them. Its floor is seen if fewer
/// than this share stand out.
pub(super) const BEFORE_NOISE: (usize, usize) = (3, 4);
/// Singular value over the largest of noise alone, from which it counts: it covers the bias of the
/// tail that the noise is taken from.
pub(super) const RANK_OVER_TAIL: f64 = 1.6;
/// Least |1 − √(columns/lines)| that the limit of noise is divided by, which would grow without
/// bounds for square data.
pub(super) const SQUARE_LEAST: f64 = 0.2;

// refine.rs

/// Fall of the sum of squares by a refinement over what its first step promises, at most. Of 2204
/// fits (960 structures of `bench wild`) 77 left little enough, one of them after a fall of 2.7
/// times the promise; of the others 1485 would have had to fall by more than four times. Poles
/// beside shapes are judged by it after some steps, where promises are nearer.
pub(super) const GAIN_OVER_PROMISE: f64 = 4.0;

// scan.rs

/// Places per block of products, which share a window: with more, it is wider than each place needs.
pub(super) const BLOCK: usize = 32;
/// Half-bandwidths on both sides of a place beyond which its resonance is taken for zero: a
/// hundredth of its energy lies there. With ten times as many, a scan takes twice as long and
/// finds the same.
pub(super) const SCAN_REACH: f64 = 60.0;
/// Loss factor if there is no pole of the band to take the usual one from.
pub(super) const UNKNOWN_LOSS: f64 = 0.01;
/// Least x that a loss factor is divided by.
pub(super) const PLACE_LEAST: f64 = 1e-12;
/// Places per line at most.
pub(super) const PLACES_PER_LINE: usize = 4;
/// Part of a column outside the model below which it is rounding.
pub(super) const OUTSIDE_LEAST: f64 = 1e-6;
/// Half-bandwidths of the broader within which a peak of the residual is misfit of a
/// known pole.
pub(super) const MISFIT_REACH: f64 = 3.0;
/// Standard deviations beyond what the largest of all lines reaches by chance.
pub(super) const PEAK_BEYOND_CHANCE: f64 = 6.0;
/// Natural frequencies at which a mode is sought outside the band, over that of its lower and of its
/// upper end.
pub(super) const BELOW: [f64; 2] = [0.8, 0.45];
/// See [`BELOW`].
pub(super) const ABOVE: [f64; 3] = [1.03, 1.12, 1.35];
/// Loss factor that such a search begins with.
pub(super) const OUTSIDE_LOSS: f64 = 0.02;

// sections.rs

/// Bands with no more visible peaks than this are searched in one piece.
pub(super) const WHOLE: usize = 12;
/// Peaks between two cuts, about. Half as many doubles the share of the overlaps, twice
/// as many doubles the cost.
pub(super) const PEAKS: usize = 6;
/// Peaks of the neighbour that a section reaches over.
pub(super) const OVERLAP: usize = 2;

// settle.rs

/// Number of added poles after which it is checked if they help, in case neighbouring lines correlate
/// everywhere; and the part of the sum of squares that they must take out together.
pub(super) const ADDED_IN_VAIN: (usize, f64) = (5, 0.2);
/// Half-widths of both poles within which one may have replaced the other. At larger distances their
/// columns share a hundredth of their energy.
pub(super) const LEANS_WITHIN: f64 = 10.0;
/// Rounds of adding poles at residual peaks before the number of poles is final.
pub(super) const SCAN_ROUNDS: usize = 6;
/// Most changes of the number of poles for each of these rounds.
pub(super) const CHANGES_PER_ROUND: usize = 3;

// significance.rs

/// Places of a pole per line that chance may choose from.
pub(super) const LOOKS_PER_LINE: f64 = 4.0;
/// Factor on the tail of the noise in the significance threshold (theory.md, eq. 8). 1.0
/// finds one more mode in heavy overlap, 3 (about BIC) loses one to three there; no
/// spurious mode was seen between.
pub(super) const SIGNIFICANCE: f64 = 1.5;

// sketched.rs

/// Half window of the noise under the peaks, lines.
pub(super) const SKETCH_NOISE_HALF_WINDOW: usize = 40;
/// Residual energy of the conjugated data over that of the data, below which the time sign is wrong.
/// Right-signed data lose a factor of 100 and more by conjugation; data of no structure
/// lose nothing either way.
pub(super) const CONJUGATE_SHARE: f64 = 0.25;
/// Noise variance from a pool of twice the size over that from the first, below which the first was
/// too small. Measured misfit (1 to 20 % of the data) cannot fall so far; hidden modes at
/// 60 dB and more do.
pub(super) const LARGER_POOL_GAIN: f64 = 1e-2;

// start.rs

/// Place of a pole without a natural frequency, and the lowest that a step goes to, over the x of the
/// first line.
pub(super) const FAR_BELOW: f64 = 0.01;
/// Poles of a pool beyond the modes asked for.
pub(super) const SPARE_ASKED: usize = 6;
/// Poles of a pool over the directions that stand out of the noise, as a fraction.
pub(super) const POOL_OVER_RANK: (usize, usize) = (13, 10);
/// Poles beyond these if the noise floor is seen.
pub(super) const SPARE_SEEN: usize = 6;
/// Poles beyond these if the noise floor is not seen.
pub(super) const SPARE_UNSEEN: usize = 8;
/// Least lines per pole.
pub(super) const LINES_PER_POLE: usize = 3;

// whiteness.rs

/// Parts of the band in which the correlation of neighbouring lines is computed.
pub(super) const BAND_PARTS: usize = 10;
/// Number of correlated parts from which errors count as correlated everywhere.
pub(super) const PARTS_CORRELATED: usize = 8;
/// Excess of the residual energy around a mode, over the whole band's and beyond chance,
/// that still counts as white: poles of the projection are not yet the refined ones. Real
/// misfit (windows, moving poles, non-linear supports) stands 10 to 1000 times above the
/// noise there.
pub(super) const WHITE_LOCAL: f64 = 0.35;
/// Correlation of neighbouring residual lines up to which a residual counts as white.
pub(super) const WHITE_CORRELATION: f64 = 0.1;
/// Correlation of neighbouring residual lines around misfitted modes below which the
/// misfit has no shape. Gain noise gives 0 (less, where it is fitted away), a missing
/// mode a line wide and more 0.4 to 1.
pub(super) const SHAPELESS: f64 = 0.2;
/// Ratio of the noise of a tenth of the band to the whole band beyond which one noise
/// level cannot serve.
pub(super) const WHITE_SEGMENT: f64 = 2.5;
/// Rate at which all whiteness looks together may call white noise coloured. A tenth of
/// it widens every limit by some 10 %.
pub(super) const WHITE_FALSE_ALARM: f64 = 0.01;
/// Share of the data's energy below which a residual is rounding and need not be white:
/// −140 dB, what no converter resolves.
pub(super) const EXPLAINED: f64 = 1e-14;
/// Parts of the band whose noise is compared.
pub(super) const NOISE_PARTS: usize = 10;
/// Fewest lines of such a part.
pub(super) const NOISE_PART_LINES: usize = 16;
/// Least limit that the ratio of a look is divided by: rounding.
pub(super) const LOOK_LEAST: f64 = 1e-12;

// zeros.rs

/// Rounds of the iteration, after which zeros are computed as eigenvalues: from good starts four to
/// eight were needed.
pub(super) const ZERO_STEPS: usize = 16;
/// Part of a zero below which its last step is rounding.
pub(super) const ZERO_SETTLED: f64 = 1e-14;
