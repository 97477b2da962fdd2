//! Sizes, ranges and counts that determine the look of the pictures.

/// Width of a figure over the whole page, px.
pub(crate) const WIDE_PX: f64 = 820.0;
/// Width of a map of the panel, px.
pub(crate) const MAP_PX: f64 = 620.0;
/// Width of a mode shape, px.
pub(crate) const SHAPE_PX: f64 = 430.0;
/// Pixels of a PNG file per px of the picture.
pub(crate) const PNG_SCALE: f64 = 2.0;

/// Residuals of all pairs together, a byte each: 1.4 of the 3 MB of a page. With 2618 pairs each
/// pair keeps 414 lines.
pub(crate) const RESIDUALS: usize = 1_100_000;
/// Most responses, and most references, whose pairs a page offers: 100 × 100 pairs keep 100
/// lines each.
pub(crate) const OFFERED_DOFS: usize = 100;
/// Lines of the sums, the CMIF and the pairs in full.
pub(crate) const SHOWN_LINES: usize = 6000;
/// Points of the grid on which shapes are shown; each mode costs 11 kB per thousand.
pub(crate) const GRID_POINTS: f64 = 1500.0;

/// Least number of responses for a MAC: with fewer the MAC of any two shapes is large.
pub(crate) const MAC_RESPONSES: usize = 4;

/// DOF pairs whose FRFs are shown in full.
pub(crate) const PAIRS: usize = 12;
/// Driving points among them at most.
pub(crate) const DRIVING_POINTS: usize = 3;
/// Lines of a synthesis without measured frequency axis.
pub(crate) const SYNTHESIS_LINES: usize = 1000;
/// Shown range of amplitudes below the largest, dB. A larger range would flatten the curves.
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

/// Standard deviations of a bound: 95 % of a normal distribution.
pub(crate) const SIGMAS: f64 = 1.96;
/// MAC beside the diagonal above which two shapes are hardly two modes.
pub(crate) const HIGH_MAC: f64 = 0.5;

// better_band.rs

/// Least lower end of the band, part of the frequency of its first mode: a fit needs about so
/// much room to separate a mode from those outside.
pub(crate) const MOST_BELOW: f64 = 0.4;
/// Largest upper end, part of the frequency of its last mode.
pub(crate) const MOST_ABOVE: f64 = 1.3;
/// Largest part of the band that a proposed band keeps; more would change little.
pub(crate) const MOST_OF_BAND: f64 = 0.7;

// data/frfs.rs

/// Lines with a common step.
pub(crate) const BLOCK: usize = 32;
/// Ratio of neighbouring steps, so that a step is at most 9 % larger than needed.
pub(crate) const STEP_RATIO: f64 = 1.09;
/// Largest power of that ratio: the steps of a page span 190 dB.
pub(crate) const STEP_CODES: u8 = 254;

// data/lines.rs

/// Spacing of lines between resonances over that near them.
pub(crate) const SPARSER: usize = 4;

// data/model.rs

/// Most source files that are listed.
pub(crate) const SOURCES_LISTED: usize = 3;

// data/time.rs

/// Levels of the first and the last colour, dB re threshold.
pub(crate) const RANGE_DB: f64 = 12.0;

// sentence.rs

/// Explained share of the data below which the sentence is a warning.
pub(crate) const HALF: f64 = 0.5;

// structure.rs

/// Largest distance of nodes from a line that they lie on, part of its length.
pub(crate) const ON_LINE: f64 = 1e-3;
/// Least cosine between a response and the line that it moves along.
pub(crate) const ALONG: f64 = 0.99;

// unlike.rs

/// Relative residual, rms, from which on a model is of another structure. Unrelated FRFs leave 1
/// or more.
pub(crate) const UNEXPLAINED: f64 = 0.7;
/// Residual from which on it is, over the residual of the model's own fit.
pub(crate) const WORSE_THAN_FIT: f64 = 2.0;
