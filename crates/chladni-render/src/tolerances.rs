//! Constants of the crate: meaning, unit, origin, and what happens at ten times more or
//! less. The rooms `rig` and `time` have tables of their own.

mod rig;
mod time;

pub use rig::*;
pub use time::*;

/// Positions closer than this are the same place, m. From the scene contract. Ten times
/// less: coordinates printed with six digits fall off the border they lie on; ten times
/// more is still far below any measuring grid.
pub const POSITION_M: f64 = 1e-6;

/// Largest number of cells of a grid. Bounds the work that a scene file can ask for; real
/// scenes have a few.
pub const MAX_CELLS: usize = 100_000;

/// Largest number of corners of all polygons together. Their union is found in
/// quadratic time; ten times more would take half a minute.
pub const MAX_POLYGON_POINTS: usize = 2000;

/// Largest level of a scene, dB: from the threshold of a fingertip to what no panel
/// survives are some 100 dB.
pub const MOST_DB: f64 = 200.0;

/// Frequencies closer than this, relative, are the same line. Six printed digits of an
/// axis; ten times less calls a line of a single-precision axis another one, ten times
/// more is a fifth of a bandwidth at 0.005 % loss.
pub const SAME_FREQUENCY: f64 = 1e-6;

/// Distance of two tones, Hz, below which they are refused: they beat for ten seconds and
/// more, one tone that swells and fades. Ten times more would refuse what two close modes
/// ask for, ten times less is no pattern of two tones.
pub const LEAST_TONE_DISTANCE_HZ: f64 = 0.1;

/// Largest drift of a scene, relative: a part of what drifts.
pub const MOST_DRIFT: f64 = 1.0;

/// Largest weight of a file, N or V: no actuator comes near it, and what is printed of it
/// is still read.
pub const MOST_WEIGHT: f64 = 1e15;

/// Difference of a weight's amplitude and phase from its parts, relative, that decimals of
/// other programs may leave.
pub const SAME_WEIGHT: f64 = 1e-2;

/// Distance of the tones that a band of a drive is made of, Hz: half of a narrow mode's
/// bandwidth on a glass panel, so that none falls between them.
pub const BAND_STEP_HZ: f64 = 2.0;

/// Most tones of one drive. Each costs a rendering of its own, and has so small a part of
/// what all share.
pub const MOST_TONES: usize = 64;

/// Number of DOFs that a message lists.
pub const DOFS_SHOWN: usize = 8;

/// Relative ridge of every normal matrix, times its mean diagonal: keeps Cholesky alive
/// where the drift is switched off. Ten times less meets rounding (condition 1e13), ten
/// times more is still 60 dB below the default isotropic error.
pub const RIDGE: f64 = 1e-12;

/// Relative width of a limit: a drive scaled to meet it exactly meets it after rounding,
/// too. A thousand roundings; the difference it can make to a judgement is 1e-11 dB.
pub const LIMIT: f64 = 1e-12;

/// Condition number above which the two-step inverse says that it is ill conditioned. The
/// study saw 4e2 for usable sets of modes and 5e5 where forces rose to newtons; ten times
/// more or less only moves a warning.
pub const ILL_CONDITIONED: f64 = 1e4;

/// Participation below this, relative to the largest of all modes, counts as zero. An
/// actuator on a nodal line by symmetry leaves only rounding there (some 1e-12); ten
/// times more or less lies between that and any placed by hand.
pub const NO_PARTICIPATION: f64 = 1e-9;

/// Largest spacing of the grid on which areas are judged, m. From the weights contract.
pub const AREA_STEP_M: f64 = 0.005;

/// Largest number of points of that grid; beyond it the step grows. 200 000 points are a
/// plate of 2 m by 2.5 m at 5 mm.
pub const MAX_AREA_POINTS: usize = 200_000;

/// Up to so many responses are interpolated by one system; above, by the
/// [`NEAREST_RESPONSES`] around each place. A wave at 2000 places (largest error, time for
/// a new set of responses), one system against patches: 330 responses 1.0e-3 against
/// 1.2e-3, 11 against 118 ms; 600 2.5e-4 against 3.2e-4, 27 against 131 ms; 2000 both
/// 1e-5, 287 against 155 ms.
pub const GLOBAL_INTERPOLATION: usize = 1000;

/// Responses × places up to which one system serves: 240 MB of numbers.
pub const GLOBAL_BASIS: usize = 30_000_000;

/// Responses around a place that its interpolated value is made of. Three rings of a
/// square grid; fewer lose accuracy at the rim of the scan, more only time.
pub const NEAREST_RESPONSES: usize = 49;

/// Coordinates nearer than this are the same, over the radius of the responses: rounding
/// of grids. A thousand times more would still be below a micrometre.
pub const SAME_COORDINATE: f64 = 1e-10;

/// Rows of places, times distances in x, lines and columns of nodes, over places times nodes,
/// up to which places of one row share sums over nodes; grids of one step have one of each.
/// Beyond, sharing costs more than it saves.
pub const SHARED_MOST: usize = 4;

/// Level above the threshold from which strength is warned about, dB: at 300 Hz some 8 dB
/// below the hand-arm action value of directive 2002/44/EC (2.5 m/s² weighted by ISO
/// 5349-1, which is 25 mm/s rms there).
pub const STRONG_DB: f64 = 35.0;

/// Relative distance to its limit within which a drive counts as limited. Only decides
/// whether a stronger ridge is tried.
pub const AT_LIMIT: f64 = 1e-6;

/// Ridges, relative to the mean diagonal of the normal matrix, tried in turn where the
/// force limit binds. From below the covariance of a good model to where the drive is
/// little more than time reversal.
pub const FORCE_RIDGES: [f64; 5] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// Steps of the magnitude iteration, and how many drives go on after them: from all
/// starts on the responses; from their leaders with every margin; from the leaders of
/// those with the ground between. All drives to the end of every round cost twice the
/// time for the same drives; two at the last end lose 4 % of the hot ground of the 3×3
/// edges.
pub const MLS_ROUNDS: [[(usize, usize); 2]; 3] =
    [[(12, 4), (18, 2)], [(20, 3), (40, 2)], [(10, 4), (30, 4)]];

/// Overshoot of the magnitude iteration, below 2 for convergence; 1 is the plain one.
/// Flat between 1.5 (κ 2.4) and 1.9 (2.6).
pub const MLS_RELAXATION: f64 = 1.8;

/// Rows of a matrix that are summed at once in its steps: eight sums of four lanes are on
/// their way, so that none waits for the one before it.
pub const LANES: usize = 8;

/// Margins by which the iteration wants its rows inside their limits, dB: all starts with
/// the first, the best start with the others. On the corner scene alone: 0.5 dB κ 1.0, 1
/// dB 2.1, 2 dB 3.3, 3 dB 3.0, 4 dB 2.6, 6 dB 1.8.
pub const MLS_MARGINS_DB: [f64; 3] = [2.0, 1.0, 3.0];

/// Weight of rows between the responses against 1 for a response. Without them 20 mm
/// between responses let dips of 1 to 2 dB through (hot ratio of the corner scene's area
/// 0.93 against 0.98); at 1, scenes near what is possible give up responses for the
/// ground between them.
pub const BETWEEN_WEIGHT: f64 = 0.3;

/// Spacing of the rows between the responses over the mean spacing of the responses. Half
/// finds the dips; a third costs twice the time for the same area ratios.
pub const BETWEEN_SPACING: f64 = 0.5;

/// The same for conic programs, where only those rows take part that are missed. With
/// half the spacing of the responses 2 to 3 % of the cold ground of quarters is lost
/// between them, with a third 0.1 to 1.5 %, in the same time.
pub const FINE_SPACING: f64 = 0.33;

/// κ above which more of it counts less than ground between the responses. Two standard
/// deviations hold for most of some 70 responses at once.
pub const KAPPA_ENOUGH: f64 = 2.0;

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

/// Chance that no response misses its limit by the errors that are assumed, above which
/// more κ is not sought. The usual level: κ 2.6 for 77 responses. With ten times the
/// chance of a miss κ is 2.1, with a tenth of it 3.0.
pub const CONFIDENCE: f64 = 0.95;

/// Share of the force limit that counts as little: margin is bought up to it and no
/// further. 2 mN of the 0.1 N that hold where a scene says nothing. Ten times more brings
/// back the last tenths of a decibel at several times the force, ten times less leaves
/// most scenes without any margin.
pub const LITTLE_FORCE: f64 = 0.02;

/// The same without a limit, over the least peak force that κ takes.
pub const MARGIN_RISE: f64 = 2.0;

/// κ on the responses below which rows between them are left out: less would give up sure
/// responses for guessed ground.
pub const KAPPA_LEAST: f64 = 1.0;

/// κ that differ by less than this, relative, are the same: a thousand roundings of a
/// conic program.
pub const SAME_KAPPA: f64 = 1e-4;

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

/// Below this distance from the certified ceiling, dB, nobody looks for a drive with
/// still more contrast.
pub const CEILING_REACHED_DB: f64 = 0.1;

/// Largest distance of the certified ceiling to what was found, dB, where method `best`
/// tells cases apart. Half of it takes three times the cases.
pub const CEILING_CASES_DB: f64 = 0.19;

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

/// Ridge of the baseline `tikhonov` over the largest eigenvalue of HᴴH; the best of the
/// study's grid of powers of ten.
pub const TIKHONOV: f64 = 1e-3;

/// Least singular value of the baseline `tsvd` over the largest.
pub const TSVD: f64 = 1e-2;

/// Directions of the baseline `vast`: the study's choice.
pub const VAST_RANK: usize = 8;

/// κ of `min-effort`.
pub const KAPPA_EFFORT: f64 = 1.0;

/// Most starts of conic programs, with method `best`.
pub const MOST_STARTS: usize = 3;

/// Likeness |aᴴb|/(‖a‖‖b‖) of drives that lead to the same place.
pub const SAME_WAY: f64 = 0.95;

/// Largest responses × actuators² for which the default method is `robust`. For 34 actuators
/// 77 responses (8.9e4) take 0.03 s of processor time, 330 (3.8e5) 0.06 s, 693 (8e5) 0.15 s, a
/// scene of the last that no drive serves 1.2 s; its programs grow with this number.
pub const ROBUST_SIZE: f64 = 1e6;

/// Relative change of the drive below which a round was the last one.
pub const SAME_DRIVE: f64 = 0.01;

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

/// Distance of the frequencies of a sweep, Hz: a fifth to a half of the bandwidth of a
/// glass panel's modes there.
pub const SWEEP_STEP_HZ: f64 = 2.0;

/// Most steps of a sweep.
pub const MOST_SWEPT: f64 = 500.0;

/// Shares of responses nearer than this are equal to the frequency chooser: less than one
/// response in a hundred.
pub const SAME_SUCCESS: f64 = 0.005;

/// Share of hot and of cold responses from which a drive serves, as in `chladni demo`.
pub const SERVES: f64 = 0.95;

/// Errors of each actuator's force for its weight that a drive of method `robust` bears
/// where its scene names none and margin allows, rms of the complex factor, relative. The
/// first is that of the scene contract (amplifiers of 1 % and 1°). docs/accuracy.md has what
/// each buys and costs.
pub const BORNE_DRIVE_ERRORS: [f64; 2] = [0.02, 0.01];

/// Rigs that are simulated for one drive: the share that survives is then sure to 1.5 %
/// where it is 0.95.
pub const ENDURANCE_RIGS: usize = 200;
/// Rigs that are simulated at a time: their matrices stay in the cache.
pub const RIGS_AT_ONCE: usize = 40;
/// Seed of these rigs: the same for every drive.
pub const ENDURANCE_SEED: u64 = 0;
/// Rms error of each natural frequency there, relative: a few
/// kelvin.
pub const ENDURANCE_FREQUENCY_ERROR: f64 = 1e-3;

/// The part that a fit of a part of the band may leave out at the drive frequency, over
/// the mobility: the isotropic error that drives are made to bear.
pub const BAND_ERROR: f64 = 3e-3;

/// Rms of a mode over the responses, over its rms at the actuators, where no driving
/// point tells. On the study's panel, with actuators at its free edges, 0.44 to 0.93 with
/// a median of 0.58; where actuators stand among the responses it is 1, and a touch does
/// twice to three times as much.
pub const RESPONSES_OVER_ACTUATORS: f64 = 0.6;

/// Noise of a measured field that does not state its own, over its rms. The study's usual
/// level; ten times more hides a dead channel, ten times less finds causes in the noise.
pub const FIELD_NOISE: f64 = 0.01;

/// Least noise that a field is believed to have, over its rms: the isotropic error of a
/// good fit.
pub const LEAST_FIELD_NOISE: f64 = 1e-4;

/// Error of each channel's gain that a prediction is taken to have at least, rms of the
/// complex factor: amplifiers of 2 % and 2° have 0.04.
pub const RIG_DRIVE_ERROR: f64 = 0.03;

/// The same at least of gains that fields have taught, at another frequency or on another
/// day: amplifiers are flat to so much over some ten hertz.
pub const CALIBRATED_DRIVE_ERROR: f64 = 0.005;

/// Size of an odd channel's factor below which it is dead.
pub const DEAD_GAIN: f64 = 0.1;

/// Standard deviation of that gain up to which it counts: a sound channel lies five deviations
/// away. A healthy one called dead, behind a common factor of 0.8, had 0.25.
pub const DEAD_GAIN_STD: f64 = 0.2;

/// Natural frequencies nearer than this, relative, are those of one model: decimals of a
/// file.
pub const SAME_MODE: f64 = 1e-9;

/// Most fingers at once: those of one hand.
pub const MOST_FINGERS: usize = 5;

/// Distance of the places that fingers are tried at, m: a fifteenth of a wavelength on the
/// study's panel, half of its responses' spacing.
pub const TOUCH_STEP_M: f64 = 0.010;

/// Most of these places; beyond, they lie farther apart.
pub const MOST_TOUCH_PLACES: usize = 150;

/// Most places of the grid that these are taken from: 10 m² at [`TOUCH_STEP_M`], some
/// milliseconds.
pub const MOST_TOUCH_GRID: f64 = 1e5;

/// Touched rows that join a conic program at once: they are alike from place to place, so
/// that a few of the worst speak for most.
pub const TOUCH_ROWS_JOINING: usize = 60;

/// Relative shortfall of κ under fingers that counts as none: rows join only where they miss
/// by more than [`JOIN_SLACK`].
pub const SAME_TOUCHED_KAPPA: f64 = 0.02;

/// Motion that a finger takes from its own place, dB, above which no program is tried in a
/// sweep: the study found none that bears it.
pub const TOUCH_LOSS_DB: f64 = 3.0;

/// Rounds of programs that a frequency of a sweep is worth.
pub const TOUCH_SWEEP_ROUNDS: usize = 4;

/// Distance from the drive, Hz, within which another frequency is looked for where fingers
/// are not borne, and the step of that.
pub const TOUCH_SEARCH_HZ: [f64; 2] = [40.0, 10.0];

/// Frequencies of these that are tried by a program.
pub const TOUCH_TRIED: usize = 3;

/// Relative step of the slope of a field over a natural frequency: a thousandth of a narrow
/// bandwidth, and a thousand times the rounding of its square root.
pub const SLOPE_STEP: f64 = 1e-6;

// interpolation.rs

/// The orders m that are tried, the smoothest first.
pub const ORDERS: [usize; 3] = [4, 3, 2];

// zones.rs

/// Corners of the outline of a spot, for pictures.
pub const SPOT_CORNERS: usize = 48;
