//! The endurance of a drive: the share of rigs on which its scene survives.
//!
//! κ speaks of the errors that were assumed. A rig as one finds it has amplifiers of 2 %
//! and 2°, natural frequencies 0.1 % off, and a light finger on its hot zone, all at once.
//! Such rigs are drawn from a seed and simulated in the model with the drive as it is: some
//! hundred fields, no more programs.

use crate::finger::Finger;
use crate::modal_field::ModalField;
use crate::problem::{amplitude, Drive};
use crate::rig_draw::{Draw, StressOptions};
use crate::setup::Setup;
use crate::tolerances;
use chladni_frf::{Finding, ModalModel, Scaling};
use ndarray::Array1;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// The endurance of a drive, simulated in its model. It serves a rig where it serves 95 % of
/// the hot and of the cold responses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Endurance {
    /// Share of the rigs that it serves.
    pub survival_ratio: f64,
    /// Rigs that were simulated.
    pub rigs: usize,
    /// Error of their gains, rms of the complex factor: that of amplifiers of 2 % and 2°, or
    /// what a calibration has left.
    pub gain_error: f64,
    /// The same share where only amplifiers err.
    pub amplifiers_alone: f64,
    /// The same where only natural frequencies are off.
    pub frequencies_alone: f64,
    /// The same where only a finger touches, over all hot responses.
    pub finger_alone: f64,
    /// False where the model is not mass-scaled, so that the size of the modes under the
    /// finger had to be guessed.
    pub touch_is_known: bool,
}

impl Endurance {
    /// Of `drive` in the scene that `setup` lays over `model`; `calibrated` is the error of
    /// the gains that a calibration has left.
    pub(crate) fn of(
        setup: &Setup,
        model: &ModalModel,
        drive: &Drive,
        calibrated: Option<f64>,
    ) -> Self {
        let finger = Finger::LIGHT;
        let mut amplifiers = StressOptions::default();
        let usual = amplifiers.gain_error();
        let gain_error = calibrated.map_or(usual, |left| left.min(usual));
        amplifiers.amplitude_relative *= gain_error / usual;
        amplifiers.phase_deg *= gain_error / usual;
        let modal = ModalField::new(model, &setup.operator, drive);
        let hot = &setup.judged[..setup.problem.rows.hot];
        let mut draw = Draw::new(tolerances::ENDURANCE_SEED);
        let mut served = [0; 3];
        for rig in 0..tolerances::ENDURANCE_RIGS {
            let driven = drive.mapv(|weight| weight * draw.gain(&amplifiers));
            let factors = draw.factors(modal.modes(), tolerances::ENDURANCE_FREQUENCY_ERROR);
            let there = ModalField::new(model, &setup.operator, &driven);
            let row = hot[rig % hot.len()];
            let fields = [
                there.touched_and_moved(&finger, row, &factors),
                there.free,
                modal.with_frequencies(|n| factors[n]),
            ];
            for (count, field) in served.iter_mut().zip(fields) {
                *count += usize::from(serves(setup, &field));
            }
        }
        let fingers = hot
            .iter()
            .filter(|&&row| serves(setup, &modal.perhaps_touched(&finger, row)));
        let share = |count: usize| count as f64 / tolerances::ENDURANCE_RIGS as f64;
        let [survival_ratio, amplifiers_alone, frequencies_alone] = served.map(share);
        Self {
            survival_ratio,
            rigs: tolerances::ENDURANCE_RIGS,
            gain_error,
            amplifiers_alone,
            frequencies_alone,
            finger_alone: fingers.count() as f64 / hot.len() as f64,
            touch_is_known: model.scaling == Scaling::UnitModalMass,
        }
    }

    /// A caution where too few rigs are served.
    pub(crate) fn finding(&self) -> Option<Finding> {
        if self.survival_ratio >= tolerances::SERVES {
            return None;
        }
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let how = match self.touch_is_known {
            true => "",
            false => " (estimated: no driving point was measured)",
        };
        let words = format!(
            "the scene survives on {} of {} simulated rigs (gains off by {:.1} % rms, natural \
             frequencies by 0.1 %, a light finger); with the gains alone on {}, the frequencies \
             alone on {}, the finger alone on {}{how}",
            percent(self.survival_ratio),
            self.rigs,
            100.0 * self.gain_error,
            percent(self.amplifiers_alone),
            percent(self.frequencies_alone),
            percent(self.finger_alone)
        );
        let of_panel = self.frequencies_alone.min(self.finger_alone);
        let help = match self.amplifiers_alone < of_panel {
            true => "measure the field and correct the drive",
            false => "choose a less sensitive frequency",
        };
        Some(
            Finding::caution("rig-sensitive", words)
                .value("survival_ratio", self.survival_ratio)
                .value("amplifiers_alone", self.amplifiers_alone)
                .value("frequencies_alone", self.frequencies_alone)
                .value("finger_alone", self.finger_alone)
                .help(help),
        )
    }
}

/// True where a field serves the judged responses of both kinds.
fn serves(setup: &Setup, velocity: &Array1<Complex64>) -> bool {
    let levels = &setup.problem.rows.levels;
    let amplitudes = setup.judged.iter().zip(levels);
    let amplitudes = amplitudes
        .map(|(&k, level)| amplitude(&velocity[k]) / level)
        .collect();
    let (hot, cold) = setup.problem.counts(&amplitudes, 1.0);
    setup.problem.min_ratio(hot, cold) >= tolerances::SERVES
}
