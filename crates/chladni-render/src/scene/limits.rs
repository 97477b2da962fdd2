//! Velocity limits of a scene.

use crate::tolerances;

/// Velocity limits of a scene, m/s peak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Threshold + limen; for a line of a band, its part of that. Hot ground moves at least
    /// so fast.
    pub hot_m_per_s: f64,
    /// Threshold.
    pub threshold_m_per_s: f64,
    /// Threshold − limen; for one of several tones, its part of that. Cold ground moves at
    /// most so fast.
    pub cold_m_per_s: f64,
}

impl Limits {
    /// True where ground that moves at `velocity_m_per_s` is felt.
    pub fn is_felt(&self, velocity_m_per_s: f64) -> bool {
        velocity_m_per_s >= self.felt_from_m_per_s()
    }
    /// True where ground that moves at `velocity_m_per_s` is quiet.
    pub fn is_quiet(&self, velocity_m_per_s: f64) -> bool {
        velocity_m_per_s <= self.quiet_to_m_per_s()
    }
    /// The least velocity that counts as felt.
    pub(crate) fn felt_from_m_per_s(&self) -> f64 {
        self.hot_m_per_s * (1.0 - tolerances::LIMIT)
    }
    /// The largest velocity that counts as quiet.
    pub(crate) fn quiet_to_m_per_s(&self) -> f64 {
        self.cold_m_per_s * (1.0 + tolerances::LIMIT)
    }
    /// Hot limit over cold limit, dB.
    pub fn apart_db(&self) -> f64 {
        20.0 * (self.hot_m_per_s / self.cold_m_per_s).log10()
    }
}
