//! Sizes, ranges and counts of the pictures: what to turn when they should look
//! different.

/// Width of a figure over the whole page, px.
pub(crate) const WIDE_PX: f64 = 820.0;
/// Width of a map of the panel, px.
pub(crate) const MAP_PX: f64 = 620.0;
/// Width of a mode shape, px.
pub(crate) const SHAPE_PX: f64 = 430.0;
/// Pixels of a PNG file per px of the picture.
pub(crate) const PNG_SCALE: f64 = 2.0;

/// Residuals of all pairs together: a byte each, 1.4 of the 3 MB of a page. With 2618 pairs
/// every pair keeps 414 lines.
pub(crate) const RESIDUALS: usize = 1_100_000;
/// Responses, and references, whose pairs a page offers: 100 × 100 pairs keep 100 lines
/// each.
pub(crate) const OFFERED_DOFS: usize = 100;
/// Lines of the sums, the CMIF and the pairs in full.
pub(crate) const SHOWN_LINES: usize = 6000;
/// Points of the grid on which shapes are shown; each mode costs 11 kB per thousand.
pub(crate) const GRID_POINTS: f64 = 1500.0;

/// Fewer responses tell no shapes apart: the MAC of any two of them is large.
pub(crate) const MAC_RESPONSES: usize = 4;

/// DOF pairs whose FRFs are shown in full.
pub(crate) const PAIRS: usize = 12;
/// Driving points among them at most.
pub(crate) const DRIVING_POINTS: usize = 3;
/// Lines of a synthesis without measured frequency axis.
pub(crate) const SYNTHESIS_LINES: usize = 1000;
/// Levels of amplitude below the largest one that are shown, dB; what lies deeper tells
/// nothing and would flatten the curves.
pub(crate) const AMPLITUDE_RANGE_DB: f64 = 100.0;
/// Singular values shown in a CMIF, six at most.
pub(crate) const SINGULAR_VALUES: usize = 6;
/// Mode shapes shown; each costs about 25 kB of the page.
pub(crate) const MODE_SHAPES: usize = 80;
/// Modes of an AutoMAC whose cells carry their numbers.
pub(crate) const NUMBERED_MODES: usize = 26;
/// Modes of an AutoMAC.
pub(crate) const MAC_MODES: usize = 150;

/// Columns of the pixels of a mode shape.
pub(crate) const SHAPE_COLUMNS: usize = 120;
/// Columns of the pixels of a field map.
pub(crate) const FIELD_COLUMNS: usize = 360;
/// Ends of the field map's colours, dB re threshold.
pub(crate) const FIELD_RANGE_DB: f64 = 12.0;
/// Free ground around the nodes on maps, part of their larger extent.
pub(crate) const MAP_BORDER: f64 = 0.07;

/// Bounds are so many standard deviations: 95 % of a normal distribution.
pub(crate) const SIGMAS: f64 = 1.96;
/// MAC beside the diagonal that calls for attention: two shapes that agree so far are
/// hardly two modes.
pub(crate) const HIGH_MAC: f64 = 0.5;

// better_band.rs

/// The band goes at most so far below its first mode, as a part of its frequency: as much
/// as fits take to tell a mode from what lies outside.
pub(crate) const MOST_BELOW: f64 = 0.4;
/// The same above its last mode.
pub(crate) const MOST_ABOVE: f64 = 1.3;
/// A proposal that keeps more of the band would change little.
pub(crate) const MOST_OF_BAND: f64 = 0.7;

// data/frfs.rs

/// Lines of a common step.
pub(crate) const BLOCK: usize = 32;
/// A step is a power of this times the smallest, and at most 9 % larger than it need be.
pub(crate) const STEP_RATIO: f64 = 1.09;
/// Largest power: the steps of a page span 190 dB.
pub(crate) const STEP_CODES: u8 = 254;

// data/lines.rs

/// Between resonances lines are so much sparser than beside them.
pub(crate) const SPARSER: usize = 4;

// data/model.rs

/// Files that are named with their hashes.
pub(crate) const SOURCES_LISTED: usize = 3;

// data/time.rs

/// Levels of the first and the last colour, dB re threshold.
pub(crate) const RANGE_DB: f64 = 12.0;

// sentence.rs

/// Share of the data from which on modes explain most of them.
pub(crate) const HALF: f64 = 0.5;

// structure.rs

/// Nodes are on one line where none is farther from it, part of its length.
pub(crate) const ON_LINE: f64 = 1e-3;
/// A response moves along that line where its direction agrees so far.
pub(crate) const ALONG: f64 = 0.99;

/// Part of measured FRFs, rms, that a model of another structure leaves at least: of FRFs that have
/// nothing to do with it 1 and more.
pub(crate) const UNEXPLAINED: f64 = 0.7;
/// Part that it leaves at least, over that of the FRFs of its own fit.
pub(crate) const WORSE_THAN_FIT: f64 = 2.0;
