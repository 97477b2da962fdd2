//! Constants of the problem that methods solve: meaning, unit, origin.

/// Participation below this, relative to the largest of all modes, counts as zero. An
/// actuator on a nodal line by symmetry leaves only rounding there (some 1e-12); ten
/// times more or less lies between that and any placed by hand.
pub const NO_PARTICIPATION: f64 = 1e-9;

/// Spacing of the rows between the responses over the mean spacing of the responses. Half
/// finds the dips; a third costs twice the time for the same area ratios.
pub const BETWEEN_SPACING: f64 = 0.5;

/// The same for conic programs, where only those rows take part that are missed. With
/// half the spacing of the responses 2 to 3 % of the cold ground of quarters is lost
/// between them, with a third 0.1 to 1.5 %, in the same time.
pub const FINE_SPACING: f64 = 0.33;

/// Chance that no response misses its limit by the errors that are assumed, above which
/// more κ is not sought. The usual level: κ 2.6 for 77 responses. With ten times the
/// chance of a miss κ is 2.1, with a tenth of it 3.0.
pub const CONFIDENCE: f64 = 0.95;

/// κ on the responses below which rows between them are left out: less would give up sure
/// responses for guessed ground.
pub const KAPPA_LEAST: f64 = 1.0;
