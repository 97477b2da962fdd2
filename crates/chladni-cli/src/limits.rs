//! Constants that decide something, under the file that uses them: meaning, unit, origin.

use std::time::Duration;

// compare.rs

/// Most characters of a file name in a heading.
pub(crate) const LONGEST_HEADING: usize = 24;

// curves.rs

/// Points of a curve; larger numbers are taken in equal steps.
pub(crate) const POINTS: usize = 20;

// demo/methods.rs

/// Powers of ω of the residual terms that any fit of a band must leave free
/// (`docs/theory.md`, eq. 5).
pub(crate) const RESIDUAL_POWERS: [i32; 4] = [-2, 0, 2, 4];

// demo/mod.rs

/// Cells of the scenes, each hot in one of them.
pub(crate) const SCENES: usize = 4;
/// Least share of hot responses that are felt, and of cold ones that are quiet.
pub(crate) const LEAST_RATIO: f64 = 0.95;

// demo/rig.rs

/// Signal-to-noise ratio of the field that the demonstration measures, dB.
pub(crate) const SCANNER_SNR_DB: f64 = 40.0;
/// Seed of that noise.
pub(crate) const SCANNER_SEED: u64 = 1;

// estimate.rs

/// Relative difference of two sampling rates up to which they are one: that of times printed
/// with five digits.
pub(crate) const SAME_RATE: f64 = 1e-4;
/// Digits of a sampling rate in messages: more than [`SAME_RATE`] tells apart.
pub(crate) const RATE_DIGITS: i32 = 6;

// evaluate/field.rs

/// Causes that the text lists.
pub(crate) const CAUSES_SHOWN: usize = 5;

// field_words.rs

/// Normalised deviation of a measured field up to which the error bars explain it.
pub(crate) const EXPLAINED_NIS: f64 = 1.5;

// fit.rs

/// Files that a command to copy may name.
pub(crate) const MOST_FILES: usize = 3;

// fit/text.rs

/// Modes up to which weak ones are listed too. A longer table without remarks has two
/// columns.
pub(crate) const FEW_MODES: usize = 16;
/// Modes that are listed at most unless all are asked for.
pub(crate) const MOST_MODES: usize = 40;
/// Width of one of two columns.
pub(crate) const COLUMN_WIDTH: usize = 38;
/// Columns of a terminal.
pub(crate) const TERMINAL_WIDTH: usize = 80;

// in_time.rs

/// Pictures of the ground in a page: 16 a second of a burst of 0.25 s run at a tenth of
/// its speed.
pub(crate) const FRAMES: usize = 60;

// indices.rs

/// Frequencies of a sweep that are listed unless all are asked for.
pub(crate) const BEST_SHOWN: usize = 6;

// info.rs

/// Alike datasets up to which each has a row of the table, and files up to which each has a
/// table, unless all are asked for.
pub(crate) const SHOWN_ALIKE: usize = 6;

// play.rs

/// Pictures of the ground, in a chart of places over time and in a moving one.
pub(crate) const PLAY_FRAMES: usize = 120;
/// Pixels of a PNG file per px of the picture.
pub(crate) const PNG_SCALE: f64 = 2.0;
/// Draws of each random trial in time. Each plays the whole scene; the worst 5 % are two.
pub(crate) const STRESS_DRAWS: usize = 40;

// render.rs

/// Hz on both sides of the drive that a sweep tries.
pub(crate) const SWEEP_HZ: f64 = 30.0;

// render/text.rs

/// Most columns of responses in the map on a terminal.
pub(crate) const MOST_COLUMNS: usize = 36;
/// Most rows of that map.
pub(crate) const MOST_ROWS: usize = 12;
/// Two coordinates nearer than this are one column or row, m.
pub(crate) const SAME_M: f64 = 1e-6;

// scene_band.rs

/// Number of left-out modes that a message lists.
pub(crate) const MODES_SHOWN: usize = 6;
/// Number of tones that a message lists.
pub(crate) const TONES_SHOWN: usize = 4;

// streaming/mod.rs

/// Parts that fit into the memory allowed. One part is held for each lane, and the results
/// of the passes need room beside them.
pub(crate) const PARTS_OF_MEMORY: u64 = 32;
/// Largest part, bytes. Larger ones (32 and 64 MiB were tried) are no faster: merging costs
/// less, but touching fresh memory costs more.
pub(crate) const PART_MOST: u64 = 16 << 20;
/// Lanes beyond one for each thread: while one waits for the disk or for its turn, the
/// others reduce. A fit of 3 GiB on two cores took 6.1 to 6.6 s with two lanes, 5.6 to 5.7
/// with four, 5.0 to 5.4 with five, 5.1 to 5.6 with six.
pub(crate) const LANES_WAITING: usize = 3;
/// Most lanes: half of [`PARTS_OF_MEMORY`], for any number of threads.
pub(crate) const LANES_MOST: usize = 16;
/// Most parts of a pilot.
pub(crate) const PILOT_PARTS: usize = 8;
/// A pilot takes at most one of so many parts.
pub(crate) const PILOT_SHARE: usize = 16;
/// Memory that a fit of a set in memory needs, over the size of the set.
pub(crate) const FIT_OVER_SET: u64 = 2;

// streaming/resume.rs

/// Time between two saves of the state, over the time that a save takes.
pub(crate) const SHARE: u32 = 40;

// studio/draft.rs

/// Lines that a draft always fits fast enough to follow a drag.
pub(crate) const FEW_LINES: usize = 300;
/// Reach of a resonance on either side, half-power bandwidths.
pub(crate) const REACH: f64 = 2.0;
/// Lines over a resonance's reach. Five determine a pole and a residue; twelve also separate
/// it from its neighbours.
pub(crate) const LINES_PER_RESONANCE: f64 = 12.0;
/// A draft uses one in so many of the other lines.
pub(crate) const ONE_OF_OTHERS: f64 = 12.0;

// studio/question.rs

/// Largest number of a question: the largest whole number that JavaScript counts exactly.
pub(crate) const MOST_QUESTIONS: u64 = (1 << 53) - 1;
/// Most modes that a question may ask for, as on the page: ten times the modes of usual bands.
pub(crate) const QUESTION_MOST_MODES: usize = 1000;
/// Highest frequency, Hz: above the bandwidth of any vibrometer.
pub(crate) const HIGHEST_HZ: f64 = 1e10;

// studio/server.rs

/// Most bytes of a question: a band or a scene needs far fewer.
pub(crate) const LARGEST_QUESTION: usize = 1 << 20;
/// Time for the head of a request, and between two requests of one connection. A browser on
/// this machine needs milliseconds; a slower client holds a handle that others may need.
pub(crate) const REQUEST_DEADLINE: Duration = Duration::from_secs(5);
/// Wait for a free handle where the system grants no more of them.
pub(crate) const PAUSE: Duration = Duration::from_millis(200);

// studio/token.rs

/// Random bytes of a token: 2²⁵⁶ possible ones.
pub(crate) const BYTES: usize = 32;

// truth.rs

/// Largest relative error of a natural frequency in a fit of the built-in panel (40 dB).
/// Noise alone makes errors a hundred times smaller.
pub(crate) const FREQUENCY_ERROR: f64 = 1e-4;
/// The same for loss factors.
pub(crate) const LOSS_FACTOR_ERROR: f64 = 1e-2;
/// Least modal assurance criterion of a shape with the true one.
pub(crate) const LEAST_MAC: f64 = 0.99;
