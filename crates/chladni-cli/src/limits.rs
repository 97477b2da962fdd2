//! Every constant of this room: meaning, unit, and where it comes from. Facts of a format
//! stand beside its parser.

use std::time::Duration;

// compare.rs

/// Names of files in a heading are cut to so many characters.
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
/// Least share of hot ground that is felt, and of cold ground that is quiet.
pub(crate) const LEAST_RATIO: f64 = 0.95;

// estimate.rs

/// Relative difference of two sampling rates up to which they are one: that of times printed
/// with five digits.
pub(crate) const SAME_RATE: f64 = 1e-4;

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

/// Modes up to which weak ones are listed unasked, and from which on a table without
/// remarks has two columns.
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

/// Alike datasets beyond this count are one line of the table, and files beyond it one
/// line each, without `-v`.
pub(crate) const SHOWN_ALIKE: usize = 6;

// play.rs

/// Pictures of the ground, in a chart of places over time and in a moving one.
pub(crate) const PLAY_FRAMES: usize = 120;
/// Pixels of a PNG file per px of the picture.
pub(crate) const PNG_SCALE: f64 = 2.0;
/// Draws of each random trial in time: each plays the whole scene, and the worst twentieth
/// is two of them.
pub(crate) const STRESS_DRAWS: usize = 40;

// render.rs

/// Hz on both sides of the drive that a sweep tries.
pub(crate) const SWEEP_HZ: f64 = 30.0;

// render/text.rs

/// Columns of responses that a terminal shows as a map.
pub(crate) const MOST_COLUMNS: usize = 36;
/// Rows of the same map.
pub(crate) const MOST_ROWS: usize = 12;
/// Two coordinates nearer than this are one column or row, m.
pub(crate) const SAME_M: f64 = 1e-6;

// scene_band.rs

/// Number of left-out modes that a message lists.
pub(crate) const MODES_SHOWN: usize = 6;
/// Number of tones.
pub(crate) const TONES_SHOWN: usize = 4;

// select.rs

/// A mode is the one that was seen where it lies so near, part of its frequency.
pub(crate) const AS_SEEN: f64 = 0.05;

// streaming/mod.rs

/// Parts that fit into the memory allowed: as many as there are lanes are held, and what
/// the passes leave needs room beside them.
pub(crate) const PARTS_OF_MEMORY: u64 = 32;
/// Bytes of a part beyond which larger ones are no faster: merging costs less, memory
/// that no part was in yet more (16, 32 and 64 MiB).
pub(crate) const PART_MOST: u64 = 16 << 20;
/// Parts at work at a time beyond one for each thread: while one waits for the disk or
/// for its turn, the others are reduced. A fit of 3 GiB on two cores took 6.1 to 6.6 s
/// with two parts in all, 5.6 to 5.7 with four, 5.0 to 5.4 with five, 5.1 to 5.6 with
/// six.
pub(crate) const LANES_WAITING: usize = 3;
/// Most parts at work at a time: half of [`PARTS_OF_MEMORY`], whatever the number of
/// threads.
pub(crate) const LANES_MOST: usize = 16;
/// Most parts of a pilot.
pub(crate) const PILOT_PARTS: usize = 8;
/// A pilot takes one of so many parts.
pub(crate) const PILOT_SHARE: usize = 16;
/// Memory that a fit of a set held in memory needs, over the set.
pub(crate) const FIT_OVER_SET: u64 = 2;

// streaming/resume.rs

/// Keeping what was done may cost one part in so many of the time.
pub(crate) const SHARE: u32 = 40;

// studio/draft.rs

/// So many lines are fitted as fast as a hand moves, whatever they hold.
pub(crate) const FEW_LINES: usize = 300;
/// Reach of a resonance on either side, half-power bandwidths.
pub(crate) const REACH: f64 = 2.0;
/// Lines over a resonance's reach: five would tell a pole and a residue, these also tell
/// it from its neighbours.
pub(crate) const LINES_PER_RESONANCE: f64 = 12.0;
/// One in so many of the other lines is looked at.
pub(crate) const ONE_OF_OTHERS: f64 = 12.0;

// studio/question.rs

/// The largest whole number that the page's script counts exactly.
pub(crate) const MOST_QUESTIONS: u64 = (1 << 53) - 1;
/// Most modes that may be asked for, as on the page: ten times what bands of plates hold.
pub(crate) const QUESTION_MOST_MODES: usize = 1000;
/// Highest frequency, Hz: above the bandwidth of any vibrometer.
pub(crate) const HIGHEST_HZ: f64 = 1e10;

// studio/server.rs

/// A question is a band or a scene: no more bytes than that needs.
pub(crate) const LARGEST_QUESTION: usize = 1 << 20;
/// Time for the head of a request, and between two of one connection: a browser on this
/// machine needs milliseconds, and who takes longer holds a handle that others may need.
pub(crate) const REQUEST_DEADLINE: Duration = Duration::from_secs(5);
/// Wait for a free handle where the system grants no more of them.
pub(crate) const PAUSE: Duration = Duration::from_millis(200);

// studio/token.rs

/// Random bytes of a token: nobody guesses one of 2²⁵⁶.
pub(crate) const BYTES: usize = 32;

// truth.rs

/// The accuracy that a fit of the built-in panel (40 dB) must reach; its actual errors
/// are a hundred times smaller, so that what lies beyond is a fault and not the noise.
pub(crate) const FREQUENCY_ERROR: f64 = 1e-4;
/// The same for loss factors.
pub(crate) const LOSS_FACTOR_ERROR: f64 = 1e-2;
/// Least modal assurance criterion of a shape with the true one.
pub(crate) const LEAST_MAC: f64 = 0.99;

// demo/rig.rs

/// Noise of the field that the demonstration measures, dB below it, and its seed.
pub const SCANNER_SNR_DB: f64 = 40.0;
pub const SCANNER_SEED: u64 = 1;
