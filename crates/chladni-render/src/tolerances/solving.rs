//! Constants of the programs and bounds that methods share: meaning, unit, origin.

/// Accuracy of conic programs (gap and feasibility, relative): a drive that keeps its
/// limit to 1e-7 keeps it. Ten times less costs a step or two of the interior-point
/// method, ten times more is still far below a hundredth of a decibel.
pub const CONIC_GAP: f64 = 1e-7;

/// Residual, relative and absolute, of the linear systems inside: a thousandth of
/// [`CONIC_GAP`]. At the solver's own 1e-13 a third of its time goes into refining steps
/// that are only directions; ten times more costs steps.
pub const CONIC_REFINEMENT: f64 = 1e-10;

/// Most steps of the interior-point method; 12 to 25 are usual.
pub const CONIC_STEPS: u32 = 100;

/// The least eigenvalue of both sides of a conic program at the beginning, where least
/// squares leave less. With 1 or 100 a fifth more steps are taken, with 0.01 half as many
/// again.
pub const CONIC_START: f64 = 10.0;

/// Share of the way to the border of the cones that a step goes. 0.95 to 0.99 take the same
/// number of steps.
pub const CONIC_STEP: f64 = 0.98;

/// A step shorter than this leads nowhere: usual ones are longer than a tenth.
pub const CONIC_LEAST_STEP: f64 = 1e-5;

/// Residual, over what it proves, of a proof that a program has no solution.
pub const CONIC_PROOF: f64 = 1e-8;

/// Relative ridge of the equations of a step, times their mean diagonal: a hundred
/// roundings, taken out again by a second solution.
pub const CONIC_RIDGE: f64 = 1e-14;

/// Rows up to which all of them are in a program from the beginning: the responses of the
/// demonstration panel and the ground that joins them.
pub const FEW_ROWS: usize = 150;

/// Rows beyond which they join by stretches: touched ones of a whole panel. 15000 at once take
/// some seconds a program, and some hundred of them bind.
pub const VERY_MANY_ROWS: usize = 3000;

/// Rows of these with which a program begins, and that join it at once. 100 take half as long
/// again.
pub const ROWS_AT_ONCE: usize = 300;

/// [`NEAR_LIMIT`] of these. With 0.05 a program finds its rows anew (twice the time).
pub const NEAR_LIMIT_OF_MANY: f64 = 0.2;

/// Distance from its limit, relative, within which a row of many is in the next program from
/// the beginning. Twice as much costs the time of twice the rows, half as much another
/// program now and then.
pub const NEAR_LIMIT: f64 = 0.05;

/// Rows of a cone above which it enters the equations of a step as one row and a fixed sum
/// in place of row by row. Error bars have 69 rows, the others three.
pub const WIDE_CONE: usize = 8;

/// κ below this is none: the rounding of a program whose largest κ is 0.
pub const NO_KAPPA: f64 = 1e-4;

/// Price of one threshold of error bar ‖L·A‖ against a factor of 1 in contrast, where the
/// margin is largest: picks among drives of equal margin the one that errs least. Ten
/// times more costs a hundredth of a decibel.
pub const DEVIATION_PRICE: f64 = 1e-4;

/// Share of the force limit that counts as little: margin is bought up to it and no
/// further. 2 mN of the 0.1 N that hold where a scene says nothing. Ten times more brings
/// back the last tenths of a decibel at several times the force, ten times less leaves
/// most scenes without any margin.
pub const LITTLE_FORCE: f64 = 0.02;

/// The same without a limit, over the least peak force that κ takes.
pub const MARGIN_RISE: f64 = 2.0;

/// A round of conic programs that gains less κ than this was the last one.
pub const KAPPA_GAIN: f64 = 0.02;

/// A round that gains less than this in the factor between rows and limits was the last
/// one: a hundredth of a decibel.
pub const MARGIN_GAIN: f64 = 1e-3;

/// Rows that join a conic program at once.
pub const ROWS_JOINING: usize = 12;

/// The amount, over its limit, by which a row must miss what was asked to join.
pub const JOIN_SLACK: f64 = 1e-4;

/// Most rounds of conic programs of each kind, see [`crate::Effort`].
pub const ROUNDS: usize = 10;

/// Share of κ, and of the margin in dB, that is kept while the peak force is lowered.
pub const KEEP: f64 = 0.9;

/// A round that lowers peak force or effort by less than this, relative, was the last
/// one.
pub const COST_GAIN: f64 = 0.02;

/// Relative gap at which the search for the certified ceiling ends: 0.005 dB. Ten times
/// less costs two more rounds of Newton steps.
pub const CEILING_GAP: f64 = 1e-3;

/// Most cases of a ceiling. Symmetric scenes of the study's panel took 30 to 150.
pub const MOST_CASES: usize = 400;

/// Multiplier over the largest below which a bounded row is left out of a case: a fifth
/// of the rows is left, and the bound loses 0.03 dB at most.
pub const CASE_ROWS: f64 = 3e-3;

/// Factor by which the weight of the objective against the barrier rises from round to
/// round.
pub const BARRIER_RISE: f64 = 8.0;

/// Most Newton steps of one round; 5 to 10 are usual.
pub const BARRIER_STEPS: usize = 30;

/// Newton decrement, squared, at which a round is centred. The certificate holds whatever
/// it is.
pub const BARRIER_DECREMENT: f64 = 1e-3;

/// Relative change of the drive below which a round was the last one.
pub const SAME_DRIVE: f64 = 0.01;
