//! Every constant of this crate that decides something: meaning, unit and origin. Facts of
//! a format stand beside its parser.

use std::time::Duration;

// arrays/foreign/mod.rs

/// Datasets that a message lists; it counts the others.
pub(crate) const DATASETS_LISTED: usize = 20;

// arrays/tree.rs

/// Most objects of a file: ends the walk through a link that leads back to its own group.
pub(crate) const MAX_OBJECTS: usize = 100_000;
/// Greatest depth of nested groups.
pub(crate) const MAX_DEPTH: usize = 32;
/// Greatest compression of deflate, 1032 : 1. A dataset that claims more bytes than that
/// times the size of the file is damaged.
pub(crate) const BEST_COMPRESSION: u64 = 1032;

// assemble/geometry.rs

/// Positions closer than this are the same, m; scenes use the same distance.
pub(crate) const SAME_PLACE_M: f64 = 1e-6;

// assemble/grid.rs

/// Names that a warning lists; it counts the others.
pub(crate) const NAMES_LISTED: usize = 50;
/// A grid of pairs this many times larger than the measured data, and above
/// [`SPARSE_BYTES`], is refused.
pub(crate) const SPARSE_FACTOR: usize = 16;
/// See [`SPARSE_FACTOR`].
pub(crate) const SPARSE_BYTES: usize = 1 << 30;
/// Partial sums in the search for infinite values and NaN, which the processor adds in
/// parallel.
pub(crate) const LANES: usize = 8;

// assemble/record.rs, assemble/axis.rs, csv/mod.rs

/// Relative rounding of six printed digits.
pub(crate) const SIX_DIGITS: f64 = 1e-5;

// assemble/axis.rs

/// Part of a line by which axes of one measurement may differ: files print five or six digits of
/// a start and a step. A tenth of a line made seven modes of four.
pub(crate) const AXES_ROUNDED: f64 = 0.02;

// checksums.rs

/// Bytes read at a time: as many as fit into the cache next to a core.
pub(crate) const BLOCK: usize = 1 << 17;
/// Size of the largest file whose checksum is SHA-256. Beyond it, SHA-256 would take a third
/// of the processor time of a fit (`chladni bench profile`), and BLAKE3 is used.
pub(crate) const SHA256_UP_TO_BYTES: u64 = 1 << 30;

// csv/cut.rs

/// Rows from which equal digits of their last numbers tell that one below them was cut. Numbers
/// without their trailing zeros have equal decimals in 10 rows in a third of all cases; the
/// eleventh is then shorter in a tenth of them.
pub(crate) const CUT_ROWS_LEAST: usize = 10;
/// A cut number has at least this many times fewer digits than any number above it, where their
/// decimals vary.
pub(crate) const CUT_DIGITS: usize = 3;
/// Last rows that are compared with the last number.
pub(crate) const CUT_ROWS_MOST: usize = 1000;

// csv/groups.rs

/// Larger than any measured magnitude in decibels: a factor of 10²⁰ above 0 dB.
pub(crate) const LARGEST_DECIBELS: f64 = 400.0;

// csv/header.rs, csv/complex_cells.rs

/// Rows in which decimal commas are told from commas between numbers, and in which complex
/// numbers are looked for.
pub(crate) const ROWS_TRIED: usize = 50;

// csv/facts.rs, arrays/foreign/frequency.rs

/// Relative difference of the factors of two labels up to which they name the same unit.
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
/// Columns of a long table, at least: a DOF, a frequency, two parts of a value.
pub(crate) const LONG_COLUMNS_LEAST: usize = 4;

// csv/table.rs

/// First rows in which the last filled column is looked for.
pub(crate) const TABLE_ROWS_TRIED: usize = 20;

// csv/text.rs

/// Lines that decide the dialect: more than any header has.
pub(crate) const LINES_TRIED: usize = 400;

// detect.rs

/// The bytes of a file that decide if it is text.
pub(crate) const HEAD_BYTES: usize = 4096;
/// The bytes of a text that decide if it is a table: more than any header with the first
/// rows.
pub(crate) const TABLE_HEAD_BYTES: u64 = 1 << 20;

// field_file.rs, field_file/remarks.rs

/// Powers of m, kg, s, V, rad, cycle of a velocity.
pub(crate) const VELOCITY: [i32; 6] = [1, 0, -1, 0, 0, 0];
/// Largest velocity of a field, m/s: the speed of light.
pub(crate) const FASTEST_M_PER_S: f64 = 3e8;
/// Most standard deviations between a value of a field and a repeat of it. Noise stays below
/// that; the value of another point of a panel is mostly a hundred away.
pub(crate) const REPEATS_APART: f64 = 20.0;
/// Part of a velocity by which it may differ from a repeat whatever its standard deviation,
/// because levels drift between passes.
pub(crate) const DRIFT_OF_LEVEL: f64 = 0.2;
/// Velocity up to which a response counts as at rest, m/s. Its square does not underflow.
pub(crate) const STILL_M_PER_S: f64 = 1e-30;

// mat/unpack.rs

/// A file may unpack to this many times its size ...
pub(crate) const MOST_EXPANSION: usize = 128;
/// ... and, however small it is, to this many bytes.
pub(crate) const LEAST_ROOM: usize = 4 << 20;

// mat/write.rs

/// Largest variable of this version that MATLAB reads, bytes.
pub(crate) const LARGEST_ELEMENT: usize = (1 << 31) - 1;

// model_file.rs

/// Largest number in a model, in its SI unit. The product of two does not overflow.
pub(crate) const LARGEST: f64 = 1e100;
/// Largest coordinate of a node, m.
pub(crate) const FARTHEST_M: f64 = 1e6;
/// Most modes of a model: a hundred times as many as fits find.
pub(crate) const MOST_MODES: usize = 100_000;
/// Loss factor of critical viscous damping (ζ = 1). From there on a mode has no pair of
/// complex poles, which the model assumes.
pub(crate) const CRITICAL: f64 = 2.0;
/// Relative difference of a damping ratio from half the loss factor that rounding by other
/// programs may leave.
pub(crate) const SAME_DAMPING: f64 = 1e-2;

// numpy/archive.rs

/// An archive may unpack to this many times its size ...
pub(crate) const ARCHIVE_MOST_EXPANSION: u64 = 128;
/// ... and, however small it is, to this many bytes.
pub(crate) const ARCHIVE_LEAST_ROOM: u64 = 4 << 20;

// phase_unit.rs

/// Phases of a measured FRF in degrees exceed this, an eighth of a turn; wrapped phases in
/// radians end at 2π.
pub(crate) const SURELY_DEGREES: f64 = 45.0;
/// One turn in degrees: a phase beyond it was unwrapped, in degrees or in radians.
pub(crate) const WRAPPED_DEGREES: f64 = 360.0;

// read.rs

/// Size beyond which a universal file is listed by its headers, bytes.
pub(crate) const LISTED_BY_HEADERS: u64 = 256 << 20;

// runs.rs, runs/even_times.rs

/// Relative difference of two steps that rounding of printed digits explains.
pub(crate) const STEP_TOLERANCE: f64 = 1e-4;
/// Part of a sample step by which the starts of channels of one run may differ: a delay that turns
/// the phase by less than 2° at half the sampling rate.
pub(crate) const STARTS_APART: f64 = 0.01;
/// Most decimals of a printed time: nanoseconds, in seconds.
pub(crate) const TIME_DECIMALS: i32 = 9;
/// Relative difference from a whole number that the conversion of printed digits leaves.
pub(crate) const WHOLE_DIGITS: f64 = 1e-9;
/// Pieces of a record whose mean steps are compared.
pub(crate) const TIME_PIECES: usize = 16;
/// Difference of the length of a piece from that of even steps, in steps, up to which its times are
/// rounded: a tenth of a step is what printed digits may take from either end.
pub(crate) const LATE_SAMPLES: f64 = 0.25;
/// The same over the steps of a piece: times summed up in single precision reach 6e-4.
pub(crate) const LATE_STEPS: f64 = 1e-3;

// shape_set.rs

/// Decimals of a number in datasets 55 and 2414, which is written as 1.23456E+01.
pub(crate) const DECIMALS_55: f64 = 5.0;

// temporary.rs

/// Age from which a temporary file of another machine, or of this one before its last start,
/// is abandoned. Not every network share passes locks on to other machines.
pub(crate) const ABANDONED: Duration = Duration::from_secs(24 * 3600);
/// Attempts to create a temporary file: another run may remove it before it is locked.
pub(crate) const TRIES: usize = 10;

// unit_label/parser.rs

/// Largest power of a unit; a larger one is a misreading.
pub(crate) const LARGEST_POWER: i32 = 9;
/// Longest text that may be a unit label, bytes.
pub(crate) const LONGEST_LABEL: usize = 80;
/// Greatest depth of nested parentheses in a unit label.
pub(crate) const PARSER_MAX_DEPTH: usize = 8;

// read.rs

/// First node number that is given to FRFs without one.
pub(crate) const FIRST_NODE: u64 = 1;

// csv/mod.rs

/// Share of lines with an impossible coherence up to which slips of the writer explain
/// them. A larger share hints at a wrong column.
pub(crate) const COHERENCE_SLIPS: f64 = 0.01;

// paths.rs

/// Files that a warning lists; it counts the others.
pub(crate) const PATHS_LISTED: usize = 5;
