//! Every constant of this room: meaning, unit, and where it comes from. Facts of a format
//! stand beside its parser.

use std::time::Duration;

// arrays/foreign/mod.rs

/// Datasets that an error lists before it only counts.
pub(crate) const DATASETS_LISTED: usize = 20;

// arrays/tree.rs

/// Objects in one file; a link that leads back to its own group would otherwise never
/// end.
pub(crate) const MAX_OBJECTS: usize = 100_000;
/// Depth of groups.
pub(crate) const MAX_DEPTH: usize = 32;
/// Deflate cannot do better than 1 : 1032; a dataset that claims more than that per byte
/// of the file lies.
pub(crate) const BEST_COMPRESSION: u64 = 1032;

// assemble/geometry.rs

/// Positions closer than this are the same, m: scenes compare positions to it as well.
pub(crate) const SAME_PLACE_M: f64 = 1e-6;

// assemble/grid.rs

/// Names that a warning lists before it only counts.
pub(crate) const NAMES_LISTED: usize = 50;
/// A grid of pairs this many times larger than the measured data, and above
/// [`SPARSE_BYTES`], is refused.
pub(crate) const SPARSE_FACTOR: usize = 16;
/// See [`SPARSE_FACTOR`].
pub(crate) const SPARSE_BYTES: usize = 1 << 30;
/// Lanes of the sum that looks for infinite values and NaN: the processor adds them side by
/// side.
pub(crate) const LANES: usize = 8;

// assemble/record.rs

/// Rounding of six printed digits; values this close are brought back into 0..=1.
pub(crate) const ROUNDING: f64 = 1e-5;

// checksums.rs

/// Bytes read at a time: they stay in the cache next to a core.
pub(crate) const BLOCK: usize = 1 << 17;
/// Size of the largest file that is named by SHA-256; beyond it the sum would take a third
/// of a fit's processor time, and BLAKE3 names the file (`chladni bench profile`).
pub(crate) const SHA256_UP_TO_BYTES: u64 = 1 << 30;

// csv/groups.rs

/// No measured magnitude in decibels is so large: it is 20 orders above 0 dB.
pub(crate) const LARGEST_DECIBELS: f64 = 400.0;

// csv/header.rs

/// Rows looked at to tell decimal commas from commas between numbers.
pub(crate) const ROWS_TRIED: usize = 50;

// csv/said.rs, arrays/foreign/frequency.rs

/// Two labels of one unit give factors that differ by less, by their rounding.
pub(crate) const SAME_UNIT: f64 = 1e-6;

// csv/long.rs

/// A grid of FRFs and lines this many times larger than the rows, and above
/// [`SPARSE_CELLS`], is refused.
pub(crate) const LONG_SPARSE_FACTOR: usize = 16;
/// See [`LONG_SPARSE_FACTOR`].
pub(crate) const SPARSE_CELLS: usize = 1 << 22;
/// Two frequencies closer than this part of their spacing are one line.
pub(crate) const SAME_LINE: f64 = 1e-3;

// csv/long_header.rs

/// Lines in which the header of a long table is looked for.
pub(crate) const HEADER_LINES: usize = 100;

// csv/table.rs

/// First rows in which the last column that is not empty is looked for.
pub(crate) const TABLE_ROWS_TRIED: usize = 20;

// csv/text.rs

/// Lines looked at to find the dialect: longer than any header, short beside any data.
pub(crate) const LINES_TRIED: usize = 400;

// detect.rs

/// The bytes of a file that decide whether it is text: analysers' headers are shorter.
pub(crate) const HEAD_BYTES: usize = 4096;
/// The bytes of a text that show whether it is a table: longer than any header with the
/// first rows.
pub(crate) const TABLE_HEAD_BYTES: u64 = 1 << 20;

// field_file.rs, field_file/remarks.rs

/// Powers of m, kg, s, V, rad, cycle of a velocity.
pub(crate) const VELOCITY: [i32; 6] = [1, 0, -1, 0, 0, 0];
/// Largest velocity of a field, m/s: nothing is faster than light, and powers of it are
/// still numbers.
pub(crate) const FASTEST_M_PER_S: f64 = 3e8;
/// Most standard deviations between a value of a field and a repeat of it: noise of any usual form
/// leaves fewer, and another point of a panel mostly a hundred.
pub(crate) const REPEATS_APART: f64 = 20.0;
/// Part of a velocity by which it may differ from a repeat whatever its deviation: levels drift
/// between passes.
pub(crate) const DRIFT_OF_LEVEL: f64 = 0.2;
/// Velocity up to which nothing moves, m/s: an atom's width takes the age of the universe at
/// 200 times as much, and powers of it are still above zero.
pub(crate) const STILL_M_PER_S: f64 = 1e-30;

// mat/unpack.rs

/// A file may unfold to this many times its size ...
pub(crate) const MOST_EXPANSION: usize = 128;
/// ... and, however small it is, to this many bytes.
pub(crate) const LEAST_ROOM: usize = 4 << 20;

// mat/write.rs

/// MATLAB reads no larger variable of this version, bytes.
pub(crate) const LARGEST_ELEMENT: usize = (1 << 31) - 1;

// model_file.rs

/// Largest number in a model, in its SI unit. No panel comes near it; the product of two
/// is still a number.
pub(crate) const LARGEST: f64 = 1e100;
/// Farthest place of a node, m: a thousand kilometres.
pub(crate) const FARTHEST_M: f64 = 1e6;
/// Most modes: a hundred times what fits find. All of them are summed at every frequency.
pub(crate) const MOST_MODES: usize = 100_000;
/// Loss factor from which a viscous mode swings no more (ζ = 1): it has no pair of poles,
/// and the model no form for it.
pub(crate) const CRITICAL: f64 = 2.0;
/// Difference of a damping ratio from half the loss factor, relative, that decimals of
/// other programs may leave.
pub(crate) const SAME_DAMPING: f64 = 1e-2;

// numpy/archive.rs

/// An archive may unfold to this many times its size ...
pub(crate) const ARCHIVE_MOST_EXPANSION: u64 = 128;
/// ... and, however small it is, to this many bytes.
pub(crate) const ARCHIVE_LEAST_ROOM: u64 = 4 << 20;

// phase_unit.rs

/// Phases of a measured FRF in degrees reach beyond this, an eighth of a turn, and
/// wrapped ones in radians do not: they end at 2π.
pub(crate) const SURELY_DEGREES: f64 = 45.0;
/// Beyond one turn in degrees a phase was unwrapped, in degrees or in radians.
pub(crate) const WRAPPED_DEGREES: f64 = 360.0;

// read.rs

/// A universal file beyond this size is listed by its headers, bytes.
pub(crate) const LISTED_BY_HEADERS: u64 = 256 << 20;

// runs.rs

/// Relative difference of two steps that counts as rounding of printed digits.
pub(crate) const STEP_TOLERANCE: f64 = 1e-4;

// temporary.rs

/// Age of a file of another machine (or of this one before it was started anew) at which
/// it is nobody's: not every network share tells one machine of the locks of another.
pub(crate) const ABANDONED: Duration = Duration::from_secs(24 * 3600);
/// Another run may take a new file away before its lock is on it; so often in a row it
/// does not.
pub(crate) const TRIES: usize = 10;

// unit_label/parser.rs

/// No sensible unit carries a larger power; a larger one is a misreading.
pub(crate) const LARGEST_POWER: i32 = 9;
/// A longer text is no unit label, in bytes.
pub(crate) const LONGEST_LABEL: usize = 80;
/// Parentheses nested more deeply stand in no unit.
pub(crate) const PARSER_MAX_DEPTH: usize = 8;

// read.rs

/// Nodes of files that name none are numbered from here.
pub(crate) const FIRST_NODE: u64 = 1;

// csv/mod.rs

/// Share of lines with an impossible coherence up to which a file is said to have slips of
/// its writer, not a wrong column.
pub(crate) const COHERENCE_SLIPS: f64 = 0.01;

// paths.rs

/// Files that a warning lists before it only counts.
pub(crate) const PATHS_LISTED: usize = 5;
