//! The drive of the actuators, and its limits.

use crate::digits::rounded;
use chladni_frf::ReferenceUnit;
use ndarray::Array1;
use num_complex::Complex64;

/// Actuator drive, peak phasors, one per actuator in use, N or V.
pub(crate) type Drive = Array1<Complex64>;

/// Limits of the drive, N or V; infinite where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriveLimits {
    /// Largest |A_i|.
    pub(crate) each: f64,
    /// Largest √Σ|A_i|².
    pub(crate) effort: f64,
    /// Unit of both.
    pub(crate) unit: ReferenceUnit,
}

impl DriveLimits {
    /// The largest factor by which `drive` may be multiplied; infinite for silence.
    pub(crate) fn allowed_gain(&self, drive: &Drive) -> f64 {
        let largest = drive.iter().map(amplitude).fold(0.0, f64::max);
        let effort = drive.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
        (self.each / largest).min(self.effort / effort)
    }

    /// The limit that `drive` is nearest to, in words, with the unit.
    pub(crate) fn binding(&self, drive: &Drive) -> String {
        let in_words = rounded::<4>;
        let each = Self {
            effort: f64::INFINITY,
            ..*self
        };
        match each.allowed_gain(drive)
            <= (Self {
                each: f64::INFINITY,
                ..*self
            })
            .allowed_gain(drive)
        {
            true => format!(
                "the limit of {} {} per actuator",
                in_words(self.each),
                self.unit
            ),
            false => format!(
                "the limit of {} {} on the root of the sum of squares",
                in_words(self.effort),
                self.unit
            ),
        }
    }
}

/// |v|. Velocities and forces are far from where squares overflow, and the safe norm takes ten times as long.
pub(crate) fn amplitude(value: &Complex64) -> f64 {
    value.norm_sqr().sqrt()
}
