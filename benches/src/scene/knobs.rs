//! Knobs of rendering: how far κ is searched for, everything else as it is.

use super::Means;
use chladni_render::{Effort, Method, MethodChoice};

/// One way to search less, or more.
pub(crate) struct SceneKnob {
    /// For the legend.
    pub(crate) about: &'static str,
    settings: &'static [usize],
    effort: fn(usize) -> Effort,
    value: fn(&Effort) -> usize,
}

/// The method whose knobs they are: it alone searches.
pub(crate) const SEARCHES: MethodChoice = MethodChoice::Only(Method::Robust);

/// The knobs, each from the least to the most.
pub(crate) const SCENE_KNOBS: [SceneKnob; 2] = [
    SceneKnob {
        about: "0, 1, 2, 3, 5, 10 conic programs",
        settings: &[0, 1, 2, 3, 5],
        effort: |conic_rounds| Effort {
            conic_rounds,
            ..Effort::default()
        },
        value: |effort| effort.conic_rounds,
    },
    SceneKnob {
        about: "1, 2, 3 starts",
        settings: &[2, 3],
        effort: |starts| Effort {
            starts,
            ..Effort::default()
        },
        value: |effort| effort.starts,
    },
];

impl SceneKnob {
    /// Place along the knob; `None` where an effort belongs to another one.
    pub(crate) fn position(&self, effort: &Effort) -> Option<f64> {
        let value = (self.value)(effort);
        (*effort == (self.effort)(value)).then_some(value as f64)
    }
}

/// Every setting of every knob, with all means.
pub(crate) fn settings() -> Vec<Means> {
    let efforts = SCENE_KNOBS
        .iter()
        .flat_map(|knob| knob.settings.iter().map(|&setting| (knob.effort)(setting)));
    efforts
        .map(|effort| Means {
            effort,
            ..Means::default()
        })
        .collect()
}

/// As tables name an effort that is not the usual one.
pub(crate) fn words(effort: &Effort) -> Option<String> {
    let (usual, rounds) = (Effort::default(), effort.conic_rounds);
    let rounds = (rounds != usual.conic_rounds).then(|| format!("conic rounds {rounds}"));
    let starts = (effort.starts != usual.starts).then(|| format!("starts {}", effort.starts));
    let words: Vec<String> = rounds.into_iter().chain(starts).collect();
    (!words.is_empty()).then(|| words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_turn_one_knob_and_the_method_as_it_is_lies_on_each() {
        let usual = Effort::default();
        assert_eq!(
            SCENE_KNOBS.map(|knob| knob.position(&usual)),
            [Some(usual.conic_rounds as f64), Some(1.0)]
        );
        for means in settings() {
            let on = SCENE_KNOBS
                .iter()
                .filter(|knob| knob.position(&means.effort).is_some())
                .count();
            assert!(on == 1 && words(&means.effort).is_some(), "{means:?}");
        }
        assert_eq!(words(&usual), None);
    }
}
