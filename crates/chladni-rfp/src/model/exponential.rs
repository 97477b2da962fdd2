//! Correction of poles for the exponential window of hammer tests.
//!
//! h(t)·e^{−αt} has the transform H(s + α): every pole is moved by −α along the real
//! axis, and its residue is the same. So the pole is corrected by s → s + α; frequency, loss
//! factor and modal constants follow from it (theory.md, eq. F5). A correction of the damping
//! alone would leave the frequency off, because |s| changes too.

use crate::damping::law::constant_power;
use crate::damping::places::{frequency_and_loss, s_of_mode};
use crate::model::limits;
use crate::model::modes::no_sure_mode;
use chladni_frf::{counted, Damping, Finding, FrfKind, ModalModel, Mode, Reason, Scaling, Trust};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Takes the decay `alpha` (1/s) off every pole of the model. Its quality stays that of the fit to
/// the windowed data.
pub(crate) fn undo(model: &mut ModalModel, alpha: f64) {
    let (law, kind, [low, high]) = (model.damping, model.frf_kind, model.band_hz);
    let is_mass_normalised = model.scaling == Scaling::UnitModalMass;
    let mut sure_but_slower = 0;
    for mode in model
        .modes
        .iter_mut()
        .filter(|mode| mode.trust != Trust::Rejected)
    {
        let measured = s_of_mode(law, mode);
        let corrected = measured + alpha;
        if corrected.re < 0.0 {
            let factor = correct(law, kind, mode, measured, corrected);
            mode.in_band = (low..=high).contains(&mode.frequency_hz);
            multiply_residues(mode, factor, is_mass_normalised);
        } else if mode.in_band {
            // a peak of noise may have any decay
            let (decay, std) = (-measured.re, 0.5 * mode.loss_factor_std * measured.norm());
            let clearly = std.is_nan() || alpha - decay > limits::CLEARLY_SLOWER * std;
            sure_but_slower += usize::from(mode.trust == Trust::Sure && clearly);
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
    if sure_but_slower > 0 {
        model.quality.trusted = false;
        let words = format!(
            "{} {} more slowly than the exponential window of {alpha} 1/s: its α is smaller, or the \
             data are not windowed",
            counted(sure_but_slower, "mode"),
            if sure_but_slower == 1 { "decays" } else { "decay" }
        );
        findings.push(
            Finding::fault("decays-not-windowed", words)
                .value("decay_per_s", alpha)
                .help("give the window's own α: ln(1/end value)/record length"),
        );
    }
    // all modes, or all sure ones, may be gone now
    if let Some(few) = no_sure_mode(&model.modes) {
        model.quality.trusted = false;
        if !findings.iter().any(|finding| finding.code == few.code) {
            findings.push(few);
        }
    }
}

/// Multiplies the residues of a mode by `factor`. Mass-normalised shapes share it between responses
/// and references; otherwise the participations take it.
fn multiply_residues(mode: &mut Mode, factor: Complex64, is_mass_normalised: bool) {
    let (at_responses, at_references) = match is_mass_normalised {
        true => (factor.sqrt(), factor.sqrt()),
        false => (Complex64::new(1.0, 0.0), factor),
    };
    mode.shape.0.iter_mut().for_each(|v| *v *= at_responses);
    let participation = mode.participation.0.iter_mut();
    participation.for_each(|v| *v *= at_references);
}

/// Sets frequency and damping of a mode to those of the pole `corrected`; returns the factor that
/// its modal constants change by.
fn correct(
    law: Damping,
    kind: FrfKind,
    mode: &mut Mode,
    measured: Complex64,
    corrected: Complex64,
) -> Complex64 {
    let before = mode.frequency_hz;
    let (omega, loss_factor) = frequency_and_loss(law, corrected);
    mode.frequency_hz = omega / TAU;
    mode.loss_factor = loss_factor;
    mode.damping_ratio = 0.5 * loss_factor;
    // the pole keeps its standard deviation; η is −2 Re s over a frequency that changed
    mode.loss_factor_std *= before / mode.frequency_hz;
    // the window keeps the residue of κ(s)·α(s)
    (corrected / measured).powi(constant_power(law, kind))
}
