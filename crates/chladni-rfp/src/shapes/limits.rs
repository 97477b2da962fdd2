//! Every constant of this room: meaning, unit, where it comes from, and what happens at other
//! values where that was tried.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// several files

/// Regularisation of structured refinement relative to a derivative's own sum of squares:
/// far below any information of interest, far above rounding.
pub(super) const STRUCTURED_RIDGE: f64 = 1e-11;

// acceleration.rs

/// Steps that the rank-one refit remembers: three slow rates at a time and one to spare.
/// On the panel 1, 2 and 8 took 20 sweeps, 4 took 25, none 39.
pub(super) const STEPS_REMEMBERED: usize = 4;
/// Ridge on the correlations of the steps remembered: what rounding makes of them.
pub(super) const STEPS_RIDGE: f64 = 1e-15;

// alternation.rs

/// Responses per block: some hundred kilobytes of residues, and several blocks for each
/// thread where there are few responses.
pub(super) const ALTERNATION_BLOCK: usize = 16;

// around.rs

/// Distance of two free poles outside the band, over the sum of their half-bandwidths,
/// below which they stand for one and its derivative.
pub(super) const FUSED: f64 = 0.02;
/// Loss factors of poles that are added outside the band: up to critical damping.
pub(super) const LOSS_ADDED: std::ops::Range<f64> = 1e-4..2.0;
/// Most poles outside the band that are added beside structured ones.
pub(super) const AROUND_MOST: usize = 3;
/// Steps from each place where a pole outside the band is tried, and how many of them are then
/// followed to their ends.
pub(super) const AROUND_FIRST_STEPS: usize = 3;
/// See above.
pub(super) const AROUND_FOLLOWED: usize = 4;

// attempt.rs

/// Standard deviations of χ² by which a structural constraint may raise the sum of
/// squares: chance passes in all but one of some thousand sets, complex shapes of 10
/// degrees scatter stand hundreds away.
pub(super) const STRUCTURE_SIGMAS: f64 = 4.0;
/// Part of the data's energy that the difference of two sums of squares loses to
/// rounding.
pub(super) const STRUCTURE_ROUNDING: f64 = 1e-12;
/// Standard deviations of χ² up to which no mode is looked for: a mode that shows may raise
/// the sum of squares of many data by less than [`STRUCTURE_SIGMAS`].
pub(super) const GROWTH_SIGMAS: f64 = 1.0;
/// The gain by a pole outside the band, in units of the noise variance beyond that of
/// every column, that makes it worth its place where the model contradicts the data.
pub(super) const AROUND_GAIN: f64 = 10.0;
/// Gain of a pole that is added outside the band, over that which it has where it is tried
/// from, at most.
pub(super) const GAIN_BEYOND_SIGHT: f64 = 30.0;

// error_bars.rs

/// Unknowns of the terms outside the band, above which their shapes get no error bars: a wrong
/// kind of FRF leaves poles of dozens of terms there, and the work goes with the third power.
pub(super) const OUTSIDE_MOST: usize = 2000;

// force_drop.rs

/// Ratios of decays that are tried; the first is an even force, the last a drop of 30 dB.
pub(super) const DROPS: [f64; 9] = [1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 18.0, 32.0];
/// Noise of the force over its power beside resonances.
pub(super) const NOISES: [f64; 6] = [0.0, 1e-4, 4e-4, 1e-3, 4e-3, 1e-2];
/// Lines per half-power bandwidth from which on lines tell a drop.
pub(super) const DROP_LINES: f64 = 1.5;
/// Half-bandwidths, and lines, on both sides of a mode.
pub(super) const DROP_REACH: (f64, f64) = (4.0, 8.0);
/// Unknowns of a mode.
pub(super) const DROP_UNKNOWNS: usize = 4;
/// Half-bandwidths to the next mode.
pub(super) const DROP_ALONE: f64 = 12.0;
/// Log-likelihood by which a drop must beat the force of the columns.
pub(super) const DROP_DECIDES: f64 = 12.0;
/// Probability of a force below which bars leave it out.
pub(super) const FORCE_LEAST: f64 = 1e-3;

// from_moments.rs

/// Least singular value of a sum of residues over the largest, from which on it counts as a shape:
/// rounding.
pub(super) const MOMENTS_RANK: f64 = 1e-9;

// growth.rs

/// Candidates per block of products.
pub(super) const GROWTH_BLOCK: usize = 64;
/// Power iterations for the largest singular value: a lower bound within a few per cent,
/// enough to rank places.
pub(super) const GROWTH_POWER_STEPS: usize = 8;

// influence.rs

/// Cycles per record within which two distances of lines are one.
pub(super) const SAME_CYCLES: f64 = 1e-6;
/// Cycles per record beyond which noise is independent: 1e-4 under a flat top.
pub(super) const CYCLES_APART: f64 = 8.0;
/// Part of the variance that FRFs must share on the median line: at most 0.17 in 400 tests
/// without noise of the force, at least 0.42 in 200 with it.
pub(super) const SHARED_PART: f64 = 0.3;
/// References whose forces are told apart; more are taken for one, whose errors are larger.
pub(super) const FORCES_MOST: usize = 4;

// inverse_root.rs

/// Square of the least pivot of an information matrix from which on every direction counts as
/// known.
pub(super) const WELL_INFORMED: f64 = 1e-5;

// leaked.rs

/// Cycles per record from a mode to the last line whose leakage counts; below half of the
/// places of a record.
pub(super) const LEAK_CYCLES: f64 = 28.0;
/// Cycles per record about a mode on which the residual tells the averages, at least.
pub(super) const LEAK_SEEN: f64 = 2.0;
/// Poles whose leakage counts for one mode, the nearest first.
pub(super) const LEAKING_MOST: usize = 5;
/// Cycles per record from a mode to the lines that tell noise of the force: from there on slopes
/// alone leak (a Hann window leaks 0.58 of the slope per cycle, 0.06 of an FRF so near a mode), and
/// the fit does not take along errors that neighbouring lines share.
pub(super) const BESIDE_CYCLES: f64 = 10.0;

// levels.rs

/// Rounds of weighing lines by what they are known to scatter: the fourth changes a level by less
/// than a hundredth.
pub(super) const LEVEL_ROUNDS: usize = 6;

// line_bars.rs, force_noise.rs

/// Factor by which bars from the residual of blows stand above those from noise of the responses
/// where they contradict them. Force noise of 0.1 % of a blow's peak makes 3 to 5; where there is
/// none the residual scatters, and with a factor of 1 bars of η hold in 0.99 of exponential windows.
pub(super) const BARS_CONTRADICT: f64 = 2.0;
/// Fewest lines that tell what all FRFs share.
pub(super) const SHARED_LINES: usize = 50;
/// Variance beside modes over the one foretold, beyond which the residual is believed and not
/// the averages that the set names: by chance it varies by a quarter. Noise of the force 34 dB
/// below it makes 1.2 to 2: at 2.0 and at 1.3 error bars of loss factors held in 0.88 of 400 cases, at 1.15 in
/// 0.90 of 240; without it in 0.91 and more at each.
pub(super) const LEAKS_AS_TOLD: f64 = 1.3;

// low_rank.rs

/// Iterations of the alternating rank-one refit of residues; separated modes need two,
/// close ones some tens.
pub(super) const RANK_ONE_ITERATIONS: usize = 60;
/// Relative change of the structured sum of squares that ends the rank-one refit.
pub(super) const RANK_ONE_CHANGE: f64 = 1e-9;
/// Part of the energy of free residues above which the misfit of low rank is told by a
/// difference of sums.
pub(super) const RANK_ONE_KNOWN: f64 = 1e-6;
/// Misfit over the energy of free residues below which it is rounding.
pub(super) const RANK_ONE_ROUNDING: f64 = 1e-12;

// order.rs

/// Most modes that structured growth adds.
pub(super) const GROWTH_MOST: usize = 12;
/// Squared distance of two poles, in units of its variance, up to which they count as one
/// repeated pole: equal poles lie farther apart in one set of a hundred.
pub(super) const REPEATED_SIGMAS: f64 = 4.6;

// own_noise.rs

/// Noise of an FRF over that of the median line, at least: what is less is nothing but leakage.
pub(super) const NOISE_OF_MEDIAN: f64 = 1e-2;
/// Standard deviations by which noise beside modes must lie below that of the median line to be
/// called less.
pub(super) const LEVEL_SIGMAS: f64 = 3.0;
/// Part of an error that must stay in the residual of a line that tells noise of the force.
pub(super) const KEPT_MOSTLY: f64 = 0.5;

// residues.rs

/// Power steps towards the strongest term of one mode's residues: its next singular value
/// is noise, or the search that follows finds it.
pub(super) const POWER_STEPS: usize = 4;
/// Singular values of an out-of-band pole's residues count where they exceed this times
/// the largest that noise makes; below it the weak direction costs more in noise than it
/// explains.
pub(super) const RANK_OVER_NOISE: f64 = 1.5;
/// Trace of ridge on a diagonal, over its own value and over the largest.
pub(super) const RESIDUES_RIDGE: (f64, f64) = (1e-12, 1e-18);
/// Part of χ² by which a misfit must raise it before poles or ranks are spent on it.
pub(super) const EXCESS_SEEN: f64 = 0.01;
/// The same on compressed columns, which hold a part of the noise: what chance allows is
/// known less well there. On the panel 0.02 gave up the shape of a mode 4 % of its
/// bandwidth above the band, and with it a tenth of the accuracy in damping.
pub(super) const EXCESS_SEEN_COMPRESSED: f64 = 0.05;

// scale.rs

/// 95 % of a normal distribution lie within so many standard deviations.
pub(super) const SIGMAS_95: f64 = 1.96;
/// Square of the relative half-width of a driving-point residue beyond which its mode's
/// scale is called no less known: the error bars are a hundred times those of first
/// order.
pub(super) const SCALE_KNOWN: f64 = 1.0 - 1e-4;

// search.rs

/// Half-bandwidths beyond the ends of the band within which a pole is sought with those
/// inside.
pub(super) const BESIDE_HALF_WIDTHS: f64 = 4.0;

// step.rs

/// Largest step of a pole in structured refinement, half-bandwidths.
pub(super) const STRUCTURED_STEP: f64 = 0.5;
/// Step, in half-bandwidths, from which structured refinement keeps its Gauss–Newton
/// matrices: they change by about this part of themselves, so each later step still
/// leaves a hundredth of the error, at a tenth of the cost.
pub(super) const MATRIX_KEPT: f64 = 1e-2;
/// Step, in half-bandwidths, that ends it where only a sum of squares is asked for.
pub(super) const STRUCTURED_ROUGH_STEP: f64 = 1e-4;
/// Error of a pole, in half-bandwidths, that ends structured refinement. Clusters stepped apart
/// converge linearly, so the next step tells it.
pub(super) const STRUCTURED_FINE: f64 = 1e-11;
/// Factor by which each step is taken to shrink the next one at most: a cluster that converges fast
/// must not hide a slow one.
pub(super) const LEAST_RATE: f64 = 1e-2;
/// A participation may be so many times as large as the pivot of its mode while steps are short.
pub(super) const PIVOT_KEPT: f64 = 2.0;
/// Part of its loss that a pole keeps at least by a step.
pub(super) const STRUCTURED_LOSS_KEPT: f64 = 0.1;

// tangent.rs

/// Modes farther apart than this many half-bandwidths are stepped apart: their columns
/// share a tenth of their energy, which a few more steps make good.
pub(super) const CLUSTER_HALF_WIDTHS: f64 = 8.0;

// target.rs

/// DOFs of the eliminated side per block: several for each thread where there are few.
pub(super) const TARGET_BLOCK: usize = 8;
