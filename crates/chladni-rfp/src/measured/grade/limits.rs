//! Every limit of the grades. They are limits of judgement, tried on the measured sets of the
//! tests: a pole without any doubt should be one that nobody disputes. Half-bandwidths are
//! half-power.
//!
//! A value without an origin is judgement: nobody has calibrated it.

/// Share of model orders and line halves that find a mode.
pub(super) const FEW_ORDERS: f64 = 0.75;
/// Rms residual over rms modal part around the peak: the peak is no resonance, and no
/// mode at all.
pub(super) const NO_RESONANCE: f64 = 0.5;
/// See above.
pub(super) const NO_MODE: f64 = 1.5;
/// The same from which on the damping is indicative only.
pub(super) const INDICATIVE: f64 = 0.2;
/// Half-bandwidths by which odd and even lines, or FRFs, may disagree.
pub(super) const DISAGREE: f64 = 0.5;
/// Relative rise of the local sum of squares without the pole below which the data hardly
/// need it, and below which they do not.
pub(super) const HARDLY_NEEDED: f64 = 1.5;
/// See above.
pub(super) const NOT_NEEDED: f64 = 0.3;
/// Times that a pole explains what chance lets one explain of correlated noise, below which
/// it is noise.
pub(super) const CHANCE: f64 = 1.0;
/// The same rise without the nearest lines: less, and nothing is left of the mode.
pub(super) const NOTHING_LEFT: f64 = 1.0;
/// Half-bandwidths beyond which the size of an error bar says nothing more.
pub(super) const NO_WIDTH: f64 = 3.0;
/// Half-bandwidths to the band edge.
pub(super) const EDGE: f64 = 2.0;
/// Modal part over the whole response (amplitudes): -20 dB.
pub(super) const BURIED: f64 = 0.1;
/// Half-widths in lines of a spike, and of what may be the skirts of another peak.
pub(super) const SPIKE_LINES: f64 = 0.5;
/// See above.
pub(super) const NARROW_LINES: f64 = 1.0;
/// Lines within the half-power bandwidth from which on damping is no upper bound.
pub(super) const FEWEST_LINES: f64 = 2.0;
/// Lines within which a stronger peak has side lobes, and how far they lie below it, dB.
pub(super) const SIDE_LOBE_LINES: f64 = 4.0;
/// See above.
pub(super) const SIDE_LOBE_DB: f64 = 8.0;
/// Loss over that of the sure modes around below which a line is a tone.
pub(super) const TONE: f64 = 0.12;
/// The same above which a line that misfits is no mode of its own.
pub(super) const BROAD: f64 = 5.0;
/// Height over the surroundings of a distinct peak, and of a line that is seen whatever
/// the grades say, dB.
pub(super) const DISTINCT_DB: f64 = 10.0;
/// See above.
pub(super) const VISIBLE_DB: f64 = 20.0;
/// A mode without a distinct peak convinces by its misfit, error bar and modal part, or by
/// a smaller error bar and misfit alone.
pub(super) const CONVINCING: (f64, f64, f64) = (0.1, 0.05, 0.5);
/// See above.
pub(super) const CONVINCING_ALONE: (f64, f64) = (0.25, 0.03);
/// Largest residue over the next, dB, beyond which one FRF alone shows a mode.
pub(super) const ALONE_DB: f64 = 20.0;
/// Modal phase collinearity below which a shape is none that one mode alone makes, and
/// half-bandwidths within which another has a part in it.
pub(super) const NO_COMMON_PHASE: f64 = 0.5;
/// See above.
pub(super) const ISOLATED: f64 = 6.0;
/// Degrees off the others from which residues do not stand with them.
pub(super) const OFF_DEGREES: f64 = 45.0;
/// Half-bandwidths within which one FRF cannot tell two modes from one.
pub(super) const HALF_PAIR: f64 = 2.0;
/// Severe doubts that reject.
pub(super) const SEVERE: usize = 2;
/// Rounds in which the sure modes tell what is usual, the first by grades that know of
/// nothing usual: poles of noise among them would else vouch for each other.
pub(super) const ROUNDS: usize = 3;

// usual.rs

/// Sure modes nearest to a pole whose losses are taken together, and the fewest that tell.
pub(super) const NEIGHBOURS: usize = 6;
/// See above.
pub(super) const FEWEST_NEIGHBOURS: usize = 3;
/// Error bar, in half-bandwidths, below which modes count as equally well known.
pub(super) const BEST_KNOWN: f64 = 0.01;
/// Modes, of equal weight, that it takes to tell where residues usually stand; and the
/// least share of them that agrees.
pub(super) const FEW: f64 = 3.0;
/// See above.
pub(super) const COMMON: f64 = 0.9;

// rules.rs

/// Least half-width in lines that a distance is counted by: rounding.
pub(super) const LEAST_HALF_WIDTH_LINES: f64 = 1e-9;
