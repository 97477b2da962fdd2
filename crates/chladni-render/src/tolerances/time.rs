//! Constants of scenes in time: meaning, unit, origin.

/// Frequencies within this distance of the carrier follow a ramp with lag, Hz: modal
/// ramps steer these modes one by one. Twice as many changes nothing on the study's
/// panel, half as many costs its fastest ramps.
pub const NEAR_MODES_HZ: f64 = 300.0;

/// Least singular value, over the largest, by which residual terms like 1/ω² get a pole at
/// rest; what is below is the noise of a fit, and its first order about the carrier will do.
pub const REST_POLE: f64 = 1e-2;

/// Distance of a pole from the carrier below which modal ramps count it no more, Hz: a
/// mode on the carrier would outweigh all others.
pub const NEAREST_POLE_HZ: f64 = 20.0;

/// Ridge of modal ramps over the largest singular value. Flat from 1e-3 to 3e-2; at 0.1
/// ground is over its limit again.
pub const MODAL_RAMP_RIDGE: f64 = 0.01;

/// Time from sample to sample where ground is judged in time, s: a thirteenth of a period
/// at 300 Hz. The field errs by −44 dB of the cold limit there, and by −50 dB at half of
/// it.
pub const JUDGE_STEP_S: f64 = 2.5e-4;

/// Relative step of the frequency over which the steepness of a threshold is taken: within
/// it the profiles run straight.
pub const THRESHOLD_STEP: f64 = 0.01;

/// Samples that are simulated and judged at once: bounds the memory of long signals, and
/// keeps it small enough to be used again. Of 2048 samples a third of the time went into
/// fresh pages.
pub const JUDGE_BLOCK: usize = 128;

/// Rows from which on the measures are judged side by side: threads that wait for blocks of
/// fewer take longer than these do.
pub const JUDGE_TOGETHER: usize = 500;

/// Time for which ground is judged after the last event, s: it is quiet long before that,
/// or it rings.
pub const JUDGE_TAIL_S: f64 = 0.15;

/// Ramps take at least so many periods of the distance from the carrier to the nearer end
/// of the model's band: what is faster excites what the model does not know. A rule of
/// thumb.
pub const RAMP_PERIODS: f64 = 2.0;

/// Periods of a raised-cosine ramp from its tone to the first zero of its spectrum.
pub const RAMP_SPREAD: f64 = 1.5;

/// A band that begins below this share of the lowest natural frequency has nothing below
/// it.
pub const BEGINS_BELOW: f64 = 0.5;

/// Longest ramp that `ramp_s = "auto"` tries, s. What does not pass then will not.
pub const LONGEST_AUTO_RAMP_S: f64 = 0.05;

/// Ramp up to which `ramp_s = "auto"` keeps the level of the steady drive, s: where none so
/// short passes, one that does at a lower level comes before a longer one.
pub const QUICK_RAMP_S: f64 = 0.010;

/// Most by which a drive in time lies below the steady one, dB. On the ninths of the study's
/// panel 0.1 to 0.5 dB bring ramps of 12 to 35 ms below 10 ms; one dB more loses half of the hot
/// ground between the responses.
pub const MOST_LOWERED_DB: f64 = 0.6;

/// The same beyond what is needed, dB: a chain is heard again among others.
pub const LOWERED_FURTHER_DB: f64 = 0.01;

/// Margin of cold ground while a drive passes from place to place, dB, where hot ground can
/// spare it. Two patterns sound at once then, and each errs.
pub const PASSAGE_MARGIN_DB: f64 = 1.0;

/// Step of the ramps that are tried, s.
pub const AUTO_RAMP_STEP_S: f64 = 1e-3;

/// Hold between rise and fall where a ramp is tried, s: what a rise leaves behind shows
/// within it.
pub const TRIAL_HOLD_S: f64 = 0.06;

/// Largest distance of the keyframes of a moving spot along its path, m. Half of it is
/// added to what is hot and to what is cold in each, so that ground keeps its limit
/// between two of them; without that, at 16 mm, cold ground was over by 0.6 dB.
pub const KEYFRAME_M: f64 = 0.008;

/// Time for which the ground under a moving spot is taken as it is in the middle of that
/// time, s: 0.8 mm at 800 mm/s.
pub const SPOT_STEP_S: f64 = 1e-3;

/// Fastest moving spot, m/s: a keyframe for each sample that is judged. No ground is felt
/// long before; at 10⁹ m/s cold ground was said to be 351 dB over its limit.
pub const FASTEST_M_PER_S: f64 = KEYFRAME_M / JUDGE_STEP_S;

/// Most repetitions of a burst, and keyframes of a move: bounds what a scene file can
/// ask for.
pub const MOST_EVENTS: usize = 10_000;

/// Latest end of an event, s. A field is judged some thousand times a second: an hour takes 0.1 GB,
/// and minutes; what lasts longer is a slip of the decimal point.
pub const LATEST_END_S: f64 = 3600.0;

/// Times nearer than this are the same, s: rounding of decimal seconds.
pub const SAME_TIME_S: f64 = 1e-9;

/// Part of a step by which rounding of decimal seconds may exceed a number of steps before it
/// counts as one more.
pub const STEP_ROUNDING: f64 = 1e-6;

/// By how much a ramp may miss what the steady drive misses already, dB: scenes that are
/// not quite met have ramps, too.
pub const STEADY_MISS_DB: f64 = 0.05;

/// Ramps of a signal that nobody tells, s: what most scenes take.
pub const GUESSED_RAMP_S: f64 = 0.01;

/// Intervals between the knots of an envelope program within a ramp. Six take three times
/// the steps for nothing; three leave a ninth at 330 Hz over its limit longest.
pub const KNOTS_PER_RAMP: f64 = 4.0;

/// Least distance of these knots, s: a thirteenth of a period at 300 Hz. Closer ones ask
/// the envelopes for what the carrier itself does.
pub const LEAST_KNOT_S: f64 = 2.5e-4;

/// Time after a rise, or before a fall, in which its program shapes the drive, s.
pub const SHAPED_BEYOND_S: f64 = 0.012;

/// Time after that for which ground is looked at, s: at half of it, beats of neighbouring
/// modes came back 0.5 dB louder later.
pub const JUDGED_BEYOND_S: f64 = 0.06;

/// Largest time from sample to sample of an envelope program, s. At twice as much the field hides between the samples: up to a decibel.
pub const PROGRAM_STEP_S: f64 = 2.5e-4;

/// Most rounds of an envelope program, and quasi-Newton steps in each.
pub const PROGRAM_ROUNDS: usize = 12;

/// See [`PROGRAM_ROUNDS`].
pub const PROGRAM_STEPS: usize = 16;

/// Rounds in a row without a better drive after which an envelope program ends: where its
/// limits can be kept each round or every other one is better. Twelve find nothing more.
pub const PROGRAM_PATIENCE: usize = 3;

/// Steps whose curvature an envelope program remembers. Twenty find nothing more.
pub const PROGRAM_MEMORY: usize = 10;

/// A step ends where the slope is this part of what it was, or after so many tries each
/// way.
pub const PROGRAM_FLAT: f64 = 0.1;

/// See [`PROGRAM_FLAT`].
pub const PROGRAM_TRIES: usize = 12;

/// Growth of a step, at most, from one try to the next.
pub const PROGRAM_GROWTH: f64 = 4.0;

/// Least distance of a try between two others from both, over theirs.
pub const PROGRAM_EDGE: f64 = 0.05;

/// Price of a control point over its limit, with the largest force of modal ramps as one,
/// beside a threshold that is missed. A third does as well.
pub const PROGRAM_FORCE: f64 = 10.0;

/// Price of every control point, likewise.
pub const PROGRAM_RIDGE: f64 = 1e-4;

/// Part of the margin, in dB, that an envelope program may leave.
pub const PROGRAM_SLACK: f64 = 0.1;

/// Margin that an envelope program aims at where the steady drive has as much, dB.
pub const PROGRAM_MARGIN_DB: f64 = 0.6;

/// Share of the steady drive's margin, in dB, that is asked of an envelope program where
/// it has less than that.
pub const PROGRAM_MARGIN: f64 = 0.9;

// channel_map.rs

/// Most channels of a converter.
pub const MOST_CHANNELS: usize = 1024;

// envelope.rs

/// Time in which the speed rises, s: 1 mm of the path at 800 mm/s lies between this
/// and a speed that jumps.
pub const EASE_S: f64 = 0.01;

// signal.rs

/// Steps of an integer sample that the peak of a drive must reach: rounding then stays some 40 dB
/// below it, and cold ground lies 20 to 30 dB below hot ground.
pub(crate) const LEAST_STEPS: f64 = 64.0;

/// Most bytes of a sound file: its header counts them in 32 bits.
pub const MOST_BYTES: f64 = 4_294_900_000.0;

// simulate.rs

/// Below this |λh| the exact functions of the recursion lose digits, and their series has
/// them all: the first term left out is below 1e-17.
pub const SMALL_STEP: f64 = 1.0;
/// Terms of that series.
pub const TERMS: u32 = 18;

// splines.rs

/// Knots over which a spline is not zero.
pub const SUPPORT: usize = 4;

// stress.rs

/// Mean time for which a finger stays, and stays away, s: taps of a hand that explores.
pub const STAYS_S: f64 = 0.05;
/// Largest share of the impedance of a light finger by which one that comes and goes may
/// press: firm.
pub const FIRMEST: f64 = 3.0;
