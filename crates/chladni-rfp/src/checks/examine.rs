//! All checks after a fit: each names one fault of the data with its evidence.
//!
//! Elsewhere: what windows leak (`data/window/leakage.rs`), FRFs far noisier
//! than the others (`data/noisy_frfs.rs`), lines that no neighbour supports
//! (`data/outliers.rs`), the wrong time sign (`poles/sketched.rs`), data that are nothing but a
//! delay (`poles/delay_alone.rs`), padded records
//! (`measured/impulse.rs`), missing values (`data/screening.rs`).

use crate::checks::case::{Case, Checked, Noise};
use crate::checks::{
    common_delay, delay, delayed_response, estimation, hidden, kind, moving, noise, reciprocal,
    split, turned_response, window_bias,
};
use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::poles::whiteness::Residual;
use chladni_frf::{Dof, ModalModel, Mode, Severity, Trust};
use rayon::prelude::*;

/// A check of the data behind a model.
type Check = fn(&Case) -> Option<Checked>;

/// Checks for poles that move. They run first: phases and scales of modes that take the place of
/// a moving one mean nothing.
const MOVEMENT: [Check; 2] = [moving::moving_poles, split::split_modes];

/// Every other check that runs after a fit.
const CHECKS: [Check; 14] = [
    kind::wrong_kind,
    noise::few_values,
    noise::noise_alone,
    hidden::single_frf,
    hidden::between_modes,
    common_delay::common_delay,
    delay::delayed_reference,
    delayed_response::delayed_responses,
    turned_response::turned_responses,
    reciprocal::not_reciprocal,
    window_bias::possible_bias,
    window_bias::modelled,
    estimation::of_blows,
    estimation::of_local_fits,
];

/// Runs all checks; what they find joins the model's findings.
pub(crate) fn examine(
    data: &DataLayout,
    values: Option<&Screened>,
    options: &FitOptions,
    residual: Residual,
    noise: Noise,
    model: &mut ModalModel,
) {
    for checks in [&MOVEMENT[..], &CHECKS] {
        let case = Case {
            data,
            values,
            model,
            options,
            noise_is_known: residual != Residual::NotWhite,
            noise,
        };
        // the few that take long must not wait for one another
        let each = checks.par_iter().with_max_len(1);
        let found: Vec<Checked> = each.filter_map(|check| check(&case)).collect();
        for checked in without_kind_of_turned(found, model) {
            join(model, checked);
        }
        drop_scale_of_moving(model);
    }
    let sure = model.in_band_modes().any(|mode| mode.trust == Trust::Sure);
    model.quality.trusted &= sure;
}

/// Findings without one on the phase of all driving points where each of these is at a response that
/// is turned against the others: then it is the response, and no matter of all FRFs. A delay of
/// all FRFs explains that phase, too.
fn without_kind_of_turned(mut found: Vec<Checked>, model: &ModalModel) -> Vec<Checked> {
    let all = found.iter().map(|checked| &checked.finding);
    let turned: Vec<Dof> = all
        .filter(|told| told.code == "turned-response")
        .flat_map(|told| told.dofs.iter().copied())
        .collect();
    let mut driving = model.references.iter();
    let at_turned = !turned.is_empty()
        && driving.all(|dof| !model.responses.contains(dof) || turned.contains(dof));
    let delayed = found.iter().any(|own| own.finding.code == "common-delay");
    if at_turned || delayed {
        let on_all = ["wrong-kind", "turned-channel"];
        found.retain(|checked| !on_all.contains(&&*checked.finding.code));
    }
    found
}

/// A finding joins those of the model; modes that it doubts are weak.
fn join(model: &mut ModalModel, checked: Checked) {
    let quality = &mut model.quality;
    quality.trusted &= checked.finding.severity != Severity::Fault;
    for (n, reason) in checked.weak {
        let mode = &mut model.modes[n];
        if mode.trust == Trust::Rejected {
            continue;
        }
        mode.trust = Trust::Weak;
        mode.reasons.push(reason);
    }
    quality.findings.push(checked.finding);
}

/// Drops the finding that modes have no scale where all of these stand for moving ones: that is
/// no matter of the driving point.
fn drop_scale_of_moving(model: &mut ModalModel) {
    let modes = &model.modes;
    let moves = |place: &f64| {
        let off = |mode: &&Mode| (mode.frequency_hz - place).abs();
        let nearest = modes.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.is_some_and(split::is_split)
    };
    model.quality.findings.retain(|told| {
        let places = told.values.get("modes_hz");
        let all_move = places.is_some_and(|places| places.as_slice().iter().all(moves));
        told.code != "scale-unknown" || !all_move
    });
}
