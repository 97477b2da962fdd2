//! The exponential window of hammer tests, taken off the poles.
//!
//! h(t)·e^{−αt} has the transform H(s + α): every pole is moved by −α along the real
//! axis, and its residue is the same. So s → s + α on the pole, and frequency, loss
//! factor and modal constants follow from it (theory.md, eq. F5). Correcting the damping
//! alone leaves the frequency off: |s| changes too.

use crate::damping::law::constant_power;
use crate::damping::places::{frequency_and_loss, s_of_mode};
use crate::model::limits;
use crate::model::modes::few_modes;
use chladni_frf::{Damping, Finding, FrfKind, ModalModel, Mode, Reason, Scaling, Trust};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Takes the decay `alpha` (1/s) off every pole of the model. Its quality stays that of
/// the fit, to the windowed data.
pub(crate) fn undo(model: &mut ModalModel, alpha: f64) {
    let (law, kind, [low, high]) = (model.damping, model.frf_kind, model.band_hz);
    let shared = model.scaling == Scaling::UnitModalMass;
    let mut explained = 0;
    for mode in model
        .modes
        .iter_mut()
        .filter(|mode| mode.trust != Trust::Rejected)
    {
        let measured = s_of_mode(law, mode);
        let own = measured + alpha;
        if own.re < 0.0 {
            let factor = correct(law, kind, mode, measured, own);
            mode.in_band = (low..=high).contains(&mode.frequency_hz);
            // mass-normalised shapes share the change between both ends
            let (at_responses, at_references) = if shared {
                (factor.sqrt(), factor.sqrt())
            } else {
                (Complex64::new(1.0, 0.0), factor)
            };
            mode.shape.0.iter_mut().for_each(|v| *v *= at_responses);
            mode.participation
                .0
                .iter_mut()
                .for_each(|v| *v *= at_references);
        } else if mode.in_band {
            // a peak of noise may have any decay
            let (decay, std) = (-measured.re, 0.5 * mode.loss_factor_std * measured.norm());
            let clearly = std.is_nan() || alpha - decay > limits::CLEARLY_SLOWER * std;
            explained += usize::from(mode.trust == Trust::Sure && clearly);
            mode.trust = Trust::Rejected;
            mode.reasons.push(
                Reason::new(
                    "slower-than-window",
                    "it decays more slowly than the exponential window alone",
                )
                .detail(format!("{decay:.3} against {alpha} 1/s")),
            );
        }
    }
    let words = format!(
        "poles are those of the structure without the exponential window of {alpha} 1/s (s + α); \
         error and χ² are those of the fit to the windowed FRFs, which the model does not \
         reproduce"
    );
    let findings = &mut model.quality.findings;
    findings.push(Finding::note("window-undone", words).value("decay_per_s", alpha));
    if explained > 0 {
        model.quality.trusted = false;
        let words = format!(
            "{explained} mode(s) decay more slowly than the exponential window of {alpha} 1/s: its \
             α is smaller, or the data are not windowed"
        );
        findings.push(
            Finding::fault("decays-not-windowed", words)
                .value("decay_per_s", alpha)
                .help("give the window's own α: ln(1/end value)/record length"),
        );
    }
    // where all of them are gone, there is nothing to trust
    if let Some(few) = few_modes(&model.modes) {
        model.quality.trusted = false;
        if !findings.iter().any(|finding| finding.code == few.code) {
            findings.push(few);
        }
    }
}

/// Frequency and damping of a mode whose pole is `own` instead of `measured`; returns
/// what its modal constants are multiplied with.
fn correct(
    law: Damping,
    kind: FrfKind,
    mode: &mut Mode,
    measured: Complex64,
    own: Complex64,
) -> Complex64 {
    let before = mode.frequency_hz;
    let (omega, loss_factor) = frequency_and_loss(law, own);
    mode.frequency_hz = omega / TAU;
    mode.loss_factor = loss_factor;
    mode.damping_ratio = 0.5 * loss_factor;
    // the pole keeps its standard deviation; η is −2 Re s over a frequency that changed
    mode.loss_factor_std *= before / mode.frequency_hz;
    // the window keeps the residue of κ(s)·α(s)
    (own / measured).powi(constant_power(law, kind))
}
