//! Lines on which a model misfits all FRFs together, while it fits their neighbours.

use crate::damping::measured_model::frf_matrix;
use crate::data::outliers::single_lines;
use crate::data::screening::Screened;
use crate::tolerances as tol;
use chladni_frf::{ModalModel, Mode, Trust};
use rayon::prelude::*;

/// Outliers under `model`, as positions among the lines used; empty if there are none or too many.
pub(crate) fn outliers_of(data: &Screened, model: &ModalModel) -> Vec<usize> {
    if model.in_band_modes().next().is_none() {
        return Vec::new();
    }
    let spacing = data.line_spacing_hz();
    let is_one_bad_line = |mode: &Mode| {
        let half_width = 0.5 * mode.loss_factor * mode.frequency_hz;
        mode.in_band && half_width < tol::SPIKE_SPACINGS * spacing
    };
    let mut without_spikes = model.clone();
    let modes = &mut without_spikes.modes;
    modes.retain(|mode| mode.trust != Trust::Rejected && !is_one_bad_line(mode));
    let (residual, fitted): (Vec<f64>, Vec<f64>) = data
        .lines
        .par_iter()
        .map(|&k| energies(data, &without_spikes, k))
        .unzip();
    single_lines(&residual, &fitted)
}

/// Energies of residual and model over all FRFs on one line, each times its weight.
fn energies(data: &Screened, model: &ModalModel, k: usize) -> (f64, f64) {
    let leakage = data.leakage.as_deref();
    let in_units = (data.kind, data.omega_max);
    let matrix = frf_matrix(model, leakage, in_units, data.frf.frequency_hz[k]);
    data.pairs
        .iter()
        .fold((0.0, 0.0), |(residual, fitted), &(i, j)| {
            let (value, weight) = (matrix[[i, j]], data.weight_of((i, j)));
            (
                residual + ((data.frf.values.get(i, j, k) - value) * weight).norm_sqr(),
                fitted + (value * weight).norm_sqr(),
            )
        })
}
