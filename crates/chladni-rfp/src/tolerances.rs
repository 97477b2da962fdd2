//! Constants that several rooms share, with meaning, unit, origin, and what happens at other
//! values. Those of one room are in its `limits.rs`.

/// The end of a refinement of poles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Precision {
    /// Most steps.
    pub steps: usize,
    /// Part of a half-bandwidth: a smaller step is the last.
    pub tolerance: f64,
}

impl Precision {
    /// The same tolerance, after at most so many steps.
    pub fn within(self, steps: usize) -> Self {
        Self { steps, ..self }
    }
}

/// Refinement steps that tell how far the poles of another method stand from the
/// likeliest ones: the first are the longest.
pub(crate) const STEPS_AHEAD: usize = 4;
/// Noise variance of clean data relative to their mean square, at which rounding of the
/// data and of the kernels begins to look like modes.
pub(crate) const ROUNDING_VARIANCE: f64 = 1e-26;
/// Part of a basis column of unit norm outside those before it from which on their Gram
/// matrix serves as well as the columns: it costs four digits of sixteen. The pools of a
/// panel stand at 0.05.
pub(crate) const OUTSTANDING: f64 = 1e-2;
/// Random mixtures that vector fitting works on. 4 begins to miss modes, 16 doubles the
/// time and finds none more.
pub(crate) const POOL_MIXTURES: usize = 8;
/// Most relaxed vector-fitting steps, unless told otherwise.
pub(crate) const POOL_ITERATIONS: usize = 8;
/// Most steps for each voting run of the measured-data path: nine for each ladder of orders. They
/// need agreement, not digits.
pub(crate) const VOTE_ITERATIONS: usize = 6;
/// Levenberg–Marquardt damping at the start, relative to the diagonal.
pub(crate) const LM_START: f64 = 1e-3;
/// Damping at which no step can help any more.
pub(crate) const LM_GIVE_UP: f64 = 1e8;
/// Refinement before the order is decided: enough to sort modes from noise.
pub(crate) const ROUGH: Precision = Precision {
    steps: 6,
    tolerance: 1e-3,
};
/// The final refinement; convergence ends it before its last step. That is quadratic, so
/// the error left is the square of the tolerance.
pub(crate) const FINE: Precision = Precision {
    steps: 30,
    tolerance: 1e-7,
};
/// Poles stay where they are.
pub(crate) const NO_STEP: Precision = Precision {
    steps: 0,
    tolerance: 0.0,
};
/// A pole narrower than this part of the line spacing is one line's error, not a
/// resonance.
pub(crate) const SPIKE_SPACINGS: f64 = 0.2;
/// Half-bandwidths on both sides that the local residual tests look at.
pub(crate) const WINDOW_HALF_WIDTHS: f64 = 3.0;
/// Least lines on each side of a local window.
pub(crate) const WINDOW_LEAST_LINES: usize = 4;
/// Partial sums of a streaming pass; fixed, so that the bits do not depend on the number
/// of threads.
pub(crate) const PASS_GROUPS: usize = 8;
/// Singular values of the columns that stay free in every pair, relative to the largest,
/// below which a direction is rounding.
pub(crate) const FREE_RANK: f64 = 1e-10;
/// Rounding of a sum of squares relative to the data's energy (of a residual's: to the
/// geometric mean of both energies), within which a step may seem to make things worse.
pub(crate) const STEP_ROUNDING: f64 = 1e-14;
/// Eigenvalue of a correlation-like information matrix below which a direction is not
/// known at all: far above rounding, far below the 1e-5 of modes that overlap threefold.
pub(crate) const UNINFORMED: f64 = 1e-10;

/// Loss factor 2ζ up to which a viscous pole is saved: at 2 it has no natural frequency
/// any more.
pub(crate) const VISCOUS_LOSS_MOST: f64 = 1.98;

/// Loss factor beyond which a pole is no resonance.
pub(crate) const BACKGROUND_LOSS: f64 = 0.4;

/// Rounds of leaving out outlier lines and fitting again: the second finds those that hid
/// beside the first.
pub(crate) const OUTLIER_ROUNDS: usize = 5;

/// Least positive number under a quotient, a root or a logarithm: an energy below it is
/// none.
pub(crate) const TINY: f64 = 1e-300;

/// Damping of Levenberg and Marquardt after a step that serves, over that before it.
pub(crate) const LM_DOWN: f64 = 0.1;

/// The same after a step that fails.
pub(crate) const LM_UP: f64 = 10.0;

/// Least damping after a step that fails, so that a few failures change it.
pub(crate) const LM_LEAST: f64 = 1e-6;

/// Standard deviation of normal values over the median of their size (1/Φ⁻¹(3/4)).
pub(crate) const SIGMA_OF_MEDIAN: f64 = 1.4826;

/// Noise variance, over the mean square of normalised data, that a fit has at least:
/// below it is rounding.
pub(crate) const VARIANCE_LEAST: f64 = 1e-30;
