//! Every constant of this room: meaning, unit, and where it comes from. Facts of a format
//! stand beside its parser.

use std::time::Duration;

// oddities.rs

/// No test of a structure that fits on a table ends so low, Hz; one whose kHz are called
/// Hz does.
pub(crate) const LOWEST_END_HZ: f64 = 5.0;
/// ... if it has so many lines.
pub(crate) const LINES_OF_A_TEST: usize = 50;
/// A part (real or imaginary) that stays at its largest value over so many lines in a row
/// is clipped: noise and resonance curves do not repeat a number.
pub(crate) const CLIPPED_LINES: usize = 5;

// progress.rs

/// Of a sum of shares, tenths.
pub(crate) const ROUNDING: f64 = 1e-6;
/// Time between two moves of the bar.
pub(crate) const TICK: Duration = Duration::from_millis(100);

// telling.rs

/// Columns of a terminal; pipes get the same text.
pub(crate) const COLUMNS: usize = 80;
/// Columns of the word before a finding: `caution`, and two blanks.
pub(crate) const INDENT: usize = 9;
