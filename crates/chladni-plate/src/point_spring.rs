//! Springs to the ground that hold a plate at points.

/// A spring without extent between plate and ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointSpring {
    /// Position, m.
    pub position_m: [f64; 2],
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
}
