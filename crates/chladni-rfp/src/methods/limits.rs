//! Limits of the classic methods.

/// Numerator terms beyond two per mode, for modes outside the band. Zero to four do
/// equally well once there are spare pole pairs.
pub(crate) const NUMERATOR_EXTRA: usize = 2;

/// Spectral lines (two real equations each) wanted for each real unknown of one FRF. At
/// one half the system is square and the fit reproduces the noise.
pub(crate) const LINES_PER_UNKNOWN: usize = 1;

/// Pole pairs beyond the peaks or the modes asked for. Four modes, 24 FRFs, 20 dB: none
/// to spare misses all four modes, two miss one, four none. Eight modes at 40 dB: one
/// misses up to three, two and more none, with a tenth of the error or less.
pub(crate) const SPARE_PAIRS: usize = 4;

/// Most visible peaks per band: with the spare pairs what the method holds.
pub(crate) const PEAKS_PER_BAND: usize = ORDER_HELD - SPARE_PAIRS;

/// Pole pairs per band that the method holds. D spans about twelve decades over twenty
/// even-spaced modes, and no weight is right for all of them at once.
pub(crate) const ORDER_HELD: usize = 12;

/// Condition beyond which the last digits of the measurement decide the answer.
pub(crate) const CONDITION_HELD: f64 = 1e12;

/// Half-bandwidth of the broadest pole that counts as a mode, relative to the width of
/// the band: broader ones stand for what lies outside.
pub(crate) const BROADEST: f64 = 0.5;

/// Largest standard deviation of a natural frequency relative to the half-bandwidth that
/// still counts as a mode. Modes stand below a third, computational poles mostly between
/// one and a thousand.
pub(crate) const MOST_UNCERTAIN: f64 = 0.5;
