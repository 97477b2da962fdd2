//! Rigs drawn at random: what differs between the model and the panel as it is.

use crate::panel::finger::Finger;
use crate::scene::drift::Drift;
use chladni_frf::Mode;
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Open01, StandardNormal};
use std::f64::consts::FRAC_1_SQRT_2;

/// Settings of the stress table.
#[derive(Debug, Clone, PartialEq)]
pub struct StressOptions {
    /// Seed of all draws.
    pub seed: u64,
    /// Draws of each random trial.
    pub draws: usize,
    /// Drift of the panel; its isotropic part does not take part.
    pub drift: Drift,
    /// A common shift of all natural frequencies, relative: temperature.
    pub common_shift: f64,
    /// The finger.
    pub finger: Finger,
    /// A mass that someone leaves on the panel, kg.
    pub added_mass_kg: f64,
    /// Standard deviation of each actuator's amplitude, relative.
    pub amplitude_relative: f64,
    /// Standard deviation of each actuator's phase, degrees.
    pub phase_deg: f64,
    /// Bits of the converter that drives the actuators; full scale is the largest weight.
    pub converter_bits: u32,
}

impl Default for StressOptions {
    /// 200 draws, so that the worst twentieth is ten of them; 1 g is a ring or a cable; 2
    /// % and 2° are amplifiers of one batch; 8 bits are coarse.
    fn default() -> Self {
        Self {
            seed: 1,
            draws: 200,
            drift: Drift::default(),
            common_shift: 2e-3,
            finger: Finger::default(),
            added_mass_kg: 1e-3,
            amplitude_relative: 0.02,
            phase_deg: 2.0,
            converter_bits: 8,
        }
    }
}

impl StressOptions {
    /// Rms of the complex error of a gain.
    pub(crate) fn gain_error(&self) -> f64 {
        self.amplitude_relative.hypot(self.phase_deg.to_radians())
    }
}

/// The least value once the worst twentieth is left out: 95 % of the cases reach it. The least
/// of all where there are fewer than twenty; `None` without values.
pub(crate) fn worst_twentieth(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 20).copied()
}

/// Seeded random changes.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Evenly from 0 to 1.
    pub(crate) fn uniform(&mut self) -> f64 {
        Open01.sample(&mut self.0)
    }

    /// An error of the size that the model states. Poles outside the band stand for the
    /// world outside and keep still.
    pub(crate) fn fit_error(&mut self, mode: &mut Mode) {
        if !mode.in_band {
            return;
        }
        mode.frequency_hz += mode.frequency_std_hz * self.normal();
        mode.loss_factor += mode.loss_factor_std * self.normal();
        for response in 0..mode.shape.0.len() {
            let deviation = mode.shape_std_at_known_scale(response);
            mode.shape.0[response] +=
                Complex64::new(self.normal(), self.normal()) * (FRAC_1_SQRT_2 * deviation);
        }
    }

    pub(crate) fn drift(&mut self, mode: &mut Mode, drift: &Drift) {
        mode.frequency_hz *= 1.0 + drift.frequency_relative * self.normal();
        mode.loss_factor *= 1.0 + drift.loss_factor_relative * self.normal();
        for value in &mut mode.shape.0 {
            *value *= 1.0 + drift.shape_relative * self.normal();
        }
    }

    /// A factor on each of `count` natural frequencies, of a relative rms error.
    pub(crate) fn factors(&mut self, count: usize, error: f64) -> Vec<f64> {
        (0..count).map(|_| 1.0 + error * self.normal()).collect()
    }

    pub(crate) fn gain(&mut self, options: &StressOptions) -> Complex64 {
        let amplitude = 1.0 + options.amplitude_relative * self.normal();
        Complex64::from_polar(amplitude, options.phase_deg.to_radians() * self.normal())
    }
}
