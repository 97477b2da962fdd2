//! Every constant of this room: meaning, unit, and where it comes from.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// aaa.rs

/// Error at which a rational function reproduces the data, relative to their largest
/// value (Chebfun's default).
pub(super) const REPRODUCED: f64 = 1e-13;
/// Newton steps on the denominator after the eigenvalues, which lose digits where the sum
/// of the weights is small.
pub(super) const POLISHING_STEPS: usize = 3;
/// Half-bandwidths of a step beyond which it would leave for another zero.
pub(super) const POLISHING_STEP: f64 = 0.1;

// auto.rs

/// Rms residual over rms data beyond which the band as a whole is not explained, whatever single
/// peaks are.
pub(super) const BAND_UNEXPLAINED: f64 = 0.5;

// bands.rs

/// One in so many peaks is left on each side of a cut.
pub(super) const CUT_LEAVES_ONE_IN: usize = 4;
/// Parts that lines per mode are compared in, as whole numbers.
pub(super) const LINES_IN_PARTS: usize = 1000;
/// Pole pairs beyond the peaks or the modes asked for. Four modes, 24 FRFs, 20 dB: none
/// to spare misses all four modes, two miss one, four none. Eight modes at 40 dB: one
/// misses up to three, two and more none, with a tenth of the error or less.
pub(crate) const SPARE_PAIRS: usize = 4;
/// Most visible peaks per band: with the spare pairs what the method holds.
pub(crate) const PEAKS_PER_BAND: usize = ORDER_HELD - SPARE_PAIRS;
/// Pole pairs per band that the method holds. D spans about twelve decades over twenty
/// even-spaced modes, and no weight is right for all of them at once.
pub(crate) const ORDER_HELD: usize = 12;

// bars.rs

/// Rms residual over rms data beyond which such a fit is not trusted: it has no other way
/// to know that it failed.
pub(super) const METHOD_ERROR_MOST: f64 = 0.2;
/// Distance of two poles in half-bandwidths below which they are one; their residues
/// could not be told apart.
pub(super) const SAME_POLE: f64 = 1e-3;

// circle.rs

/// Half-bandwidths on both sides of the peak that belong to the circle: 2.5 make an arc
/// of 270°; farther lines add more background than circle.
pub(super) const ARC_HALF_WIDTHS: f64 = 2.5;
/// Lines on both sides at least.
pub(super) const ARC_LEAST_LINES: usize = 3;
/// Gauss–Newton steps on the angle; three or four settle it.
pub(super) const ANGLE_STEPS: usize = 12;
/// Part of its diameter that the points may miss a circle by (rms) and still count.
pub(super) const ROUND: f64 = 0.2;
/// Fewest points of a circle with a centre, a radius and a misfit.
pub(super) const CIRCLE_LEAST_POINTS: usize = 4;
/// Misfit over the radius below which it is rounding.
pub(super) const CIRCLE_ROUNDING: f64 = 1e-12;
/// Largest step of the pole, half-bandwidths, and that which ends the fit.
pub(super) const ANGLE_STEP: f64 = 0.5;
/// See [`ANGLE_STEP`].
pub(super) const ANGLE_STILL: f64 = 1e-12;

// band_lines.rs

/// Condition beyond which the last digits of the measurement decide the answer.
pub(crate) const CONDITION_HELD: f64 = 1e12;
/// Half-bandwidth of the broadest pole that counts as a mode, relative to the width of
/// the band: broader ones represent out-of-band modes.
pub(crate) const BROADEST: f64 = 0.5;
/// Largest standard deviation of a natural frequency relative to the half-bandwidth that
/// still counts as a mode. Modes stand below a third, computational poles mostly between
/// one and a thousand.
pub(crate) const MOST_UNCERTAIN: f64 = 0.5;

// clusters.rs

/// Poles belong together within this part of the smaller half-bandwidth. Larger merges
/// modes a bandwidth apart, smaller breaks noisy clusters up.
pub(super) const RADIUS: f64 = 0.5;

// equation_error.rs

/// Singular values below this part of the largest are rounding, not information; the
/// solution of least norm is taken. At 1e-15 rounding passes for information, at 1e-11
/// the last digits of clean data at order 12 are lost.
pub(super) const RANK_CUTOFF: f64 = 1e-13;
/// Numerator terms beyond two per mode, for modes outside the band. Zero to four do
/// equally well once there are spare pole pairs.
pub(crate) const NUMERATOR_EXTRA: usize = 2;
/// Spectral lines (two real equations each) wanted for each real unknown of one FRF. At
/// one half the system is square and the fit reproduces the noise.
pub(crate) const LINES_PER_UNKNOWN: usize = 1;

// forsythe.rs

/// A recurrence coefficient below this part of the largest |y| means that the lines carry
/// no further polynomial: there are fewer of them, with weight, than the degree asks for.
/// Rounding leaves about 1e-15.
pub(super) const BREAKDOWN: f64 = 1e-13;

// fraction.rs

/// Energy of a line below which it has no say, relative to the largest.
pub(super) const SILENT: f64 = 1e-30;

// instrumental.rs

/// A largest step, in half-bandwidths, that ends the iteration: the next one would be a
/// hundredth of it.
pub(super) const CONVERGED: f64 = 1e-5;
/// Part of a step below which it is not tried any more.
pub(super) const LEAST_PART: f64 = 0.01;
/// Relative rounding of what the numerators explain.
pub(super) const ROUNDING: f64 = 1e-13;

// lanczos.rs

/// A recurrence coefficient below this says that the lines carry no further polynomial:
/// fewer of them have weight than the degree asks for.
pub(super) const LANCZOS_BREAKDOWN: f64 = 1e-13;
/// Size of a leading coefficient over the largest one below which it is rounding.
pub(super) const VANISHING: f64 = 1e-16;

// lean.rs

/// Loss factor over the usual one from which a pole of the band, beyond as many as are
/// asked for or visible, is no mode.
pub(super) const BROAD: f64 = 3.0;
/// Poles of the residual that are tried in place of weaker ones, beyond those that are missing.
pub(super) const EXCHANGES: usize = 4;

// local.rs

/// Most FRFs fitted. The median over 200 is known to a tenth of the single scatter, and
/// bias then dominates.
pub(super) const FRFS_USED: usize = 200;
/// Radius of a cluster for poles sharper than the lines resolve, in line spacings.
pub(super) const CLUSTER_SPACINGS: f64 = 0.25;
/// A cluster counts where at least one in this many FRFs joins it.
pub(super) const CLUSTER_SHARE: usize = 3;
/// Members from which the scatter says more than the single fits.
pub(super) const SCATTER_MEMBERS: usize = 6;
/// Standard deviation of a median over that of a mean, of normal scatter (√(π/2)).
pub(super) const MEDIAN_OVER_MEAN: f64 = 1.2533;

// matrix_fraction.rs

/// Points of the circle without lines, relative to those with. The narrower, the harder
/// the model must turn there, and the more it bends the modes next to the ends: on the
/// reference panel the errors are 5 times the Cramér–Rao bound at a tenth, 2 at three
/// tenths and 1.2 at a half. Wider was not tried: powers lose digits as the arc shrinks.
pub(super) const GAP: f64 = 0.5;
/// Distance of a line from the even grid, in spacings, up to which the axis counts as
/// even.
pub(super) const UNEVEN: f64 = 0.01;
/// Grid points per line beyond which lines are too scattered to be called a grid with
/// gaps.
pub(super) const SPARSEST: usize = 8;
/// Ridge on normal equations, relative to their diagonal: clean data leave M singular at
/// rounding level beyond the true order, and polynomials of high degree may live in the
/// gap alone.
pub(super) const RIDGE: f64 = 1e-14;
/// Ridge at which something else is wrong.
pub(super) const MOST_RIDGE: f64 = 1e-6;
/// Outputs whose normal equations are summed one after the other, for sums that do not
/// depend on threads.
pub(super) const OUTPUTS_TOGETHER: usize = 8;
/// Ridge after one that did not do, over it.
pub(super) const RIDGE_UP: f64 = 10.0;

// peak.rs

/// Least drop of power on one side of a peak that says something about its width.
pub(super) const LEAST_DROP: f64 = 1.2;
/// Rise of power over the lowest on the way from a peak at which its flank ends.
pub(super) const FLANK_ENDS: f64 = 2.0;

// plscf.rs

/// Combinations of references kept. The four strongest of the reference panel miss six of
/// its modes, one symmetry class; eight miss none.
pub(super) const REFERENCES: usize = 8;
/// Combinations of responses kept. The 24 strongest hide weak modes.
pub(super) const RESPONSES: usize = 80;

// rfp.rs

/// Leading coefficient of a denominator over the length of all, below which its roots
/// lose digits.
pub(super) const LEAST_LEADING: f64 = 1e-3;

// rfp_search.rs

/// Reweighted fits after the linear one.
pub(super) const REWEIGHTED: usize = 3;
/// Steps of the last fraction.
pub(super) const LAST_STEPS: usize = 3;
/// Half-bandwidths beyond its core at which a band may still claim a pole.
pub(super) const CLAIM: f64 = 0.25;
/// Half-bandwidths within which two poles of neighbouring bands are one.
pub(super) const TWINS: f64 = 0.5;
/// Loss factor and bandwidth over their medians, both, from which a pole of the band
/// serves the background.
pub(super) const BACKGROUND: f64 = 4.0;
/// Part of the distance from the end of the band to such a place ([`HELPERS_AT`]) within which a
/// pole is there already.
pub(super) const HELPER_TAKEN: f64 = 0.5;

// sanathanan_koerner.rs

/// Eigenvalues of M, whose largest is at most one, below this are rounding.
pub(super) const SANATHANAN_KOERNER_ROUNDING: f64 = 1e-15;

// selection.rs

/// Mean distances of modes beyond the ends of the band at which poles represent out-of-band
/// modes.
pub(super) const HELPERS_AT: f64 = 2.0;
/// Variance of a residue, relative to that of its pole alone, beyond which the pole adds
/// nothing to the others: two poles a hundred-thousandth of a bandwidth apart.
pub(super) const MOST_INFLATION: f64 = 1e10;

// stabilization.rs

/// Orders looked at, about.
pub(super) const ORDERS: usize = 24;
/// Move of a natural frequency to the next order, in half-bandwidths, up to which it is
/// stable. The usual 1 % of the frequency is a whole bandwidth of a plate.
pub(super) const STABLE_FREQUENCY: f64 = 0.2;
/// Relative change of the damping ratio up to which it is stable: the usual 5 % loses
/// weak modes at 40 dB.
pub(super) const STABLE_DAMPING: f64 = 0.2;
/// Part of the orders that must agree on a mode.
pub(super) const AGREED: f64 = 0.3;
/// Damping ratio beyond which a pole is background.
pub(super) const HEAVIEST: f64 = 0.2;
/// Part of the band's width beyond its ends in which poles represent out-of-band modes; residual
/// terms represent those that are farther.
pub(super) const BEYOND: f64 = 0.1;
/// Radius of a cluster for poles sharper than the lines resolve, in line spacings.
pub(super) const STABILIZATION_CLUSTER_SPACINGS: f64 = 0.25;
/// Orders that must agree at least.
pub(super) const AGREED_LEAST: f64 = 2.0;
/// Lines per mode at least.
pub(super) const LINES_PER_MODE: usize = 3;

// stabilization.rs, the highest order

/// Highest order: poles per expected mode, and more for what lies outside the band. Twice
/// per mode misses weak modes, four times doubles the time for a third less bias.
pub(super) const POLES_PER_MODE: usize = 3;
/// See [`POLES_PER_MODE`].
pub(super) const MORE_POLES: usize = 24;
/// Lines per pole at least.
pub(super) const LINES_PER_POLE: usize = 4;

// survey.rs

/// Half window of the noise estimate under the peaks, lines; a few dozen bandwidths at
/// usual resolutions.
pub(super) const NOISE_HALF_WINDOW: usize = 40;
/// Poles beyond the modes asked for: they take up noise and what lies outside the band.
/// The reference panel needs four.
pub(super) const SPARE_POLES: usize = 6;
/// Modes to expect over those that show: a third more.
pub(super) const EXPECTED: (usize, usize) = (4, 3);

// vf.rs

/// Random mixtures of the compressed columns: twice those of a starter, since nothing
/// refines the result.
pub(super) const MIXTURES: usize = 2 * crate::tolerances::POOL_MIXTURES;

// overlapping_bands.rs

/// Visible peaks per band. With the spare poles |a| then spans six decades.
pub(super) const WINDOWS_PEAKS_PER_BAND: usize = 8;
/// Lines of its neighbours on each side, over the width of a band.
pub(super) const OVERLAP: f64 = 0.15;
/// Poles beyond the visible ones.
pub(super) const WINDOWS_SPARE_POLES: usize = 6;
/// Peaks that a border may stand off an equal share of them, in shares.
pub(super) const LEEWAY: f64 = 0.35;
/// Lines beyond twice the order that a fraction needs.
pub(super) const LEAST_LINES: usize = 8;
