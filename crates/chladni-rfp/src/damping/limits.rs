//! Every constant of this room: meaning, unit, where it comes from, and what happens at other
//! values where that was tried.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// bars.rs

/// Limits of 95 % of real errors, in error bars: to both sides, and to one side.
pub(super) const REAL_95: [f64; 2] = [1.9600, 1.6449];
/// The same of complex errors: without a preferred direction, and to one side where nobody knows the
/// direction. There it holds 97 % of errors without one, and 92 % of those along the shift. With 1.1631,
/// 95 % and 88 %: shapes of bursts under a Hann window then held in 0.88.
pub(super) const COMPLEX_95: [f64; 2] = [1.7308, 1.4];

// filled.rs

/// Lines that are written at a time: the widest registers hold eight numbers.
pub(super) const LANES: usize = 8;

// gram.rs

/// Columns that a thread makes at a time: fewer take less time than to share them out.
pub(super) const POLES_AT_A_TIME: usize = 8;
/// Most poles whose columns are alive at a time in products: those of 8 poles and their
/// derivatives on 1601 lines take 0.4 MB, which stay in the cache of a core. 16 take the same time.
pub(super) const POLES_IN_CACHE: usize = 8;

// law.rs

/// Largest loss factor that a step gives a viscous pole: critical damping is 2.
pub(super) const LOSS_MOST: f64 = 1.9;

// phased.rs

/// Powers of y = √x beside those of x: the residual terms of the viscous law that the
/// structural one has not.
pub(super) const ODD_POWERS: [i32; 4] = [-3, 1, 3, 5];
/// Steps at most. Complex shapes, which one angle for each mode does not fit, take many: with 20,
/// hard structure 40135 of the benches ended where its laws differ by what the search had left.
pub(super) const STEPS: usize = 200;
/// Promised decrease of the sum of squares by a step, in units of the noise variance,
/// below which it is not made: a thousandth of what decides.
pub(super) const PROMISED: f64 = 1e-2;
/// Steps that together must bring what [`PROMISED`] asks of each: where a pole of noise stands at
/// the end of its room, each promises more than it brings.
pub(super) const STEPS_TOGETHER: usize = 10;
/// Largest step of an angle, rad.
pub(super) const TURN: f64 = 0.3;
/// Largest step of a pole, half-bandwidths, and the part of its loss and of its square of
/// frequency that a pole keeps at least.
pub(super) const PHASED_STEP: f64 = 0.5;
/// See [`PHASED_STEP`].
pub(super) const PHASED_KEPT: f64 = 0.2;

// places.rs

/// Least loss factor of a pole that is taken from one law to the other: steps are
/// measured in half-bandwidths.
pub(super) const LEAST_LOSS: f64 = 1e-6;

// plane.rs

/// Numerator terms beyond the degree of the denominator: residual terms from 1/x to x².
pub(super) const RESIDUAL_TERMS: usize = 3;

// saved.rs

/// Relative gain of a step below which the next would gain nothing.
pub(super) const SAVED_SETTLED: f64 = 1e-9;
/// Half-widths of a pole over which derivatives are differences.
pub(super) const SAVED_DIFFERENCE: f64 = 1e-4;
/// Part of itself that Re λ (the square of a frequency) or Im λ loses at most by a step; it may
/// double.
pub(super) const SAVED_LOSS_BY_STEP: f64 = 0.5;

// partial_fractions.rs

/// Place of a viscous pole over that of the last line, from which on its products keep their digits:
/// a tenth in frequency. Where lines weigh as ω³ and more, those of near poles keep ten there.
pub(super) const LEAST_PLACE: f64 = 1e-2;
/// Half-bandwidths within which a line must lie: products of derivatives lose the square of the
/// distance.
pub(super) const LINE_WITHIN: f64 = 30.0;

// verdict.rs

/// Shift of a frequency and a loss factor under the wrong law, relative and over η²: those of one
/// pole read in both laws, −s² = ω²(1 − η²/2 + jη√(1 − η²/4)).
pub(super) const FREQUENCY_SHIFT: f64 = 0.25;
/// See above.
pub(super) const LOSS_SHIFT: f64 = 0.375;
/// Turn of a mass-normalised shape under the wrong law, over η: that of √(1 + jη/2).
pub(super) const SHAPE_TURN: f64 = 0.25;
/// Difference of −2 ln likelihood up to which a mode is left out of the verdict: fifty such modes
/// make a thirtieth of what decides.
pub(super) const SAYS_NOTHING: f64 = 0.01;
/// Difference of −2 ln likelihood that decides: for two models with as many unknowns each
/// the wrong one wins by so much with a probability below Φ(−4) = 3e-5.
pub(super) const DECIDES: f64 = 16.0;
/// A form of angles below this, in the same unit, is no rounding: its poles fell together.
pub(super) const FORM_LEAST: f64 = -1.0;
/// Standard deviations of χ² that the angles of the better law may stand over its mean.
pub(super) const ANGLES_EXPLAINED: f64 = 4.0;
/// Loss factor from which on a pole of the band is background.
pub(super) const BROAD: f64 = 0.3;
/// Distance from the end of the other law's search, in half-bandwidths and rad, within which a search
/// has ended in the same minimum.
pub(super) const SAME_END: f64 = 0.1;
/// Searches at most that start again from the poles of the other law; two have sufficed.
pub(super) const RESTARTS: usize = 4;
