//! Constants of fewest modes, fewest actuators and bands: meaning, unit, origin.

/// Rounds of the reweighted sum of amplitudes. The study's 8; the number of actuators
/// settles after 4 or 5.
pub const REWEIGHTINGS: usize = 8;

/// Amplitude over the largest at which the price of an actuator falls to half. Ten times
/// more hardly prices, ten times less freezes the first choice.
pub const PRICE_FLOOR: f64 = 0.01;

/// Amplitude over the largest below which an actuator counts as unused.
pub const UNUSED: f64 = 1e-3;

/// Rounds of conic programs by which the ground is judged that a subset of actuators
/// could serve. One does not yet see the rows that are missed next.
pub const EXCHANGE_ROUNDS: usize = 3;

/// Most exchanges of one actuator for another.
pub const MOST_EXCHANGES: usize = 4;

/// Terms of the series of a folded mode, above and below the drive frequency: powers 0,
/// 2, 4 and −2, −4 of ω, as in the residual terms that fits use.
pub const FOLDED_TERMS: [i32; 2] = [3, 2];

/// Share of ground between the responses that fewer modes may cost.
pub const LOSS_OF_GROUND: f64 = 0.005;

/// Share of hot and of cold responses from which a drive serves, as in `chladni demo`.
pub const SERVES: f64 = 0.95;

/// The part that a fit of a part of the band may leave out at the drive frequency, over
/// the mobility: the isotropic error that drives are made to tolerate.
pub const BAND_ERROR: f64 = 3e-3;
