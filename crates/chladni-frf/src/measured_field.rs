//! A field as it was measured under a drive: what `evaluate` and `correct` read.

use crate::Dof;
use num_complex::Complex64;

/// Velocities measured at some responses under one set of weights.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredField {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// SHA-256 of the weights file that was played, where the file names it.
    pub weights_sha256: Option<String>,
    /// True where phases are unknown: the values are then magnitudes.
    pub magnitudes_only: bool,
    /// One entry per response, repeats averaged.
    pub points: Vec<FieldPoint>,
}

/// The velocity of one response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldPoint {
    /// Response DOF.
    pub response: Dof,
    /// Velocity along the DOF, m/s, peak phasor of e^{+jωt} against the drive signal; a
    /// magnitude where phases are unknown.
    pub velocity_m_per_s: Complex64,
    /// Standard deviation √E|δv|² of that value, m/s; `None` where neither the file nor its
    /// repeats tell.
    pub std_m_per_s: Option<f64>,
    /// Number of measurements that were averaged.
    pub repeats: usize,
}
