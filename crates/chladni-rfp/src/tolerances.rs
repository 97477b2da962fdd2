//! Every constant of the identification, with its meaning, unit, origin, and what happens
//! at other values.

/// Refinement steps that tell how far the poles of another method stand from the
/// likeliest ones: the first are the longest.
pub(crate) const STEPS_AHEAD: usize = 4;
/// Noise variance of clean data relative to their mean square, at which rounding of the
/// data and of the kernels begins to look like modes.
pub(crate) const ROUNDING_VARIANCE: f64 = 1e-26;
/// Columns of the count sketch, unless told otherwise. 64–96 keep every mode that stands
/// out of the noise (study); fewer lose weak modes that share a bucket, more only cost
/// time.
pub(crate) const SKETCH_COLUMNS: usize = 80;
/// Part of a basis column of unit norm outside those before it from which on their Gram
/// matrix serves as well as the columns: it costs four digits of sixteen. The pools of a
/// panel stand at 0.05.
pub(crate) const OUTSTANDING: f64 = 1e-2;
/// Random mixtures that vector fitting works on. 4 begins to miss modes, 16 doubles the
/// time and finds none more.
pub(crate) const POOL_MIXTURES: usize = 8;
/// Most relaxed vector-fitting steps, unless told otherwise.
pub(crate) const POOL_ITERATIONS: usize = 8;
/// Change of what a step leaves, as part of it, after which there is no further one: a
/// panel then stands still after four, heavy overlap and wide bands take all eight.
pub(crate) const POOL_SETTLED: f64 = 2e-3;
/// Most steps for each of the nine voting runs of the measured-data path: they need
/// agreement, not digits.
pub(crate) const VOTE_ITERATIONS: usize = 6;
/// Loss factor below which the two damping laws differ by less (about η²/4 in frequency)
/// than measured line shapes can tell.
pub(crate) const LAW_ALIKE: f64 = 0.02;
/// Factor on the tail of the noise in the significance threshold (theory.md, eq. 8). 1.0
/// finds one more mode in heavy overlap, 3 (about BIC) loses one to three there; no
/// spurious mode was seen between.
pub(crate) const SIGNIFICANCE: f64 = 1.5;
/// Rise of the sum of squares, in units of the significance threshold, below which a pole
/// is judged by a fit without it. Poles that lean on a neighbour were seen at 2 to 5;
/// modes in noise stand at 10 and more, and each costs a refinement.
pub(crate) const LEANING: f64 = 10.0;
/// Levenberg–Marquardt damping at the start, relative to the diagonal.
pub(crate) const LM_START: f64 = 1e-3;
/// Damping at which no step can help any more.
pub(crate) const LM_GIVE_UP: f64 = 1e8;
/// Steps of a refinement before the order is decided: enough to sort modes from noise.
pub(crate) const REFINE_ROUGH: usize = 6;
/// Steps of the final refinement; convergence stops it earlier.
pub(crate) const REFINE_FINE: usize = 30;
/// A step smaller than this part of a half-bandwidth ends a rough refinement.
pub(crate) const ROUGH_STEP: f64 = 1e-3;
/// The same for the final one. With quadratic convergence the error left is the square of
/// it.
pub(crate) const FINE_STEP: f64 = 1e-7;
/// What a step promises to take off the sum of squares, in units of the noise variance,
/// below which it is the last: no pole moves by more than 1e-3 of its error bar in it,
/// and what is left after it is a tenth and less of that.
pub(crate) const PROMISED: f64 = 1e-6;
/// Part of the residual's energy that the rounding of normal equations may reach: a
/// thousandth of the noise of one value in a set of some 10⁵.
pub(crate) const NORMAL_ROUNDING: f64 = 1e-8;
/// Part of a derivative outside the columns (its square) that normal equations still tell
/// from rounding.
pub(crate) const DERIVATIVE_OUTSIDE: f64 = 1e-9;
/// Steps after which a pool is thinned again: poles of noise are told from others long
/// before they stand still.
pub(crate) const THINNING_STEPS: usize = 2;
/// Times that this may take none out before the pool counts as thinned.
pub(crate) const THINNING_ROUNDS: usize = 3;
/// A pole narrower than this part of the line spacing is one line's error, not a
/// resonance.
pub(crate) const SPIKE_SPACINGS: f64 = 0.2;
/// What a place must take out of all FRFs beyond their noise, as part of what a pole
/// there would have to, before a pass is spent on it: the place is not refined yet, and
/// sees at least this much of a mode next to it.
pub(crate) const CONFIRMED: f64 = 0.5;
/// The same of a place that the sketch has refined, before a whole pass is made for it:
/// it sees nearly all of a mode.
pub(crate) const CONFIRMED_REFINED: f64 = 0.9;
/// Most places that one such look asks for.
pub(crate) const PLACES: usize = 16;
/// Distance in half-bandwidths within which two passes found the same pole.
pub(crate) const SAME_POLE: f64 = 0.3;
/// Largest share of a pole's column (its square) outside the basis of a pilot with which
/// one pass is enough: so much of what the data say of that pole is lost at most.
pub(crate) const PILOT_SHARE: f64 = 0.01;
/// Most passes over the data beyond the two, for modes that only all FRFs together show
/// and for columns without the noise of poles that are gone.
pub(crate) const EXTRA_PASSES: usize = 3;
/// Rounds of adding poles at residual peaks before the order stands.
pub(crate) const SCAN_ROUNDS: usize = 6;
/// Half-bandwidths on both sides that the local residual tests look at.
pub(crate) const WINDOW_HALF_WIDTHS: f64 = 3.0;
/// Least lines on each side of a local window.
pub(crate) const WINDOW_LEAST_LINES: usize = 4;
/// Excess of the residual energy around a mode, over the whole band's and beyond chance,
/// that still counts as white: poles of the projection are not yet the refined ones. Real
/// misfit (windows, moving poles, non-linear supports) stands 10 to 1000 times above the
/// noise there.
pub(crate) const WHITE_LOCAL: f64 = 0.35;
/// Correlation of neighbouring residual lines up to which a residual counts as white.
pub(crate) const WHITE_CORRELATION: f64 = 0.1;
/// Correlation of neighbouring residual lines around misfitted modes below which the
/// misfit has no shape. Gain noise gives 0 (less, where it is fitted away), a missing
/// mode a line wide and more 0.4 to 1.
pub(crate) const SHAPELESS: f64 = 0.2;
/// Ratio of the noise of a tenth of the band to the whole band beyond which one noise
/// level cannot serve.
pub(crate) const WHITE_SEGMENT: f64 = 2.5;
/// Rate at which all whiteness looks together may call white noise coloured. A tenth of
/// it widens every limit by some 10 %.
pub(crate) const WHITE_FALSE_ALARM: f64 = 0.01;
/// Prominence of a peak of the mean |FRF|² that may seed a pole, dB.
pub(crate) const SEED_PROMINENCE_DB: f64 = 4.0;
/// Height of a seed over the local noise, dB.
pub(crate) const SEED_OVER_NOISE_DB: f64 = 6.0;
/// Prominence and height over the local noise of a peak that must be explained, dB. Side
/// lobes and noise stay below.
pub(crate) const STRIKING_PROMINENCE_DB: f64 = 12.0;
/// See above, dB.
pub(crate) const STRIKING_OVER_NOISE_DB: f64 = 20.0;
/// Most seeds.
pub(crate) const SEEDS_MOST: usize = 100;
/// FRFs per block in a streaming pass: a block of 2000 lines stays in the second-level
/// cache.
pub(crate) const BLOCK_FRFS: usize = 64;
/// Partial sums of a streaming pass; fixed, so that the bits do not depend on the number
/// of threads.
pub(crate) const PASS_GROUPS: usize = 8;
/// Least FRFs of one such sum: fewer, and adding the sums costs more than making them.
pub(crate) const GROUP_FRFS: usize = 128;
/// Least share of a line's noise that a model leaves: less, and the residual there tells
/// rounding, not noise.
pub(crate) const LEVERAGE_LEFT: f64 = 0.05;
/// Records longer than this keep all lines near the peaks and thin out the rest.
pub(crate) const DECIMATE_ABOVE_LINES: usize = 4000;
/// Iterations of the alternating rank-one refit of residues; separated modes need two,
/// close ones some tens.
pub(crate) const RANK_ONE_ITERATIONS: usize = 60;
/// Relative change of the structured sum of squares that ends the rank-one refit.
pub(crate) const RANK_ONE_CHANGE: f64 = 1e-9;
/// Steps that the rank-one refit remembers: three slow rates at a time and one to spare.
/// On the panel 1, 2 and 8 took 20 sweeps, 4 took 25, none 39.
pub(crate) const STEPS_REMEMBERED: usize = 4;
/// Ridge on the correlations of the steps remembered: what rounding makes of them.
pub(crate) const STEPS_RIDGE: f64 = 1e-15;
/// Part of the energy of free residues above which the misfit of low rank is told by a
/// difference of sums.
pub(crate) const RANK_ONE_KNOWN: f64 = 1e-6;
/// Power steps towards the strongest term of one mode's residues: its next singular value
/// is noise, or the search that follows finds it.
pub(crate) const POWER_STEPS: usize = 4;
/// Singular values of an out-of-band pole's residues count where they exceed this times
/// the largest that noise makes; below it the weak direction costs more in noise than it
/// explains.
pub(crate) const RANK_OVER_NOISE: f64 = 1.5;
/// Part of the modes whose neighbourhood is misfitted beyond which the fast chain gives
/// up before it settles the order.
pub(crate) const MISFIT_SHARE: f64 = 0.4;
/// Visible peaks from which the strongest sections of the band are judged before the
/// chain begins: below, the whole chain costs no more than a few such looks.
pub(crate) const FIRST_LOOK_ABOVE: usize = 50;
/// Share of the residual energy left after conjugation that proves the wrong time sign.
/// Right-signed data lose a factor of 100 and more by conjugation; data of no structure
/// lose nothing either way.
pub(crate) const CONJUGATE_SHARE: f64 = 0.25;
/// Directions of the second pass weaker than this part of the strongest (in energy) are
/// rounding: the Gram matrix holds them to about 1e-16 of it.
pub(crate) const GRAM_ROUNDING: f64 = 1e-13;
/// Part of a direction of the second pass outside those before it from which on none is
/// near rounding.
pub(crate) const GRAM_SOUND: f64 = 1e-6;
/// Singular values of the columns that stay free in every pair, relative to the largest,
/// below which a direction is rounding.
pub(crate) const FREE_RANK: f64 = 1e-10;
/// Modes farther apart than this many half-bandwidths are stepped apart: their columns
/// share a tenth of their energy, which a few more steps make good.
pub(crate) const CLUSTER_HALF_WIDTHS: f64 = 8.0;
/// Largest step of a pole in structured refinement, half-bandwidths.
pub(crate) const STRUCTURED_STEP: f64 = 0.5;
/// Standard deviations of χ² by which a structural constraint may raise the sum of
/// squares: chance passes in all but one of some thousand sets, complex shapes of 10
/// degrees scatter stand hundreds away.
pub(crate) const STRUCTURE_SIGMAS: f64 = 4.0;
/// Step, in half-bandwidths, from which structured refinement keeps its Gauss–Newton
/// matrices: they change by about this part of themselves, so each later step still
/// leaves a hundredth of the error, at a tenth of the cost.
pub(crate) const MATRIX_KEPT: f64 = 1e-2;
/// Part of the data's energy that the difference of two sums of squares loses to
/// rounding.
pub(crate) const STRUCTURE_ROUNDING: f64 = 1e-12;
/// Most modes that structured growth adds.
pub(crate) const GROWTH_MOST: usize = 12;
/// Squared distance of two poles, in units of its variance, up to which they count as one
/// repeated pole: equal poles lie farther apart in one set of a hundred.
pub(crate) const REPEATED_SIGMAS: f64 = 4.6;
/// Half-bandwidths beyond the ends of the band within which a pole is sought with those
/// inside.
pub(crate) const BESIDE_HALF_WIDTHS: f64 = 4.0;
/// Regularisation of structured refinement relative to a derivative's own sum of squares:
/// far below any information of interest, far above rounding.
pub(crate) const STRUCTURED_RIDGE: f64 = 1e-11;
/// Drop of the noise variance by which a pool of twice the size proves that the first was
/// too small. Measured misfit (1 to 20 % of the data) cannot fall so far; hidden modes at
/// 60 dB and more do.
pub(crate) const LARGER_POOL_GAIN: f64 = 1e-2;
/// Share of the data's energy below which a residual is rounding and need not be white:
/// −140 dB, what no converter resolves.
pub(crate) const EXPLAINED: f64 = 1e-14;
/// The same where only a sum of squares is asked for.
pub(crate) const STRUCTURED_ROUGH_STEP: f64 = 1e-4;
/// Step, in half-bandwidths, that ends structured refinement: clusters stepped apart
/// converge linearly, so the error left is of the step's own size.
pub(crate) const STRUCTURED_FINE_STEP: f64 = 1e-11;
/// Rounding of a sum of squares relative to the data's energy (of a residual's: to the
/// geometric mean of both energies), within which a step may seem to make things worse.
pub(crate) const STEP_ROUNDING: f64 = 1e-14;
/// Eigenvalue of a correlation-like information matrix below which a direction is not
/// known at all: far above rounding, far below the 1e-5 of modes that overlap threefold.
pub(crate) const UNINFORMED: f64 = 1e-10;
/// Square of the least pivot of such a matrix from which on every direction counts as
/// known.
pub(crate) const WELL_INFORMED: f64 = 1e-5;
/// 95 % of a normal distribution lie within so many standard deviations.
pub(crate) const SIGMAS_95: f64 = 1.96;
/// Square of the relative half-width of a driving-point residue beyond which its mode's
/// scale is called no less known: the error bars are a hundred times those of first
/// order.
pub(crate) const SCALE_KNOWN: f64 = 1.0 - 1e-4;
