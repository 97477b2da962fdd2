//! Constants that decide something, under the file that uses them: meaning, unit, origin.
//!
//! A value without an origin is judgement: nobody has calibrated it.

// compare/common_dofs.rs

/// Points farther apart than this part of the spacing of the coarser set are different
/// points.
pub(super) const SAME_POINT: f64 = 0.5;
/// Nodes whose distance to their neighbour is looked at for the spacing.
pub(super) const SPACING_SAMPLES: usize = 400;

// compare/mod.rs

/// Shapes less alike than this belong to different modes.
pub(super) const LEAST_MAC: f64 = 0.5;
/// Least part of the DOFs of the smaller set that has a partner at its place; below it the
/// coordinates may not be the same. Of a plate whose origin lies one point off, more than
/// half of the points still fall on others.
pub(super) const LEAST_PAIRED: f64 = 0.5;
/// Extents this many times apart: millimetres taken for metres.
pub(super) const UNIT_FACTOR: f64 = 1000.0;
/// Extents of one structure, measured at other points, agree within this factor.
pub(super) const SAME_EXTENT: f64 = 2.0;
