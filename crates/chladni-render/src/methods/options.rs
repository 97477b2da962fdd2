//! Options that a user may set.

use crate::methods::choice::MethodChoice;
use crate::methods::effort::Effort;
use crate::scene::count::Count;
use crate::scene::drift::Drift;

/// Options of [`crate::render`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RenderOptions {
    /// The method that finds the weights.
    pub method: MethodChoice,
    /// Number of modes to sum explicitly.
    pub modes: Count,
    /// Number of actuators to use.
    pub actuators: Count,
    /// Drift of the panel away from its model.
    pub drift: Drift,
    /// Effort spent on finding weights.
    pub effort: Effort,
    /// Method `modal`: its two steps as one, (ΓΨ)⁺, without singular values below this
    /// share of the largest; `None`: one step after the other, without a cut.
    pub cut: Option<f64>,
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
