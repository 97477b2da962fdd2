//! Every constant of this room: meaning, unit, origin, and the effect of other values if they were
//! tried.
//!
//! A value without an origin is judgement; it was not calibrated.

// above_noise.rs

/// Excess of χ² per degree of freedom up to which nothing is said. The search for shapes accepts half
/// of it; of 150 structures drawn by the benches (docs/accuracy.md) none leaves as much.
pub(super) const ABOVE_NOISE: f64 = 0.1;
/// ... and standard deviations of χ².
pub(super) const ABOVE_CHANCE: f64 = 8.0;

// build.rs

/// χ² per degree of freedom beyond which one shape per mode does not hold.
pub(super) const SHAPE_MISFIT: f64 = 1.5;

// decide.rs

/// Loss factor below which the two damping laws differ by less (about η²/4 in frequency)
/// than measured line shapes can tell.
pub(super) const LAW_ALIKE: f64 = 0.02;
/// Shift of a mode under the other law, in error bars, from which a finding names it.
pub(super) const LAW_SHIFTS: f64 = 1.0;
// fewer_poles.rs

/// Shift of a mode under the other law, in error bars, from which the wrong law may need more poles.
/// At 30 the panel of the benches (40 dB) paid a second search that told nothing.
pub(super) const LAW_COSTS_POLES: f64 = 1000.0;
/// Lead of a law that tells, in poles that are just significant. With each law true, the other
/// one was not seen to lead at all; where neither held, one of 40 sets led by more.
pub(super) const LEAD_THAT_TELLS: f64 = 1.5;
/// Noise variance over the mean square of the data at which poles are counted, at least: −120 dB.
pub(super) const NOISE_THAT_TELLS: f64 = 1e-12;
/// Seed of this noise: any.
pub(super) const SEED_OF_ADDED_NOISE: u64 = 0;

// exponential.rs

/// Standard deviations by which a sure mode decays more slowly than the exponential window when the
/// window's α is wrong.
pub(super) const CLEARLY_SLOWER: f64 = 5.0;

// free_fit.rs

/// Rounds in which poles outside the band get one more direction each. If these are not enough, all
/// directions are tried at once. Judgement: no model of
/// `scripts/record_results.sh` changes by it.
pub(super) const RANK_ROUNDS: usize = 8;
/// Least singular value of a pole's residues, over the largest, that counts as another mode: 1 % of
/// the energy. Judgement: a delay or a moved pole of one reference makes none.
pub(super) const SECOND_SHAPE: f64 = 0.1;
/// Natural frequency over that of the last line below which a pole has none.
pub(super) const NO_FREQUENCY: f64 = 1e-6;
/// FRFs per block of loops over FRFs.
pub(super) const BUILD_BLOCK: usize = 1024;
/// Rounding error of a rise of the sum of squares, over the energy of the data.
pub(super) const RISE_ROUNDING: f64 = 1e-12;

// modes.rs

/// Largest standard deviation of a loss factor in the file: a mode that vibrates has one
/// below 2.
pub(super) const LOSS_FACTOR_UNKNOWN: f64 = 2.0;
/// Relative error bar of a mass scale below which the angle of its shape is evidence on phases.
pub(super) const SCALE_TELLS: f64 = 0.1;

// moved_poles.rs

/// Gauss-Newton steps on the poles of a known model; five are usual.
pub(super) const TRACK_STEPS: usize = 20;
/// Change of a natural frequency, in bandwidths, below which a step is the last.
pub(super) const TRACK_CHANGE: f64 = 1e-6;
/// Largest relative common shift that is tried: 200 K in glass.
pub(super) const MOST_TRACKED_SHIFT: f64 = 0.02;
/// Spacing of the trials, in bandwidths of the narrowest mode: from within a quarter of one, steps
/// lead to the nearest minimum.
pub(super) const TRACK_SPACING: f64 = 0.25;
/// Most trials on either side.
pub(super) const MOST_TRACK_TRIALS: f64 = 60.0;
/// Relative prior standard deviation of each natural frequency about the common shift: wide, and
/// enough to hold modes that the FRFs do not show.
pub(super) const TRACK_FREQUENCY_PRIOR: f64 = 3e-3;
/// Relative prior standard deviation of each loss factor.
pub(super) const TRACK_LOSS_PRIOR: f64 = 0.3;
/// Least noise of FRFs, over their rms: rounding.
pub(super) const TRACK_ROUNDING: f64 = 1e-9;
/// Relative step of numerical slopes: differences keep ten digits.
pub(super) const TRACK_SLOPE_STEP: f64 = 1e-5;
/// Relative error over that of the model, from which its shapes no longer hold.
pub(super) const TRACK_MISFIT: f64 = 3.0;
/// Relative error from which the FRFs are of another structure: half of their power is left.
pub(super) const TRACK_LOST: f64 = 0.7;
/// Least relative error of a model for this comparison.
pub(super) const LEAST_MISFIT: f64 = 0.01;
/// Largest relative change of a loss factor in a step.
pub(super) const TRACK_LOSS_STEP: f64 = 0.5;

// residual_energy.rs

/// Residual of an FRF over its energy, below which the difference of these sums is rounding.
pub(super) const RESIDUAL_KNOWN: f64 = 1e-9;
/// FRFs per block.
pub(super) const RESIDUAL_ENERGY_BLOCK: usize = 256;
