//! Constants that decide something, under the file that uses them: meaning, unit, origin.

use std::time::Duration;

// args.rs

/// Most threads that may be asked for: more than any machine has cores that a fit keeps busy.
pub(crate) const MOST_THREADS: u16 = 1024;

// input.rs

/// Longest delay of a measurement, s: a slip of the unit lies beyond.
pub(crate) const DELAY_MOST_S: f64 = 1000.0;

// oddities.rs

/// End of a frequency axis, Hz, below which it is doubtful: such an axis is probably in kHz.
pub(crate) const LOWEST_END_HZ: f64 = 5.0;
/// Least number of lines of an axis that is doubted so.
pub(crate) const LINES_OF_A_TEST: usize = 50;
/// Lines in a row at the largest value from which on a part (real or imaginary) is clipped.
/// Noise and resonances do not repeat a number.
pub(crate) const CLIPPED_LINES: usize = 5;

// progress.rs

/// Rounding error of a sum of shares, tenths.
pub(crate) const ROUNDING: f64 = 1e-6;
/// Time between two moves of the bar.
pub(crate) const TICK: Duration = Duration::from_millis(100);

// telling.rs

/// Columns of a terminal; pipes get the same text.
pub(crate) const COLUMNS: usize = 80;
/// Columns of the severity before a finding: `caution` and two blanks.
pub(crate) const INDENT: usize = 9;
/// Most cautions that all show their next steps. With more, only steps that are options are
/// shown, so that a result fits on a screen. Faults always show theirs.
pub(crate) const MOST_WITH_HELP: usize = 2;
