//! All checks after a fit: each names one fault of the data with its evidence.
//!
//! Elsewhere: what windows leak (`data/window/leakage.rs`), FRFs far noisier
//! than the others (`data/noisy_frfs.rs`), lines that no neighbour supports
//! (`data/outliers.rs`), the wrong time sign (`poles/sketched.rs`), padded records
//! (`measured/impulse.rs`), missing values (`data/screening.rs`).

use crate::checks::case::{Case, Checked};
use crate::checks::{
    delay, delayed_response, estimation, hidden, kind, moving, noise, reciprocal, split, window_bias,
};
use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::poles::whiteness::Residual;
use chladni_frf::{ModalModel, Severity, Trust};
use rayon::prelude::*;

/// Every check that runs after a fit.
const CHECKS: [fn(&Case) -> Option<Checked>; 14] = [
    kind::wrong_kind,
    noise::few_values,
    noise::noise_alone,
    moving::moving_poles,
    split::split_modes,
    hidden::single_frf,
    hidden::between_modes,
    delay::delayed_reference,
    delayed_response::delayed_responses,
    reciprocal::not_reciprocal,
    window_bias::possible_bias,
    window_bias::modelled,
    estimation::of_blows,
    estimation::of_local_fits,
];

/// Runs all checks; what they find joins the model's findings.
///
/// * `noise_variance`: of one work value, where the residual is white
/// * `left_of_frfs`: residual energy of each FRF as fitted; empty where not known
pub(crate) fn examine(
    data: &DataLayout,
    values: Option<&Screened>,
    options: &FitOptions,
    residual: Residual,
    (noise_variance, left_of_frfs): (f64, &[f64]),
    model: &mut ModalModel,
) {
    let case = Case {
        data,
        values,
        model,
        options,
        white: residual == Residual::White,
        noise_variance,
        left_of_frfs,
    };
    let found: Vec<Checked> = CHECKS.par_iter().filter_map(|check| check(&case)).collect();
    for checked in found {
        model.quality.trusted &= checked.finding.severity != Severity::Fault;
        for (n, reason) in checked.weak {
            let mode = &mut model.modes[n];
            if mode.trust == Trust::Rejected {
                continue;
            }
            mode.trust = Trust::Weak;
            mode.reasons.push(reason);
        }
        model.quality.findings.push(checked.finding);
    }
    let sure = model.in_band_modes().any(|mode| mode.trust == Trust::Sure);
    model.quality.trusted &= sure;
}
