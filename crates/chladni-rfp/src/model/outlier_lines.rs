//! Lines on which all FRFs together leave a model, and their neighbours do not.

use crate::damping::measured_model::frf_matrix;
use crate::data::outliers::single_lines;
use crate::data::screening::Screened;
use crate::tolerances as tol;
use chladni_frf::{ModalModel, Trust};
use rayon::prelude::*;

/// Positions among the lines used that are outliers under `model`; empty where there are
/// none or too many.
pub(crate) fn outliers_of(data: &Screened, model: &ModalModel) -> Vec<usize> {
    if model.in_band_modes().next().is_none() {
        return Vec::new(); // nothing to judge by
    }
    let spacing = data.line_spacing_hz();
    let narrow = |f: f64, eta: f64| 0.5 * eta * f < tol::SPIKE_SPACINGS * spacing;
    let mut without = model.clone();
    without.modes.retain(|mode| {
        mode.trust != Trust::Rejected
            && !(mode.in_band && narrow(mode.frequency_hz, mode.loss_factor))
    });
    let (left, fitted): (Vec<f64>, Vec<f64>) = data
        .lines
        .par_iter()
        .map(|&k| energies(data, &without, k))
        .unzip();
    single_lines(&left, &fitted)
}

/// Energies of residual and model over all FRFs on one line, each times its weight.
fn energies(data: &Screened, model: &ModalModel, k: usize) -> (f64, f64) {
    let leakage = data.leakage.as_deref();
    let in_units = (data.kind, data.omega_max);
    let matrix = frf_matrix(model, leakage, in_units, data.frf.frequency_hz[k]);
    data.pairs
        .iter()
        .fold((0.0, 0.0), |(left, fitted), &(i, j)| {
            let (value, weight) = (matrix[[i, j]], data.weight_of((i, j)));
            (
                left + ((data.frf.values.get(i, j, k) - value) * weight).norm_sqr(),
                fitted + (value * weight).norm_sqr(),
            )
        })
}
