//! The endurance of a drive before it fails: natural frequencies that are off, and a
//! finger.
//!
//! κ speaks of the errors that were assumed. What lies beyond them, a model of another
//! day or a touch that it does not know, is asked here, with the field of the drive taken
//! apart by modes: a few hundred fields of one drive, no more programs.

use crate::field::Field;
use crate::finger::{finger_rows, Finger};
use crate::modal_field::ModalField;
use crate::problem::{amplitude, Drive};
use crate::setup::Setup;
use crate::tolerances;
use chladni_frf::{Finding, ModalModel, Scaling};
use ndarray::Array1;
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// The endurance of a drive in its model. It serves where it serves
/// 95 % of the hot and of the cold responses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Endurance {
    /// Random errors of all natural frequencies, rms, relative, up to which it serves; at
    /// most 0.032.
    pub frequency_relative: f64,
    /// Share of responses, the smaller one of hot and cold, that it serves with a light
    /// finger at the worst of a few places in the hot zone.
    pub touched_min_ratio: f64,
    /// False where the model is not mass-scaled, so that the size of the modes under the
    /// finger had to be guessed.
    pub touch_is_known: bool,
}

impl Endurance {
    /// Of `drive` in the scene that `setup` lays over `model`.
    pub(crate) fn of(setup: &Setup, model: &ModalModel, drive: &Drive) -> Self {
        let modal = ModalField::new(model, &setup.operator, drive);
        let served = |velocity: Array1<Complex64>| {
            let levels = &setup.problem.rows.levels;
            let amplitudes = setup
                .judged
                .iter()
                .zip(levels)
                .map(|(&k, level)| amplitude(&velocity[k]) / level)
                .collect();
            let (hot, cold) = setup.problem.counts(&amplitudes, 1.0);
            setup.problem.min_ratio(hot, cold)
        };
        let field = Field::new(&setup.operator, &setup.zones, drive);
        let touched = finger_rows(&field)
            .into_iter()
            .map(|row| served(modal.perhaps_touched(&Finger::default(), row)));
        Self {
            touched_min_ratio: touched.fold(1.0, f64::min),
            touch_is_known: model.scaling == Scaling::UnitModalMass,
            frequency_relative: largest_error(&modal, |velocity| {
                served(velocity) >= tolerances::SERVES
            }),
        }
    }

    /// Findings about it.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        if self.frequency_relative < tolerances::THIN_FREQUENCY_ERROR {
            let words = format!(
                "the drive holds for natural frequencies up to {:.1} % off; on another day or at \
                 another temperature they may be further off",
                100.0 * self.frequency_relative
            );
            findings.push(
                Finding::caution("frequency-sensitive", words)
                    .value("frequency_relative", self.frequency_relative)
                    .help("check on a fresh measurement, or choose a less sensitive frequency"),
            );
        }
        if self.touched_min_ratio < tolerances::TOUCHED_SERVES {
            let how = if self.touch_is_known {
                ""
            } else {
                " (estimated: no driving point was measured)"
            };
            let words = format!(
                "under a light touch, {:.0} % of the responses in the worse zone meet their \
                 limit{how}",
                100.0 * self.touched_min_ratio
            );
            findings.push(
                Finding::caution("touch-sensitive", words)
                    .value("touched_min_ratio", self.touched_min_ratio)
                    .help("choose a less sensitive frequency"),
            );
        }
        findings
    }
}

/// The largest rms error of natural frequencies, relative, at which all draws are served.
fn largest_error(modal: &ModalField, serves: impl Fn(Array1<Complex64>) -> bool) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut draw = || -> Vec<f64> {
        (0..modal.modes())
            .map(|_| StandardNormal.sample(&mut random))
            .collect()
    };
    let draws: Vec<Vec<f64>> = (0..tolerances::ENDURANCE_DRAWS).map(|_| draw()).collect();
    let endured = |error: f64| {
        draws
            .iter()
            .all(|draw| serves(modal.with_frequencies(|n| 1.0 + error * draw[n])))
    };
    let (mut low, mut high) = (0.0, tolerances::LEAST_FREQUENCY_ERROR);
    while high < tolerances::MOST_FREQUENCY_ERROR && endured(high) {
        (low, high) = (high, 2.0 * high);
    }
    if high >= tolerances::MOST_FREQUENCY_ERROR {
        return tolerances::MOST_FREQUENCY_ERROR;
    }
    for _ in 0..3 {
        let middle = 0.5 * (low + high);
        if endured(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
