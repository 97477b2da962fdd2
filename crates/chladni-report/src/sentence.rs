//! The first sentence of a result.

use crate::better_band::{better_band, BetterBand};
use crate::sizes::HALF;
use crate::text::{counted, plain, significant};
use chladni_frf::{ModalModel, Trust};

/// The band to fit instead, where the modes explain less than half of the data.
pub(crate) fn advised_band(model: &ModalModel) -> Option<BetterBand> {
    let is_little = 1.0 - model.quality.relative_error < HALF;
    better_band(model).filter(|_| is_little)
}

/// A sentence on the number of modes, their trust, and the part of the data that they explain,
/// with a better band where that is little.
pub fn sentence(model: &ModalModel) -> String {
    let modes = model.in_band_modes().count();
    let sure = model
        .in_band_modes()
        .filter(|mode| mode.trust == Trust::Sure)
        .count();
    let [low, high] = model.band_hz.map(plain);
    let share = (1.0 - model.quality.relative_error).max(0.0);
    let percent = significant(100.0 * share, 3);
    let explained = match share < HALF {
        false => format!("{percent} % of the data, {low} to {high} Hz."),
        true => {
            let advice = advised_band(model).map_or_else(String::new, |band| {
                let [low, high] = band.hz.map(plain);
                let there = match (band.sure, sure) {
                    (1, 1) => "the sure mode lies there".to_owned(),
                    (some, all) if some == all => format!("all {all} sure modes lie there"),
                    (some, all) => format!("{some} of {all} sure modes lie there"),
                };
                format!(" Fit {low} to {high} Hz: {there}.")
            });
            format!(
                "{percent} % of the data, {low} to {high} Hz: most of it is noise, or motion that \
                 no resonance explains.{advice}"
            )
        }
    };
    match (sure, modes - sure) {
        (0, 0) => format!("No mode between {low} and {high} Hz."),
        (1, 0) => format!("1 sure mode explains {explained}"),
        (_, 0) => format!("{sure} sure modes explain {explained}"),
        (0, 1) => format!("1 weak mode and no sure one; it explains {explained}"),
        (0, _) => format!("{modes} weak modes and no sure one; they explain {explained}"),
        (_, weak) => format!(
            "{}, {weak} weak; together they explain {explained}",
            counted(sure, "sure mode")
        ),
    }
}
