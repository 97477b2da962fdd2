//! What a user may turn.

use crate::count::Count;
use crate::methods::MethodChoice;
use crate::tolerances;

/// Options of [`crate::render`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RenderOptions {
    /// How the weights are found.
    pub method: MethodChoice,
    /// How many modes to sum explicitly.
    pub modes: Count,
    /// How many actuators to use.
    pub actuators: Count,
    /// How far the panel may move away from its model.
    pub drift: Drift,
    /// What is spent on finding weights.
    pub effort: Effort,
    /// Method `modal`: its two steps as one, (ΓΨ)⁺, without singular values below this
    /// share of the largest; `None`: one step after the other, without a cut.
    pub cut: Option<f64>,
}

/// How much is spent on the search for the largest κ: what moves the conic methods along
/// the front of speed and success.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Most drives that `robust` climbs from, the best first; `best` takes
    /// [`tolerances::MOST_STARTS`] or more.
    pub starts: usize,
    /// Most conic programs in a row for each thing that is sought: κ, then margin, then
    /// peak force or effort.
    pub conic_rounds: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            starts: 1,
            conic_rounds: tolerances::ROUNDS,
        }
    }
}

impl RenderOptions {
    /// The options as results echo them, with the drift that held.
    pub(crate) fn to_json(&self, drift: &Drift) -> serde_json::Map<String, serde_json::Value> {
        let drift = drift
            .named()
            .map(|(key, value)| (key.to_owned(), value.into()))
            .into_iter()
            .collect::<serde_json::Map<_, _>>();
        let effort = (self.effort != Effort::default())
            .then(|| ("effort", serde_json::json!({"starts": self.effort.starts, "conic_rounds": self.effort.conic_rounds})));
        [
            ("method", self.method.to_string().into()),
            ("modes", self.modes.to_string().into()),
            ("actuators", self.actuators.to_string().into()),
            ("drift", drift.into()),
        ]
        .into_iter()
        .chain(effort)
        .chain(self.cut.map(|cut| ("cut", cut.into())))
        .map(|(key, value): (&str, serde_json::Value)| (key.to_owned(), value))
        .collect()
    }
}

/// How far the panel may move away from its model between the measurement and the use;
/// one sigma each.
///
/// These add, as squares, to the standard deviations that the model itself carries.
/// Without them a drive from a precise model leans on a mode at resonance, and the first
/// degree of warming breaks it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// Of each natural frequency, relative.
    pub frequency_relative: f64,
    /// Of each loss factor, relative.
    pub loss_factor_relative: f64,
    /// Of each mode shape, relative to its size at each response.
    pub shape_relative: f64,
    /// Of each entry of the mobility matrix, independent of all others, relative to the
    /// rms of the matrix.
    pub isotropic_relative: f64,
    /// Of each actuator's force for its weight: gains and phases of amplifiers and coils.
    pub drive_relative: f64,
}

impl Drift {
    /// The keys of `[drift]` in a scene, and the values here.
    pub(crate) fn named(&self) -> [(&'static str, f64); 5] {
        [
            ("frequency_relative", self.frequency_relative),
            ("loss_factor_relative", self.loss_factor_relative),
            ("shape_relative", self.shape_relative),
            ("isotropic_relative", self.isotropic_relative),
            ("drive_relative", self.drive_relative),
        ]
    }

    /// The value that a key of `[drift]` sets.
    pub(crate) fn named_mut(&mut self, key: &str) -> Option<&mut f64> {
        match key {
            "frequency_relative" => Some(&mut self.frequency_relative),
            "loss_factor_relative" => Some(&mut self.loss_factor_relative),
            "shape_relative" => Some(&mut self.shape_relative),
            "isotropic_relative" => Some(&mut self.isotropic_relative),
            "drive_relative" => Some(&mut self.drive_relative),
            _ => None,
        }
    }
}

impl Default for Drift {
    /// ω_n 0.1 % and η 10 %: the random drift under which the methods of this crate were
    /// compared (a few kelvin, or another clamping). Ten times less lets the drive lean
    /// on the mode at 299.4 Hz of the study's panel; ten times more gives up hot ground
    /// that could be had. The shapes carry the error bars of the fit. The isotropic part,
    /// 0.3 %, lies above the error of a mobility fitted to 40 dB data (0.03 % at 300 Hz,
    /// 0.2 % at 335 Hz); 1 % halves the forces of `mls` and takes the corner scene from κ
    /// = 2.6 to 0.5, 2 % loses some of its responses.
    fn default() -> Self {
        Self {
            frequency_relative: 1e-3,
            loss_factor_relative: 0.1,
            shape_relative: 0.0,
            isotropic_relative: 3e-3,
            drive_relative: 0.0,
        }
    }
}
