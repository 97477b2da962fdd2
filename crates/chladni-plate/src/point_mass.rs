//! Masses that load a plate at points.

/// A mass without extent, fixed to the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMass {
    /// Position, m.
    pub position_m: [f64; 2],
    /// Mass, kg.
    pub mass_kg: f64,
}
