//! The figures of a report, one file each.

mod auto_mac;
mod cmif;
mod field_map;
mod frf_overlay;
mod mode_shape;
mod plane;
mod stabilization;
mod weights_around_edge;

pub(crate) use auto_mac::auto_mac;
pub(crate) use cmif::cmif;
pub(crate) use field_map::field_map;
pub(crate) use frf_overlay::{frf_overlay, frf_sum};
pub(crate) use mode_shape::{mode_shapes, shown_responses};
pub(crate) use stabilization::stabilization;
pub(crate) use weights_around_edge::{weights_around_edge, weights_by_actuator};

use chladni_frf::ModalModel;

/// 20 log10 of an amplitude; NaN for zero, so that curves break there.
pub(crate) fn level(amplitude: f64) -> f64 {
    if amplitude > 0.0 {
        20.0 * amplitude.log10()
    } else {
        f64::NAN
    }
}

/// Natural frequencies of the modes in the band, Hz.
pub(crate) fn natural_frequencies(model: Option<&ModalModel>) -> Vec<f64> {
    model.map(|model| model.in_band_modes().map(|mode| mode.frequency_hz).collect()).unwrap_or_default()
}
